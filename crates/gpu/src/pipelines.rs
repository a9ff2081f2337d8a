//! Pipelines: linked programs made ready to run, kept as long as the renderer.

use crate::device::Device;
use crate::error::Error;
use crate::volume_texture::Storage;
use std::sync::Arc;
use strahl_shader::{PARAMETERS_BINDING, Program};

/// What the ray loop draws into: linear, premultiplied, as computed.
pub const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The pipelines for textures of one storage.
#[derive(Debug)]
pub struct Pipelines {
    pub bindings: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    made: Vec<(Arc<Program>, wgpu::RenderPipeline)>,
}

impl Pipelines {
    pub fn new(device: &Device, storage: &Storage) -> Pipelines {
        use strahl_shader::Texels;
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        };
        let filterable = storage.is_filterable;
        let volume = match storage.texels {
            Texels::Float => wgpu::TextureSampleType::Float { filterable },
            Texels::Unsigned => wgpu::TextureSampleType::Uint,
            Texels::Signed => wgpu::TextureSampleType::Sint,
        };
        let sampler = if filterable {
            wgpu::SamplerBindingType::Filtering
        } else {
            wgpu::SamplerBindingType::NonFiltering
        };
        let unfilterable = wgpu::TextureSampleType::Float { filterable: false };
        use wgpu::TextureViewDimension::{D2, D3};
        let entries = [
            (0, uniform),
            (PARAMETERS_BINDING, uniform),
            (2, texture(volume, D3)),
            (3, wgpu::BindingType::Sampler(sampler)),
            (4, texture(unfilterable, D2)),
            (5, texture(wgpu::TextureSampleType::Uint, D3)),
        ]
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        });
        let bindings = device
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("ray loop"),
                entries: &entries,
            });
        let layout = device
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("ray loop"),
                bind_group_layouts: &[Some(&bindings)],
                immediate_size: 0,
            });
        Pipelines {
            bindings,
            layout,
            made: Vec::new(),
        }
    }

    /// The pipeline of `program`: made on the first call, found on the others.
    pub fn of(
        &mut self,
        device: &Device,
        program: &Arc<Program>,
    ) -> Result<&wgpu::RenderPipeline, Error> {
        let found = self.made.iter().position(|(p, _)| Arc::ptr_eq(p, program));
        let index = match found {
            Some(index) => index,
            None => {
                let pipeline = self.make(device, program);
                device.check()?;
                self.made.push((program.clone(), pipeline));
                self.made.len() - 1
            }
        };
        Ok(&self.made[index].1)
    }

    fn make(&self, device: &Device, program: &Program) -> wgpu::RenderPipeline {
        // With all checks: indices stay inside, and no loop turns for ever.
        let module = device
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("ray loop"),
                source: wgpu::ShaderSource::Wgsl(program.wgsl().into()),
            });
        device
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("ray loop"),
                layout: Some(&self.layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment"),
                    compilation_options: Default::default(),
                    targets: &[Some(TARGET.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
    }
}
