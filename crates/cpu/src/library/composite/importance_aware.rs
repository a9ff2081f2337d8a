//! Importance-aware compositing (F. de Moura Pinto and C. M. D. S. Freitas 2010): what is more important than all before it
//! shines through.

use super::rule::{Rule, Sample};
use super::state::State;
use crate::elementary::{exp_of_negative, ln_of_share, powers_of_share};
use crate::lanes::{F32s, Mask, Vec3s, dot, each, length, scale, unit};
use crate::levels::{Level, inlined, vectorized};
use crate::library::classify::Surface;
use crate::scenery::Look;

/// By a measure of importance. Of a [`State`] it uses `color` and `alpha`, and `value`, the importance so far.
#[derive(Clone, Copy)]
pub struct ImportanceAware {
    pub measure: u32,
    pub gain: f32,
    pub first: f32,
    pub second: f32,
    pub third: f32,
    pub full_per_mm: f32,
    pub low: f32,
    pub high: f32,
}

impl ImportanceAware {
    /// Whether the importance of a sample hangs on its gradient.
    fn is_of_gradient(&self) -> bool {
        !(3..=5).contains(&self.measure)
    }

    /// What is to be added of `sample`, with its importance; `None` if nothing.
    #[inline(always)]
    fn look<S: Level>(
        &self,
        state: &mut State<S>,
        sample: &Sample<S>,
    ) -> Option<(Look<S>, F32s<S>)> {
        let object = sample.crossing.object;
        let zero = F32s::zero();
        let mut normal = state.last_normal;
        if !object.is_of_single_samples() {
            let (mut look, gradient) = match self.is_of_gradient() {
                true => sample.look_and_gradient(&mut normal),
                false => (sample.look(&mut normal), [zero; 3]),
            };
            state.last_normal = normal;
            if !look.visible.any() {
                return None;
            }
            let own = self.importance(sample, gradient) * F32s::splat(self.gain);
            look.visible = look.visible & !is_negligible(state, own);
            return Some((look, own));
        }
        // What is negligible needs no light, which takes longest.
        let shown = sample.sampled & zero.lt(object.table.opacity_at(sample.value));
        if !shown.any() {
            return None;
        }
        let gradient = match self.is_of_gradient() {
            true => sample.gradient(shown),
            false => [zero; 3],
        };
        let own = self.importance(sample, gradient) * F32s::splat(self.gain);
        let visible = shown & !is_negligible(state, own);
        if !visible.any() {
            return None;
        }
        let mut surface = object.table.at(sample.value);
        if !object.shading.is_unlit() {
            surface = match self.is_of_gradient() {
                true => sample.shade_by(surface, gradient, visible, &mut normal),
                false => sample
                    .crossing
                    .shade(surface, sample.position, visible, &mut normal),
            };
        }
        surface.opacity = object.of_step(surface.opacity);
        Some((Look { surface, visible }, own))
    }

    /// The importance of samples before the gain, by their gradients where it hangs on them.
    #[inline(never)]
    fn importance<S: Level>(&self, sample: &Sample<S>, gradient: Vec3s<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let (zero, one) = (F32s::zero(), F32s::splat(1.0));
                if self.measure == 4 {
                    return one;
                }
                if self.measure == 5 {
                    let places = &sample.crossing.scenery.important_places;
                    return match places {
                        Some(places) => places.at(sample.position),
                        None => zero,
                    };
                }
                if self.measure == 3 {
                    let share = (sample.value - F32s::splat(self.low))
                        .over(F32s::splat(self.high - self.low));
                    return share.max(zero).min(one);
                }
                let steepness = length(gradient)
                    .over(F32s::splat(self.full_per_mm))
                    .max(zero)
                    .min(one);
                if self.measure == 0 {
                    return steepness;
                }
                let (normal, has_normal) = unit(gradient);
                let cosine = dot(normal, *sample.crossing.to_eye);
                let facing = has_normal.select(cosine.max(-cosine).min(one), zero);
                self.of_surface(steepness, facing)
            },
        )
    }

    /// That of a place of this steepness; `facing` is the cosine of its normal to the eye.
    #[inline(always)]
    fn of_surface<S: Level>(&self, steepness: F32s<S>, facing: F32s<S>) -> F32s<S> {
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let power = inlined(
            #[inline(always)]
            |x: F32s<S>, e: f32| powers_of_share(x, F32s::splat(e)),
        );
        if self.measure == 2 {
            return F32s::splat(3.0)
                - power(facing, self.first)
                - power(facing, self.second)
                - power(one - steepness, self.third);
        }
        let (slant, begin) = (one - facing, F32s::splat(self.second));
        let width = self.third - self.second;
        let ramp = match width == 0.0 {
            true => begin.le(slant).select(one, zero),
            false => (slant - begin).over(F32s::splat(width)),
        };
        let ramp = ramp.max(zero).min(one);
        power(steepness, self.first) * ramp * ramp * (F32s::splat(3.0) - ramp - ramp)
    }
}

/// What is seen so far, and how important it is.
pub struct Accumulated<S: Level> {
    /// Premultiplied.
    pub color: Vec3s<S>,
    pub alpha: F32s<S>,
    pub importance: F32s<S>,
}

impl<S: Level> Accumulated<S> {
    /// Adds samples of this color, premultiplied, opacity, above 0, and importance where `visible`: section 4 of the
    /// paper.
    #[inline(always)]
    pub fn add(&mut self, visible: Mask<S>, color: Vec3s<S>, opacity: F32s<S>, own: F32s<S>) {
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let rise = own - self.importance;
        let is_more = visible & zero.lt(rise);
        // How much of what lies before may still be seen.
        let rest = exp_of_negative((-rise).min(zero));
        let is_hidden = is_more & (one - self.alpha).lt(one - rest);
        let kept = is_hidden.select(rest.over(is_hidden.select(self.alpha, one)), one);
        let passing = one - opacity;
        let modulated = kept * self.alpha * passing + opacity;
        let alpha = self.alpha * passing + opacity;
        let ratio = alpha.over(visible.select(modulated, one));
        let behind = one - kept * self.alpha;
        let mixed = each!([0, 1, 2], |c| {
            (kept * self.color[c] + behind * color[c]) * ratio
        });
        let accumulated = own + ln_of_share(opacity + passing * rest);
        self.color = visible.select3(mixed, self.color);
        self.alpha = visible.select(alpha, self.alpha);
        self.importance = is_more.select(self.importance.max(accumulated), self.importance);
    }
}

impl Rule for ImportanceAware {
    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        let Some((look, own)) = self.look(state, sample) else {
            return Mask::none();
        };
        let Surface { color, opacity } = look.surface;
        let mut seen = Accumulated {
            color: state.color,
            alpha: state.alpha,
            importance: state.value,
        };
        // Shading may have left nothing of it.
        let adding = look.visible & F32s::zero().lt(opacity);
        seen.add(adding, scale(color, opacity), opacity, own);
        (state.color, state.alpha, state.value) = (seen.color, seen.alpha, seen.importance);
        look.visible
    }

    /// Where next to nothing more would be seen of whatever comes.
    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        let most = if self.measure == 2 { 3.0 } else { 1.0 };
        is_negligible(state, F32s::splat(self.gain * most))
    }
}

/// Below this share of light nothing is seen.
const LEAST_LIGHT: f32 = 1.0 / 256.0;

/// Where next to nothing would be seen of a sample that is `own` important: too little light passes, and it asks for no
/// more. It asks for 1 − e^−rise, which is below `rise`.
#[inline(always)]
fn is_negligible<S: Level>(state: &State<S>, own: F32s<S>) -> Mask<S> {
    let least = F32s::splat(LEAST_LIGHT);
    (F32s::splat(1.0) - state.alpha).lt(least) & (own - state.value).lt(least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::Portable;

    fn white(alpha: f32, importance: f32) -> Accumulated<Portable> {
        Accumulated {
            color: [F32s::splat(alpha); 3],
            alpha: F32s::splat(alpha),
            importance: F32s::splat(importance),
        }
    }

    /// Adds something black.
    fn add(seen: &mut Accumulated<Portable>, opacity: f32, importance: f32) {
        let (opacity, own) = (F32s::splat(opacity), F32s::splat(importance));
        seen.add(!Mask::none(), [F32s::zero(); 3], opacity, own);
    }

    fn near(got: F32s<Portable>, expected: f64) {
        let got = f64::from(got.lane(0));
        assert!((got - expected).abs() < 2e-6, "{got} instead of {expected}");
    }

    #[test]
    fn a_worked_example() {
        let mut seen = white(0.9, 0.0);
        add(&mut seen, 0.5, 1.0);
        near(seen.alpha, 0.95);
        near(seen.importance, 0.620_115);
        // White before black: what is left of it is m · A · A_new / A', with m 0.408755 and A' 0.683940.
        near(seen.color[0], 0.408_755 * 0.9 * 0.95 / 0.683_940);
    }

    #[test]
    fn importance_never_decreases_and_opacity_is_that_of_emission_and_absorption() {
        let mut seen = white(0.0, 0.0);
        let (mut passing, mut before) = (1.0f64, 0.0f32);
        for i in 0..200u32 {
            let [opacity, importance] = [97, 61].map(|n| (i * n % 41) as f32 / 41.0);
            if opacity == 0.0 {
                continue;
            }
            add(&mut seen, 0.2 * opacity, 3.0 * importance);
            passing *= 1.0 - f64::from(0.2 * opacity);
            near(seen.alpha, 1.0 - passing);
            assert!(seen.importance.lane(0) >= before);
            before = seen.importance.lane(0);
            assert!((-1e-6..=1.0 + 1e-5).contains(&seen.color[0].lane(0)));
        }
        assert!(before > 2.0);
    }

    #[test]
    fn equal_importance_is_emission_and_absorption() {
        let mut seen = white(0.6, 2.0);
        add(&mut seen, 0.5, 2.0);
        near(seen.color[0], 0.6);
        near(seen.importance, 2.0);
        add(&mut seen, 1.0, 1.0);
        near(seen.importance, 2.0);
    }
    #[test]
    fn opaque_samples_show_what_lies_before_by_the_modulation_factor() {
        // Of opaque samples C = m·C + (1 − m·A)·C_s: here of white, with m = e^−1 and A = 1, before black.
        let mut seen = white(1.0, 0.0);
        add(&mut seen, 1.0, 1.0);
        near(seen.color[0], (-1.0f64).exp());
        near(seen.alpha, 1.0);
        near(seen.importance, 1.0);
    }

    fn rule(measure: u32, [first, second, third]: [f32; 3]) -> ImportanceAware {
        ImportanceAware {
            measure,
            gain: 2.0,
            first,
            second,
            third,
            full_per_mm: 1.0,
            low: 0.0,
            high: 1.0,
        }
    }

    #[test]
    fn silhouettes_and_lighting_are_their_formulas() {
        let smoothstep = |from: f64, to: f64, x: f64| {
            let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        // Both orientations of the ramp; the values are those of the source.
        for parameters in [[0.4f32, 0.2, 0.6], [0.1, 0.5, 0.2], [0.4, 0.5, 0.2]] {
            let [p1, p2, p3] = parameters.map(f64::from);
            for step in 0..=20 {
                let (steepness, facing) = (0.05 * f64::from(step), 1.0 - 0.045 * f64::from(step));
                let [steep, cosine] = [steepness, facing].map(|n| F32s::splat(n as f32));
                let silhouette = steepness.powf(p1) * smoothstep(p2, p3, 1.0 - facing);
                near(rule(1, parameters).of_surface(steep, cosine), silhouette);
                let lit = 3.0 - facing.powf(p1) - facing.powf(p2) - (1.0 - steepness).powf(p3);
                near(rule(2, parameters).of_surface(steep, cosine), lit);
            }
        }
        // A ramp without width is a step.
        let step =
            |facing| rule(1, [0.0, 0.5, 0.5]).of_surface(F32s::splat(1.0), F32s::splat(facing));
        near(step(0.6), 0.0);
        near(step(0.4), 1.0);
    }

    #[test]
    fn a_ray_ends_only_where_nothing_more_important_can_come() {
        let ends = |measure: u32, alpha: f32, importance: f32| {
            let state = State::<Portable> {
                alpha: F32s::splat(alpha),
                value: F32s::splat(importance),
                ..State::start(0.0)
            };
            rule(measure, [1.0; 3]).done(&state).any()
        };
        // The gain is 2: up to 2, and by lighting up to 6.
        assert!(ends(0, 0.999, 2.0) && !ends(0, 0.999, 1.9) && !ends(0, 0.99, 2.0));
        assert!(ends(2, 0.999, 6.0) && !ends(2, 0.999, 2.0));
    }
}
