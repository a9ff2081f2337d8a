//! How many lattice points a sample can stand for, by the opacity around it.

use crate::brick_bytes::BrickBytes;
use crate::brick_number::EDGE;
use crate::clipped::ClippedBricks;
use crate::lanes::{F32s, I32s, Mask, each};
use crate::levels::{Level, inlined};
use crate::line::Line;
use crate::making::Making;
use strahl_scene::plan::{Plan, Sampling};
use strahl_scene::visibility::{ContributionKey, most_opacity};
use strahl_volume::Cancelled;
use strahl_volume::bricks::Bricks;

/// Strides of 1, 2 or 4 lattice points. A longer one is taken where what lies along it can make up no more than a share of
/// the pixel: the rate of sampling follows what is still seen of it, as J. Danskin and P. Hanrahan's β-acceleration
/// (1992) has it, and how opaque the volume is there, of which an upper bound is known beforehand, so that nothing
/// thin and opaque is stepped over.
pub struct Strides {
    /// What [`most_opacity`] gives.
    most_opacity: BrickBytes,
    /// In 255ths, as the opacities.
    share: f32,
}

impl Strides {
    /// Those of object number `object`; `None` if every lattice point is to be looked at.
    pub fn new(
        making: &Making,
        contribution: &ContributionKey,
        bricks: &Bricks,
        (plan, object): (&Plan, usize),
        clipped: Option<&ClippedBricks>,
    ) -> Result<Option<Strides>, Cancelled> {
        let Sampling::ByOpacity { share } = plan.sampling else {
            return Ok(None);
        };
        let of = (plan, object);
        let found = BrickBytes::new(making, contribution, bricks, of, clipped, most_opacity)?;
        Ok(found.map(|most_opacity| Strides {
            most_opacity,
            share: share * 255.0,
        }))
    }

    /// Those along rays; `last_alpha` is that of [`RayStrides`], 0 before the first lattice point.
    #[inline(always)]
    pub fn along<S: Level>(&self, line: &Line<S>, last_alpha: F32s<S>) -> RayStrides<'_, S> {
        // A little less than the edge: positions are rounded.
        let most = F32s::splat(0.99 * EDGE as f32);
        let [x, y, z] = each!(line.step_in_voxel, |step| step.abs());
        let steps = x.max(y).max(z);
        let fits = inlined(
            #[inline(always)]
            |stride: F32s<S>| (steps * stride).le(most),
        );
        let longest = longest_that(fits);
        RayStrides {
            strides: self,
            longest,
            last_alpha,
        }
    }
}

/// Strides along the rays of a packet.
pub struct RayStrides<'s, S: Level> {
    strides: &'s Strides,
    /// That stays within the bricks around that of the sample: of more nothing is known.
    longest: F32s<S>,
    /// In front of the sample before, where its brick may show something.
    pub last_alpha: F32s<S>,
}

impl<S: Level> RayStrides<'_, S> {
    /// The strides of samples in `cell`, where they are `sampled`; anything elsewhere. With their own, `left` lattice
    /// points are left of each ray. `alpha` is that of the pixel in front of them. What counts is the
    /// one in front of the sample before, so that the loop need not wait for what the last sample was. (Alpha only
    /// grows: it is a bound as well.)
    #[inline(always)]
    pub fn at(
        &mut self,
        cell: [I32s<S>; 3],
        sampled: Mask<S>,
        alpha: F32s<S>,
        left: F32s<S>,
    ) -> F32s<S> {
        let most = self.strides.most_opacity.at(cell);
        // Elsewhere no sample stands for anything, and skipping may leave it out: the next lattice point may be seen.
        let shows = I32s::splat(0).lt(most);
        let of_step = most.to_f32s() * (F32s::splat(1.0) - self.last_alpha);
        self.last_alpha = (sampled & shows).select(alpha, self.last_alpha);
        let longest = self.longest.min(left);
        let share = F32s::splat(self.strides.share);
        longest_that(inlined(
            #[inline(always)]
            |stride: F32s<S>| shows & stride.le(longest) & (of_step * stride).le(share),
        ))
    }
}

/// The longest stride that `fits`, or 1.
#[inline(always)]
fn longest_that<S: Level>(fits: impl Fn(F32s<S>) -> Mask<S>) -> F32s<S> {
    let (one, two, four) = (F32s::splat(1.0), F32s::splat(2.0), F32s::splat(4.0));
    fits(four).select(four, fits(two).select(two, one))
}

/// The opacity of as many steps as a stride has, from that of one.
#[inline(always)]
pub fn of_stride<S: Level>(opacity: F32s<S>, stride: F32s<S>) -> F32s<S> {
    let (two, four) = (F32s::splat(2.0), F32s::splat(4.0));
    // 1 − (1 − a)², with all its digits for small a.
    let of_two = opacity * (two - opacity);
    let of_four = of_two * (two - of_two);
    four.le(stride)
        .select(of_four, two.le(stride).select(of_two, opacity))
}
