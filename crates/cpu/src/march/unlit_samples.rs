//! Samples that wait until every lane can light one.

use crate::lanes::{F32s, LANES, Mask, Vec3s, each, lanes, to_rows};
use crate::levels::Level;

/// Samples that are to be lit, in the order of each ray.
pub(super) struct UnlitSamples {
    pub(super) number: usize,
    /// Position (voxel space), value, share of the pixel, ray.
    samples: [[f32; UnlitSamples::MOST]; 6],
    pub(super) to_eye: [[f32; LANES]; 3],
    /// The color of each ray so far.
    pub(super) sums: [[f32; 4]; LANES],
}

impl UnlitSamples {
    /// One less than those that are lit at once, those of one step, and what appending writes behind them.
    pub(super) const MOST: usize = 3 * LANES;

    #[inline(always)]
    pub(super) fn new<S: Level>(to_eye: Vec3s<S>, [r, g, b]: Vec3s<S>) -> UnlitSamples {
        UnlitSamples {
            number: 0,
            samples: [[0.0; UnlitSamples::MOST]; 6],
            to_eye: each!(to_eye, |part| part.to_array()),
            sums: to_rows([r, g, b, F32s::zero()]),
        }
    }

    #[inline(always)]
    pub(super) fn push<S: Level>(
        &mut self,
        position: Vec3s<S>,
        value: F32s<S>,
        share: F32s<S>,
        visible: Mask<S>,
    ) {
        let ray = F32s::from_array(lanes(|i| i as f32));
        let [x, y, z] = position;
        let to = &mut self.samples;
        let at = self.number;
        let [a, b, c, d, e, f] = to;
        visible.append(x, a, at);
        visible.append(y, b, at);
        visible.append(z, c, at);
        visible.append(value, d, at);
        visible.append(share, e, at);
        visible.append(ray, f, at);
        self.number += visible.count() as usize;
    }

    #[inline(always)]
    pub(super) fn first<S: Level>(&self) -> [F32s<S>; 6] {
        let [a, b, c, d, e, f] = &self.samples;
        [
            F32s::from_start(a),
            F32s::from_start(b),
            F32s::from_start(c),
            F32s::from_start(d),
            F32s::from_start(e),
            F32s::from_start(f),
        ]
    }

    #[inline(always)]
    pub(super) fn drop_first(&mut self, number: usize) {
        self.number -= number;
        if number == LANES {
            for numbers in &mut self.samples {
                numbers.copy_within(LANES..2 * LANES, 0);
            }
        }
    }
}
