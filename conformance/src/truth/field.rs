//! What is integrated: voxels under a reconstruction, or a formula.

use glam::DVec3;
use strahl_scene::plan::Reconstruct;
use strahl_volume::{Grid, Rescale, Samples, Volume};

/// A scalar field over the grid of a Plan.
pub trait Field {
    /// The value at a place in voxel space; not finite where there is none.
    fn value(&self, in_voxel: DVec3) -> f64;

    /// How much single precision may change a value, beside moving its place: a number of the size of
    /// the largest that are added on the way, times a few of its ulps. 0 by default.
    fn rounding(&self) -> f64 {
        0.0
    }
}

/// A formula over world space (RAS mm), placed on a grid.
pub struct Formula<F> {
    grid: Grid,
    value: F,
}

impl<F: Fn(DVec3) -> f64> Formula<F> {
    /// `value` of a place in world space.
    pub fn new(grid: Grid, value: F) -> Formula<F> {
        Formula { grid, value }
    }
}

impl<F: Fn(DVec3) -> f64> Field for Formula<F> {
    fn value(&self, in_voxel: DVec3) -> f64 {
        (self.value)(self.grid.world_from_voxel().transform_point3(in_voxel))
    }
}

/// The voxels of a volume, reconstructed as docs/plan.md says.
pub struct Voxels {
    dims: [usize; 3],
    /// What is stored; NaN for what renderers, in single precision, cannot hold.
    stored: Vec<f64>,
    rescale: Rescale,
    reconstruct: Reconstruct,
    rounding: f64,
}

impl Voxels {
    /// `volume` under `reconstruct`.
    pub fn new(volume: &Volume, reconstruct: Reconstruct) -> Voxels {
        let samples = volume.samples();
        let stored = |i: usize| {
            let stored = samples.get(i);
            if stored.abs() <= f64::from(f32::MAX) {
                stored
            } else {
                f64::NAN
            }
        };
        let stored: Vec<f64> = (0..samples.len()).map(stored).collect();
        let largest = stored.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let rescale = volume.rescale();
        // Numbers that f32 cannot hold are rounded before anything else.
        let inexact = match samples {
            Samples::U32(_) | Samples::I32(_) | Samples::F64(_) => 2.0,
            _ => 0.0,
        };
        let operations = match reconstruct {
            Reconstruct::Nearest => 2.0 + inexact,
            // Each linear step rounds three times, numbers up to twice the largest.
            Reconstruct::Trilinear => 14.0 + inexact,
            // Weights of some ten operations, 64 products and as many sums, of numbers that may cancel.
            Reconstruct::BSpline | Reconstruct::CatmullRom => 60.0 + inexact,
            Reconstruct::BSplineInterpolating => unreachable!("not covered"),
        };
        let size = rescale.slope.abs() * largest + rescale.intercept.abs();
        Voxels {
            dims: volume.grid().dims(),
            stored,
            rescale,
            reconstruct,
            rounding: size * operations * 0.5 * f64::from(f32::EPSILON),
        }
    }

    /// The stored numbers weighed with a kernel of the distance along each axis, which reaches less than 2.
    fn convolved(&self, place: [f64; 3], kernel: impl Fn(f64) -> f64) -> f64 {
        let low: [isize; 3] =
            std::array::from_fn(|a| (place[a] as isize).min(self.dims[a] as isize - 2).max(0));
        let mut sum = 0.0;
        for tap in 0..64 {
            let voxel: [isize; 3] = std::array::from_fn(|a| low[a] - 1 + (tap >> (2 * a) & 3));
            let weight: f64 = (0..3)
                .map(|a| kernel((place[a] - voxel[a] as f64).abs()))
                .product();
            let inside =
                std::array::from_fn(|a| voxel[a].clamp(0, self.dims[a] as isize - 1) as usize);
            sum += weight * self.at(inside);
        }
        sum
    }

    fn at(&self, [x, y, z]: [usize; 3]) -> f64 {
        self.stored[x + self.dims[0] * (y + self.dims[1] * z)]
    }
}

impl Field for Voxels {
    fn value(&self, in_voxel: DVec3) -> f64 {
        let dims = self.dims;
        let place: [f64; 3] = std::array::from_fn(|a| in_voxel[a].clamp(0.0, (dims[a] - 1) as f64));
        let stored = match self.reconstruct {
            Reconstruct::Nearest => self.at(place.map(|p| (p + 0.5).floor() as usize)),
            Reconstruct::Trilinear => {
                let low: [usize; 3] =
                    std::array::from_fn(|a| (place[a] as usize).min(dims[a].saturating_sub(2)));
                // Corners one axis after the other, z first.
                let mut corners: [f64; 8] = std::array::from_fn(|corner| {
                    self.at(std::array::from_fn(|a| {
                        (low[a] + (corner >> a & 1)).min(dims[a] - 1)
                    }))
                });
                for axis in [2, 1, 0] {
                    let part = place[axis] - low[axis] as f64;
                    for i in 0..1 << axis {
                        let (near, far) = (corners[i], corners[i + (1 << axis)]);
                        corners[i] = near + part * (far - near);
                    }
                }
                corners[0]
            }
            Reconstruct::BSpline => self.convolved(place, |x| match x {
                ..1.0 => 2.0 / 3.0 - x * x + 0.5 * x.powi(3),
                _ => (2.0 - x).max(0.0).powi(3) / 6.0,
            }),
            Reconstruct::CatmullRom => self.convolved(place, |x| match x {
                ..1.0 => 1.0 - 2.5 * x * x + 1.5 * x.powi(3),
                ..2.0 => 2.0 - 4.0 * x + 2.5 * x * x - 0.5 * x.powi(3),
                _ => 0.0,
            }),
            Reconstruct::BSplineInterpolating => unreachable!("not covered"),
        };
        self.rescale.value(stored)
    }

    fn rounding(&self) -> f64 {
        self.rounding
    }
}
