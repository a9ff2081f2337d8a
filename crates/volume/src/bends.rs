//! How far from straight the voxels of each brick lie: what bounds the way from trilinear to cubic reconstruction.

use crate::bricks::{dims, touched};
use crate::rows::{for_each_row, made};
use crate::{Control, Error, Sample, Volume, Work, memory, with_samples};
use bytemuck::Zeroable;
use std::ops::Range;

/// Bounds of the second differences (v₋₁ − 2·v₀ + v₁ along an axis; beyond the border there is the voxel at the border
/// again) of a volume's stored numbers in each brick of `edge`³ cells, x fastest, as
/// [`Bricks`](crate::bricks::Bricks) has them: the smallest along x, y and z added up, at most 0, and the largest, at
/// least 0.
///
/// Along the axis the voxels count that the brick has, across it also those one further out, which kernels four
/// voxels wide read. Along an axis such a kernel that is exact for lines differs from linear interpolation by a multiple of
/// a mean of the second differences at both ends of the cell: the uniform cubic B-spline by 0 to 1/6, Catmull–Rom by
/// −1/8 to 0 of it.
///
/// On all cores (feature `threads`). A volume with numbers that are not finite gives anything.
///
/// ```
/// use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume, bends::bends};
/// let grid = Grid::centered([4, 1, 1], glam::DVec3::ONE)?;
/// let samples = Samples::U8(vec![5, 6, 7, 3]);
/// let volume = Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default())?;
/// assert_eq!(bends(&volume, 4), [[-5.0, 4.0]]);
/// # Ok::<(), strahl_volume::Error>(())
/// ```
///
/// # Panics
/// If `edge` is 0.
pub fn bends(volume: &Volume, edge: usize) -> Vec<[f32; 2]> {
    made(bends_under(volume, edge, &Control::NONE, |bounds| bounds))
}

/// What `of` makes of them, under `control`.
///
/// # Errors
/// It was cancelled; no memory.
///
/// # Panics
/// If `edge` is 0.
pub fn bends_under<T: Zeroable + Send>(
    volume: &Volume,
    edge: usize,
    control: &Control,
    of: impl Fn([f32; 2]) -> T + Sync,
) -> Result<Vec<T>, Error> {
    assert!(edge > 0, "bricks of no cells");
    let voxels = volume.grid().dims();
    let dims = dims(voxels, edge);
    let mut of_bricks = memory::zeroed(dims.iter().product())?;
    let of_row = |row: usize, of_bricks: &mut [T]| {
        let mut bounds = vec![[0.0; 2]; of_bricks.len()];
        let at = [row % dims[1], row / dims[1]];
        with_samples!(volume.samples(), samples => {
            let block = Block::new(samples, voxels, [1, 2].map(|axis| {
                touched(at[axis - 1], edge, 2, voxels[axis])
            }));
            let own = [1, 2].map(|axis| touched(at[axis - 1], edge, 0, voxels[axis]));
            let wide = [1, 2].map(|axis| touched(at[axis - 1], edge, 1, voxels[axis]));
            block.bends(edge, &own, &wide, &mut bounds);
        });
        for (into, bounds) in of_bricks.iter_mut().zip(bounds) {
            *into = of(bounds);
        }
    };
    let parts = control.parts(Work::Preparing, dims[1] * dims[2]);
    for_each_row(&mut of_bricks, dims[0], &parts, of_row)?;
    Ok(of_bricks)
}

/// The rows of voxels around a row of bricks.
struct Block {
    /// Voxels along x.
    nx: usize,
    /// Rows along y and z.
    rows: [Range<usize>; 2],
    /// Number of rows of the volume along y and z.
    voxels: [usize; 2],
    numbers: Vec<f32>,
}

impl Block {
    fn new<T: Sample>(samples: &[T], [nx, ny, nz]: [usize; 3], rows: [Range<usize>; 2]) -> Block {
        let mut numbers = Vec::with_capacity(nx * rows[0].len() * rows[1].len());
        for z in rows[1].clone() {
            for y in rows[0].clone() {
                let row = &samples[nx * (y + ny * z)..][..nx];
                numbers.extend(row.iter().map(|sample| sample.to_f32()));
            }
        }
        Block {
            nx,
            rows,
            voxels: [ny, nz],
            numbers,
        }
    }

    /// The row at (y, z), moved by as much along each axis, but not beyond the border.
    fn row(&self, at: [usize; 2], by: [isize; 2]) -> &[f32] {
        let [y, z] = [0, 1].map(|axis| {
            let moved = at[axis].saturating_add_signed(by[axis]);
            moved.min(self.voxels[axis] - 1) - self.rows[axis].start
        });
        &self.numbers[self.nx * (y + self.rows[0].len() * z)..][..self.nx]
    }

    /// Those of each brick of the row, which has the voxels of the rows `own`, `wide` with one more on either side.
    fn bends(
        &self,
        edge: usize,
        own: &[Range<usize>; 2],
        wide: &[Range<usize>; 2],
        of_bricks: &mut [[f32; 2]],
    ) {
        let mut bounds = [(); 3].map(|()| Bounds::new(self.nx));
        for z in wide[1].clone() {
            for y in wide[0].clone() {
                let at = [y, z];
                let row = self.row(at, [0, 0]);
                bounds[0].add_along(row);
                if own[0].contains(&y) {
                    bounds[1].add(self.row(at, [-1, 0]), row, self.row(at, [1, 0]));
                }
                if own[1].contains(&z) {
                    bounds[2].add(self.row(at, [0, -1]), row, self.row(at, [0, 1]));
                }
            }
        }
        for (brick, of_brick) in of_bricks.iter_mut().enumerate() {
            for (axis, bounds) in bounds.iter().enumerate() {
                let further = usize::from(axis > 0);
                let [least, most] = bounds.of(touched(brick, edge, further, self.nx));
                of_brick[0] += least;
                of_brick[1] += most;
            }
        }
    }
}

/// Bounds of second differences in each column of voxels, and 0.
struct Bounds {
    least: Vec<f32>,
    most: Vec<f32>,
}

impl Bounds {
    fn new(nx: usize) -> Bounds {
        Bounds {
            least: vec![0.0; nx],
            most: vec![0.0; nx],
        }
    }

    /// Adds those from row to row.
    fn add(&mut self, before: &[f32], row: &[f32], behind: &[f32]) {
        let bounds = self.least.iter_mut().zip(&mut self.most);
        for (((least, most), before), (here, behind)) in
            bounds.zip(before).zip(row.iter().zip(behind))
        {
            let bend = before - 2.0 * here + behind;
            *least = if bend < *least { bend } else { *least };
            *most = if bend > *most { bend } else { *most };
        }
    }

    /// Adds those along a row.
    fn add_along(&mut self, row: &[f32]) {
        let last = row.len() - 1;
        for x in [0, last] {
            let bend = row[x.saturating_sub(1)] - 2.0 * row[x] + row[(x + 1).min(last)];
            self.least[x] = self.least[x].min(bend);
            self.most[x] = self.most[x].max(bend);
        }
        if last >= 2 {
            let mut inner = Bounds {
                least: std::mem::take(&mut self.least),
                most: std::mem::take(&mut self.most),
            };
            let bounds = inner.least[1..last]
                .iter_mut()
                .zip(&mut inner.most[1..last]);
            for ((least, most), around) in bounds.zip(row.windows(3)) {
                let bend = around[0] - 2.0 * around[1] + around[2];
                *least = if bend < *least { bend } else { *least };
                *most = if bend > *most { bend } else { *most };
            }
            *self = inner;
        }
    }

    fn of(&self, columns: Range<usize>) -> [f32; 2] {
        [
            self.least[columns.clone()]
                .iter()
                .copied()
                .fold(0.0, f32::min),
            self.most[columns].iter().copied().fold(0.0, f32::max),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, Metadata, Rescale, Samples};
    use proptest::prelude::*;

    /// The definition, voxel by voxel.
    fn brute_force(volume: &Volume, edge: usize, brick: [usize; 3]) -> [f32; 2] {
        let n = volume.grid().dims();
        let at = |voxel: [isize; 3]| {
            let voxel = [0, 1, 2].map(|a| voxel[a].clamp(0, n[a] as isize - 1) as usize);
            volume
                .samples()
                .get(voxel[0] + n[0] * (voxel[1] + n[1] * voxel[2])) as f32
        };
        let mut bounds = [0.0; 2];
        for axis in 0..3 {
            let (mut least, mut most) = (0f32, 0f32);
            let range = |a: usize| touched(brick[a], edge, usize::from(a != axis), n[a]);
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        let here = [x, y, z].map(|v| v as isize);
                        let moved = |by: isize| {
                            let mut there = here;
                            there[axis] += by;
                            at(there)
                        };
                        let bend = moved(-1) - 2.0 * at(here) + moved(1);
                        (least, most) = (least.min(bend), most.max(bend));
                    }
                }
            }
            bounds[0] += least;
            bounds[1] += most;
        }
        bounds
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn bends_are_those_of_all_voxels_that_count(
            voxels in [1usize..14, 1usize..14, 1usize..14],
            seed in any::<u32>(),
            is_byte in any::<bool>(),
            edge in prop_oneof![Just(2), Just(4), Just(8)],
        ) {
            let count = voxels.iter().product::<usize>() as u32;
            let noise = (0..count).map(|i| (i ^ seed).wrapping_mul(2_654_435_761) >> 16);
            let samples = if is_byte {
                Samples::U8(noise.map(|n| n as u8).collect())
            } else {
                Samples::F32(noise.map(|n| n as f32 - 3e4).collect())
            };
            let grid = Grid::centered(voxels, glam::DVec3::ONE).unwrap();
            let volume =
                Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap();
            let dims = voxels.map(|n| (n - 1).div_ceil(edge).max(1));
            let found = bends(&volume, edge);
            prop_assert_eq!(found.len(), dims.iter().product::<usize>());
            for (i, found) in found.into_iter().enumerate() {
                let brick = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                prop_assert_eq!(found, brute_force(&volume, edge, brick));
            }
        }
    }
}
