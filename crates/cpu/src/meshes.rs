//! Opaque surfaces of triangles: where a ray meets them, and what they look like.

use crate::making::Making;
use crate::mesh_tree::tree;
use glam::{DVec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::ray::{Ray as Search, RayHit};
use obvhs::triangle::Triangle;
use std::sync::Arc;
use strahl_scene::plan::{Plan, PlanLight, PlanMesh, Ray};
use strahl_volume::{Cancelled, ContentId, Key, Mesh};

/// The share of a mesh's color that is there without light, and the one that follows the light.
const AMBIENT: f64 = 0.25;
const DIFFUSE: f64 = 0.75;

/// Meshes ready to be searched.
pub struct Meshes(Vec<Arc<SearchTree>>);

/// Key of the tree over a mesh.
#[derive(Clone, PartialEq)]
struct SearchTreeKey(ContentId);

impl Key for SearchTreeKey {
    type Value = SearchTree;

    const NAME: &str = "trees of meshes";

    fn bytes(&self, value: &SearchTree) -> usize {
        let triangles = size_of::<Triangle>() + size_of::<[DVec3; 3]>();
        let normals = value.normals.as_ref().map_or(0, |n| size_of_val(&n[..]));
        let nodes = size_of_val(&value.tree.nodes[..]);
        value.triangles.len() * triangles + normals + nodes
    }
}

struct SearchTree {
    tree: Bvh2,
    triangles: Vec<Triangle>,
    /// Corners of each triangle, as given.
    corners: Vec<[DVec3; 3]>,
    /// Normals at the corners, where the mesh has them: it is smooth then.
    normals: Option<Vec<[DVec3; 3]>>,
    center: DVec3,
    /// Of a ball about the center that holds it all.
    radius: f64,
}

struct Hit {
    t_mm: f64,
    /// Not normalized, in the space of the mesh.
    normal: DVec3,
}

impl Meshes {
    /// Builds a tree of boxes over the triangles of each mesh.
    pub fn new(making: &Making, meshes: &[Mesh]) -> Result<Meshes, Cancelled> {
        let find = |mesh: &Mesh| {
            let make = || Ok(SearchTree::new(mesh));
            making.find(&SearchTreeKey(mesh.id()), make)
        };
        meshes
            .iter()
            .map(find)
            .collect::<Result<_, _>>()
            .map(Meshes)
    }

    /// What is behind all volumes on a ray of `plan`: the distance of the nearest surface (infinite
    /// without) and its premultiplied color, or the background.
    pub fn behind(&self, ray: &Ray, plan: &Plan) -> (f64, [f32; 4]) {
        let mut nearest: Option<(Hit, &PlanMesh)> = None;
        for placed in &plan.meshes {
            let before = nearest.as_ref().map_or(f64::INFINITY, |(hit, _)| hit.t_mm);
            if let Some(hit) = self.0[placed.mesh].first_hit(ray, placed)
                && hit.t_mm < before
            {
                nearest = Some((hit, placed));
            }
        }
        match nearest {
            None => (f64::INFINITY, plan.background),
            Some((hit, placed)) => (hit.t_mm, color(plan, ray, &hit, placed)),
        }
    }
}

impl SearchTree {
    fn new(mesh: &Mesh) -> SearchTree {
        let at = |i: u32| mesh.positions()[i as usize];
        let corners: Vec<[[f32; 3]; 3]> = mesh.triangles().iter().map(|t| t.map(at)).collect();
        let triangles: Vec<Triangle> = corners
            .iter()
            .map(|&[a, b, c]| Triangle {
                v0: Vec3A::from_array(a),
                v1: Vec3A::from_array(b),
                v2: Vec3A::from_array(c),
            })
            .collect();
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let (lo, hi) = mesh.bounds_mm();
        SearchTree {
            tree: tree(&triangles),
            triangles,
            corners: corners.iter().map(|t| t.map(double)).collect(),
            normals: mesh.normals().map(|normals| {
                let normal = |i: u32| double(normals[i as usize]);
                mesh.triangles().iter().map(|t| t.map(normal)).collect()
            }),
            center: 0.5 * (lo + hi),
            radius: 0.5001 * hi.distance(lo),
        }
    }

    /// The first triangle that the ray meets; distances are those along the ray in the world.
    fn first_hit(&self, ray: &Ray, placed: &PlanMesh) -> Option<Hit> {
        let mesh_from_world = placed.world_from_mesh.inverse();
        let origin = mesh_from_world.transform_point3(ray.origin_mm);
        let direction = mesh_from_world.transform_vector3(ray.direction);
        // The search is in single precision: it starts just before the mesh, wherever the eye is, and
        // goes ahead only.
        let length = direction.length();
        let center = direction.dot(self.center - origin) / length;
        let before = (center - self.radius) / length;
        let before = if before.is_finite() {
            before.max(0.0)
        } else {
            0.0
        };
        let start = (origin + before * direction).as_vec3a();
        let search = Search::new(start, direction.as_vec3a(), 0.0, f32::INFINITY);
        let mut hit = RayHit::none();
        let index = |id: usize| self.tree.primitive_indices[id] as usize;
        let found = self.tree.ray_traverse(search, &mut hit, |search, id| {
            meet(&self.triangles[index(id)], search)
        });
        if !found {
            return None;
        }
        let triangle = index(hit.primitive_id as usize);
        let [a, b, c] = self.corners[triangle];
        let face = (b - a).cross(c - a);
        // Again in double precision, now that the triangle is known.
        let t_mm = face.dot(a - origin) / face.dot(direction);
        let t_mm = if t_mm.is_finite() {
            t_mm
        } else {
            before + f64::from(hit.t)
        };
        let normal = match &self.normals {
            None => face,
            Some(normals) => {
                let place = origin + t_mm * direction;
                let share = |u: DVec3, v: DVec3| (u - place).cross(v - place).dot(face);
                let [na, nb, nc] = normals[triangle];
                na * share(b, c) + nb * share(c, a) + nc * share(a, b)
            }
        };
        Some(Hit { t_mm, normal })
    }
}

/// Where a ray meets a triangle, from either side; infinite where it does not. T. Möller and
/// B. Trumbore (1997).
fn meet(triangle: &Triangle, ray: &Search) -> f32 {
    let (ab, ac) = (triangle.v1 - triangle.v0, triangle.v2 - triangle.v0);
    let across = ray.direction.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return f32::INFINITY;
    }
    let from_corner = ray.origin - triangle.v0;
    let u = from_corner.dot(across) / determinant;
    let along = from_corner.cross(ab);
    let v = ray.direction.dot(along) / determinant;
    // A hair of overlap, so that no ray slips between two triangles.
    const HAIR: f32 = 1e-6;
    if u < -HAIR || v < -HAIR || u + v > 1.0 + HAIR {
        return f32::INFINITY;
    }
    let t = ac.dot(along) / determinant;
    if t >= ray.tmin { t } else { f32::INFINITY }
}

/// Matt and two-sided, opaque.
fn color(plan: &Plan, ray: &Ray, hit: &Hit, placed: &PlanMesh) -> [f32; 4] {
    let place = ray.origin_mm + hit.t_mm * ray.direction;
    // Normals go by the inverse transpose.
    let map = placed.world_from_mesh.matrix3.inverse().transpose();
    let normal = (map * hit.normal).normalize_or(-ray.direction);
    let normal = if normal.dot(ray.direction) > 0.0 {
        -normal
    } else {
        normal
    };
    let mut light = DVec3::splat(AMBIENT);
    for source in &plan.lights {
        let (to_light, radiance, fall) = match *source {
            PlanLight::Directional { to_light, radiance } => (to_light, radiance, 1.0),
            PlanLight::Head { radiance } => (-ray.direction, radiance, 1.0),
            PlanLight::Point {
                place_mm,
                reach_mm,
                radiance,
            } => {
                let way = place_mm - place;
                let reach = f64::from(reach_mm);
                let distance = way.length().max(0.001 * reach);
                (way / distance, radiance, (reach / distance).powi(2))
            }
        };
        let radiance = DVec3::from_array(radiance.map(f64::from));
        light += radiance * (DIFFUSE * fall * normal.dot(to_light).max(0.0));
    }
    let [r, g, b] = placed.color;
    let lit = light * DVec3::new(r.into(), g.into(), b.into());
    [lit.x as f32, lit.y as f32, lit.z as f32, 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    /// A square of 2 mm about the origin, facing +x.
    fn square() -> Mesh {
        let corner = |y: f32, z: f32| [0.0, y, z];
        let positions = vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3]], None).unwrap()
    }

    fn distance(ray: &Ray, world_from_mesh: DAffine3) -> Option<f64> {
        let meshes = [SearchTree::new(&square())];
        let placed = PlanMesh {
            mesh: 0,
            world_from_mesh,
            color: [1.0; 3],
        };
        meshes[0].first_hit(ray, &placed).map(|hit| hit.t_mm)
    }

    #[test]
    fn distances_are_those_of_the_plane_from_far_and_near_and_both_sides() {
        for far in [1e-3, 1.0, 1e5] {
            for side in [1.0, -1.0] {
                for y in [-0.99, 0.0, 0.3, 0.99] {
                    let ray = Ray {
                        origin_mm: DVec3::new(side * far + 7.0, y, y),
                        direction: DVec3::new(-side, 0.0, 0.0),
                    };
                    let moved = DAffine3::from_translation(DVec3::new(7.0, 0.0, 0.0));
                    let t = distance(&ray, moved).unwrap();
                    assert!((t - far).abs() <= 1e-12 * far, "{t} for {far}");
                }
            }
        }
    }

    #[test]
    fn what_lies_before_the_middle_of_a_mesh_is_hit() {
        for y in [-0.99, -0.5, 0.5, 0.99] {
            let direction = DVec3::new(-0.1, 1.0, 0.0).normalize();
            let ray = Ray {
                origin_mm: DVec3::new(0.0, y, 0.0) - 30.0 * direction,
                direction,
            };
            let t = distance(&ray, DAffine3::IDENTITY).unwrap();
            assert!((t - 30.0).abs() < 1e-12, "{y}: {t}");
        }
    }

    #[test]
    fn scaled_meshes_are_hit_where_they_are() {
        let grown = DAffine3::from_scale(DVec3::new(1.0, 10.0, 10.0));
        let ray = |y: f64, x: f64| Ray {
            origin_mm: DVec3::new(x, y, 0.0),
            direction: -DVec3::X,
        };
        assert_eq!(distance(&ray(9.5, 5.0), grown), Some(5.0));
        assert_eq!(distance(&ray(10.5, 5.0), grown), None);
        // What lies behind the eye is not seen.
        assert_eq!(distance(&ray(0.0, -5.0), grown), None);
    }
}
