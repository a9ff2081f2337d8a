//! Triangle meshes: opaque surfaces that are drawn together with volumes.

use crate::{ContentId, Error, Grid};
use glam::{DAffine3, DVec3, Vec3};
use std::borrow::Cow;
use std::sync::Arc;

/// A surface of triangles in the world of the volumes: RAS, millimeters. Seen from its front, the
/// corners of a triangle run counter-clockwise. Immutable once made; clones share its content and its
/// [`id`](Mesh::id).
///
/// ```
/// use strahl_volume::Mesh;
/// let corners = vec![[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]];
/// let mesh = Mesh::new(corners, vec![[0, 1, 2]], None)?;
/// assert_eq!(mesh.bounds_mm().1, glam::DVec3::new(10.0, 10.0, 0.0));
/// assert_eq!(mesh.vertex_normals()[0], [0.0, 0.0, 1.0]);
/// # Ok::<(), strahl_volume::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mesh {
    id: ContentId,
    surface: Arc<Surface>,
}

#[derive(Debug, PartialEq)]
struct Surface {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    bounds_mm: (DVec3, DVec3),
}

impl Mesh {
    /// A mesh of `triangles` whose corners are indices into `positions` (RAS mm). `normals`, if
    /// given, has one direction per position, of any length; 0 where there is none.
    ///
    /// # Errors
    /// No triangle; a corner that is no position; a position or normal that is not finite; a
    /// position beyond [`Grid::FARTHEST_MM`]; another number of normals than of positions.
    pub fn new(
        positions: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        normals: Option<Vec<[f32; 3]>>,
    ) -> Result<Mesh, Error> {
        let farthest = Grid::FARTHEST_MM as f32;
        for (i, position) in positions.iter().enumerate() {
            // NaN is not at most anything.
            if !position.iter().all(|c| c.abs() <= farthest) {
                return Err(Error::field(
                    format!("position {i}"),
                    format!("{position:?}"),
                    format!("three numbers from -{farthest:e} to {farthest:e} mm"),
                ));
            }
        }
        if triangles.is_empty() {
            return Err(Error::field("number of triangles", 0, "at least one"));
        }
        for (i, triangle) in triangles.iter().enumerate() {
            if let Some(corner) = triangle.iter().find(|c| **c as usize >= positions.len()) {
                return Err(Error::field(
                    format!("corner of triangle {i}"),
                    corner,
                    format!(
                        "an index below {}, the number of positions",
                        positions.len()
                    ),
                ));
            }
        }
        let normals = match normals {
            Some(normals) => Some(unit_normals(normals, positions.len())?),
            None => None,
        };
        let corners = triangles.iter().flatten().map(|&c| position(&positions, c));
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let bounds_mm = corners.fold(nothing, |(lo, hi), c| (lo.min(c), hi.max(c)));
        Ok(Mesh {
            id: ContentId::unique(),
            surface: Arc::new(Surface {
                positions,
                triangles,
                normals,
                bounds_mm,
            }),
        })
    }

    /// What clones of this mesh have in common, and no other mesh has.
    pub fn id(&self) -> ContentId {
        self.id
    }

    /// Where the vertices lie, RAS mm.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.surface.positions
    }

    /// Three indices into [`Mesh::positions`] each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.surface.triangles
    }

    /// The normals that came with the mesh: one per position, of unit length, or 0.
    pub fn normals(&self) -> Option<&[[f32; 3]]> {
        self.surface.normals.as_deref()
    }

    /// One normal per position: those that came with the mesh, else the mean of the normals of the
    /// triangles around, weighted by their areas (H. Gouraud 1971, with weights). 0 where no triangle
    /// with an area is, or where opposite ones cancel out.
    pub fn vertex_normals(&self) -> Cow<'_, [[f32; 3]]> {
        if let Some(normals) = &self.surface.normals {
            return Cow::Borrowed(normals);
        }
        let mut sums = vec![DVec3::ZERO; self.surface.positions.len()];
        for triangle in &self.surface.triangles {
            let [a, b, c] = triangle.map(|corner| position(&self.surface.positions, corner));
            // Twice the area long.
            let normal = (b - a).cross(c - a);
            for &corner in triangle {
                sums[corner as usize] += normal;
            }
        }
        let normals = sums.into_iter();
        Cow::Owned(
            normals
                .map(|sum| sum.normalize_or_zero().as_vec3().to_array())
                .collect(),
        )
    }

    /// Axis-aligned box around all triangles in RAS mm: (smallest corner, largest corner).
    pub fn bounds_mm(&self) -> (DVec3, DVec3) {
        self.surface.bounds_mm
    }

    /// The mesh moved by `to_from_mesh`. A map that mirrors turns the triangles around too, so that
    /// their fronts stay outside.
    ///
    /// # Errors
    /// A map that is not finite or cannot be inverted; a position moved beyond [`Grid::FARTHEST_MM`].
    pub fn transformed(&self, to_from_mesh: DAffine3) -> Result<Mesh, Error> {
        let matrix = to_from_mesh.matrix3;
        let determinant = matrix.determinant();
        let inverse = matrix.inverse();
        if !to_from_mesh.is_finite() || determinant == 0.0 || !inverse.is_finite() {
            return Err(Error::field(
                "map that moves a mesh",
                crate::grid::rows(&to_from_mesh),
                "a finite one that can be inverted",
            ));
        }
        let moved = |p: &[f32; 3]| {
            let point = Vec3::from_array(*p).as_dvec3();
            to_from_mesh.transform_point3(point).as_vec3().to_array()
        };
        // Planes go by the inverse transpose; it keeps the outside of a mirrored mesh outside.
        let normals_matrix = inverse.transpose();
        let turned = |n: &[f32; 3]| {
            let normal = normals_matrix * Vec3::from_array(*n).as_dvec3();
            normal.normalize_or_zero().as_vec3().to_array()
        };
        let triangles = self
            .surface
            .triangles
            .iter()
            .map(|&[a, b, c]| match determinant > 0.0 {
                true => [a, b, c],
                false => [a, c, b],
            });
        Mesh::new(
            self.surface.positions.iter().map(moved).collect(),
            triangles.collect(),
            self.surface
                .normals
                .as_ref()
                .map(|normals| normals.iter().map(turned).collect()),
        )
    }
}

/// By what they show, whatever their ids.
impl PartialEq for Mesh {
    fn eq(&self, other: &Mesh) -> bool {
        self.surface == other.surface
    }
}

impl From<&Mesh> for Mesh {
    /// A clone.
    fn from(mesh: &Mesh) -> Mesh {
        mesh.clone()
    }
}

fn position(positions: &[[f32; 3]], index: u32) -> DVec3 {
    Vec3::from_array(positions[index as usize]).as_dvec3()
}

fn unit_normals(mut normals: Vec<[f32; 3]>, positions: usize) -> Result<Vec<[f32; 3]>, Error> {
    if normals.len() != positions {
        return Err(Error::field(
            "number of normals",
            normals.len(),
            format!("{positions}, the number of positions"),
        ));
    }
    for (i, normal) in normals.iter_mut().enumerate() {
        let direction = Vec3::from_array(*normal);
        if !direction.is_finite() {
            return Err(Error::field(
                format!("normal {i}"),
                format!("{normal:?}"),
                "three finite numbers",
            ));
        }
        // In double precision, for squares of f32 overflow.
        *normal = direction
            .as_dvec3()
            .normalize_or_zero()
            .as_vec3()
            .to_array();
    }
    Ok(normals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    /// The tetrahedron with corners at the origin and one along each axis, fronts outside.
    fn tetrahedron() -> Mesh {
        Mesh::new(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            None,
        )
        .unwrap()
    }

    #[test]
    fn what_cannot_be_a_mesh_is_refused() {
        let message = |positions: Vec<[f32; 3]>, triangles, normals| {
            Mesh::new(positions, triangles, normals)
                .unwrap_err()
                .to_string()
        };
        let three = || vec![[0.0; 3], [1.0; 3], [2.0, 0.0, 0.0]];
        let found = message(three(), vec![[0, 1, 2], [0, 1, 3]], None);
        assert_eq!(
            found,
            "corner of triangle 1 is 3; allowed: an index below 3, the number of positions"
        );
        assert!(message(three(), vec![], None).contains("number of triangles is 0"));
        for bad in [f32::NAN, f32::INFINITY, -2e12] {
            let found = message(vec![[0.0; 3], [0.0, bad, 0.0]], vec![[0, 1, 1]], None);
            assert!(found.contains("position 1"), "{found}");
        }
        let found = message(three(), vec![[0, 1, 2]], Some(vec![[1.0, 0.0, 0.0]]));
        assert!(
            found.contains("number of normals is 1; allowed: 3"),
            "{found}"
        );
        let found = message(three(), vec![[0, 1, 2]], Some(vec![[f32::NAN; 3]; 3]));
        assert!(found.contains("normal 0"), "{found}");
    }

    #[test]
    fn normals_are_weighted_by_area() {
        // At the origin three equal triangles meet; at the corner on x, two of 1/2 and the slanted one
        // of √3/2, whose normal is (1, 1, 1)/√3: (0, 0, −1) + (0, −1, 0) + (1, 1, 1).
        let mesh = tetrahedron();
        let normals = mesh.vertex_normals();
        let third = -(1.0f32 / 3.0).sqrt();
        for c in 0..3 {
            assert!((normals[0][c] - third).abs() < 1e-6, "{:?}", normals[0]);
        }
        let expected = [1.0, 0.0, 0.0];
        for c in 0..3 {
            assert!(
                (normals[1][c] - expected[c]).abs() < 1e-6,
                "{:?}",
                normals[1]
            );
        }
    }

    #[test]
    fn stated_normals_are_kept_at_unit_length() {
        let normals = vec![[0.0, 0.0, -3e30], [0.0; 3], [1e-30, 0.0, 0.0]];
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::new(corners, vec![[0, 1, 2]], Some(normals)).unwrap();
        let expected = [[0.0, 0.0, -1.0], [0.0; 3], [1.0, 0.0, 0.0]];
        assert_eq!(*mesh.vertex_normals(), expected);
    }

    #[test]
    fn triangles_without_area_have_no_say() {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [1, 1, 1]], None).unwrap();
        assert_eq!(*mesh.vertex_normals(), [[0.0; 3]; 3]);
    }

    #[test]
    fn vertices_of_no_triangle_do_not_widen_the_bounds() {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [900.0; 3]];
        let mesh = Mesh::new(corners, vec![[0, 1, 2]], None).unwrap();
        let expected = (DVec3::new(0.0, -2.0, 0.0), DVec3::new(1.0, 0.0, 0.0));
        assert_eq!(mesh.bounds_mm(), expected);
    }

    /// Fronts outside: the volume by the divergence theorem is above 0 and grows by the determinant.
    #[test]
    fn maps_keep_the_outside_outside() {
        let volume = |mesh: &Mesh| -> f64 {
            let parts = mesh.triangles().iter().map(|triangle| {
                let [a, b, c] = triangle.map(|corner| position(mesh.positions(), corner));
                a.dot(b.cross(c)) / 6.0
            });
            parts.sum()
        };
        let mesh = tetrahedron();
        assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-7);
        for scale in [DVec3::new(2.0, 3.0, 0.5), DVec3::new(-1.0, 1.0, 4.0)] {
            let matrix = DMat3::from_rotation_x(0.3) * DMat3::from_diagonal(scale);
            let map = DAffine3::from_mat3_translation(matrix, DVec3::new(5.0, -7.0, 1.0));
            let moved = mesh.transformed(map).unwrap();
            let expected = matrix.determinant().abs() / 6.0;
            assert!((volume(&moved) - expected).abs() < 1e-4 * expected.abs().max(1.0));
            // A stated normal of a face stays perpendicular to it, and outside.
            let slanted = Mesh::new(
                mesh.positions().to_vec(),
                vec![[1, 2, 3]],
                Some(vec![[1.0; 3]; 4]),
            );
            let slanted = slanted.unwrap().transformed(map).unwrap();
            let stated = Vec3::from_array(slanted.normals().unwrap()[1]);
            let own = Mesh::new(
                slanted.positions().to_vec(),
                slanted.triangles().to_vec(),
                None,
            );
            let own = Vec3::from_array(own.unwrap().vertex_normals()[1]);
            assert!(stated.distance(own) < 1e-5, "{stated} {own}");
        }
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert!(mesh.transformed(flat).is_err());
        assert!(
            mesh.transformed(DAffine3::from_scale(DVec3::splat(f64::NAN)))
                .is_err()
        );
    }
}
