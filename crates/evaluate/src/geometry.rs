//! Opaque meshes behind the volumes: of every pixel, how far away and in what color.
//!
//! Triangle by triangle, over the pixels that it can cover, by the exact ray of each pixel.

use glam::{DVec2, DVec3};
use std::ops::RangeInclusive;
use strahl_scene::plan::{Plan, PlanLight, Projection, Ray};
use strahl_shader::NOWHERE_MM;
use strahl_volume::{Cancelled, Control, Mesh};

/// The share of a mesh's color that is there without light, and the one that follows the light.
const AMBIENT: f64 = 0.25;
const DIFFUSE: f64 = 0.75;

/// What is behind the volumes, row by row.
pub struct Geometry {
    /// Along the ray; [`NOWHERE_MM`] without.
    pub distance_mm: Vec<f32>,
    /// Linear, premultiplied; the background without.
    pub color: Vec<[f32; 4]>,
}

/// Draws the meshes of `plan`.
pub fn draw(plan: &Plan, meshes: &[Mesh], control: &Control) -> Result<Geometry, Cancelled> {
    let (width, height) = (plan.width, plan.height);
    let pixels = width as usize * height as usize;
    let mut nearest = vec![f64::INFINITY; pixels];
    let mut color = vec![plan.background; pixels];
    for placed in &plan.meshes {
        let mesh = &meshes[placed.mesh];
        let map = placed.world_from_mesh;
        // Normals go by the inverse transpose.
        let normal_map = map.matrix3.inverse().transpose();
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        for triangle in mesh.triangles() {
            control.check()?;
            let own = triangle.map(|i| double(mesh.positions()[i as usize]));
            let corners = own.map(|p| map.transform_point3(p));
            let own_face = (own[1] - own[0]).cross(own[2] - own[0]);
            let Some((columns, rows)) = covered(plan, corners) else {
                continue;
            };
            for y in rows {
                for x in columns.clone() {
                    let ray = plan.camera.ray(x, y, width, height);
                    let at = (y * width + x) as usize;
                    let Some((t_mm, shares)) = meet(&ray, corners) else {
                        continue;
                    };
                    if t_mm >= nearest[at] {
                        continue;
                    }
                    let normal = match mesh.normals() {
                        None => own_face,
                        Some(normals) => {
                            let [a, b, c] = triangle.map(|i| double(normals[i as usize]));
                            a * shares[0] + b * shares[1] + c * shares[2]
                        }
                    };
                    nearest[at] = t_mm;
                    color[at] = lit(plan, &ray, t_mm, normal_map * normal, placed.color);
                }
            }
        }
    }
    let distance = |t: f64| if t.is_finite() { t as f32 } else { NOWHERE_MM };
    Ok(Geometry {
        distance_mm: nearest.into_iter().map(distance).collect(),
        color,
    })
}

/// Columns and rows of the pixels that a triangle may cover.
fn covered(plan: &Plan, corners: [DVec3; 3]) -> Option<(RangeInclusive<u32>, RangeInclusive<u32>)> {
    let camera = &plan.camera;
    let (width, height) = (f64::from(plan.width), f64::from(plan.height));
    let mut low = DVec2::INFINITY;
    let mut high = DVec2::NEG_INFINITY;
    for corner in corners {
        let way = corner - camera.eye_mm;
        let half = match camera.projection {
            Projection::Orthographic { half_height_mm } => half_height_mm,
            Projection::Perspective { tan_half_height } => {
                let ahead = way.dot(camera.forward);
                // Beside or behind the eye: anywhere in the picture.
                if ahead <= 1e-6 * way.length() {
                    return Some((0..=plan.width - 1, 0..=plan.height - 1));
                }
                tan_half_height * ahead
            }
        };
        let across = way.dot(camera.right) / (half * width / height);
        let upward = way.dot(camera.up) / half;
        let place = DVec2::new((across + 1.0) * 0.5 * width, (1.0 - upward) * 0.5 * height);
        low = low.min(place);
        high = high.max(place);
    }
    let range = |low: f64, high: f64, pixels: u32| {
        let last = f64::from(pixels) - 1.0;
        let (low, high) = ((low - 1.0).floor(), (high + 1.0).ceil());
        (low <= last && high >= 0.0).then(|| low.max(0.0) as u32..=high.min(last) as u32)
    };
    Some((
        range(low.x, high.x, plan.width)?,
        range(low.y, high.y, plan.height)?,
    ))
}

/// Where a ray meets a triangle, from either side, and the share of each corner there. T. Möller and
/// B. Trumbore (1997).
fn meet(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
    let (ab, ac) = (b - a, c - a);
    let across = ray.direction.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from_corner = ray.origin_mm - a;
    let u = from_corner.dot(across) / determinant;
    let along = from_corner.cross(ab);
    let v = ray.direction.dot(along) / determinant;
    let t = ac.dot(along) / determinant;
    // A hair of overlap, so that no ray slips between two triangles.
    const HAIR: f64 = 1e-9;
    (u >= -HAIR && v >= -HAIR && u + v <= 1.0 + HAIR && t >= 0.0)
        .then_some((t, [1.0 - u - v, u, v]))
}

/// Matt and two-sided, opaque.
fn lit(plan: &Plan, ray: &Ray, t_mm: f64, normal: DVec3, color: [f32; 3]) -> [f32; 4] {
    let place = ray.origin_mm + t_mm * ray.direction;
    let normal = normal.normalize_or(-ray.direction);
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
    let [r, g, b] = [0, 1, 2].map(|i| (light[i] * f64::from(color[i])) as f32);
    [r, g, b, 1.0]
}
