use crate::lanes::{F32s, I32s, Mask, Vec3s, each};
use crate::levels::{Level, inlined};
use crate::library::fetch::{Fetch, Shape};

/// A separable cubic kernel over the 4 × 4 × 4 voxels around a position, which is clamped to the hull
/// of the voxel centers, and so are the voxels.
#[inline(always)]
pub fn cubic<S: Level, F: Fetch<S>>(
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
    let row = inlined(
        #[inline(always)]
        |y: usize, z: usize| {
            let (y_tap, z_tap) = (taps[y][1], taps[z][2]);
            // SAFETY: taps are clamped to the grid of `shape`, for which the row was made.
            let numbers = match unsafe { row_along_x.numbers(fetch, y_tap, z_tap) } {
                Some(numbers) => numbers,
                // SAFETY: taps are clamped to the grid.
                None => unsafe {
                    [
                        fetch.fetch([taps[0][0], y_tap, z_tap]),
                        fetch.fetch([taps[1][0], y_tap, z_tap]),
                        fetch.fetch([taps[2][0], y_tap, z_tap]),
                        fetch.fetch([taps[3][0], y_tap, z_tap]),
                    ]
                },
            };
            sum(numbers, weights[0])
        },
    );
    // The rows of a plane are written out, the planes are not: a loop over rows takes a tenth longer, and without one over
    // planes everything takes a third longer.
    let mut planes = [F32s::zero(); 4];
    for (z, plane) in planes.iter_mut().enumerate() {
        *plane = sum([row(0, z), row(1, z), row(2, z), row(3, z)], weights[1]);
    }
    sum(planes, weights[2])
}

/// By weights that add up to one. Added up are differences from the second number, so that of equal numbers nothing is
/// left but that number: constant parts have no gradient.
#[inline(always)]
fn sum<S: Level>(numbers: [F32s<S>; 4], weights: [F32s<S>; 4]) -> F32s<S> {
    let [before, at, ahead, further] = numbers;
    let [w0, _, w2, w3] = weights;
    at + ((before - at) * w0 + (ahead - at) * w2 + (further - at) * w3)
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

    /// # Safety
    /// The row is of the shape of `fetch`, and `y` and `z` lie inside its grid.
    #[inline(always)]
    unsafe fn numbers<F: Fetch<S>>(
        &self,
        fetch: &F,
        y: I32s<S>,
        z: I32s<S>,
    ) -> Option<[F32s<S>; 4]> {
        // SAFETY: as the caller promises; along x there are two cells behind the first one at least.
        let [a, b, c, d] = unsafe { fetch.four([self.first?, y, z]) }?;
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
