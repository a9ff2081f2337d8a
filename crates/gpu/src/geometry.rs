//! Opaque meshes: rasterized before the volumes, which end their rays there.

use crate::device::Device;
use crate::error::Error;
use crate::pipelines::{COLOR, DISTANCE};
use crate::target::{PART, Plane};
use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};
use std::sync::Arc;
use strahl_program::{rows, single};
use strahl_scene::plan::{Plan, PlanLight, Projection};
use strahl_shader::NOWHERE_MM;
use strahl_volume::Mesh;
use wgpu::util::DeviceExt;

/// The struct `View` of `geometry.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct View {
    eye_mm: [f32; 3],
    half_height: f32,
    right: [f32; 3],
    aspect: f32,
    up: [f32; 3],
    is_perspective: u32,
    forward: [f32; 3],
    near_mm: f32,
    size: [f32; 2],
    origin: [f32; 2],
    far_mm: f32,
    part: f32,
    padding: [f32; 2],
}

/// The struct `Mesh` of `geometry.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct PlacedMesh {
    world_from_mesh: [[f32; 4]; 3],
    normal_map: [[f32; 4]; 3],
    color: [f32; 4],
}

/// A mesh on the device.
#[derive(Debug)]
pub struct MeshCorners {
    /// Corners of all triangles: position and normal.
    corners: wgpu::Buffer,
    bounds_mm: (DVec3, DVec3),
}

impl MeshCorners {
    pub fn new(device: &Device, mesh: &Mesh) -> Result<MeshCorners, Error> {
        let numbers = corners_of(mesh);
        let bytes: &[u8] = bytemuck::cast_slice(&numbers);
        let most = device.device.limits().max_buffer_size;
        if bytes.len() as u64 > most {
            return Err(Error::MeshTooLarge {
                triangles: mesh.triangles().len(),
                most: (most / 72) as usize,
            });
        }
        let description = wgpu::util::BufferInitDescriptor {
            label: Some("mesh"),
            contents: bytes,
            usage: wgpu::BufferUsages::VERTEX,
        };
        Ok(MeshCorners {
            corners: device.device.create_buffer_init(&description),
            bounds_mm: mesh.bounds_mm(),
        })
    }

    /// That it takes on the device.
    pub fn bytes(&self) -> usize {
        self.corners.size() as usize
    }
}

fn corners_of(mesh: &Mesh) -> Vec<[f32; 6]> {
    let mut corners = Vec::with_capacity(3 * mesh.triangles().len());
    for triangle in mesh.triangles() {
        let places = triangle.map(|i| mesh.positions()[i as usize]);
        let [a, b, c] = places.map(Vec3::from_array);
        // Without normals of its own a mesh shows its triangles.
        let face = (b - a).cross(c - a).normalize_or_zero().to_array();
        for (i, [x, y, z]) in triangle.iter().zip(places) {
            let [u, v, w] = mesh.normals().map_or(face, |n| n[*i as usize]);
            corners.push([x, y, z, u, v, w]);
        }
    }
    corners
}

/// What is behind the volumes of one part: color and distance.
pub struct Geometry {
    pub color: Plane,
    pub distance: Plane,
    nearest: Plane,
    pipeline: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    view_numbers: View,
    /// Of each mesh of the Plan: which one, its resources.
    placed: Vec<(usize, wgpu::BindGroup)>,
    background: [f32; 4],
}

impl Geometry {
    /// The meshes of `plan`, ready to be drawn.
    pub fn new(device: &Device, meshes: &[Arc<MeshCorners>], plan: &Plan) -> Geometry {
        let depth_format = wgpu::TextureFormat::Depth32Float;
        let sources: Vec<_> = plan.lights.iter().map(source).collect();
        let sources = if sources.is_empty() {
            vec![[[0.0; 4]; 2]]
        } else {
            sources
        };
        let text = format!(
            "const SOURCES: u32 = {}u;\n\n{}",
            sources.len(),
            include_str!("geometry.wgsl")
        );
        let module = device
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("geometry"),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
        let pipeline = device
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("geometry"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: 24,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
                    })],
                },
                primitive: Default::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: depth_format,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment"),
                    compilation_options: Default::default(),
                    targets: &[Some(COLOR.into()), Some(DISTANCE.into())],
                }),
                multiview_mask: None,
                cache: None,
            });
        let uniform = |label, bytes: &[u8]| {
            device
                .device
                .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some(label),
                    contents: bytes,
                    usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                })
        };
        let view_numbers = view(plan, meshes);
        let view = uniform("view", bytemuck::bytes_of(&view_numbers));
        let sources = uniform("lights", bytemuck::cast_slice(&sources));
        let layout = pipeline.get_bind_group_layout(0);
        let place = |placed: &strahl_scene::plan::PlanMesh| {
            let map = placed.world_from_mesh;
            let normals = DAffine3::from_mat3(map.matrix3.inverse().transpose());
            let [r, g, b] = placed.color;
            let numbers = PlacedMesh {
                world_from_mesh: rows(&map),
                normal_map: rows(&normals),
                color: [r, g, b, 1.0],
            };
            let mesh = uniform("mesh", bytemuck::bytes_of(&numbers));
            let entries = [&view, &mesh, &sources];
            let entries: Vec<_> = (0..)
                .zip(entries)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let bindings = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("geometry"),
                layout: &layout,
                entries: &entries,
            });
            (placed.mesh, bindings)
        };
        Geometry {
            color: Plane::new(device, "geometry color", COLOR),
            distance: Plane::new(device, "geometry distance", DISTANCE),
            nearest: Plane::new(device, "geometry order", depth_format),
            placed: plan.meshes.iter().map(place).collect(),
            pipeline,
            view,
            view_numbers,
            background: plan.background,
        }
    }

    /// Draws the part whose corner is pixel `origin` of the picture.
    pub fn draw(&mut self, device: &Device, meshes: &[Arc<MeshCorners>], origin: [u32; 2]) {
        self.view_numbers.origin = origin.map(|c| c as f32);
        device
            .queue
            .write_buffer(&self.view, 0, bytemuck::bytes_of(&self.view_numbers));
        let attachment = |plane, [r, g, b, a]: [f32; 4]| {
            let [r, g, b, a] = [r, g, b, a].map(f64::from);
            Some(wgpu::RenderPassColorAttachment {
                view: plane,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let mut encoder = device.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("geometry"),
                color_attachments: &[
                    attachment(&self.color.view, self.background),
                    attachment(&self.distance.view, [NOWHERE_MM; 4]),
                ],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.nearest.view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            pass.set_pipeline(&self.pipeline);
            for (mesh, bindings) in &self.placed {
                let corners = &meshes[*mesh].corners;
                pass.set_bind_group(0, bindings, &[]);
                pass.set_vertex_buffer(0, corners.slice(..));
                pass.draw(0..(corners.size() / 24) as u32, 0..1);
            }
        }
        device.queue.submit([encoder.finish()]);
    }
}

/// The struct `Source` of `geometry.wgsl`.
fn source(light: &PlanLight) -> [[f32; 4]; 2] {
    let (place, w, [r, g, b]) = match *light {
        PlanLight::Directional { to_light, radiance } => (to_light, 0.0, radiance),
        PlanLight::Head { radiance } => (DVec3::ZERO, -1.0, radiance),
        PlanLight::Point {
            place_mm,
            reach_mm,
            radiance,
        } => (place_mm, reach_mm, radiance),
    };
    let [x, y, z] = single(place);
    [[x, y, z, w], [r, g, b, 0.0]]
}

fn view(plan: &Plan, meshes: &[Arc<MeshCorners>]) -> View {
    let camera = &plan.camera;
    let (is_perspective, half_height) = match camera.projection {
        Projection::Perspective { tan_half_height } => (1, tan_half_height),
        Projection::Orthographic { half_height_mm } => (0, half_height_mm),
    };
    let mut far_mm = 1.0f64;
    for placed in &plan.meshes {
        let (lo, hi) = meshes[placed.mesh].bounds_mm;
        for corner in 0..8 {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 1 {
                    hi[axis]
                } else {
                    lo[axis]
                }
            };
            let place = DVec3::new(pick(0), pick(1), pick(2));
            let way = placed.world_from_mesh.transform_point3(place) - camera.eye_mm;
            far_mm = far_mm.max(way.length() * 1.001);
        }
    }
    View {
        eye_mm: single(camera.eye_mm),
        half_height: half_height as f32,
        right: single(camera.right),
        aspect: (f64::from(plan.width) / f64::from(plan.height)) as f32,
        up: single(camera.up),
        is_perspective,
        forward: single(camera.forward),
        near_mm: (far_mm * 1e-6) as f32,
        size: [plan.width as f32, plan.height as f32],
        origin: [0.0; 2],
        far_mm: far_mm as f32,
        part: PART as f32,
        padding: [0.0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::TypeInner;

    /// The name and first byte of every field, which have to be all that there are.
    macro_rules! fields {
        ($name:ident { $($field:ident),* $(,)? }) => {{
            let $name { $($field: _),* } = $name::zeroed();
            vec![$((stringify!($field).to_owned(), std::mem::offset_of!($name, $field))),*]
        }};
    }

    #[test]
    fn blocks_lie_as_the_program_reads_them() {
        let text = format!(
            "const SOURCES: u32 = 2u;\n{}",
            include_str!("geometry.wgsl")
        );
        let program = naga::front::wgsl::parse_str(&text).unwrap();
        let struct_of = |name: &str| {
            let mut types = program.types.iter().map(|(_, ty)| ty);
            let found = types.find(|ty| ty.name.as_deref() == Some(name));
            let Some(TypeInner::Struct { members, span }) = found.map(|ty| &ty.inner) else {
                panic!("there is no struct {name}");
            };
            let member = |m: &naga::StructMember| (m.name.clone().unwrap(), m.offset as usize);
            let members: Vec<_> = members.iter().map(member).collect();
            (members, *span as usize)
        };
        let mut view = fields!(View {
            eye_mm,
            half_height,
            right,
            aspect,
            up,
            is_perspective,
            forward,
            near_mm,
            size,
            origin,
            far_mm,
            part,
            padding,
        });
        // The padding has no name there.
        view.pop();
        assert_eq!(struct_of("View"), (view, size_of::<View>()));
        let mesh = fields!(PlacedMesh {
            world_from_mesh,
            normal_map,
            color
        });
        assert_eq!(struct_of("Mesh"), (mesh, size_of::<PlacedMesh>()));
        let source = vec![("place".to_owned(), 0), ("radiance".to_owned(), 16)];
        assert_eq!(struct_of("Source"), (source, size_of::<[[f32; 4]; 2]>()));
    }
}
