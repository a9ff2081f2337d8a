//! The uniform block of the ray loop: camera, lattice and table of a Plan.

use crate::volume_texture::Storage;
use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3};
use strahl_scene::plan::{Plan, Projection};

/// The struct `Frame` of the ray loop, byte for byte.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Frame {
    pub eye_mm: [f32; 3],
    pub step_mm: f32,
    pub right: [f32; 3],
    pub half_height: f32,
    pub up: [f32; 3],
    pub aspect: f32,
    pub forward: [f32; 3],
    pub is_perspective: u32,
    pub voxel_from_world: [[f32; 4]; 3],
    pub world_from_voxel: [[f32; 4]; 3],
    pub background: [f32; 4],
    pub dims: [u32; 3],
    pub number: u32,
    pub size: [u32; 2],
    pub origin: [u32; 2],
    pub steps_per_reference: f32,
    pub table_entries: u32,
    pub table_domain: [f32; 2],
    pub slope: f32,
    pub intercept: f32,
    pub padding: [f32; 2],
}

impl Frame {
    /// The frame of `plan` over a texture of this storage.
    pub fn of(plan: &Plan, storage: &Storage) -> Frame {
        let camera = &plan.camera;
        let (is_perspective, half_height) = match camera.projection {
            Projection::Perspective { tan_half_height } => (1, tan_half_height),
            Projection::Orthographic { half_height_mm } => (0, half_height_mm),
        };
        let grid = &plan.objects[0].grid;
        let rescale = plan.objects[0].rescale;
        let table = &plan.objects[0].table;
        // value = slope · (scale · texel + shift) + intercept
        let slope = rescale.slope * f64::from(storage.scale);
        let intercept = rescale.slope * f64::from(storage.shift) + rescale.intercept;
        Frame {
            eye_mm: single(camera.eye_mm),
            step_mm: plan.lattice.step_mm as f32,
            right: single(camera.right),
            half_height: half_height as f32,
            up: single(camera.up),
            aspect: (f64::from(plan.width) / f64::from(plan.height)) as f32,
            forward: single(camera.forward),
            is_perspective,
            voxel_from_world: rows(&grid.voxel_from_world()),
            world_from_voxel: rows(&grid.world_from_voxel()),
            background: plan.background,
            dims: grid.dims().map(|n| n as u32),
            number: 0,
            size: [plan.width, plan.height],
            origin: [0, 0],
            steps_per_reference: (plan.lattice.step_mm / f64::from(table.reference_mm())) as f32,
            table_entries: table.entries().len() as u32,
            table_domain: table.domain(),
            slope: slope as f32,
            intercept: intercept as f32,
            padding: [0.0; 2],
        }
    }
}

fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

fn rows(map: &DAffine3) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|r| {
        let linear = map.matrix3.row(r);
        [linear.x, linear.y, linear.z, map.translation[r]].map(|v| v as f32)
    })
}
