//! Samples that wait until every lane can light one.

use crate::lanes::{F32s, I32s, LANES, Mask, Vec3s, each, lanes, to_rows};
use crate::levels::{Level, inlined};

/// Samples that are to be lit, in the order of each ray.
pub(super) struct UnlitSamples {
    pub(super) number: usize,
    /// Position (voxel space), value, share of the pixel, ray.
    samples: [[f32; UnlitSamples::MOST]; 6],
    to_eye: [[f32; LANES]; 3],
    /// The color of each ray so far.
    sums: [[f32; 4]; LANES],
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

    /// As many as there are lanes, or all.
    #[inline(always)]
    pub(super) fn batch<S: Level>(&self) -> Batch<S> {
        let [a, b, c, d, e, f] = &self.samples;
        let number = self.number.min(LANES);
        let lane = F32s::from_array(lanes(|i| i as f32));
        let ray: I32s<S> = F32s::from_start(f).to_i32s();
        Batch {
            number,
            asked: lane.lt(F32s::splat(number as f32)),
            position: [
                F32s::from_start(a),
                F32s::from_start(b),
                F32s::from_start(c),
            ],
            value: F32s::from_start(d),
            share: F32s::from_start(e),
            to_eye: each!(&self.to_eye, |part| F32s::picked(part, ray)),
            ray,
        }
    }

    /// Adds the samples of `batch`, which have this `color`, to their rays, and drops them.
    #[inline(always)]
    pub(super) fn add<S: Level>(&mut self, batch: &Batch<S>, color: Vec3s<S>) {
        let [r, g, b] = each!(color, |c| batch.share * c);
        let seen = to_rows([r, g, b, F32s::zero()]);
        let rays = batch.ray.to_array();
        for (seen, ray) in seen.iter().zip(rays).take(batch.number) {
            let sum = &mut self.sums[ray as usize % LANES];
            for (sum, seen) in sum.iter_mut().zip(seen) {
                *sum += seen;
            }
        }
        self.number -= batch.number;
        if batch.number == LANES {
            for numbers in &mut self.samples {
                numbers.copy_within(LANES..2 * LANES, 0);
            }
        }
    }

    /// The colors that the rays have come to.
    #[inline(always)]
    pub(super) fn colors<S: Level>(&self) -> Vec3s<S> {
        let channel = inlined(
            #[inline(always)]
            |c: usize| F32s::from_array(lanes(|lane| self.sums[lane][c])),
        );
        each!([0, 1, 2], |c| channel(c))
    }
}

/// Samples that are lit at once.
pub(super) struct Batch<S: Level> {
    pub(super) number: usize,
    /// Which lanes have one. The others have an old one, or 0: a place in the volume and a ray all the same.
    pub(super) asked: Mask<S>,
    /// In voxel space.
    pub(super) position: Vec3s<S>,
    pub(super) value: F32s<S>,
    pub(super) to_eye: Vec3s<S>,
    /// Of the pixel.
    share: F32s<S>,
    ray: I32s<S>,
}
