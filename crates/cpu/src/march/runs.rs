//! Where rays stand among the segments of a label volume.

use crate::lanes::{F32s, Mask, Vec3s, each};
use crate::levels::{Level, vectorized};
use crate::library::composite::LUMINANCE;
use crate::library::composite::importance_aware::Accumulated;
use crate::segment_numbers::SegmentNumbers;
use strahl_scene::plan::GlobalRule;

/// Where rays stand among segments, and what the runs that have ended add up to.
#[derive(Clone, Copy)]
pub struct Runs<S: Level> {
    /// The number of the segment, counted from 1; 0 before the first.
    pub segment: F32s<S>,
    /// Its technique, counted from 1; 0 where it is hidden or the ray is complete, and
    /// [`FINISHED`](crate::segment_looks::FINISHED) where nothing of the run is left to be added.
    pub technique: F32s<S>,
    /// Its group, counted from 1; 0 where it is in none.
    pub group: F32s<S>,
    /// What runs without a group, and groups, add up to.
    pub all: Sum<S>,
    /// What the runs of the group add up to so far.
    pub of_group: Sum<S>,
    /// The importance of the places of the run so far …
    pub by_place: F32s<S>,
    /// … and that of the places of the group's earlier runs.
    pub group_by_place: F32s<S>,
    /// Lattice coordinate of the first hit among the runs …
    pub place: F32s<S>,
    /// … if there was one: 1.
    pub has_place: F32s<S>,
}

/// What runs add up to.
#[derive(Clone, Copy)]
pub struct Sum<S: Level> {
    /// Premultiplied.
    pub color: Vec3s<S>,
    /// Opacity.
    pub alpha: F32s<S>,
    /// What the rule remembers of them: the largest luminance, or the importance so far …
    pub weight: F32s<S>,
    /// … and the number of those that are not transparent, or whether there was one: 1.
    pub number: F32s<S>,
}

/// A run of each ray that has ended.
pub struct Run<S: Level> {
    /// Premultiplied, with the tint of its segment.
    pub color: Vec3s<S>,
    pub alpha: F32s<S>,
    /// Of its segment.
    pub importance: F32s<S>,
}

impl<S: Level> Runs<S> {
    /// Those of rays that have not begun.
    #[inline(always)]
    pub fn none() -> Runs<S> {
        Runs {
            segment: F32s::zero(),
            technique: F32s::zero(),
            group: F32s::zero(),
            all: Sum::none(),
            of_group: Sum::none(),
            by_place: F32s::zero(),
            group_by_place: F32s::zero(),
            place: F32s::zero(),
            has_place: F32s::zero(),
        }
    }

    /// Where nothing behind can be seen.
    #[inline(always)]
    pub fn are_complete(&self, segments: &SegmentNumbers) -> Mask<S> {
        let passing = F32s::splat(1.0) - self.all.alpha;
        match segments.rule {
            GlobalRule::EmissionAbsorption {
                stop_at_transmittance,
            } => passing.lt(F32s::splat(stop_at_transmittance)) | passing.le(F32s::zero()),
            GlobalRule::Mip | GlobalRule::Average => Mask::none(),
            GlobalRule::First => F32s::zero().lt(self.all.number),
            GlobalRule::ImportanceAware => {
                let is_opaque = passing.lt(F32s::splat(1.0 / 256.0));
                is_opaque & F32s::splat(segments.most_important).le(self.all.weight)
            }
        }
    }

    /// Adds `run` of the rays `of` to what their groups add up to, or to all.
    #[inline(always)]
    pub fn add(&mut self, segments: &SegmentNumbers, of: Mask<S>, run: &Run<S>) {
        if segments.groups.is_empty() {
            return self.all.add(segments.rule, of, run);
        }
        self.all
            .add(segments.rule, of & self.group.eq(F32s::zero()), run);
        for (i, group) in segments.groups.iter().enumerate() {
            let own = of & self.group.eq(F32s::splat(1.0 + i as f32));
            if own.any() {
                self.of_group.add(group.rule, own, run);
                let most = self.group_by_place.max(self.by_place);
                self.group_by_place = own.select(most, self.group_by_place);
            }
        }
    }

    /// Makes one sample of each group in which the rays `of` are, and adds it to all.
    #[inline(never)]
    pub fn end_groups(&mut self, segments: &SegmentNumbers, of: Mask<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                for (i, group) in segments.groups.iter().enumerate() {
                    let own = of & self.group.eq(F32s::splat(1.0 + i as f32));
                    if !own.any() {
                        continue;
                    }
                    let (color, alpha) = self.of_group.pixel(group.rule);
                    let opacity = F32s::splat(group.opacity);
                    let sample = Run {
                        color: each!(color, |c| c * opacity),
                        alpha: alpha * opacity,
                        importance: F32s::splat(group.importance) + self.group_by_place,
                    };
                    self.all.add(segments.rule, own, &sample);
                    self.of_group = Sum::select(own, &Sum::none(), &self.of_group);
                    self.group_by_place = own.select(F32s::zero(), self.group_by_place);
                    self.group = own.select(F32s::zero(), self.group);
                }
            },
        );
    }

    /// The opacity of all that rays have met.
    #[inline(never)]
    pub fn opacity(&self, segments: &SegmentNumbers) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let one = F32s::splat(1.0);
                let (_, all) = self.all.pixel(segments.rule);
                let mut passing = one - all.min(one);
                for (i, group) in segments.groups.iter().enumerate() {
                    let own = self.group.eq(F32s::splat(1.0 + i as f32));
                    let (_, of_group) = self.of_group.pixel(group.rule);
                    passing = own.select(passing * (one - of_group.min(one)), passing);
                }
                one - passing
            },
        )
    }
}

impl<S: Level> Sum<S> {
    #[inline(always)]
    pub fn none() -> Sum<S> {
        Sum {
            color: [F32s::zero(); 3],
            alpha: F32s::zero(),
            weight: F32s::zero(),
            number: F32s::zero(),
        }
    }

    #[inline(always)]
    fn select(mask: Mask<S>, yes: &Sum<S>, no: &Sum<S>) -> Sum<S> {
        Sum {
            color: mask.select3(yes.color, no.color),
            alpha: mask.select(yes.alpha, no.alpha),
            weight: mask.select(yes.weight, no.weight),
            number: mask.select(yes.number, no.number),
        }
    }

    /// Adds `run` where `of` says so and where it is not transparent.
    #[inline(always)]
    pub fn add(&mut self, rule: GlobalRule, of: Mask<S>, run: &Run<S>) {
        let Run {
            color,
            alpha,
            importance,
        } = *run;
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let of = of & zero.lt(alpha);
        match rule {
            GlobalRule::EmissionAbsorption { .. } => {
                let passing = one - self.alpha;
                for (sum, color) in self.color.iter_mut().zip(color) {
                    *sum += of.select(passing * color, zero);
                }
                self.alpha += of.select(passing * alpha, zero);
            }
            GlobalRule::Mip => {
                let [r, g, b] = each!([0, 1, 2], |c| color[c] * F32s::splat(LUMINANCE[c]));
                let luminance = r + g + b;
                let better = of & self.weight.lt(luminance);
                self.color = better.select3(color, self.color);
                self.alpha = better.select(alpha, self.alpha);
                self.weight = better.select(luminance, self.weight);
            }
            GlobalRule::Average => {
                self.color = each!([0, 1, 2], |c| self.color[c] + of.select(color[c], zero));
                self.alpha += of.select(alpha, zero);
                self.number += of.select(one, zero);
            }
            GlobalRule::First => {
                let first = of & self.number.le(zero);
                self.color = first.select3(color, self.color);
                self.alpha = first.select(alpha, self.alpha);
                self.number = first.select(one, self.number);
            }
            GlobalRule::ImportanceAware => {
                let mut seen = Accumulated {
                    color: self.color,
                    alpha: self.alpha,
                    importance: self.weight,
                };
                seen.add(of, color, alpha, importance);
                (self.color, self.alpha, self.weight) = (seen.color, seen.alpha, seen.importance);
            }
        }
    }

    /// The color, premultiplied, and the opacity that they come to.
    #[inline(always)]
    pub fn pixel(&self, rule: GlobalRule) -> (Vec3s<S>, F32s<S>) {
        match rule {
            GlobalRule::Average => {
                let number = self.number.max(F32s::splat(1.0));
                let color = each!(self.color, |c| c.over(number));
                (color, self.alpha.over(number))
            }
            _ => (self.color, self.alpha),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;

    /// The pixel of a red run that hides 0.4, a transparent one, and a brighter green one that hides 0.5.
    fn pixel(rule: GlobalRule, importances: [f32; 2]) -> [f32; 3] {
        let mut runs = Sum::<Portable>::none();
        for (color, alpha, importance) in [
            ([0.4, 0.0, 0.0], 0.4, importances[0]),
            ([0.0; 3], 0.0, 9.0),
            ([0.0, 0.5, 0.0], 0.5, importances[1]),
        ] {
            let run = Run {
                color: color.map(F32s::splat),
                alpha: F32s::splat(alpha),
                importance: F32s::splat(importance),
            };
            runs.add(rule, !Mask::none(), &run);
        }
        let ([r, g, _], alpha) = runs.pixel(rule);
        [r, g, alpha].map(|number| number.lane(0))
    }

    #[test]
    fn each_rule_makes_the_pixel_that_it_says() {
        let plain = GlobalRule::EmissionAbsorption {
            stop_at_transmittance: 0.0,
        };
        let importance = GlobalRule::ImportanceAware;
        // Of importance 3 behind 0: vis 1 − e^−3 is more than the 0.6 that pass, so m = e^−3 / 0.4.
        let kept = (-3.0f32).exp() / 0.4;
        let ratio = 0.7 / (kept * 0.4 * 0.5 + 0.5);
        let important = [kept * 0.4 * ratio, (1.0 - kept * 0.4) * 0.5 * ratio, 0.7];
        for (rule, importances, expected) in [
            (plain, [0.0; 2], [0.4, 0.6 * 0.5, 0.7]),
            (GlobalRule::Mip, [0.0; 2], [0.0, 0.5, 0.5]),
            (GlobalRule::Average, [0.0; 2], [0.2, 0.25, 0.45]),
            (GlobalRule::First, [0.0; 2], [0.4, 0.0, 0.4]),
            (importance, [0.0; 2], [0.4, 0.6 * 0.5, 0.7]),
            (importance, [0.0, 3.0], important),
        ] {
            let found = pixel(rule, importances);
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-5,
                    "{rule:?}: {found} instead of {expected}"
                );
            }
        }
    }
}
