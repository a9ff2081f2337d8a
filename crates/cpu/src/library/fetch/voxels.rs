use super::shape::Shape;
use crate::lanes::{F32s, I32s, each};
use crate::levels::{Level, inlined};

/// Where the voxels of a grid come from. Implemented per stored type and layout; everything above
/// works on numbers.
pub trait Fetch<S: Level>: Sync {
    /// The size of the grid.
    fn shape(&self) -> &Shape;

    /// The stored numbers of voxels.
    ///
    /// # Safety
    /// In every lane the voxel lies inside the grid that [`shape`](Self::shape) is of.
    unsafe fn fetch(&self, voxel: [I32s<S>; 3]) -> F32s<S>;

    /// The stored numbers at the corners of cells.
    ///
    /// # Safety
    /// In every lane the cell is one of that grid: 0 to [`Shape::last_cell`] along each axis.
    #[inline(always)]
    unsafe fn corners(&self, cell: [I32s<S>; 3]) -> Corners<S> {
        let [dx, dy, dz] = each!(self.shape().across, |stride| i32::from(stride > 0));
        let pair = inlined(
            #[inline(always)]
            |y: i32, z: i32| {
                let [x, y, z] = [cell[0], cell[1] + I32s::splat(y), cell[2] + I32s::splat(z)];
                // SAFETY: the corners of a cell of the grid lie inside it; `across` is 0 where they are one voxel.
                unsafe {
                    [
                        self.fetch([x, y, z]),
                        self.fetch([x + I32s::splat(dx), y, z]),
                    ]
                }
            },
        );
        [pair(0, 0), pair(dy, 0), pair(0, dz), pair(dy, dz)]
    }

    /// The stored numbers of four voxels in a row along x, the first of which is `voxel`. `None` where voxels have to be
    /// fetched one by one.
    ///
    /// # Safety
    /// In every lane all four lie inside the grid.
    #[inline(always)]
    unsafe fn four(&self, _voxel: [I32s<S>; 3]) -> Option<[F32s<S>; 4]> {
        None
    }

    /// The stored numbers of the voxels one further out along each axis, too, of cells that are not at
    /// the border; `None` where voxels have to be fetched one by one.
    ///
    /// # Safety
    /// In every lane the cell is 1 to [`Shape::last_cell`] − 1 along each axis.
    #[inline(always)]
    unsafe fn surroundings(&self, _cell: [I32s<S>; 3]) -> Option<Surroundings<S>> {
        None
    }
}

/// Pairs along x, at (y, z) = (0, 0), (1, 0), (0, 1), (1, 1).
pub type Corners<S> = [[F32s<S>; 2]; 4];

/// What central differences in a cell need.
pub struct Surroundings<S: Level> {
    /// From x − 1 to x + 2, in the order of [`Corners`].
    pub along_x: [[F32s<S>; 4]; 4],
    /// The corners of the cells at y − 1 and y + 1, as far as they are not in the cell itself: pairs at
    /// (y, z) = (−1, 0), (2, 0), (−1, 1), (2, 1).
    pub along_y: Corners<S>,
    /// Pairs at (y, z) = (0, −1), (1, −1), (0, 2), (1, 2).
    pub along_z: Corners<S>,
}
