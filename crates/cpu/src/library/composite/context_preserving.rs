//! Context-preserving rendering (S. Bruckner, S. Grimm, A. Kanitsar and M. E. Gröller 2005): what is flat, brightly lit, near
//! and not yet covered becomes transparent.

use super::LUMINANCE;
use super::emission_absorption::{self, EmissionAbsorption};
use super::rule::{Rule, Sample};
use super::state::State;
use crate::elementary::{power, powers_of_share};
use crate::lanes::{F32s, Mask, Vec3s, each, length};
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;

/// The opacity of a surface by how it lies to the light and to the eye.
#[derive(Clone, Copy)]
pub struct ContextPreserving {
    pub cut_depth: f32,
    pub cut_sharpness: f32,
    pub full_per_mm: f32,
    pub nearest_mm: f32,
    pub farthest_mm: f32,
    pub stop_at_transmittance: f32,
    pub covered_by: u32,
}

impl ContextPreserving {
    /// What is kept of the opacity of a surface of this steepness, 0 to 1, in this light: equation 4 of the paper. `far` is
    /// 0 for the nearest place and 1 for the farthest, `passing` the share of light that comes through what lies before it.
    #[inline(always)]
    fn kept<S: Level>(
        &self,
        steepness: F32s<S>,
        light: F32s<S>,
        far: F32s<S>,
        passing: F32s<S>,
    ) -> F32s<S> {
        let one = F32s::splat(1.0);
        let cut = F32s::splat(self.cut_depth) * light * (one - far) * passing;
        powers_of_share(steepness, power(cut, self.cut_sharpness))
    }

    /// Color and opacity of one step of the samples `visible`, where those are classified as `surface`.
    #[inline(never)]
    fn look<S: Level>(
        &self,
        sample: &Sample<S>,
        surface: Surface<S>,
        visible: Mask<S>,
        passing: F32s<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let (zero, one) = (F32s::zero(), F32s::splat(1.0));
                let crossing = &sample.crossing;
                let mut lit = Surface {
                    color: [one; 3],
                    opacity: surface.opacity,
                };
                let gradient = sample.gradient(visible);
                let object = crossing.object;
                if !object.shading.is_unlit() {
                    let (position, to_eye) = (sample.position, *crossing.to_eye);
                    lit = object.light_by(lit, gradient, position, to_eye, visible, last_normal);
                }
                let [r, g, b] = each!([0, 1, 2], |c| lit.color[c] * F32s::splat(LUMINANCE[c]));
                let light = (r + g + b).max(zero);
                let steepness = length(gradient).over(F32s::splat(self.full_per_mm));
                let way = crossing.distance_mm(sample.place()) - F32s::splat(self.nearest_mm);
                let far = way.over(F32s::splat(self.farthest_mm - self.nearest_mm));
                let kept = self.kept(
                    steepness.max(zero).min(one),
                    light,
                    far.max(zero).min(one),
                    passing,
                );
                let color = each!([0, 1, 2], |c| surface.color[c] * lit.color[c]);
                Surface {
                    color: sample.illustrate(color, gradient, visible),
                    opacity: crossing.object.of_step(lit.opacity * kept),
                }
            },
        )
    }
}

/// Of a [`State`] it uses `color` and `alpha`, and `value`, the opacity of what lies before the run.
impl Rule for ContextPreserving {
    #[inline(always)]
    fn is_covered_by_ray(&self) -> bool {
        self.covered_by == 1
    }

    #[inline(always)]
    fn start_behind<S: Level>(&self, opacity: F32s<S>) -> State<S> {
        State {
            value: opacity,
            ..State::start(0.0)
        }
    }

    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let object = sample.crossing.object;
        let surface = object.classify(sample.value, sample.position, sample.sampled);
        let visible = sample.sampled & F32s::zero().lt(surface.opacity);
        if visible.any() {
            let mut normal = state.last_normal;
            let one = F32s::splat(1.0);
            let passing = (one - state.alpha) * (one - state.value);
            let Surface { color, opacity } =
                self.look(sample, surface, visible, passing, &mut normal);
            state.last_normal = normal;
            emission_absorption::add(state, visible, color, opacity);
        }
        visible
    }

    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        let stop_at_transmittance = self.stop_at_transmittance;
        EmissionAbsorption {
            stop_at_transmittance,
        }
        .done(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;

    fn kept(cut_depth: f32, cut_sharpness: f32, [steepness, light, far, alpha]: [f32; 4]) -> f32 {
        let rule = ContextPreserving {
            cut_depth,
            cut_sharpness,
            full_per_mm: 1.0,
            nearest_mm: 0.0,
            farthest_mm: 1.0,
            stop_at_transmittance: 0.0,
            covered_by: 0,
        };
        let all = F32s::<Portable>::splat;
        rule.kept(all(steepness), all(light), all(far), all(1.0 - alpha))
            .lane(0)
    }

    #[test]
    fn a_worked_example() {
        // κt 3, κs 0.8: base 1.944, exponent 1.70199.
        let factor = kept(3.0, 0.8, [0.25, 0.9, 0.2, 0.1]);
        assert!((factor - 0.094_471_3).abs() < 2e-6, "{factor}");
        assert!((0.8 * factor - 0.075_577).abs() < 2e-6);
    }

    #[test]
    fn its_limits() {
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-5, "{a} {b}");
        // Without sharpness the exponent is 1: the gradient alone.
        near(kept(3.0, 0.0, [0.3, 0.9, 0.2, 0.1]), 0.3);
        near(kept(0.0, 0.0, [0.3, 0.9, 0.2, 0.1]), 0.3);
        // A sharp cut lies where the base crosses 1.
        near(kept(3.0, 20.0, [0.3, 0.9, 0.2, 0.1]), 0.0);
        near(kept(3.0, 20.0, [0.3, 0.2, 0.2, 0.1]), 1.0);
        // Flat places vanish, unless nothing is asked of them: far away, covered, dark, or no cut.
        near(kept(3.0, 0.8, [0.0, 0.9, 0.2, 0.1]), 0.0);
        for args in [
            [0.0, 0.9, 1.0, 0.1],
            [0.0, 0.9, 0.2, 1.0],
            [0.0, 0.0, 0.2, 0.1],
        ] {
            near(kept(3.0, 0.8, args), 1.0);
        }
        near(kept(0.0, 0.8, [0.0, 0.9, 0.2, 0.1]), 1.0);
        near(kept(100.0, 20.0, [1.0, 1000.0, 0.0, 0.0]), 1.0);
    }
}
