//! Where samples lie: dimensions and the map from voxel indices to the world.

use crate::error::{Error, ErrorKind};
use glam::{DAffine3, DMat3, DVec3};

/// The place of a grid in the world.
///
/// World space is patient RAS in millimeters (x to the patient's right, y to the front, z to the
/// head); grids without units count as 1 mm. Voxel centers lie at whole-number indices. The sampled
/// extent is the hull of the voxel centers plus half a voxel on every side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    world_from_voxel: DAffine3,
    voxel_from_world: DAffine3,
}

impl Grid {
    /// The largest number of voxels along one axis: what NIfTI-1 can say is far below it, and f32
    /// positions along a ray stay exact to 1/8 voxel up to it.
    pub const MAX_EDGE: usize = 1 << 20;

    /// Largest voxel edge and distance from the origin, and one over the smallest edge: from atoms to
    /// planets, and squares and products of lengths stay finite.
    pub const FARTHEST_MM: f64 = 1e12;

    /// A grid of `dims` voxels (x, y, z) placed by `world_from_voxel` (voxel index → RAS mm).
    ///
    /// # Errors
    /// A dimension of 0 or above [`Grid::MAX_EDGE`], a voxel count beyond `isize::MAX`, an affine
    /// with a value that is not finite, one that cannot be inverted, or one beyond
    /// [`Grid::FARTHEST_MM`].
    pub fn new(dims: [usize; 3], world_from_voxel: DAffine3) -> Result<Grid, Error> {
        for (axis, &n) in dims.iter().enumerate() {
            if n == 0 || n > Self::MAX_EDGE {
                return Err(Error::field(
                    format!("dimension {}", ["x", "y", "z"][axis]),
                    n,
                    format!("1 to {}", Self::MAX_EDGE),
                ));
            }
        }
        voxel_count(dims).ok_or_else(|| {
            Error::field(
                "dimensions",
                format!("{dims:?}"),
                "fewer voxels than this machine can address",
            )
        })?;
        if !world_from_voxel.is_finite() {
            return Err(ErrorKind::BadAffine {
                affine: rows(&world_from_voxel),
                why: "has a value that is not finite; all twelve have to be numbers",
            }
            .into());
        }
        // Relative to the lengths of the axes, so that micrometre grids are not called singular.
        let m = world_from_voxel.matrix3;
        let axes = [m.x_axis, m.y_axis, m.z_axis];
        let [x, y, z] = axes.map(DVec3::normalize_or_zero);
        let voxel_from_world = world_from_voxel.inverse();
        if DMat3::from_cols(x, y, z).determinant().abs() <= 1e-9 {
            return Err(ErrorKind::BadAffine {
                affine: rows(&world_from_voxel),
                why: "cannot be inverted: two voxel axes are parallel, or one has no length; they have to span the space",
            }
            .into());
        }
        let in_reach = |length: f64| length <= Self::FARTHEST_MM;
        if !axes
            .iter()
            .all(|a| in_reach(a.length()) && in_reach(1.0 / a.length()))
            || !in_reach(world_from_voxel.translation.length())
            || !voxel_from_world.is_finite()
        {
            return Err(ErrorKind::BadAffine {
                affine: rows(&world_from_voxel),
                why: "has a voxel edge outside 1e-12 to 1e12 mm, or lies farther out than 1e12 mm",
            }
            .into());
        }
        Ok(Grid {
            dims,
            world_from_voxel,
            voxel_from_world,
        })
    }

    /// An axis-aligned grid (voxel axes = R, A, S) with its center at the world's origin.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn centered(dims: [usize; 3], spacing_mm: DVec3) -> Result<Grid, Error> {
        let last = DVec3::new(
            dims[0] as f64 - 1.0,
            dims[1] as f64 - 1.0,
            dims[2] as f64 - 1.0,
        );
        Grid::new(
            dims,
            DAffine3::from_mat3_translation(
                DMat3::from_diagonal(spacing_mm),
                -0.5 * last * spacing_mm,
            ),
        )
    }

    /// Number of voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Number of voxels; at most `isize::MAX`.
    pub fn voxel_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Position of a voxel in the sample array: x + nx·(y + ny·z).
    #[inline]
    pub fn index(&self, x: usize, y: usize, z: usize) -> usize {
        debug_assert!(x < self.dims[0] && y < self.dims[1] && z < self.dims[2]);
        x + self.dims[0] * (y + self.dims[1] * z)
    }

    /// Voxel index → RAS mm.
    pub fn world_from_voxel(&self) -> DAffine3 {
        self.world_from_voxel
    }

    /// RAS mm → voxel index.
    pub fn voxel_from_world(&self) -> DAffine3 {
        self.voxel_from_world
    }

    /// Distance between neighboring voxel centers along x, y, z in mm.
    pub fn spacing_mm(&self) -> DVec3 {
        let m = self.world_from_voxel.matrix3;
        DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
    }

    /// The smallest of the three spacings in mm.
    pub fn min_spacing_mm(&self) -> f64 {
        self.spacing_mm().min_element()
    }

    /// The mean of the three spacings in mm: the default reference length of opacity.
    pub fn mean_spacing_mm(&self) -> f64 {
        self.spacing_mm().element_sum() / 3.0
    }

    /// The sampled extent in voxel space: (−0.5, −0.5, −0.5) to dims − 0.5.
    pub fn extent_in_voxels(&self) -> (DVec3, DVec3) {
        let [x, y, z] = self.dims;
        (
            DVec3::splat(-0.5),
            DVec3::new(x as f64, y as f64, z as f64) - 0.5,
        )
    }

    /// The eight corners of the sampled extent in RAS mm.
    pub fn corners_mm(&self) -> [DVec3; 8] {
        let (lo, hi) = self.extent_in_voxels();
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i >> bit & 1 == 1 { hi } else { lo };
            self.world_from_voxel.transform_point3(DVec3::new(
                pick(0, lo.x, hi.x),
                pick(1, lo.y, hi.y),
                pick(2, lo.z, hi.z),
            ))
        })
    }

    /// The center of the grid in RAS mm.
    pub fn center_mm(&self) -> DVec3 {
        let (lo, hi) = self.extent_in_voxels();
        self.world_from_voxel.transform_point3(0.5 * (lo + hi))
    }

    /// Axis-aligned box around the sampled extent in RAS mm: (smallest corner, largest corner).
    pub fn bounds_mm(&self) -> (DVec3, DVec3) {
        let corners = self.corners_mm();
        corners
            .iter()
            .fold((corners[0], corners[0]), |(lo, hi), &c| {
                (lo.min(c), hi.max(c))
            })
    }

    /// The nearest anatomical direction of each voxel axis, such as `RAS` or `LPS`.
    pub fn orientation(&self) -> String {
        let m = self.world_from_voxel.matrix3;
        [m.x_axis, m.y_axis, m.z_axis]
            .iter()
            .map(|axis| {
                let size = axis.abs();
                let (positive, negative, along) = if size.x >= size.y && size.x >= size.z {
                    ('R', 'L', axis.x)
                } else if size.y >= size.z {
                    ('A', 'P', axis.y)
                } else {
                    ('S', 'I', axis.z)
                };
                if along >= 0.0 { positive } else { negative }
            })
            .collect()
    }

    /// Whether `other` has the same dimensions and places every voxel within `tolerance_mm`.
    pub fn matches(&self, other: &Grid, tolerance_mm: f64) -> bool {
        self.dims == other.dims
            && self
                .corners_mm()
                .iter()
                .zip(other.corners_mm())
                .all(|(a, b)| a.distance(b) <= tolerance_mm)
    }
}

/// Number of voxels of a grid, if it can be addressed on this machine.
pub fn voxel_count(dims: [usize; 3]) -> Option<usize> {
    dims.iter()
        .try_fold(1usize, |n, &d| n.checked_mul(d))
        .filter(|&n| n <= isize::MAX as usize)
}

pub(crate) fn rows(affine: &DAffine3) -> String {
    let (m, t) = (affine.matrix3, affine.translation);
    format!(
        "[{} {} {} {}; {} {} {} {}; {} {} {} {}]",
        m.x_axis.x,
        m.y_axis.x,
        m.z_axis.x,
        t.x,
        m.x_axis.y,
        m.y_axis.y,
        m.z_axis.y,
        t.y,
        m.x_axis.z,
        m.y_axis.z,
        m.z_axis.z,
        t.z
    )
}
