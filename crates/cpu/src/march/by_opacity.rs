//! One sample for one, two or four lattice points, as the opacity around allows, with any functions;
//! [`Packet::through_voxels`] does the same for what most pictures are made of.

use super::Packet;
use crate::lanes::F32s;
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;
use crate::library::composite::emission_absorption;
use crate::scenery::Object;
use crate::strides::{Strides, of_stride};

impl<S: Level> Packet<'_, S> {
    /// Front to back through one volume by strides; how many lattice points each ray has walked.
    #[inline(never)]
    pub(super) fn by_strides(&mut self, object: &Object<S>, strides: &Strides) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.by_strides_here(object, strides),
        )
    }

    #[inline(always)]
    fn by_strides_here(&mut self, object: &Object<S>, strides: &Strides) -> F32s<S> {
        let (rays, line) = (self.rays, &self.rays.lines[0]);
        let (zero, one) = (F32s::zero(), F32s::splat(1.0));
        let shape = object.values.shape();
        let longest = Strides::longest(line);
        let mut last_alpha = zero;
        let mut k = zero;
        let mut live = k.lt(rays.count);
        while live.any() {
            let position = line.position(k + rays.jitter);
            if let Some(next) = self.behind_nothing(object, position, k, live) {
                k = next;
                live = live & k.lt(rays.count);
                continue;
            }
            let cell = shape.cell(shape.clamp(position));
            let longest = longest.min(rays.count - k);
            let stride = strides.at(
                strides.most_opacity(cell),
                live,
                self.state.alpha,
                &mut last_alpha,
                longest,
            );
            let sampled = object.clips.keep(position, live);
            if sampled.any() {
                let value = self.value(object, position, sampled);
                let sampled = sampled & value.is_finite();
                let look = self.classified(object, value, position, sampled);
                let Surface { colour, opacity } = look.surface;
                let opacity = of_stride(opacity, stride);
                emission_absorption::add(&mut self.state, look.visible, colour, opacity);
                self.visible += look.visible.select(one, zero);
            }
            k = live.select(k + stride, k);
            live = live & k.lt(rays.count) & !self.done();
        }
        k
    }
}
