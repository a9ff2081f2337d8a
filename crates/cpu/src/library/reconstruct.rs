//! Slot reconstruct: the value at any place from the voxels around it.

mod b_spline;
mod catmull_rom;
mod cubic;
mod nearest;
pub mod trilinear;

pub use b_spline::weights as b_spline_weights;

use crate::lanes::{F32s, I32s, Mask, Vec3s, each};
use crate::levels::{Level, vectorized};
use crate::library::fetch::{Fetch, Linear, OutlinedVoxels, Shape};
use strahl_scene::plan::Reconstruct;
use strahl_volume::{Grid, Rescale, Samples, with_samples};

/// The values of a volume anywhere: fetch, reconstruction and rescale in one, chosen once per object.
///
/// A call through a table per packet costs little beside the fetches behind it, and the loop is compiled
/// once per instruction set instead of once per type of sample, too.
pub trait Values<S: Level>: Sync {
    /// The size of the grid.
    fn shape(&self) -> &Shape;
    /// The values at `position` (voxel space).
    fn at(&self, position: Vec3s<S>) -> F32s<S>;
    /// The values at `position` linear between voxels, whatever the method.
    fn linear(&self, position: Vec3s<S>) -> F32s<S>;
    /// The values of single voxels; indices beyond the border give the voxel at the border.
    fn voxel(&self, voxel: [I32s<S>; 3]) -> F32s<S>;
    /// Half the difference between the values one voxel to either side of `position` along each axis, and how large the
    /// values are of which that is the difference; where `asked`, and anything elsewhere.
    fn central_differences(&self, position: Vec3s<S>, asked: Mask<S>) -> (Vec3s<S>, F32s<S>);
}

/// The values of `samples` on `grid`.
pub fn values<'v, S: Level>(
    grid: &Grid,
    samples: &'v Samples,
    rescale: Rescale,
    method: Reconstruct,
) -> Box<dyn Values<S> + 'v> {
    if S::HAS_LOOPS_PER_TYPE {
        match samples {
            Samples::U8(samples) => return of_voxels(Linear::new(grid, samples), rescale, method),
            Samples::U16(samples) => return of_voxels(Linear::new(grid, samples), rescale, method),
            Samples::I16(samples) => return of_voxels(Linear::new(grid, samples), rescale, method),
            Samples::F32(samples) => return of_voxels(Linear::new(grid, samples), rescale, method),
            _ => {}
        }
    }
    with_samples!(samples, samples => of_fetch(Linear::new(grid, samples), rescale, method))
}

/// The values of voxels that any function gives, by what is compiled once for all of them.
pub fn of_fetch<'v, S: Level>(
    fetch: impl Fetch<S> + 'v,
    rescale: Rescale,
    method: Reconstruct,
) -> Box<dyn Values<S> + 'v> {
    of_voxels(OutlinedVoxels::new(fetch), rescale, method)
}

/// The values of voxels, by what is compiled for their type.
pub fn of_voxels<'v, S: Level, F: Fetch<S> + 'v>(
    fetch: F,
    rescale: Rescale,
    method: Reconstruct,
) -> Box<dyn Values<S> + 'v> {
    Box::new(Reconstruction {
        fetch,
        method,
        slope: rescale.slope as f32,
        intercept: rescale.intercept as f32,
    })
}

/// How values are found: reconstruction of stored numbers, then slope and intercept.
struct Reconstruction<F> {
    fetch: F,
    method: Reconstruct,
    slope: f32,
    intercept: f32,
}

impl<F> Reconstruction<F> {
    #[inline(always)]
    fn rescaled<S: Level>(&self, stored: F32s<S>) -> F32s<S> {
        stored * F32s::splat(self.slope) + F32s::splat(self.intercept)
    }

    #[inline(always)]
    fn stored<S: Level>(&self, position: Vec3s<S>) -> F32s<S>
    where
        F: Fetch<S>,
    {
        match self.method {
            Reconstruct::Nearest => nearest::stored(&self.fetch, position),
            Reconstruct::Trilinear => trilinear::stored(&self.fetch, position),
            // The fetched numbers are coefficients if the spline shall interpolate.
            Reconstruct::BSpline | Reconstruct::BSplineInterpolating | Reconstruct::CatmullRom => {
                self.cubic(position)
            }
        }
    }

    /// Not inlined: 64 fetches wherever there is a value would be most of the program.
    #[inline(never)]
    fn cubic<S: Level>(&self, position: Vec3s<S>) -> F32s<S>
    where
        F: Fetch<S>,
    {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                if self.method == Reconstruct::CatmullRom {
                    catmull_rom::stored(&self.fetch, position)
                } else {
                    b_spline::stored(&self.fetch, position)
                }
            },
        )
    }

    /// For where it is asked for often.
    #[inline(never)]
    fn stored_apart<S: Level>(&self, position: Vec3s<S>) -> F32s<S>
    where
        F: Fetch<S>,
    {
        vectorized::<S, _>(
            #[inline(always)]
            || self.stored(position),
        )
    }

    /// The difference between the stored numbers one voxel ahead and one behind along each axis, and the largest of the
    /// six values without its sign.
    #[inline(never)]
    fn difference<S: Level>(&self, position: Vec3s<S>) -> (Vec3s<S>, F32s<S>)
    where
        F: Fetch<S>,
    {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut difference = [F32s::zero(); 3];
                let mut largest = F32s::zero();
                for (axis, difference) in difference.iter_mut().enumerate() {
                    for by in [1.0, -1.0] {
                        let mut position = position;
                        position[axis] += F32s::splat(by);
                        let stored = self.stored_apart(position);
                        *difference += stored * F32s::splat(by);
                        largest = self.rescaled(stored).abs().max(largest);
                    }
                }
                (difference, largest)
            },
        )
    }
}

impl<S: Level, F: Fetch<S>> Values<S> for Reconstruction<F> {
    fn shape(&self) -> &Shape {
        self.fetch.shape()
    }

    fn at(&self, position: Vec3s<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.rescaled(self.stored(position)),
        )
    }

    fn linear(&self, position: Vec3s<S>) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.rescaled(trilinear::stored(&self.fetch, position)),
        )
    }

    fn voxel(&self, voxel: [I32s<S>; 3]) -> F32s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let shape = self.fetch.shape();
                // SAFETY: clamped to the grid.
                self.rescaled(unsafe { self.fetch.fetch(shape.clamp_voxel(voxel)) })
            },
        )
    }

    fn central_differences(&self, position: Vec3s<S>, asked: Mask<S>) -> (Vec3s<S>, F32s<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let half = F32s::splat(0.5 * self.slope);
                let inside = if self.method == Reconstruct::Trilinear {
                    trilinear::differences(&self.fetch, position, asked)
                } else {
                    None
                };
                let (differences, largest) = match inside {
                    None => self.difference(position),
                    Some((differences, middle, inside)) => {
                        // Where the differences are next to nothing, the value between is as large as those around.
                        let size = self.rescaled(middle).abs();
                        if (asked & !inside).any() {
                            let (others, of_others) = self.difference(position);
                            (
                                inside.select3(differences, others),
                                inside.select(size, of_others),
                            )
                        } else {
                            (differences, size)
                        }
                    }
                };
                (each!(differences, |difference| difference * half), largest)
            },
        )
    }
}
