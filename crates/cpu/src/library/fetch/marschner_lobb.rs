use super::shape::Shape;
use super::voxels::Fetch;
use crate::lanes::{F32s, I32s, each, lanes};
use crate::levels::Level;
use std::f32::consts::TAU;

/// The test signal of S. Marschner and R. Lobb (Visualization 1994) with −1 to 1 over the voxel centers
/// along each axis:
/// ((1 − sin(πz/2)) + α·(1 + cos(2π·f·cos(π·√(x² + y²)/2)))) / (2·(1 + α)).
pub struct MarschnerLobb {
    pub shape: Shape,
    pub frequency: f32,
    pub alpha: f32,
}

impl<S: Level> Fetch<S> for MarschnerLobb {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Lane by lane.
    #[inline(never)]
    unsafe fn fetch(&self, voxel: [I32s<S>; 3]) -> F32s<S> {
        F32s::from_array(lanes(|i| {
            let voxel = each!(voxel, |axis| axis.lane(i) as usize);
            let [x, y, z] = [0, 1, 2].map(|axis: usize| {
                let last = self.shape.last[axis].max(1.0);
                2.0 * voxel[axis] as f32 / last - 1.0
            });
            let radius = (x * x + y * y).sqrt();
            let wave = (TAU * self.frequency * (0.25 * TAU * radius).cos()).cos();
            let slope = 1.0 - (0.25 * TAU * z).sin();
            (slope + self.alpha * (1.0 + wave)) / (2.0 * (1.0 + self.alpha))
        }))
    }
}
