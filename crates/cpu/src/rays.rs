//! Rays through pixels, in world space.

use crate::doubles::{self, F64s, Points};
use crate::lanes::{PACKET, each, lanes};
use crate::levels::{Level, inlined};
use glam::DVec3;
use strahl_scene::plan::{Plan, Projection, Ray};

/// Rays in world space; points are `origin_mm + t · direction`, t ≥ 0 in mm.
pub struct Rays<S: Level> {
    /// t = 0.
    pub origin_mm: Points<S>,
    /// Unit length.
    pub direction: Points<S>,
}

impl<S: Level> Rays<S> {
    /// The rays through the centers of the pixels in these columns and rows, with the arithmetic of
    /// [`PlanCamera::ray`].
    ///
    /// [`PlanCamera::ray`]: strahl_scene::plan::PlanCamera::ray
    #[inline(always)]
    pub fn of_camera(plan: &Plan, columns: [u32; PACKET[0]], rows: [u32; PACKET[1]]) -> Rays<S> {
        let camera = &plan.camera;
        let (width, height) = (f64::from(plan.width), f64::from(plan.height));
        let aspect = width / height;
        let (mut across, mut upward) = ([0.0; PACKET[0]], [0.0; PACKET[1]]);
        for (across, x) in across.iter_mut().zip(columns) {
            *across = (2.0 * (f64::from(x) + 0.5) / width - 1.0) * aspect;
        }
        for (upward, y) in upward.iter_mut().zip(rows) {
            *upward = 1.0 - 2.0 * (f64::from(y) + 0.5) / height;
        }
        let across = F64s::from_array(lanes(|lane| across[lane % PACKET[0]]));
        let upward = F64s::from_array(lanes(|lane| upward[lane / PACKET[0]]));
        let one = F64s::splat(1.0);
        let (right, up) = (doubles::splat(camera.right), doubles::splat(camera.up));
        let forward = doubles::splat(camera.forward);
        let offset = inlined(
            #[inline(always)]
            |axis: usize| right[axis] * across + up[axis] * upward,
        );
        let offset = [offset(0), offset(1), offset(2)];
        let eye = doubles::splat(camera.eye_mm);
        match camera.projection {
            Projection::Perspective { tan_half_height } => {
                let long = doubles::along(forward, offset, F64s::splat(tan_half_height));
                let shorter = one.over(doubles::dot(long, long).sqrt());
                Rays {
                    origin_mm: eye,
                    direction: each!(long, |d| d * shorter),
                }
            }
            Projection::Orthographic { half_height_mm } => Rays {
                origin_mm: doubles::along(eye, offset, F64s::splat(half_height_mm)),
                direction: forward,
            },
        }
    }

    /// That of one lane.
    pub fn ray(&self, lane: usize) -> Ray {
        let vector = |v: &Points<S>| DVec3::new(v[0].lane(lane), v[1].lane(lane), v[2].lane(lane));
        Ray {
            origin_mm: vector(&self.origin_mm),
            direction: vector(&self.direction),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::LANES;
    use crate::levels::Portable;
    use strahl_scene::{Scene, resolve};
    use strahl_volume::Phantom;

    #[test]
    fn rays_are_those_of_the_camera() {
        let volume = Phantom::Tree.volume([8, 8, 8]).unwrap();
        for projection in ["perspective", "orthographic"] {
            let scene = format!(
                r#"{{ "size": [37, 23], "camera": {{ "projection": "{projection}", "azimuth_deg": 31 }} }}"#
            );
            let scene = Scene::parse("scene", &scene).unwrap();
            let plan = resolve(&scene, &volume.header(), None).unwrap();
            let columns = std::array::from_fn(|i| 8 + i as u32);
            let rows = std::array::from_fn(|i| 4 + i as u32);
            let rays = Rays::<Portable>::of_camera(&plan, columns, rows);
            for lane in 0..LANES {
                let (x, y) = (8 + lane % PACKET[0], 4 + lane / PACKET[0]);
                let ray = plan.camera.ray(x as u32, y as u32, plan.width, plan.height);
                assert_eq!(rays.ray(lane), ray, "{projection}, lane {lane}");
            }
        }
    }
}
