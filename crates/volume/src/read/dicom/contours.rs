//! Closed contours in planes of a grid, filled: the voxels whose centers lie inside.
//!
//! Several contours of one plane count even–odd, so a contour in another one is a hole. A slice of the grid takes the
//! nearest plane of contours, if that is within half the distance of planes.

use crate::error::{Error, ErrorKind};
use crate::memory;
use glam::DVec2;
use std::ops::Range;

/// Crossings of rows with the contours of one plane that any grid may have; beyond, at most one for each voxel.
const FREE_CROSSINGS: usize = 1 << 12;

/// Contours that lie in one plane, in voxels of the grid.
pub(super) struct Plane {
    /// Along the slices; slice k is at k.
    pub(super) height: f64,
    /// Corners; the last one is joined to the first.
    pub(super) contours: Vec<Vec<DVec2>>,
}

/// The planes of one structure, from low to high.
pub(super) struct Planes {
    planes: Vec<Plane>,
    /// From plane to plane, in slices.
    distance: f64,
}

impl Planes {
    /// Puts contours in order by their heights. `slab` is how thick a single plane is, in slices.
    pub(super) fn new(mut contours: Vec<(f64, Vec<DVec2>)>, slab: f64) -> Planes {
        /// Heights that differ by less, in slices, are rounded differently.
        const SAME: f64 = 0.02;
        contours.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut planes: Vec<Plane> = Vec::new();
        for (height, contour) in contours {
            match planes.last_mut() {
                Some(plane) if height - plane.height <= SAME => plane.contours.push(contour),
                _ => planes.push(Plane {
                    height,
                    contours: vec![contour],
                }),
            }
        }
        let distances = planes
            .windows(2)
            .map(|pair| pair[1].height - pair[0].height);
        let distance = distances.min_by(f64::total_cmp).unwrap_or(slab);
        Planes { planes, distance }
    }

    /// The runs of voxels inside, within `dims`: slice, row, columns.
    ///
    /// # Errors
    /// Contours that cross more rows than anyone draws, or no memory; an error of `run`.
    pub(super) fn runs(
        &self,
        dims: [usize; 3],
        run: &mut dyn FnMut(usize, usize, Range<usize>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        for (i, plane) in self.planes.iter().enumerate() {
            let slices = self.slices(i, dims[2]);
            if slices.is_empty() {
                continue;
            }
            let crossings = crossings(plane, dims)?;
            for slice in slices {
                for row in crossings.chunk_by(|a, b| a.0 == b.0) {
                    for pair in row.chunks_exact(2) {
                        let columns = voxels_between(pair[0].1, pair[1].1, dims[0]);
                        if !columns.is_empty() {
                            run(slice, pair[0].0, columns)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The slices of a grid with `count` of them that take a plane: nearer to it than to its neighbors, and within half
    /// the distance. Of two that are equally near, the upper plane is taken.
    fn slices(&self, plane: usize, count: usize) -> Range<usize> {
        let height = self.planes[plane].height;
        let mut low = height - self.distance / 2.0;
        let mut high = height + self.distance / 2.0;
        if let Some(below) = plane.checked_sub(1) {
            low = low.max((self.planes[below].height + height) / 2.0);
        }
        if let Some(above) = self.planes.get(plane + 1) {
            high = high.min((above.height + height) / 2.0);
        }
        first_at(low, count)..first_at(high, count)
    }
}

/// The first of `count` whole numbers that is not below `bound`, but for rounding.
fn first_at(bound: f64, count: usize) -> usize {
    const ROUNDING: f64 = 1e-6;
    (bound - ROUNDING).ceil().clamp(0.0, count as f64) as usize
}

/// The voxels of a row or column of `count` whose centers lie between two places.
fn voxels_between(from: f64, to: f64, count: usize) -> Range<usize> {
    let first = |x: f64| x.ceil().clamp(0.0, count as f64) as usize;
    first(from)..first(to)
}

/// Row and place of every crossing of an edge with the middle of a row, sorted.
fn crossings(plane: &Plane, dims: [usize; 3]) -> Result<Vec<(usize, f64)>, Error> {
    let most = FREE_CROSSINGS.saturating_add(dims[0].saturating_mul(dims[1]));
    let mut crossings: Vec<(usize, f64)> = Vec::new();
    for contour in &plane.contours {
        let ends = contour.iter().cycle().skip(1);
        for (from, to) in contour.iter().zip(ends) {
            let (low, high) = if from.y < to.y {
                (from, to)
            } else {
                (to, from)
            };
            // A corner in the middle of a row belongs to the edge above it, so that it counts once.
            let rows = voxels_between(low.y, high.y, dims[1]);
            if crossings.len() + rows.len() > most {
                return Err(ErrorKind::Unsupported {
                    feature: format!("a plane of contours that cross rows more than {most} times"),
                    instead: "draw them with fewer points".into(),
                }
                .into());
            }
            memory::grow(&mut crossings, rows.len())?;
            let slope = (high.x - low.x) / (high.y - low.y);
            crossings.extend(rows.map(|y| (y, low.x + slope * (y as f64 - low.y))));
        }
    }
    crossings.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    Ok(crossings)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(left: f64, top: f64, right: f64, bottom: f64) -> Vec<DVec2> {
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        corners.map(|(x, y)| DVec2::new(x, y)).to_vec()
    }

    fn filled(planes: &Planes, dims: [usize; 3]) -> Vec<usize> {
        let mut filled = vec![0; dims.iter().product()];
        planes
            .runs(dims, &mut |z, y, columns| {
                for x in columns {
                    filled[x + dims[0] * (y + dims[1] * z)] += 1;
                }
                Ok(())
            })
            .unwrap();
        filled
    }

    #[test]
    fn the_contour_in_another_one_is_a_hole() {
        let outer = rectangle(0.5, 0.5, 5.5, 4.5);
        let hole = rectangle(1.5, 1.5, 3.5, 2.5);
        let planes = Planes::new(vec![(0.0, outer), (0.0, hole)], 1.0);
        #[rustfmt::skip]
        let expected = [
            0, 0, 0, 0, 0, 0, 0,
            0, 1, 1, 1, 1, 1, 0,
            0, 1, 0, 0, 1, 1, 0,
            0, 1, 1, 1, 1, 1, 0,
            0, 1, 1, 1, 1, 1, 0,
        ];
        assert_eq!(filled(&planes, [7, 5, 1]), expected);
    }

    #[test]
    fn neighbors_share_the_edge_between_them() {
        // An edge through centers of voxels belongs to one of both sides, also along rows.
        for (first, second) in [
            (rectangle(0.0, 0.0, 2.0, 3.0), rectangle(2.0, 0.0, 4.0, 3.0)),
            (rectangle(0.0, 0.0, 4.0, 1.0), rectangle(0.0, 1.0, 4.0, 3.0)),
        ] {
            let [first, second] = [first, second].map(|c| Planes::new(vec![(0.0, c)], 1.0));
            let dims = [4, 3, 1];
            let sum = filled(&first, dims)
                .iter()
                .zip(filled(&second, dims))
                .map(|(a, b)| a + b)
                .collect::<Vec<_>>();
            assert_eq!(sum, [1; 12]);
        }
    }

    #[test]
    fn slices_take_the_nearest_plane_within_half_the_distance() {
        let square = || rectangle(-0.5, -0.5, 0.5, 0.5);
        let slices = |heights: &[f64], slab: f64, count: usize| {
            let contours = heights.iter().map(|height| (*height, square())).collect();
            filled(&Planes::new(contours, slab), [1, 1, count])
        };
        assert_eq!(slices(&[1.0, 2.0], 1.0, 4), [0, 1, 1, 0]);
        // Every other slice has a plane: three planes, two slices each.
        assert_eq!(
            slices(&[2.0, 4.0, 6.0], 1.0, 9),
            [0, 1, 1, 1, 1, 1, 1, 0, 0]
        );
        // A plane is missing.
        assert_eq!(slices(&[1.0, 2.0, 5.0], 1.0, 7), [0, 1, 1, 0, 0, 1, 0]);
        // One plane as thick as it says; twice as many planes as slices.
        assert_eq!(slices(&[2.0], 3.0, 5), [0, 1, 1, 1, 0]);
        assert_eq!(slices(&[0.0, 0.5, 1.0, 1.5, 2.0], 1.0, 4), [1, 1, 1, 0]);
        // Rounded positions.
        assert_eq!(slices(&[1.0, 1.999, 3.0001], 1.0, 5), [0, 1, 1, 1, 0]);
        // Outside of the grid.
        assert_eq!(slices(&[-7.0, -6.0, 90.0], 1.0, 2), [0, 0]);
    }

    #[test]
    fn a_disk_has_its_area() {
        let (center, radius) = (DVec2::new(50.3, 49.8), 40.25);
        let corner = |i: u32| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 3600.0).sin_cos();
            center + radius * DVec2::new(cos, sin)
        };
        let planes = Planes::new(vec![(0.0, (0..3600).map(corner).collect())], 1.0);
        let area: usize = filled(&planes, [100, 100, 1]).iter().sum();
        // Gauss' circle problem: the deviation is a fraction of the circumference.
        let exact = std::f64::consts::PI * radius * radius;
        assert!((area as f64 - exact).abs() < 20.0, "{area} is not {exact}");
    }
}
