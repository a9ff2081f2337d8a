use super::shape::Shape;
use super::voxels::{Corners, Fetch, Surroundings};
use crate::lanes::{F32s, I32s};
use crate::levels::{Level, vectorized};

/// Voxels behind a call each time that some are fetched: what is compiled for these serves all types of sample.
pub struct OutlinedVoxels<'v, S: Level> {
    shape: Shape,
    voxels: Box<dyn Fetch<S> + 'v>,
}

impl<'v, S: Level> OutlinedVoxels<'v, S> {
    /// Those of `voxels`.
    pub fn new(voxels: impl Fetch<S> + 'v) -> OutlinedVoxels<'v, S> {
        OutlinedVoxels {
            shape: *voxels.shape(),
            voxels: Box::new(OutlinedFetch(voxels)),
        }
    }
}

impl<S: Level> Fetch<S> for OutlinedVoxels<'_, S> {
    #[inline(always)]
    fn shape(&self) -> &Shape {
        &self.shape
    }

    #[inline(always)]
    unsafe fn fetch(&self, voxel: [I32s<S>; 3]) -> F32s<S> {
        // SAFETY: as the caller promises.
        unsafe { self.voxels.fetch(voxel) }
    }

    #[inline(always)]
    unsafe fn corners(&self, cell: [I32s<S>; 3]) -> Corners<S> {
        // SAFETY: as the caller promises.
        unsafe { self.voxels.corners(cell) }
    }

    #[inline(always)]
    unsafe fn four(&self, voxel: [I32s<S>; 3]) -> Option<[F32s<S>; 4]> {
        // SAFETY: as the caller promises.
        unsafe { self.voxels.four(voxel) }
    }

    #[inline(always)]
    unsafe fn surroundings(&self, cell: [I32s<S>; 3]) -> Option<Surroundings<S>> {
        // SAFETY: as the caller promises.
        unsafe { self.voxels.surroundings(cell) }
    }
}

/// What is called: compiled for the instruction set on its own.
struct OutlinedFetch<F>(F);

impl<S: Level, F: Fetch<S>> Fetch<S> for OutlinedFetch<F> {
    fn shape(&self) -> &Shape {
        self.0.shape()
    }

    unsafe fn fetch(&self, voxel: [I32s<S>; 3]) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            // SAFETY: as the caller promises.
            || unsafe { self.0.fetch(voxel) },
        )
    }

    unsafe fn corners(&self, cell: [I32s<S>; 3]) -> Corners<S> {
        vectorized::<S, _>(
            #[inline(always)]
            // SAFETY: as the caller promises.
            || unsafe { self.0.corners(cell) },
        )
    }

    unsafe fn four(&self, voxel: [I32s<S>; 3]) -> Option<[F32s<S>; 4]> {
        vectorized::<S, _>(
            #[inline(always)]
            // SAFETY: as the caller promises.
            || unsafe { self.0.four(voxel) },
        )
    }

    unsafe fn surroundings(&self, cell: [I32s<S>; 3]) -> Option<Surroundings<S>> {
        vectorized::<S, _>(
            #[inline(always)]
            // SAFETY: as the caller promises.
            || unsafe { self.0.surroundings(cell) },
        )
    }
}
