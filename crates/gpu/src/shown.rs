//! Pictures in textures that somebody else shows.

use crate::device::Device;
use crate::pipelines::COLOR;
use crate::target::Plane;
use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;

/// A texture of somebody else's that a picture is drawn into, without a way through memory.
///
/// It lies on the device of the renderer, can be rendered to, and is at least as large as the picture, which begins at its
/// first pixel. It gets what an [`Image`](strahl_scene::Image) holds: linear, premultiplied light, which formats
/// that end in `Srgb` encode; neither exposure nor tone map.
#[derive(Clone, Copy, Debug)]
pub struct TextureTarget<'t> {
    /// Where the picture goes.
    pub view: &'t wgpu::TextureView,
    /// The format of that view.
    pub format: wgpu::TextureFormat,
}

/// The struct `Show` of `shown.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Show {
    pub origin: [f32; 2],
    pub weight: f32,
    pub is_encoded: u32,
}

/// What brings parts into the textures of others, and adds up frames before that.
#[derive(Debug)]
pub struct Shower {
    layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    /// By the format that they draw into.
    pipelines: Vec<(wgpu::TextureFormat, wgpu::RenderPipeline)>,
    /// A texel of zeros.
    pub nothing: wgpu::TextureView,
    /// The sums of the frames before, in turns.
    pub sums: [Plane; 2],
}

impl Shower {
    pub fn new(device: &Device) -> Shower {
        let wgpu = &device.device;
        let texture = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let uniform = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let layout = wgpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shown"),
            entries: &[uniform, texture(1), texture(2)],
        });
        let pipeline_layout = wgpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("shown"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = wgpu.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("shown"),
            source: wgpu::ShaderSource::Wgsl(include_str!("shown.wgsl").into()),
        });
        // Textures are zero before anything is written to them.
        let nothing = wgpu.create_texture(&wgpu::TextureDescriptor {
            label: Some("nothing"),
            size: wgpu::Extent3d::default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: COLOR,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Shower {
            layout,
            pipeline_layout,
            module,
            pipelines: Vec::new(),
            nothing: nothing.create_view(&Default::default()),
            sums: [(); 2].map(|()| Plane::new(device, "sum of frames", COLOR)),
        }
    }

    /// Adds `part` and what was `before`, and puts it `into` a texture at the place of the part, whose size is `size`.
    pub fn show(
        &mut self,
        device: &Device,
        [part, before]: [&wgpu::TextureView; 2],
        how: Show,
        size: [u32; 2],
        into: &TextureTarget,
    ) {
        let pipeline = self.pipeline(device, into.format);
        let wgpu = &device.device;
        let uniform = wgpu.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("shown"),
            contents: bytemuck::bytes_of(&how),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let resources = [
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(part),
            wgpu::BindingResource::TextureView(before),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bindings = wgpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shown"),
            layout: &self.layout,
            entries: &entries,
        });
        let mut encoder = wgpu.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shown"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: into.view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: None,
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            let ([x, y], [width, height]) = (how.origin, size.map(|n| n as f32));
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bindings, &[]);
            pass.set_viewport(x, y, width, height, 0.0, 1.0);
            pass.draw(0..3, 0..1);
        }
        device.queue.submit([encoder.finish()]);
    }

    fn pipeline(&mut self, device: &Device, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
        if let Some((_, known)) = self.pipelines.iter().find(|(of, _)| *of == format) {
            return known.clone();
        }
        let description = wgpu::RenderPipelineDescriptor {
            label: Some("shown"),
            layout: Some(&self.pipeline_layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        };
        let pipeline = device.device.create_render_pipeline(&description);
        self.pipelines.push((format, pipeline.clone()));
        pipeline
    }
}
