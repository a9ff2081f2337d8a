//! The place in the world of files that say nothing about directions: raw, `.dat`, PVM, npy and
//! pictures.
//!
//! They are taken as ITK takes them: voxel axes are the patient's left, back and head (LPS), the
//! first voxel's center lies at the origin. In RAS this is diag(−sx, −sy, sz). Both that frame and
//! "x to the right, y down, z away from the viewer" of a picture stack are right-handed, so nothing
//! is mirrored: seen from the feet with the front up, slice z is the picture as it is in the file,
//! and an axial slice saved from a viewer with the patient's left on the right lies correctly.

use super::ReadOptions;
use crate::{Error, Grid};
use glam::{DAffine3, DMat3, DVec3};

/// The grid of a file without directions; `spacing_mm` is the distance between voxel centers.
///
/// # Errors
/// A spacing that is not a positive number, or as [`Grid::new`].
pub(crate) fn grid(dims: [usize; 3], spacing_mm: [f64; 3]) -> Result<Grid, Error> {
    for (axis, &spacing) in ["x", "y", "z"].iter().zip(&spacing_mm) {
        if !(spacing > 0.0 && spacing.is_finite()) {
            return Err(Error::field(
                format!("spacing along {axis}"),
                spacing,
                "a number above 0",
            ));
        }
    }
    let [x, y, z] = spacing_mm;
    Grid::new(
        dims,
        DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-x, -y, z))),
    )
}

/// The spacing to use: what the user says goes before what the file says, else 1. Also returns
/// whether it has a length unit, which the file's answers for itself.
pub(crate) fn spacing_mm(
    options: &ReadOptions,
    of_file: Option<([f64; 3], bool)>,
) -> ([f64; 3], bool) {
    match (options.spacing_mm, of_file) {
        (Some(said), _) => (said, true),
        (None, Some(of_file)) => of_file,
        (None, None) => ([1.0; 3], false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_left_back_head_and_right_handed() {
        let grid = grid([4, 5, 6], [0.5, 2.0, 3.0]).unwrap();
        assert_eq!(grid.orientation(), "LPS");
        assert!(grid.world_from_voxel().matrix3.determinant() > 0.0);
        let corner = grid
            .world_from_voxel()
            .transform_point3(DVec3::new(1.0, 1.0, 1.0));
        assert_eq!(corner, DVec3::new(-0.5, -2.0, 3.0));
    }

    #[test]
    fn spacing_that_is_no_length_is_named() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = super::grid([1, 1, 1], [1.0, bad, 1.0]).unwrap_err();
            assert!(error.to_string().contains("spacing along y"), "{error}");
        }
    }
}
