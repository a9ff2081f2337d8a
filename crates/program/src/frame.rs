//! The uniform block of the ray loop: camera, lattice and objects of a Plan.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3};
use strahl_scene::plan::{Plan, Projection};

/// The struct `Frame` of the ray loop up to its objects, byte for byte.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Frame {
    /// Where rays start: the eye, or the middle of the image plane.
    pub eye_mm: [f32; 3],
    /// Distance between samples.
    pub step_mm: f32,
    /// Unit vector.
    pub right: [f32; 3],
    /// Tangent of half the view angle, or half the height of the picture in mm.
    pub half_height: f32,
    /// Unit vector.
    pub up: [f32; 3],
    /// Width over height.
    pub aspect: f32,
    /// Unit vector.
    pub forward: [f32; 3],
    /// 1 or 0.
    pub is_perspective: u32,
    /// Linear, premultiplied.
    pub background: [f32; 4],
    /// Of the picture, in pixels.
    pub size: [u32; 2],
    /// The pixel at the corner of the part that is drawn.
    pub origin: [u32; 2],
    /// Which of the pictures that are averaged.
    pub number: u32,
    /// The slice that the first instance draws; 0 where no slices are drawn.
    pub first_slice: i32,
    /// Of what is drawn into, in pixels: the first triangle corner lies at its lower left end.
    pub viewport: [u32; 2],
}

/// The struct `Object` of the ray loop, byte for byte.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Object {
    /// Rows of an affine map.
    pub voxel_from_world: [[f32; 4]; 3],
    /// Rows of an affine map.
    pub world_from_voxel: [[f32; 4]; 3],
    /// Voxels.
    pub dims: [u32; 3],
    /// Which of the volumes it shows.
    pub volume: u32,
    /// Where its bricks begin in the texture of all.
    pub bricks_first: [u32; 3],
    /// The entry at which its transfer table begins.
    pub table_first: u32,
    /// Where its pages begin in the texture of all.
    pub pages_first: [u32; 3],
    /// Entries of its table.
    pub table_entries: u32,
    /// Values of the first and last entry.
    pub table_domain: [f32; 2],
    /// value = slope · texel + intercept.
    pub slope: f32,
    /// See `slope`.
    pub intercept: f32,
    /// The exponent of the opacity correction.
    pub steps_per_reference: f32,
    /// Unused.
    pub padding: [u32; 3],
}

impl Frame {
    /// The frame of `plan`.
    pub fn of(plan: &Plan) -> Frame {
        let camera = &plan.camera;
        let (is_perspective, half_height) = match camera.projection {
            Projection::Perspective { tan_half_height } => (1, tan_half_height),
            Projection::Orthographic { half_height_mm } => (0, half_height_mm),
        };
        Frame {
            eye_mm: single(camera.eye_mm),
            step_mm: plan.lattice.step_mm as f32,
            right: single(camera.right),
            half_height: half_height as f32,
            up: single(camera.up),
            aspect: (f64::from(plan.width) / f64::from(plan.height)) as f32,
            forward: single(camera.forward),
            is_perspective,
            background: plan.background,
            size: [plan.width, plan.height],
            origin: [0, 0],
            number: 0,
            first_slice: 0,
            viewport: [plan.width, plan.height],
        }
    }

    /// The bytes of the block: the frame, then the objects.
    pub fn bytes(&self, objects: &[Object]) -> Vec<u8> {
        let mut bytes = bytemuck::bytes_of(self).to_vec();
        bytes.extend_from_slice(bytemuck::cast_slice(objects));
        bytes
    }
}

impl Object {
    /// Layer number `layer` of `plan`, whose values are slope · texel + intercept. Where its table, bricks and
    /// pages begin is left 0.
    pub fn of(plan: &Plan, layer: usize, slope: f64, intercept: f64) -> Object {
        let (field, table) = (plan.field_of(layer), &plan.technique_of(layer).table);
        Object {
            voxel_from_world: rows(&field.grid.voxel_from_world()),
            world_from_voxel: rows(&field.grid.world_from_voxel()),
            dims: field.grid.dims().map(|n| n as u32),
            volume: field.volume as u32,
            bricks_first: [0; 3],
            table_first: 0,
            pages_first: [0; 3],
            table_entries: table.entries().len() as u32,
            table_domain: table.domain(),
            slope: slope as f32,
            intercept: intercept as f32,
            steps_per_reference: (plan.lattice.step_mm / f64::from(table.reference_mm())) as f32,
            padding: [0; 3],
        }
    }
}

/// The struct `ImportanceVolume` of the ray loop, byte for byte.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct ImportanceBlock {
    /// Rows of an affine map.
    pub unit_from_world: [[f32; 4]; 3],
    /// The numbers of the texture that count as 0 and as 1.
    pub range: [f32; 2],
    /// Which of the masks.
    pub mask: u32,
    /// 1 or 0.
    pub is_there: u32,
}

impl ImportanceBlock {
    /// That of `plan`; `number` turns a value of a mask into the number of its texture.
    pub fn of(plan: &Plan, number: impl Fn(usize, f32) -> f64) -> ImportanceBlock {
        let Some(importance) = plan.importance else {
            return ImportanceBlock::default();
        };
        let number = |value| number(importance.mask, value) as f32;
        ImportanceBlock {
            unit_from_world: rows(&importance.unit_from_world),
            range: [number(importance.low), number(importance.high)],
            mask: importance.mask as u32,
            is_there: 1,
        }
    }
}

/// In single precision.
pub fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// The rows of an affine map.
pub fn rows(map: &DAffine3) -> [[f32; 4]; 3] {
    [0, 1, 2].map(|r| {
        let linear = map.matrix3.row(r);
        [linear.x, linear.y, linear.z, map.translation[r]].map(|v| v as f32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::TypeInner;
    use strahl_scene::{Scene, resolve};
    use strahl_volume::Phantom;

    /// The name and first byte of every field, which have to be all that there are.
    macro_rules! fields {
        ($name:ident { $($field:ident),* $(,)? }) => {{
            let $name { $($field: _),* } = $name::zeroed();
            vec![$((stringify!($field), std::mem::offset_of!($name, $field))),*]
        }};
    }

    /// The name and first byte of every member of a struct in WGSL, and its size.
    fn members<'n>(naga: &'n naga::Module, name: &str) -> (Vec<(&'n str, usize)>, usize) {
        let mut types = naga.types.iter().map(|(_, ty)| ty);
        let found = types.find(|ty| ty.name.as_deref() == Some(name));
        let Some(TypeInner::Struct { members, span }) = found.map(|ty| &ty.inner) else {
            panic!("there is no struct {name}");
        };
        let member = |m: &'n naga::StructMember| (m.name.as_deref().unwrap(), m.offset as usize);
        (members.iter().map(member).collect(), *span as usize)
    }

    #[test]
    fn the_block_of_the_ray_loop_lies_as_the_program_reads_it() {
        let volume = Phantom::Tree.volume([8; 3]).unwrap();
        let plan = resolve(&Scene::default(), &volume.header(), None).unwrap();
        let program = crate::program(&plan).unwrap();
        let (frame, _) = members(program.naga(), "Frame");
        let mut ours = fields!(Frame {
            eye_mm,
            step_mm,
            right,
            half_height,
            up,
            aspect,
            forward,
            is_perspective,
            background,
            size,
            origin,
            number,
            first_slice,
            viewport,
        });
        ours.push(("objects", size_of::<Frame>()));
        assert_eq!(frame, ours);

        let (object, size) = members(program.naga(), "Object");
        let ours = fields!(Object {
            voxel_from_world,
            world_from_voxel,
            dims,
            volume,
            bricks_first,
            table_first,
            pages_first,
            table_entries,
            table_domain,
            slope,
            intercept,
            steps_per_reference,
            padding,
        });
        assert_eq!(object, ours[..ours.len() - 1], "all but the padding");
        assert_eq!(size, size_of::<Object>());
    }
}
