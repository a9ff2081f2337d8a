//! The ray loops through several volumes: at each lattice point their looks are mixed.

use super::packet::Packet;
use crate::lanes::{F32s, Mask, each};
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::{Rule, back_to_front, emission_absorption, with_rule};
use crate::scenery::Look;
use strahl_scene::plan::MOST_LAYERS;

impl<S: Level> Packet<'_, S> {
    /// Through several volumes, in the order of the rule: at each lattice point their looks are mixed.
    #[inline(never)]
    pub(super) fn through_several(&mut self) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.through_several_here(),
        );
    }

    #[inline(always)]
    fn through_several_here(&mut self) {
        let rays = self.rays;
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let is_back_to_front = with_rule!(self.scenery.composite, rule => rule.is_back_to_front());
        let (mut k, end, mut live) = self.stand();
        let mut shows = [Mask::none(); MOST_LAYERS];
        while live.any() {
            let (at, jump) = if is_back_to_front {
                let at = rays.count - one - k;
                self.inside_each(at, &mut shows);
                (at, zero)
            } else {
                (k, self.jump_over_all(k, &mut shows))
            };
            let empty = live & zero.lt(jump);
            if empty.any() {
                let next = empty.select((k + jump).min(rays.count), k);
                self.skipped += next - k;
                k = next;
                live = live & k.lt(end);
                continue;
            }
            let look = self.mixed(at, live, &shows);
            let Surface { color, opacity } = look.surface;
            k = live.select(k + one, k);
            live = live & k.lt(end);
            if !look.visible.any() {
                continue;
            }
            if is_back_to_front {
                back_to_front::add(&mut self.state, look.visible, color, opacity);
            } else {
                emission_absorption::add(&mut self.state, look.visible, color, opacity);
            }
            self.visible += look.visible.select(one, zero);
            live = live & !self.done();
        }
        self.k = k;
    }

    /// Which rays are inside each volume at lattice point `k`.
    #[inline(always)]
    fn inside_each(&self, k: F32s<S>, inside: &mut [Mask<S>; MOST_LAYERS]) {
        for (line, inside) in self.rays.lines.iter().zip(inside) {
            *inside = line.first.le(k) & k.lt(line.end);
        }
    }

    /// How many lattice points from `k` on show nothing of any volume; and which volumes may show something at `k`.
    #[inline(always)]
    fn jump_over_all(&self, k: F32s<S>, shows: &mut [Mask<S>; MOST_LAYERS]) -> F32s<S> {
        let mut jump = self.rays.count - k;
        let objects = self.scenery.objects.iter().zip(&self.rays.lines);
        for ((object, line), shows) in objects.zip(shows) {
            let inside = line.first.le(k) & k.lt(line.end);
            let before = k.lt(line.first);
            *shows = inside;
            let own = match &object.skip {
                Some(skip) if inside.any() => {
                    let position = line.position(k + self.rays.jitter);
                    let jump = skip.jump(object.values.shape(), line, position);
                    *shows = inside & !F32s::zero().lt(jump);
                    // Behind its last point it shows nothing either.
                    let to_end = (line.end - k).le(jump);
                    to_end.select(self.rays.count - k, jump)
                }
                _ => F32s::zero(),
            };
            let elsewhere = before.select(line.first - k, self.rays.count - k);
            jump = jump.min(inside.select(own, elsewhere));
        }
        jump.max(F32s::zero())
    }

    /// The looks of all volumes at lattice point `k`, mixed so that their order does not matter:
    /// A = 1 − Π(1 − aᵢ), C = Σ aᵢ·cᵢ / Σ aᵢ, which is exact for short steps. Only those that `shows` is set for are
    /// looked at.
    #[inline(always)]
    fn mixed(&mut self, k: F32s<S>, live: Mask<S>, shows: &[Mask<S>; MOST_LAYERS]) -> Look<S> {
        let one = F32s::splat(1.0);
        let (mut color, mut opacities, mut passes) = ([F32s::zero(); 3], F32s::zero(), one);
        let mut visible = Mask::none();
        let objects = self.scenery.objects.iter().zip(&self.rays.lines);
        for ((object, line), &shows) in objects.zip(shows) {
            let shown = live & shows;
            if !shown.any() {
                continue;
            }
            let look = self.look(object, line.position(k + self.rays.jitter), shown);
            let opacity = look.visible.select(look.surface.opacity, F32s::zero());
            for (sum, c) in color.iter_mut().zip(look.surface.color) {
                *sum += look.visible.select(c * opacity, F32s::zero());
            }
            opacities += opacity;
            passes = passes * (one - opacity);
            visible = visible | look.visible;
        }
        // Most lattice points show nothing, and divisions take long.
        if !visible.any() {
            return Look::nothing();
        }
        let divisor = F32s::zero().lt(opacities).select(opacities, one);
        Look {
            surface: Surface {
                color: each!(color, |c| c.over(divisor)),
                opacity: one - passes,
            },
            visible,
        }
    }
}
