//! Min/max bricks: what range of numbers a block of a volume can give, the basis of skipping.

use crate::rows::{for_each_row, made};
use crate::{
    Cancelled, ContentId, Control, Error, Grid, Key, Sample, Samples, Volume, Work, memory,
    with_samples,
};
use bytemuck::Zeroable;
use std::ops::Range;

/// The smallest and the largest number that reconstruction can find in each brick of a volume.
///
/// A brick is a block of [`edge`](Bricks::edge)³ *cells* (a cell lies between eight neighboring voxels),
/// so that its range covers the voxels of its far faces too, which the next brick has as well.
/// Cell `i` of an axis spans the positions i to i + 1 in voxel space; positions in the outer half
/// voxel belong to the first and the last cell, an axis of a single voxel has a single cell.
/// Trilinear and nearest reconstruction, clamped at the border, stay within the range (up to the
/// rounding of the interpolation itself, which the user of the range has to allow for).
///
/// Numbers are stored numbers as [`Sample::to_f32`] gives them. NaN voxels are left out: a cell with
/// a NaN corner gives NaN wherever it is sampled trilinearly.
///
/// Ranges of 8- and 16-bit samples are kept as such, others in single precision: with the usual edge two samples
/// per 512 voxels, 0.4 % of the volume.
///
/// ```
/// use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume, bricks::Bricks};
/// let grid = Grid::centered([3, 1, 1], glam::DVec3::ONE)?;
/// let volume = Volume::new(grid, Samples::U8(vec![7, 9, 4]), Rescale::IDENTITY, Metadata::default())?;
/// let bricks = Bricks::new(&volume);
/// assert_eq!(bricks.dims(), [1, 1, 1]);
/// assert_eq!((bricks.range([0, 0, 0]).lo, bricks.range([0, 0, 0]).hi), (4.0, 9.0));
/// # Ok::<(), strahl_volume::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bricks {
    edge: usize,
    reach: usize,
    dims: [usize; 3],
    ranges: Ranges,
}

/// The smallest and the largest number of each brick.
#[derive(Clone, Debug)]
enum Ranges {
    U8(Vec<[u8; 2]>),
    I8(Vec<[i8; 2]>),
    U16(Vec<[u16; 2]>),
    I16(Vec<[i16; 2]>),
    F32(Vec<[f32; 2]>),
}

impl Ranges {
    fn number(&self) -> usize {
        match self {
            Ranges::U8(ranges) => ranges.len(),
            Ranges::I8(ranges) => ranges.len(),
            Ranges::U16(ranges) => ranges.len(),
            Ranges::I16(ranges) => ranges.len(),
            Ranges::F32(ranges) => ranges.len(),
        }
    }

    fn get(&self, brick: usize) -> BrickRange {
        let [lo, hi] = match self {
            Ranges::U8(ranges) => ranges[brick].map(f32::from),
            Ranges::I8(ranges) => ranges[brick].map(f32::from),
            Ranges::U16(ranges) => ranges[brick].map(f32::from),
            Ranges::I16(ranges) => ranges[brick].map(f32::from),
            Ranges::F32(ranges) => ranges[brick],
        };
        BrickRange { lo, hi }
    }
}

/// Key of the bricks of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct BricksKey {
    volume: ContentId,
    edge: usize,
    reach: usize,
}

impl BricksKey {
    /// Those that [`Bricks::with_reach`] makes.
    pub fn new(volume: &Volume, edge: usize, reach: usize) -> BricksKey {
        BricksKey {
            volume: volume.id(),
            edge,
            reach,
        }
    }
}

impl Key for BricksKey {
    type Value = Bricks;

    const NAME: &str = "bricks";

    fn bytes(&self, value: &Bricks) -> usize {
        size_of::<(BricksKey, Bricks)>() + value.bytes()
    }
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

    /// The numbers of both, and those between.
    pub fn joined(self, other: BrickRange) -> BrickRange {
        BrickRange {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }

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

    /// Bricks of `edge`³ cells. Half the edge is eight times the memory: for edge 4 3 % of the volume.
    ///
    /// # Panics
    /// If `edge` is not a power of two.
    pub fn with_edge(volume: &Volume, edge: usize) -> Bricks {
        Bricks::with_reach(volume, edge, 0)
    }

    /// The same whose ranges cover `reach` voxels more to every side: one for reconstruction from four voxels along each
    /// axis.
    ///
    /// # Panics
    /// If `edge` is not a power of two.
    pub fn with_reach(volume: &Volume, edge: usize, reach: usize) -> Bricks {
        made(Bricks::under(volume, edge, reach, &Control::NONE))
    }

    /// The same under `control`.
    ///
    /// # Errors
    /// It was cancelled; no memory.
    ///
    /// # Panics
    /// If `edge` is not a power of two.
    pub fn under(
        volume: &Volume,
        edge: usize,
        reach: usize,
        control: &Control,
    ) -> Result<Bricks, Error> {
        Bricks::of(volume.grid(), volume.samples(), edge, reach, control)
    }

    fn of(
        grid: &Grid,
        samples: &Samples,
        edge: usize,
        reach: usize,
        control: &Control,
    ) -> Result<Bricks, Error> {
        assert!(edge.is_power_of_two(), "bricks of {edge} cells");
        let voxels = grid.dims();
        let dims = dims(voxels, edge);
        let bricks = Blocks {
            edge,
            reach,
            voxels,
            dims,
            control,
        };
        let ranges = match samples {
            Samples::U8(samples) => {
                Ranges::U8(bricks.ranges(samples, |s| s, [u8::MAX, u8::MIN])?)
            }
            Samples::I8(samples) => {
                Ranges::I8(bricks.ranges(samples, |s| s, [i8::MAX, i8::MIN])?)
            }
            Samples::U16(samples) => {
                Ranges::U16(bricks.ranges(samples, |s| s, [u16::MAX, u16::MIN])?)
            }
            Samples::I16(samples) => {
                Ranges::I16(bricks.ranges(samples, |s| s, [i16::MAX, i16::MIN])?)
            }
            _ => {
                let BrickRange { lo, hi } = BrickRange::EMPTY;
                with_samples!(samples, s => Ranges::F32(bricks.ranges(s, Sample::to_f32, [lo, hi])?))
            }
        };
        Ok(Bricks {
            edge,
            reach,
            dims,
            ranges,
        })
    }

    /// Cells along the edge of these bricks.
    pub fn edge(&self) -> usize {
        self.edge
    }

    /// Voxels that ranges cover beyond the corners of the cells, to every side.
    pub fn reach(&self) -> usize {
        self.reach
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
        self.ranges.get(x + nx * (y + ny * z))
    }

    /// The number of bricks.
    pub fn number(&self) -> usize {
        self.ranges.number()
    }

    /// Bytes of all ranges.
    pub fn bytes(&self) -> usize {
        let of_range = match self.ranges {
            Ranges::U8(_) | Ranges::I8(_) => 2,
            Ranges::U16(_) | Ranges::I16(_) => 4,
            Ranges::F32(_) => 8,
        };
        of_range * self.number()
    }

    /// All ranges, x fastest.
    pub fn ranges(&self) -> impl ExactSizeIterator<Item = BrickRange> {
        (0..self.number()).map(|brick| self.ranges.get(brick))
    }

    /// The range of the whole volume, as all bricks have it together.
    ///
    /// # Errors
    /// `control` was cancelled.
    pub fn whole_under(&self, control: &Control) -> Result<BrickRange, Cancelled> {
        // Between two looks at the control: a fraction of a millisecond.
        const BRICKS: usize = 1 << 16;
        let mut whole = BrickRange::EMPTY;
        for first in (0..self.number()).step_by(BRICKS) {
            control.check()?;
            let bricks = first..self.number().min(first + BRICKS);
            whole = bricks.fold(whole, |all, brick| all.joined(self.ranges.get(brick)));
        }
        Ok(whole)
    }

    /// What `of` makes of every range, x fastest; on all cores.
    pub fn map<T: Copy + Default + Send>(&self, of: impl Fn(BrickRange) -> T + Sync) -> Vec<T> {
        made(self.map_under(&Control::NONE, of).map_err(Error::from))
    }

    /// The same under `control`.
    ///
    /// # Errors
    /// It was cancelled.
    pub fn map_under<T: Copy + Default + Send>(
        &self,
        control: &Control,
        of: impl Fn(BrickRange) -> T + Sync,
    ) -> Result<Vec<T>, Cancelled> {
        // A task takes longer than handing it over.
        const BRICKS: usize = 4096;
        let mut all = vec![T::default(); self.number()];
        let parts = control.parts(Work::Preparing, self.number().div_ceil(BRICKS));
        for_each_row(&mut all, BRICKS, &parts, |row, all| {
            for (brick, made) in (row * BRICKS..).zip(all) {
                *made = of(self.ranges.get(brick));
            }
        })?;
        Ok(all)
    }
}

/// How a volume is cut into bricks.
struct Blocks<'c> {
    edge: usize,
    reach: usize,
    /// Number of voxels along x, y, z.
    voxels: [usize; 3],
    /// Number of bricks along x, y, z.
    dims: [usize; 3],
    control: &'c Control,
}

impl Blocks<'_> {
    /// The smallest and the largest of the `numbers` of samples in each brick; `empty` is the range of none.
    ///
    /// One row of bricks (along x) after the other: first the range over y and z of every voxel column,
    /// then along x. The long inner loops run over neighboring voxels and vectorize.
    fn ranges<T: Sample, N: PartialOrd + Zeroable + Copy + Send + Sync>(
        &self,
        samples: &[T],
        number: impl Fn(T) -> N + Sync,
        empty: [N; 2],
    ) -> Result<Vec<[N; 2]>, Error> {
        let [nx, ny, nz] = self.voxels;
        // Written so that NaN changes neither end.
        let smaller = |a: N, b: N| if b < a { b } else { a };
        let larger = |a: N, b: N| if b > a { b } else { a };
        let row_of_bricks = |row: usize, ranges: &mut [[N; 2]]| {
            let (by, bz) = (row % self.dims[1], row / self.dims[1]);
            // Apart, so that neighbors lie side by side.
            let (mut smallest, mut largest) = (vec![empty[0]; nx], vec![empty[1]; nx]);
            for z in self.touched(bz, nz) {
                for y in self.touched(by, ny) {
                    let voxels = &samples[nx * (y + ny * z)..][..nx];
                    let columns = smallest.iter_mut().zip(&mut largest);
                    for ((lo, hi), &voxel) in columns.zip(voxels) {
                        let number = number(voxel);
                        *lo = smaller(*lo, number);
                        *hi = larger(*hi, number);
                    }
                }
            }
            for (bx, [lo, hi]) in ranges.iter_mut().enumerate() {
                let columns = self.touched(bx, nx);
                *lo = smallest[columns.clone()]
                    .iter()
                    .copied()
                    .fold(empty[0], smaller);
                *hi = largest[columns].iter().copied().fold(empty[1], larger);
            }
        };
        let mut ranges = memory::zeroed(self.dims.iter().product())?;
        let rows = self.dims[1] * self.dims[2];
        let parts = self.control.parts(Work::Preparing, rows);
        for_each_row(&mut ranges, self.dims[0], &parts, row_of_bricks)?;
        Ok(ranges)
    }

    /// The voxels that brick `brick` covers on an axis of `n` voxels.
    fn touched(&self, brick: usize, n: usize) -> Range<usize> {
        touched(brick, self.edge, self.reach, n)
    }
}

/// Number of bricks of `edge`³ cells along x, y, z in a volume of as many `voxels`.
pub(crate) fn dims(voxels: [usize; 3], edge: usize) -> [usize; 3] {
    voxels.map(|n| (n - 1).div_ceil(edge).max(1))
}

/// The voxels at the corners of the cells of brick `brick` on an axis of `n` voxels, and `reach` ones on either side.
pub(crate) fn touched(brick: usize, edge: usize, reach: usize, n: usize) -> Range<usize> {
    let first = brick * edge;
    first.saturating_sub(reach)..(first + edge + 1 + reach).min(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition, voxel by voxel.
    fn brute_force(
        [edge, reach]: [usize; 2],
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
                        .all(|(&v, b)| v + reach >= edge * b && v <= edge * b + edge + reach);
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
            kind in 0..6,
            edge in prop_oneof![Just(4), Just(8), Just(16)],
            reach in 0usize..3,
        ) {
            let count = voxels.iter().product::<usize>() as u32;
            let noise = (0..count).map(|i| (i ^ seed).wrapping_mul(2_654_435_761) >> 16);
            let samples = match kind {
                0 => Samples::U8(noise.map(|n| n as u8).collect()),
                1 => Samples::I8(noise.map(|n| n as i8).collect()),
                2 => Samples::U16(noise.map(|n| n as u16).collect()),
                3 => Samples::I16(noise.map(|n| n as i16).collect()),
                4 => Samples::I32(noise.map(|n| n as i32 - 30_000).collect()),
                _ => Samples::F32(noise.map(|n| if n % 5 == 0 { f32::NAN } else { n as f32 - 3e4 }).collect()),
            };
            let grid = Grid::centered(voxels, glam::DVec3::ONE).unwrap();
            let bricks = made(Bricks::of(&grid, &samples, edge, reach, &Control::NONE));
            let ends = |range: BrickRange| [range.lo, range.hi];
            prop_assert_eq!(bricks.map(ends), bricks.ranges().map(ends).collect::<Vec<_>>());
            for z in 0..bricks.dims()[2] {
                for y in 0..bricks.dims()[1] {
                    for x in 0..bricks.dims()[0] {
                        prop_assert_eq!(
                            bricks.range([x, y, z]),
                            brute_force([edge, reach], voxels, &samples, [x, y, z])
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn number_of_bricks_covers_every_cell() {
        for (voxels, bricks) in [(1, 1), (2, 1), (9, 1), (10, 2), (17, 2), (18, 3)] {
            let grid = Grid::centered([voxels, 1, 1], glam::DVec3::ONE).unwrap();
            let samples = Samples::U8(vec![0; voxels]);
            let found = made(Bricks::of(&grid, &samples, 8, 0, &Control::NONE));
            assert_eq!(found.dims(), [bricks, 1, 1], "{voxels} voxels");
        }
    }

    #[test]
    fn nothing_but_nan_is_an_empty_range() {
        let grid = Grid::centered([2, 2, 2], glam::DVec3::ONE).unwrap();
        let samples = Samples::F64(vec![f64::NAN; 8]);
        let bricks = made(Bricks::of(&grid, &samples, 8, 0, &Control::NONE));
        assert!(bricks.range([0, 0, 0]).is_empty());
    }
}
