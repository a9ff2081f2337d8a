//! How many lattice points a sample can stand for, by the opacity around it.

use crate::lanes::{F32s, I32s, Mask, each};
use crate::levels::{Level, inlined};
use crate::of_bricks::{OfBricks, RecentOfBricks};
use crate::ray::Line;
use crate::skip::Skip;
use strahl_scene::plan::{Plan, Sampling};
use strahl_scene::visibility::most_opacity;
use strahl_volume::bricks::Bricks;

/// Strides of 1, 2 or 4 lattice points. A longer one is taken where what lies along it can make up no more than a share of
/// the pixel: the rate of sampling follows what is still seen of it, as J. Danskin and P. Hanrahan's β-acceleration
/// (1992) has it, and how opaque the volume is there, of which an upper bound is known beforehand, so that nothing
/// thin and opaque is stepped over.
pub struct Strides {
    /// What [`most_opacity`] gives.
    most_opacity: OfBricks,
    /// In 255ths, as the opacities.
    share: f32,
}

impl Strides {
    /// Those of object number `object`; `None` if every lattice point is to be looked at.
    pub fn new(
        recent: &RecentOfBricks,
        bricks: &Bricks,
        plan: &Plan,
        object: usize,
    ) -> Option<Strides> {
        let Sampling::ByOpacity { share } = plan.sampling else {
            return None;
        };
        let most_opacity = OfBricks::new(recent, bricks, plan, object, most_opacity)?;
        Some(Strides {
            most_opacity,
            share: share * 255.0,
        })
    }

    /// The longest stride that stays within the bricks around that of the sample: of more nothing is known.
    #[inline(always)]
    pub fn longest<S: Level>(line: &Line<S>) -> F32s<S> {
        // A little less than the edge: positions are rounded.
        let most = F32s::splat(0.99 * Skip::EDGE as f32);
        let [x, y, z] = each!(line.step_in_voxel, |step| step.abs());
        let steps = x.max(y).max(z);
        let (one, two, four) = (F32s::splat(1.0), F32s::splat(2.0), F32s::splat(4.0));
        let fits = inlined(
            #[inline(always)]
            |stride: F32s<S>| (steps * stride).le(most),
        );
        fits(four).select(four, fits(two).select(two, one))
    }

    /// How opaque a step can be around each cell, in 255ths; 0 where nothing is shown.
    #[inline(always)]
    pub fn most_opacity<S: Level>(&self, cell: [I32s<S>; 3]) -> I32s<S> {
        self.most_opacity.at(cell)
    }

    /// The strides of samples with such a `most` opacity around, at most `longest`, where they are `sampled`; anything
    /// elsewhere. `alpha` is that of the pixel in front of them, `last` the one in front of the sample before, of which
    /// it becomes that of this one: the loop need not wait for what the last sample was. (Alpha only grows: it is a bound
    /// as well.)
    #[inline(always)]
    pub fn at<S: Level>(
        &self,
        most: I32s<S>,
        sampled: Mask<S>,
        alpha: F32s<S>,
        last: &mut F32s<S>,
        longest: F32s<S>,
    ) -> F32s<S> {
        let (one, two, four) = (F32s::splat(1.0), F32s::splat(2.0), F32s::splat(4.0));
        // Elsewhere no sample stands for anything, and skipping may leave it out: the next lattice point may be seen.
        let shows = I32s::splat(0).lt(most);
        let share = most.to_f32s() * (one - *last);
        *last = (sampled & shows).select(alpha, *last);
        let most = F32s::splat(self.share);
        let fits = inlined(
            #[inline(always)]
            |stride: F32s<S>| shows & stride.le(longest) & (share * stride).le(most),
        );
        fits(four).select(four, fits(two).select(two, one))
    }
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
