//! Min/max bricks: what range of numbers a block of a volume can give, the basis of skipping.

use crate::{Grid, Sample, Samples, Volume, with_samples};

/// The smallest and the largest number that reconstruction can find in each brick of a volume.
///
/// A brick is a block of [`edge`](Bricks::edge)³ *cells* (a cell lies between eight neighbouring voxels),
/// so that its range covers the voxels of its far faces too, which the next brick has as well.
/// Cell `i` of an axis spans the positions i to i + 1 in voxel space; positions in the outer half
/// voxel belong to the first and the last cell, an axis of a single voxel has a single cell.
/// Trilinear and nearest reconstruction, clamped at the border, stay within the range (up to the
/// rounding of the interpolation itself, which the user of the range has to allow for).
///
/// Numbers are stored numbers as [`Sample::to_f32`] gives them. NaN voxels are left out: a cell with
/// a NaN corner gives NaN wherever it is sampled trilinearly.
///
/// Memory with the usual edge is 8 bytes per 512 voxels: 1.6 % of a `u8` volume, 0.8 % of an `i16` one.
///
/// ```
/// use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume, bricks::Bricks};
/// let grid = Grid::centred([3, 1, 1], glam::DVec3::ONE)?;
/// let volume = Volume::new(grid, Samples::U8(vec![7, 9, 4]), Rescale::IDENTITY, Metadata::default())?;
/// let bricks = Bricks::new(&volume);
/// assert_eq!(bricks.dims(), [1, 1, 1]);
/// assert_eq!((bricks.range([0, 0, 0]).lo, bricks.range([0, 0, 0]).hi), (4.0, 9.0));
/// # Ok::<(), strahl_volume::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bricks {
    edge: usize,
    dims: [usize; 3],
    ranges: Vec<BrickRange>,
}

/// The numbers of a brick, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickRange {
    /// The smallest number; +∞ if there is none but NaN.
    pub lo: f32,
    /// The largest number; −∞ if there is none but NaN.
    pub hi: f32,
}

impl BrickRange {
    /// The range of no number at all.
    pub const EMPTY: BrickRange = BrickRange {
        lo: f32::INFINITY,
        hi: f32::NEG_INFINITY,
    };

    /// Whether the brick holds nothing but NaN.
    pub fn is_empty(&self) -> bool {
        self.lo > self.hi
    }
}

impl Bricks {
    /// The usual number of cells along the edge of a brick. Smaller bricks skip closer to the surface but cost more to
    /// walk through and to keep; 8 is the size that most renderers have settled on.
    pub const EDGE: usize = 8;

    /// The bricks of `volume`, on all cores (feature `threads`).
    pub fn new(volume: &Volume) -> Bricks {
        Bricks::with_edge(volume, Self::EDGE)
    }

    /// Bricks of `edge`³ cells. Half the edge is eight times the memory: for edge 4 12.5 % of a `u8`
    /// volume.
    ///
    /// # Panics
    /// If `edge` is not a power of two.
    pub fn with_edge(volume: &Volume, edge: usize) -> Bricks {
        Bricks::of(volume.grid(), volume.samples(), edge)
    }

    fn of(grid: &Grid, samples: &Samples, edge: usize) -> Bricks {
        assert!(edge.is_power_of_two(), "bricks of {edge} cells");
        let voxels = grid.dims();
        let dims = voxels.map(|n| (n - 1).div_ceil(edge).max(1));
        let mut ranges = vec![BrickRange::EMPTY; dims.iter().product()];
        with_samples!(samples, s => fill(edge, voxels, dims, s, &mut ranges));
        Bricks { edge, dims, ranges }
    }

    /// Cells along the edge of these bricks.
    pub fn edge(&self) -> usize {
        self.edge
    }

    /// Number of bricks along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The range of brick (x, y, z).
    ///
    /// # Panics
    /// If there is no such brick.
    pub fn range(&self, [x, y, z]: [usize; 3]) -> BrickRange {
        let [nx, ny, nz] = self.dims;
        assert!(
            x < nx && y < ny && z < nz,
            "brick ({x}, {y}, {z}) outside {:?}",
            self.dims
        );
        self.ranges[x + nx * (y + ny * z)]
    }

    /// All ranges, x fastest.
    pub fn ranges(&self) -> &[BrickRange] {
        &self.ranges
    }
}

/// One row of bricks (along x) after the other: first the range over y and z of every voxel column,
/// then along x. The long inner loops run over neighbouring voxels and vectorise.
fn fill<T: Sample>(
    edge: usize,
    voxels: [usize; 3],
    dims: [usize; 3],
    samples: &[T],
    ranges: &mut [BrickRange],
) {
    let [nx, ny, nz] = voxels;
    let row_of_bricks = |row: usize, ranges: &mut [BrickRange]| {
        let (by, bz) = (row % dims[1], row / dims[1]);
        let mut columns = vec![BrickRange::EMPTY; nx];
        for z in touched(edge, bz, nz) {
            for y in touched(edge, by, ny) {
                let start = nx * (y + ny * z);
                for (column, voxel) in columns.iter_mut().zip(&samples[start..start + nx]) {
                    let stored = voxel.to_f32();
                    // Written so that NaN changes neither end.
                    column.lo = if stored < column.lo {
                        stored
                    } else {
                        column.lo
                    };
                    column.hi = if stored > column.hi {
                        stored
                    } else {
                        column.hi
                    };
                }
            }
        }
        for (bx, range) in ranges.iter_mut().enumerate() {
            for column in &columns[touched(edge, bx, nx)] {
                range.lo = range.lo.min(column.lo);
                range.hi = range.hi.max(column.hi);
            }
        }
    };
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        ranges
            .par_chunks_mut(dims[0])
            .enumerate()
            .for_each(|(row, ranges)| row_of_bricks(row, ranges));
    }
    #[cfg(not(feature = "threads"))]
    for (row, ranges) in ranges.chunks_mut(dims[0]).enumerate() {
        row_of_bricks(row, ranges);
    }
}

/// The voxels at the corners of the cells of brick `brick` on an axis of `n` voxels.
fn touched(edge: usize, brick: usize, n: usize) -> std::ops::Range<usize> {
    let first = brick * edge;
    first..(first + edge + 1).min(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition, voxel by voxel.
    fn brute_force(
        edge: usize,
        voxels: [usize; 3],
        samples: &Samples,
        brick: [usize; 3],
    ) -> BrickRange {
        let mut range = BrickRange::EMPTY;
        for z in 0..voxels[2] {
            for y in 0..voxels[1] {
                for x in 0..voxels[0] {
                    let inside = [x, y, z]
                        .iter()
                        .zip(brick)
                        .all(|(&v, b)| v >= edge * b && v <= edge * b + edge);
                    let stored = samples.get(x + voxels[0] * (y + voxels[1] * z)) as f32;
                    if inside && !stored.is_nan() {
                        range.lo = range.lo.min(stored);
                        range.hi = range.hi.max(stored);
                    }
                }
            }
        }
        range
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn ranges_are_those_of_all_corner_voxels(
            voxels in [1usize..20, 1usize..20, 1usize..20],
            seed in any::<u32>(),
            float in any::<bool>(),
            edge in prop_oneof![Just(4), Just(8), Just(16)],
        ) {
            let count = voxels.iter().product::<usize>() as u32;
            let noise = (0..count).map(|i| (i ^ seed).wrapping_mul(2_654_435_761) >> 16);
            let samples = if float {
                Samples::F32(noise.map(|n| if n % 5 == 0 { f32::NAN } else { n as f32 - 3e4 }).collect())
            } else {
                Samples::I16(noise.map(|n| n as i16).collect())
            };
            let grid = Grid::centred(voxels, glam::DVec3::ONE).unwrap();
            let bricks = Bricks::of(&grid, &samples, edge);
            for z in 0..bricks.dims()[2] {
                for y in 0..bricks.dims()[1] {
                    for x in 0..bricks.dims()[0] {
                        prop_assert_eq!(
                            bricks.range([x, y, z]),
                            brute_force(edge, voxels, &samples, [x, y, z])
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn number_of_bricks_covers_every_cell() {
        for (voxels, bricks) in [(1, 1), (2, 1), (9, 1), (10, 2), (17, 2), (18, 3)] {
            let grid = Grid::centred([voxels, 1, 1], glam::DVec3::ONE).unwrap();
            let made = Bricks::of(&grid, &Samples::U8(vec![0; voxels]), 8);
            assert_eq!(made.dims(), [bricks, 1, 1], "{voxels} voxels");
        }
    }

    #[test]
    fn nothing_but_nan_is_an_empty_range() {
        let grid = Grid::centred([2, 2, 2], glam::DVec3::ONE).unwrap();
        let bricks = Bricks::of(&grid, &Samples::F64(vec![f64::NAN; 8]), 8);
        assert!(bricks.range([0, 0, 0]).is_empty());
    }
}
