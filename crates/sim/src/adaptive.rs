//! Adaptive distance sampling: over how many steps opacity may be interpolated instead of read (document §3.3).
//!
//! Per voxel, the largest radius (at most 7) within which dropping samples and interpolating opacity linearly keeps the
//! error of the integral below a bound, checked along the three axes and the four cube diagonals only, as the document
//! says; so a ray in another direction may see a larger error.

use crate::stages::classify::Tables;
use crate::stages::fetch::Voxels;
use rayon::prelude::*;

/// The largest leap.
pub const MOST_STEPS: i32 = 7;

const DIRECTIONS: [[i32; 3]; 7] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 1],
    [-1, 1, 1],
    [1, -1, 1],
    [1, 1, -1],
];

/// Radius of every voxel, in steps.
#[derive(Clone, Debug)]
pub struct RadiusStore {
    dims: [i32; 3],
    steps: Vec<u8>,
}

impl RadiusStore {
    /// For an error of at most `bound` opacity words, summed over a leap; none if `bound` is 0.
    pub fn new(bound: u32, voxels: &Voxels, tables: &Tables, step: f64) -> Option<RadiusStore> {
        if bound == 0 {
            return None;
        }
        let dims = voxels.dims();
        let opacity = |at: [i32; 3]| {
            let word = u32::from(voxels.word(at));
            tables.opacity(word, word) as i32
        };
        let plane = dims[0] * dims[1];
        let steps = (0..plane * dims[2])
            .into_par_iter()
            .map(|i| {
                let at = [i % dims[0], i / dims[0] % dims[1], i / plane].map(|c| c as i32);
                let radius = (2..=MOST_STEPS)
                    .take_while(|r| fits(&opacity, at, *r, bound as i32))
                    .last()
                    .unwrap_or(1);
                (f64::from(radius) / step)
                    .floor()
                    .clamp(1.0, f64::from(MOST_STEPS)) as u8
            })
            .collect();
        Some(RadiusStore {
            dims: dims.map(|n| n as i32),
            steps,
        })
    }

    /// How many steps may be interpolated from a cell; 1 outside.
    #[inline]
    pub fn steps(&self, [x, y, z]: [i32; 3]) -> u8 {
        let [nx, ny, nz] = self.dims;
        if (x as u32) < nx as u32 && (y as u32) < ny as u32 && (z as u32) < nz as u32 {
            self.steps[x as usize + nx as usize * (y as usize + ny as usize * z as usize)]
        } else {
            1
        }
    }
}

/// Whether along all directions, both ways, the straight line over `radius` voxels differs from what lies between by no
/// more than `bound` in sum.
fn fits(opacity: &impl Fn([i32; 3]) -> i32, at: [i32; 3], radius: i32, bound: i32) -> bool {
    let here = opacity(at);
    DIRECTIONS.iter().all(|direction| {
        [1, -1].into_iter().all(|way| {
            let along = |k: i32| opacity(std::array::from_fn(|i| at[i] + way * k * direction[i]));
            let end = along(radius);
            let error: i32 = (1..radius)
                .map(|k| (radius * along(k) - (radius - k) * here - k * end).abs())
                .sum();
            error <= bound * radius
        })
    })
}
