//! Cheap rejection before a cubic reconstruction: eight voxels say between which numbers the value that takes 64
//! must lie, and most that cannot be seen need not be worked out.
//!
//! Along one axis a cubic kernel that is exact for lines differs from linear interpolation by a multiple of a mean of the
//! second differences at both ends of the cell. In three dimensions
//! C·C·C − L·L·L = (C − L)·C·C + L·(C − L)·C + L·L·(C − L), a second difference of each axis, weighted across it by
//! kernels whose weights add up to 1. Bricks have bounds of all that.

use crate::brick_number::{EDGE, brick_number};
use crate::lanes::{F32s, I32s, Mask, Vec3s, words_inside};
use crate::levels::{Level, inlined, vectorized};
use crate::library::classify::IntervalVisibility;
use crate::library::composite::visible_values::VisibleValues;
use crate::library::reconstruct::Values;
use crate::making::Making;
use crate::skip::rounded_up;
use std::sync::Arc;
use strahl_scene::plan::{Classify, Fetch, Plan, Reconstruct};
use strahl_volume::bends::bends_under;
use strahl_volume::bricks::{BrickRange, Bricks, BricksKey};
use strahl_volume::{ContentId, Error, Key, Rescale, Volume};

/// What cubic reconstruction of a volume rests on, beside the voxels.
pub struct CubicBounds {
    /// With the reach of the kernels.
    pub bricks: Arc<Bricks>,
    bends: Arc<Option<Bends>>,
}

/// Key of the bounds of a volume's second differences.
#[derive(Clone, PartialEq)]
struct BendsKey(ContentId);

impl Key for BendsKey {
    /// `None` if nothing is known.
    type Value = Option<Bends>;

    const NAME: &str = "second differences";

    fn bytes(&self, value: &Option<Bends>) -> usize {
        value.as_ref().map_or(0, |bends| 4 * bends.words.len())
    }
}

/// Bounds of the second differences of stored numbers.
#[derive(Clone)]
struct Bends {
    /// Of each brick the smallest and the largest in the lower and the upper half of a word: the upper halves of the bits of
    /// both numbers, rounded away from 0.
    words: Arc<Vec<u32>>,
    /// No number is further from 0.
    largest: f32,
}

impl CubicBounds {
    pub fn new(making: &Making, volume: &Volume) -> Result<CubicBounds, Error> {
        let control = making.control;
        let make = || Bricks::under(volume, EDGE, 1, control);
        let bricks = making.find(&BricksKey::new(volume, EDGE, 1), make)?;
        let bends = making.find(&BendsKey(volume.id()), || {
            let BrickRange { lo, hi } = bricks.whole_under(control)?;
            let largest = lo.abs().max(hi.abs());
            // Of voxels without a value nothing is known, and sums of larger numbers overflow.
            let is_whole = volume.statistics_under(control)?.not_finite == 0 && largest < 1e36;
            // Words are gathered at 32-bit offsets.
            let fits = bricks.number() <= i32::MAX as usize / 8;
            if !is_whole || !fits {
                return Ok(None);
            }
            let half = |number: f32| u32::from(rounded_up(number.abs()));
            let word = |[least, most]: [f32; 2]| half(most) << 16 | half(least);
            let words = bends_under(volume, EDGE, control, word)?;
            Ok::<_, Error>(Some(Bends {
                words: Arc::new(words),
                largest,
            }))
        })?;
        Ok(CubicBounds { bricks, bends })
    }
}

/// Which samples of an object need not be worked out.
pub struct Rejection {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    bends: Bends,
    /// How far below the linear value the cubic one may lie, as multiples of how far second differences lie below 0 and
    /// above.
    below: [f32; 2],
    /// Likewise above the linear value.
    above: [f32; 2],
    /// Of single precision.
    rounding: f32,
    seen: Seen,
}

/// Which values a rule sees.
enum Seen {
    /// Those that are classified as anything.
    Shown(IntervalVisibility),
    /// From this one on.
    From(f32),
    /// Beyond that of the ray so far.
    Larger,
    Smaller,
}

impl Rejection {
    /// That of layer number `layer`, whose values are `rescale`d from numbers like those of `of_cubic`; `None` if
    /// every sample is to be worked out.
    pub fn new(
        of_cubic: &CubicBounds,
        plan: &Plan,
        layer: usize,
        rescale: Rescale,
        sees: VisibleValues,
    ) -> Option<Rejection> {
        let bends = Option::as_ref(&of_cubic.bends)?;
        let (field, technique) = (plan.field_of(layer), plan.technique_of(layer));
        if field.fetch != Fetch::Stored {
            return None;
        }
        // How far below the line and above, for bends below 0 and above: the multiple of the kernel, and what weights below 0
        // across the axis add, of which Catmull–Rom has up to 1/8 along each.
        let (below, above) = match field.reconstruct {
            Reconstruct::BSpline | Reconstruct::BSplineInterpolating => {
                ([1.0 / 6.0, 0.0], [0.0, 1.0 / 6.0])
            }
            Reconstruct::CatmullRom => {
                // (5/4)² is the sum of the weights without their signs.
                let (more, less) = (41.0 / 32.0 / 8.0, 9.0 / 32.0 / 8.0);
                ([less, more], [more, less])
            }
            Reconstruct::Nearest | Reconstruct::Trilinear => return None,
        };
        let seen = match sees {
            // This one does not classify values at samples.
            VisibleValues::Shown if technique.classify == Classify::PreClassified => return None,
            VisibleValues::Shown => Seen::Shown(IntervalVisibility::new(
                technique.classify,
                &technique.table,
            )),
            VisibleValues::From(threshold) => Seen::From(threshold),
            VisibleValues::Larger => Seen::Larger,
            VisibleValues::Smaller => Seen::Smaller,
            VisibleValues::Every => return None,
        };
        let slope = rescale.slope as f32;
        let scaled = |multiples: [f32; 2]| multiples.map(|multiple| multiple * slope.abs());
        let (below, above) = if slope < 0.0 {
            (above, below)
        } else {
            (below, above)
        };
        // Some 30 operations of 2⁻²⁴ each, on weights that add up to 2 without their signs.
        let size = slope.abs() * bends.largest + rescale.intercept.abs() as f32;
        Some(Rejection {
            dims: of_cubic.bricks.dims().map(|n| n as i32),
            bends: bends.clone(),
            below: scaled(below),
            above: scaled(above),
            rounding: size / (1 << 17) as f32,
            seen,
        })
    }

    /// Where a sample at `position` may be seen, of those `asked`. `so_far` is the largest or smallest value of a ray, if the
    /// rule keeps one.
    #[inline(never)]
    pub fn may_be_seen<S: Level>(
        &self,
        values: &dyn Values<S>,
        position: Vec3s<S>,
        so_far: F32s<S>,
        asked: Mask<S>,
    ) -> Mask<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let shape = values.shape();
                let index = brick_number(self.dims, shape.cell(shape.clamp(position)));
                let words = bytemuck::cast_slice(&self.bends.words);
                let bends: I32s<S> = words_inside(words, index.shifted_up(2));
                let least = bends.shifted_up(16).as_bits();
                let most = bends.and(0xFFFF_0000_u32 as i32).as_bits();
                let linear = values.linear(position);
                let rounding = F32s::splat(self.rounding);
                let off = inlined(
                    #[inline(always)]
                    |[of_least, of_most]: [f32; 2]| {
                        least * F32s::splat(of_least) + most * F32s::splat(of_most) + rounding
                    },
                );
                let lo = linear - off(self.below);
                let hi = linear + off(self.above);
                asked
                    & match &self.seen {
                        Seen::Shown(between) => between.any(lo, hi),
                        Seen::From(threshold) => F32s::splat(*threshold).le(hi),
                        Seen::Larger => so_far.le(hi),
                        Seen::Smaller => lo.le(so_far),
                    }
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::lanes;
    use crate::levels::Portable;
    use crate::library::composite::{Rule, with_rule};
    use crate::library::reconstruct::values;
    use proptest::prelude::*;
    use strahl_scene::plan::Composite;
    use strahl_scene::{Scene, resolve};
    use strahl_volume::{Control, Grid, Metadata, Samples, Store};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        /// Values on either side of a threshold, of noise between two levels that are steep or almost alike.
        #[test]
        fn what_is_seen_is_never_rejected_and_much_of_the_rest_is(
            dims in [1usize..12, 1usize..12, 1usize..12],
            seed in any::<u32>(),
            height in prop_oneof![Just(1u32), Just(10), Just(200)],
            reconstruct in prop_oneof![
                Just(Reconstruct::BSpline),
                Just(Reconstruct::BSplineInterpolating),
                Just(Reconstruct::CatmullRom),
            ],
            slope in prop_oneof![Just(1.0), Just(-0.7)],
            threshold in 0f32..250.0,
        ) {
            let noise = |i: u32| (i.wrapping_add(seed)).wrapping_mul(2_654_435_761) >> 8;
            let number = dims.iter().product::<usize>() as u32;
            let voxels = (0..number).map(|i| (20 + noise(noise(i)) % height) as u8);
            let grid = Grid::centered(dims, glam::DVec3::ONE).unwrap();
            let rescale = Rescale::new(slope, 3.0);
            let volume =
                Volume::new(grid, Samples::U8(voxels.collect()), rescale, Metadata::default());
            let volume = volume.unwrap();
            let scene = Scene::parse("scene", "{}").unwrap();
            let mut plan = resolve(&scene, &volume.header(), None).unwrap();
            plan.field_mut().reconstruct = reconstruct;
            let coefficients = volume.b_spline_coefficients().unwrap();
            let read = match reconstruct {
                Reconstruct::BSplineInterpolating => &coefficients,
                _ => &volume,
            };
            let store = Store::default();
            let making = Making { store: &store, control: &Control::NONE, pool: None };
            let of_cubic = CubicBounds::new(&making, read).unwrap();
            let values = values::<Portable>(&grid, read.samples(), read.rescale(), reconstruct);
            let place = |axis: usize| {
                F32s::from_array(lanes(|lane| {
                    let part = noise(seed ^ (lane * 3 + axis) as u32) as f32 / (1 << 24) as f32;
                    part * dims[axis] as f32 - 0.5
                }))
            };
            let position = [place(0), place(1), place(2)];
            let found = values.at(position);
            let all = F32s::<Portable>::zero().le(F32s::zero());
            let yes = |mask: Mask<Portable>| mask.select(F32s::splat(1.0), F32s::zero());
            for composite in [
                Composite::FirstHit { threshold },
                Composite::Mip,
                Composite::Minip,
            ] {
                plan.technique_mut().composite = composite;
                let sees = with_rule!(composite, rule => rule.sees());
                let rejection = Rejection::new(&of_cubic, &plan, 0, read.rescale(), sees).unwrap();
                let so_far = F32s::splat(threshold);
                let seen = yes(rejection.may_be_seen(&*values, position, so_far, all));
                let is_seen = match composite {
                    Composite::Minip => found.le(so_far),
                    _ => so_far.le(found),
                };
                // How far two linear kernels and a cubic one can lie apart at all; coefficients, more than their values.
                let of_coefficients = reconstruct == Reconstruct::BSplineInterpolating;
                let most = height as f32 * if of_coefficients { 40.0 } else { 4.0 } + 1.0;
                for lane in 0..crate::lanes::LANES {
                    let (seen, is_seen) = (seen.lane(lane) > 0.0, yes(is_seen).lane(lane) > 0.0);
                    prop_assert!(seen || !is_seen, "{} rejected", found.lane(lane));
                    let is_far = (found.lane(lane) - threshold).abs() > most;
                    prop_assert!(is_seen || !seen || !is_far, "{} not rejected", found.lane(lane));
                }
            }
        }
    }
}
