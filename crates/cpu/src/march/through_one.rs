//! The ray loop through one volume with any functions.

use super::packet::Packet;
use super::unlit_samples::UnlitSamples;
use crate::lanes::{F32s, Mask};
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::average::Average;
use crate::library::composite::back_to_front;
use crate::library::composite::emission_absorption::EmissionAbsorption;
use crate::library::composite::gmip::Gmip;
use crate::library::composite::mida::Mida;
use crate::library::composite::{Crossing, Rule, Sample, State, with_rule};
use crate::scenery::Object;
use strahl_scene::plan::Composite;

/// The rule of a Plan, chosen at every step.
#[derive(Clone, Copy)]
struct Chosen(Composite);

impl Rule for Chosen {
    fn is_back_to_front(&self) -> bool {
        with_rule!(self.0, rule => rule.is_back_to_front())
    }

    #[inline(always)]
    fn start<S: Level>(&self) -> State<S> {
        with_rule!(self.0, rule => rule.start())
    }

    #[inline(always)]
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S> {
        with_rule!(self.0, rule => rule.add(state, sample))
    }

    #[inline(always)]
    fn done<S: Level>(&self, state: &State<S>) -> Mask<S> {
        with_rule!(self.0, rule => rule.done(state))
    }

    #[inline(always)]
    fn finish<S: Level>(&self, state: &mut State<S>, rays: &Crossing<S>) {
        with_rule!(self.0, rule => rule.finish(state, rays));
    }
}

impl<S: Level> Packet<'_, S> {
    /// Through one volume, in the order of the rule. Those that draw many samples of every ray have a loop of their own;
    /// a loop for each would take longer to compile than it saves.
    #[inline(always)]
    pub(super) fn through_one(&mut self, object: &Object<S>) {
        match self.scenery.composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => {
                let rule = EmissionAbsorption {
                    stop_at_transmittance,
                };
                if S::HAS_LOOPS_PER_TYPE && object.is_lit_apart() {
                    self.through_one_lit(object, rule);
                } else {
                    self.through_one_by(object, rule);
                }
            }
            Composite::BackToFront => self.through_one_backwards(object),
            Composite::Mida {
                low,
                high,
                blend,
                stop_at_transmittance,
            } => self.through_one_by(
                object,
                Mida {
                    low,
                    high,
                    blend,
                    stop_at_transmittance,
                },
            ),
            Composite::Average => self.through_one_by(object, Average),
            Composite::Gmip { white_per_mm } => {
                self.through_one_by(object, Gmip { white_per_mm });
            }
            other => self.through_one_by(object, Chosen(other)),
        }
    }

    #[inline(never)]
    fn through_one_by(&mut self, object: &Object<S>, rule: impl Rule) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                self.through_one_here(
                    object,
                    rule,
                    #[inline(always)]
                    move |_, state, sample| rule.add(state, sample),
                );
            },
        );
    }

    /// The same picture: opacities add up at once, and lit samples are collected until every lane has one.
    #[inline(never)]
    fn through_one_lit(&mut self, object: &Object<S>, rule: EmissionAbsorption) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut waiting = UnlitSamples::new(self.to_eye, self.state.color);
                self.through_one_here(
                    object,
                    rule,
                    #[inline(always)]
                    |packet, state, sample| {
                        packet.collect(object, &mut state.alpha, &mut waiting, sample)
                    },
                );
                self.light_all(object, &mut waiting);
            },
        );
    }

    /// `add` adds a sample to the state of the rays and says for which of them it showed something.
    #[inline(always)]
    fn through_one_here(
        &mut self,
        object: &Object<S>,
        rule: impl Rule,
        mut add: impl FnMut(&Self, &mut State<S>, &Sample<S>) -> Mask<S>,
    ) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let to_eye = self.to_eye;
        let crossing = Crossing {
            scenery: self.scenery,
            object,
            packet: rays,
            to_eye: &to_eye,
        };
        let is_back_to_front = rule.is_back_to_front();
        let strides = object.strides.as_ref().filter(|_| !is_back_to_front);
        let mut strides = strides.map(|strides| strides.along(line, self.last_alpha));
        // What changes at every lattice point is held here: in `self` it would be written to memory each time.
        let mut state = self.state;
        let (mut taken, mut visible, mut skipped) = (self.sampled, self.visible, self.skipped);
        let (mut k, end, mut live) = self.stand();
        while live.any() {
            let at = if is_back_to_front {
                rays.count - one - k
            } else {
                k
            };
            let position = line.position(at + rays.jitter);
            if let Some(next) = self.behind_nothing(object, position, k, live) {
                skipped += next - k;
                k = next;
                live = live & k.lt(end);
                continue;
            }
            let sampled = object.clips.keep(position, live);
            let (moving, sampled) =
                Self::moving_and_sampled(object, position, state.value, live, sampled);
            let stride = match &mut strides {
                Some(strides) => {
                    let shape = object.values.shape();
                    let cell = shape.cell(shape.clamp(position));
                    strides.at(cell, moving, state.alpha, rays.count - k)
                }
                None => one,
            };
            if sampled.any() {
                taken += sampled.select(one, zero);
                let value = object.values.at(position);
                let sample = Sample {
                    crossing,
                    k: at,
                    stride,
                    position,
                    value,
                    // What is not finite is no value: no rule counts it.
                    sampled: sampled & value.is_finite(),
                };
                visible += add(self, &mut state, &sample).select(one, zero);
            }
            k = moving.select(k + stride, k);
            live = live & k.lt(end) & !rule.done(&state);
        }
        self.state = state;
        (self.sampled, self.visible, self.skipped) = (taken, visible, skipped);
        self.k = k;
        if let Some(strides) = strides {
            self.last_alpha = strides.last_alpha;
        }
    }

    /// From the last lattice point to the first. No point is skipped and no ray ends early, so this loop asks for less.
    #[inline(never)]
    fn through_one_backwards(&mut self, object: &Object<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || self.through_one_backwards_here(object),
        );
    }

    #[inline(always)]
    fn through_one_backwards_here(&mut self, object: &Object<S>) {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let one = F32s::splat(1.0);
        let (mut k, end, mut live) = self.stand();
        while live.any() {
            let at = rays.count - one - k;
            let look = self.look(object, line.position(at + rays.jitter), live);
            let Surface { color, opacity } = look.surface;
            back_to_front::add(&mut self.state, look.visible, color, opacity);
            self.visible += look.visible.select(one, F32s::zero());
            k = live.select(k + one, k);
            live = live & k.lt(end);
        }
        self.k = k;
    }
}
