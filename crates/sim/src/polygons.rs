//! Polygons for the processor (document §8.5): the host rasterises them to one fragment per pixel, with its distance in
//! planes; the processor merges it among the samples of the ray.
//!
//! Of surfaces one behind the other the nearest is kept, as a frame buffer does. What lies before the image plane is put
//! onto it.

use crate::rays::RaySetup;
use crate::spec::{Shape, Spec};
use crate::stages::shade::phong;
use glam::{DAffine3, DVec3};
use std::ops::Range;
use strahl_volume::Mesh;

/// What a polygon shows in a pixel (document §8.5): the frame buffer of a rasteriser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fragment {
    /// Its distance from the image plane in steps: samples of this plane and behind are behind it.
    pub plane: u16,
    /// Its opacity: `widths.data` bits. A ray ends at an opaque one.
    pub opacity: u32,
    /// Its light: `widths.intensity` bits; grey pictures use the first.
    pub intensity: [u32; 3],
}

/// A surface in voxels.
#[derive(Clone, Debug)]
pub enum Surface {
    /// A point, and across it.
    Plane(DVec3, DVec3),
    /// Centre and radius.
    Sphere(DVec3, f64),
    /// Corners of triangles, and the normals there.
    Triangles(Vec<[(DVec3, DVec3); 3]>),
}

/// Where a ray meets a surface: how far behind the image plane in voxels along the view direction, and the normal there.
type Hit = (f64, DVec3);

impl Surface {
    /// A shape of the Spec; none for [`Shape::None`] and for files, which are read outside.
    pub fn of_shape(shape: &Shape) -> Option<Surface> {
        match *shape {
            Shape::None | Shape::File { .. } => None,
            Shape::Plane { point, normal } => Some(Surface::Plane(
                DVec3::from_array(point),
                DVec3::from_array(normal).normalize(),
            )),
            Shape::Sphere { centre, radius } => {
                Some(Surface::Sphere(DVec3::from_array(centre), radius))
            }
        }
    }

    /// The triangles of a mesh.
    pub fn of_mesh(mesh: &Mesh, voxel_from_world: DAffine3) -> Surface {
        let normals = mesh.vertex_normals();
        // Normals go with the transpose of the inverse.
        let turn = voxel_from_world.matrix3.inverse().transpose();
        let corner = |i: u32| {
            let position = DVec3::from_array(mesh.positions()[i as usize].map(f64::from));
            let normal = DVec3::from_array(normals[i as usize].map(f64::from));
            (
                voxel_from_world.transform_point3(position),
                (turn * normal).normalize_or_zero(),
            )
        };
        Surface::Triangles(mesh.triangles().iter().map(|t| t.map(corner)).collect())
    }

    /// The nearest fragment of every pixel (rows from the bottom), as far as it lies in `planes`.
    pub fn fragments(
        &self,
        spec: &Spec,
        setup: &RaySetup,
        planes: Range<u32>,
    ) -> Vec<Option<Fragment>> {
        let [width, height] = setup.size;
        let mut nearest: Vec<Option<Hit>> = vec![None; setup.pixel_count()];
        let eye = setup.eye_distance().map_or(f64::NEG_INFINITY, |d| -d);
        let mut meet = |x: u32, y: u32, hit: Option<Hit>| {
            let at = &mut nearest[y as usize * width as usize + x as usize];
            if let Some(hit) = hit
                && hit.0 > eye + 1e-6
                && at.is_none_or(|old| hit.0 < old.0)
            {
                *at = Some(hit);
            }
        };
        match self {
            Surface::Triangles(triangles) => {
                for triangle in triangles {
                    let [columns, rows] = seen(setup, triangle);
                    for y in rows {
                        for x in columns.clone() {
                            let (start, direction) = setup.line(x, y);
                            meet(x, y, triangle_hit(triangle, start, direction));
                        }
                    }
                }
            }
            _ => {
                for y in 0..height {
                    for x in 0..width {
                        let (start, direction) = setup.line(x, y);
                        meet(x, y, self.hit(start, direction, eye));
                    }
                }
            }
        }
        let widths = &spec.widths;
        let word = |share: f64, bits: u32| (share * f64::from((1u32 << bits) - 1)).round() as u32;
        let color = match spec.look.materials.is_empty() {
            true => [spec.polygons.color.iter().sum::<f64>() / 3.0; 3],
            false => spec.polygons.color,
        };
        let fragment = |(depth, normal): Hit| {
            let plane = ((depth / setup.step() - 1e-9).ceil()).clamp(0.0, 65535.0) as u32;
            // Both sides of a surface are lit.
            let facing = match normal.dot(setup.axes.forward) > 0.0 {
                true => -normal,
                false => normal,
            };
            let light = phong(&spec.look, &setup.axes, facing);
            planes.contains(&plane).then(|| Fragment {
                plane: plane as u16,
                opacity: word(spec.polygons.opacity, widths.data),
                intensity: color.map(|c| word((c * light).clamp(0.0, 1.0), widths.intensity)),
            })
        };
        nearest
            .into_iter()
            .map(|hit| hit.and_then(fragment))
            .collect()
    }

    /// Where a ray meets a plane or a ball first, behind the eye.
    fn hit(&self, start: DVec3, direction: DVec3, eye: f64) -> Option<Hit> {
        match self {
            Surface::Plane(point, normal) => {
                let t = (*point - start).dot(*normal) / direction.dot(*normal);
                t.is_finite().then_some((t, *normal))
            }
            Surface::Sphere(centre, radius) => {
                let from = start - *centre;
                let (a, b) = (direction.length_squared(), from.dot(direction));
                let root = (b * b - a * (from.length_squared() - radius * radius)).sqrt();
                let near = [(-b - root) / a, (-b + root) / a];
                let t = near.into_iter().find(|t| *t > eye + 1e-6)?;
                Some((t, (from + direction * t).normalize_or_zero()))
            }
            Surface::Triangles(triangles) => triangles
                .iter()
                .filter_map(|triangle| triangle_hit(triangle, start, direction))
                .filter(|hit| hit.0 > eye + 1e-6)
                .min_by(|a, b| a.0.total_cmp(&b.0)),
        }
    }
}

/// The pixels of a box around a triangle; all, if a corner lies at the eye or behind it.
fn seen(setup: &RaySetup, triangle: &[(DVec3, DVec3); 3]) -> [Range<u32>; 2] {
    let corners: Vec<[f64; 2]> = triangle
        .iter()
        .filter_map(|(p, _)| setup.project(*p))
        .collect();
    [0, 1].map(|axis| {
        let n = setup.size[axis];
        if corners.len() < 3 {
            return 0..n;
        }
        let at = corners.iter().map(|c| c[axis]);
        let low = at.clone().fold(f64::INFINITY, f64::min);
        let high = at.fold(f64::NEG_INFINITY, f64::max);
        low.floor().clamp(0.0, f64::from(n)) as u32
            ..(high.ceil() + 1.0).clamp(0.0, f64::from(n)) as u32
    })
}

/// T. Möller, B. Trumbore: "Fast, minimum storage ray/triangle intersection", 1997; normals are interpolated.
fn triangle_hit(triangle: &[(DVec3, DVec3); 3], start: DVec3, direction: DVec3) -> Option<Hit> {
    let [(a, na), (b, nb), (c, nc)] = *triangle;
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from = start - a;
    let u = from.dot(across) / determinant;
    let turned = from.cross(ab);
    let v = direction.dot(turned) / determinant;
    // Edges belong to both triangles, so that no ray slips between them.
    const SLACK: f64 = 1e-9;
    if u < -SLACK || v < -SLACK || u + v > 1.0 + SLACK {
        return None;
    }
    let normal = na * (1.0 - u - v) + nb * u + nc * v;
    let normal = match normal.length_squared() > 1e-12 {
        true => normal.normalize(),
        false => ab.cross(ac).normalize_or_zero(),
    };
    Some((ac.dot(turned) / determinant, normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Projection;
    use proptest::prelude::*;

    proptest! {
        /// Rasterised within the box of each triangle or met by every ray alone: the same fragments, parallel and perspective.
        #[test]
        fn boxes_of_triangles_lose_no_pixel(
            corners in prop::collection::vec(prop::array::uniform3(-30.0f64..60.0), 3..12),
            angle in 0.0f64..360.0, is_perspective in any::<bool>(),
        ) {
            let mut spec = Spec::default();
            spec.view.rotate_z_deg = angle;
            if is_perspective {
                spec.view.projection = Projection::Perspective { angle_deg: 60.0 };
            }
            let setup = RaySetup::new(&spec, [20, 24, 16]).unwrap();
            let corners: Vec<_> = corners.into_iter().map(|c| (DVec3::from_array(c), DVec3::ZERO)).collect();
            let triangles = corners.windows(3).map(|w| [w[0], w[1], w[2]]).collect();
            let surface = Surface::Triangles(triangles);
            let fragments = surface.fragments(&spec, &setup, 0..u32::MAX);
            let eye = setup.eye_distance().map_or(f64::NEG_INFINITY, |d| -d);
            for y in 0..setup.size[1] {
                for x in 0..setup.size[0] {
                    let (start, direction) = setup.line(x, y);
                    let expected = surface.hit(start, direction, eye).map(|(t, _)| (t - 1e-9).ceil().max(0.0) as u16);
                    let got = fragments[(y * setup.size[0] + x) as usize].map(|f| f.plane);
                    prop_assert_eq!(got, expected);
                }
            }
        }
    }

    #[test]
    fn a_ball_is_as_far_away_as_its_front() {
        let spec = Spec::default();
        let setup = RaySetup::new(&spec, [21, 41, 21]).unwrap();
        let ball = Surface::Sphere(DVec3::new(10.0, 20.0, 10.0), 6.0);
        let fragments = ball.fragments(&spec, &setup, 0..u32::MAX);
        let at = |x: usize, y: usize| fragments[y * 21 + x].map(|f| f.plane);
        assert_eq!(at(10, 10), Some(14));
        assert_eq!(at(10, 14), Some(16));
        assert_eq!(at(10, 17), None);
        let count = fragments.iter().flatten().count();
        assert!((100..120).contains(&count), "π · 6² = 113: {count}");
    }
}
