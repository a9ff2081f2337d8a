//! Slot reconstruct: the value at any place from the voxels around it.

mod b_spline;
mod catmull_rom;
mod nearest;
pub mod trilinear;

pub use b_spline::weights as b_spline_weights;

use crate::lanes::{F32s, I32s, Mask, Vec3s, each};
use crate::levels::{Level, inlined, vectorized};
use crate::library::fetch::{Fetch, Linear, Shape};
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
    /// Half the difference between the values one voxel to either side of `position` along each axis,
    /// where `asked`; anything elsewhere.
    fn central_differences(&self, position: Vec3s<S>, asked: Mask<S>) -> Vec3s<S>;
}

/// The values of `samples` on `grid`.
pub fn values<'v, S: Level>(
    grid: &Grid,
    samples: &'v Samples,
    rescale: Rescale,
    method: Reconstruct,
) -> Box<dyn Values<S> + 'v> {
    with_samples!(samples, samples => of_fetch(Linear::new(grid, samples), rescale, method))
}

/// The values of voxels that any function gives.
pub fn of_fetch<'v, S: Level, F: Fetch<S> + 'v>(
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

    /// The difference between the stored numbers one voxel ahead and one behind along each axis.
    #[inline(never)]
    fn difference<S: Level>(&self, position: Vec3s<S>) -> Vec3s<S>
    where
        F: Fetch<S>,
    {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let mut difference = [F32s::zero(); 3];
                for (axis, difference) in difference.iter_mut().enumerate() {
                    for by in [1.0, -1.0] {
                        let mut position = position;
                        position[axis] += F32s::splat(by);
                        *difference += self.stored_apart(position) * F32s::splat(by);
                    }
                }
                difference
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
                self.rescaled(self.fetch.fetch(shape.clamp_voxel(voxel)))
            },
        )
    }

    fn central_differences(&self, position: Vec3s<S>, asked: Mask<S>) -> Vec3s<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let half = F32s::splat(0.5 * self.slope);
                let inside = if self.method == Reconstruct::Trilinear {
                    trilinear::differences(&self.fetch, position, asked)
                } else {
                    None
                };
                let differences = match inside {
                    None => self.difference(position),
                    Some((differences, inside)) => {
                        if (asked & !inside).any() {
                            inside.select3(differences, self.difference(position))
                        } else {
                            differences
                        }
                    }
                };
                each!(differences, |difference| difference * half)
            },
        )
    }
}

/// A separable cubic kernel over the 4 × 4 × 4 voxels around a position, which is clamped to the hull
/// of the voxel centres, and so are the voxels.
#[inline(always)]
fn cubic<S: Level, F: Fetch<S>>(
    fetch: &F,
    position: Vec3s<S>,
    weights: impl Fn(F32s<S>) -> [F32s<S>; 4],
) -> F32s<S> {
    let shape = fetch.shape();
    let clamped = shape.clamp(position);
    let cell = shape.cell(clamped);
    let weights = each!([0, 1, 2], |axis| {
        weights(clamped[axis] - cell[axis].to_f32s())
    });
    let tap = inlined(
        #[inline(always)]
        |tap: usize| {
            let offset = I32s::splat(tap as i32 - 1);
            shape.clamp_voxel([cell[0] + offset, cell[1] + offset, cell[2] + offset])
        },
    );
    let taps = [tap(0), tap(1), tap(2), tap(3)];
    let row_along_x = RowAlongX::new(shape, cell[0]);
    let mut sum = F32s::zero();
    for z in 0..4 {
        let mut plane = F32s::zero();
        for y in 0..4 {
            let (y_tap, z_tap) = (taps[y][1], taps[z][2]);
            let numbers = match row_along_x.numbers(fetch, y_tap, z_tap) {
                Some(numbers) => numbers,
                None => [
                    fetch.fetch([taps[0][0], y_tap, z_tap]),
                    fetch.fetch([taps[1][0], y_tap, z_tap]),
                    fetch.fetch([taps[2][0], y_tap, z_tap]),
                    fetch.fetch([taps[3][0], y_tap, z_tap]),
                ],
            };
            let mut row = F32s::zero();
            for x in 0..4 {
                row += numbers[x] * weights[0][x];
            }
            plane += row * weights[1][y];
        }
        sum += plane * weights[2][z];
    }
    sum
}

/// Four voxels in a row around cells, those beyond the border replaced by that at the border.
struct RowAlongX<S: Level> {
    /// The first one that is fetched; `None` where no row has four.
    first: Option<I32s<S>>,
    /// Where the first one lies beyond the border, or the last.
    beyond: [Mask<S>; 2],
    is_inside: bool,
}

impl<S: Level> RowAlongX<S> {
    #[inline(always)]
    fn new(shape: &Shape, cell: I32s<S>) -> RowAlongX<S> {
        let last_cell = shape.last_cell[0];
        let lower = cell.lt(I32s::splat(1));
        let upper = I32s::splat(last_cell - 1).lt(cell);
        let first = (cell + I32s::splat(-1)).max(0).min(last_cell - 2);
        RowAlongX {
            first: (last_cell >= 2).then_some(first),
            beyond: [lower, upper],
            is_inside: !(lower | upper).any(),
        }
    }

    #[inline(always)]
    fn numbers<F: Fetch<S>>(&self, fetch: &F, y: I32s<S>, z: I32s<S>) -> Option<[F32s<S>; 4]> {
        let [a, b, c, d] = fetch.four([self.first?, y, z])?;
        if self.is_inside {
            return Some([a, b, c, d]);
        }
        let [lower, upper] = self.beyond;
        Some([
            upper.select(b, a),
            upper.select(c, lower.select(a, b)),
            upper.select(d, lower.select(b, c)),
            lower.select(c, d),
        ])
    }
}
