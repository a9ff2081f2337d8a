//! Pipelines: linked programs made ready to run, kept as long as the renderer.

use crate::device::Device;
use crate::error::Error;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use strahl_program::{Blend, BlendPart, Factor, Operation};
use strahl_shader::{Program, Texels, bindings};

/// What the ray loop draws into: linear, premultiplied, as computed.
pub const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Distances along rays, in mm.
pub const DISTANCE: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// A program ready to run.
#[derive(Debug)]
pub struct Ready {
    pub pipeline: wgpu::RenderPipeline,
    pub layout: wgpu::BindGroupLayout,
}

/// What a pipeline draws into, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// The colors of rays.
    Color,
    /// Colors, and how far away what is hit lies.
    ColorAndDepth,
    /// The colors of slices, blended with what is there.
    Slices(Blend),
}

/// What decides about a pipeline. The texels are those of the volumes that the program reads.
#[derive(Clone, Debug)]
struct Key {
    program: Arc<Program>,
    into: Output,
}

impl Key {
    fn is(&self, program: &Arc<Program>, into: Output) -> bool {
        Arc::ptr_eq(&self.program, program) && self.into == into
    }
}

/// The pipelines that were made, and those that are being made.
#[derive(Debug, Default)]
pub struct Pipelines {
    made: Vec<(Key, Arc<Ready>)>,
    in_making: Vec<(Key, Receiver<Ready>)>,
}

impl Pipelines {
    /// The pipeline of `program`: made on the first call, found on the others.
    pub fn of(
        &mut self,
        device: &Device,
        program: &Arc<Program>,
        texels: &[Texels],
        into: Output,
    ) -> Result<Arc<Ready>, Error> {
        if let Some(found) = self.found(program, into) {
            return Ok(found);
        }
        let begun = self
            .in_making
            .iter()
            .position(|(key, _)| key.is(program, into));
        let ready = match begun {
            Some(index) => {
                let (_, receiver) = self.in_making.swap_remove(index);
                receiver
                    .recv()
                    .map_err(|why| Error::Driver(why.to_string()))?
            }
            None => make(&device.device, program, texels, into),
        };
        device.check()?;
        Ok(self.keep(program, into, ready))
    }

    /// Whether the pipeline of `program` is made; if not, a thread makes it from now on.
    pub fn is_ready(
        &mut self,
        device: &Device,
        program: &Arc<Program>,
        texels: &[Texels],
        into: Output,
    ) -> Result<bool, Error> {
        if self.found(program, into).is_some() {
            return Ok(true);
        }
        let begun = self
            .in_making
            .iter()
            .position(|(key, _)| key.is(program, into));
        match begun {
            Some(index) => {
                let Ok(ready) = self.in_making[index].1.try_recv() else {
                    return Ok(false);
                };
                self.in_making.swap_remove(index);
                device.check()?;
                self.keep(program, into, ready);
                Ok(true)
            }
            None => {
                let (sender, receiver) = channel();
                let (device, texels) = (device.device.clone(), texels.to_vec());
                let key = Key {
                    program: program.clone(),
                    into,
                };
                let program = program.clone();
                std::thread::spawn(move || {
                    // Nobody listens any more if the renderer is gone.
                    let _ = sender.send(make(&device, &program, &texels, into));
                });
                self.in_making.push((key, receiver));
                Ok(false)
            }
        }
    }

    fn found(&self, program: &Arc<Program>, into: Output) -> Option<Arc<Ready>> {
        let found = self.made.iter().find(|(key, _)| key.is(program, into));
        found.map(|(_, ready)| ready.clone())
    }

    fn keep(&mut self, program: &Arc<Program>, into: Output, ready: Ready) -> Arc<Ready> {
        let ready = Arc::new(ready);
        let key = Key {
            program: program.clone(),
            into,
        };
        self.made.push((key, ready.clone()));
        ready
    }
}

/// What may be bound at a place of group 0.
fn binding_type(binding: u32, texels: &[Texels]) -> wgpu::BindingType {
    use wgpu::TextureSampleType::{Float, Sint, Uint};
    use wgpu::TextureViewDimension::{D2, D3};
    let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled: false,
    };
    let unfilterable = Float { filterable: false };
    match binding {
        bindings::FRAME | bindings::PARAMETERS | bindings::IMPORTANCE => {
            wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            }
        }
        bindings::VOLUME_SAMPLER => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        bindings::BRICKS | bindings::PAGES | bindings::LABELS => texture(Uint, D3),
        bindings::SEGMENTS => texture(Uint, D2),
        bindings::TABLES | bindings::NOISE_TILE | bindings::OPAQUE_MM | bindings::OPAQUE_COLOR => {
            texture(unfilterable, D2)
        }
        _ if binding < bindings::FIRST_VOLUME => texture(unfilterable, D3),
        _ if binding >= bindings::FIRST_TEXTURE => texture(unfilterable, D2),
        _ => {
            let volume = (binding - bindings::FIRST_VOLUME) as usize;
            let sample_type = match texels[volume] {
                Texels::Float => Float { filterable: true },
                Texels::UnfilterableFloat | Texels::FloatPages => unfilterable,
                Texels::Unsigned | Texels::UnsignedPages => Uint,
                Texels::Signed | Texels::SignedPages => Sint,
            };
            texture(sample_type, D3)
        }
    }
}

fn make(device: &wgpu::Device, program: &Program, texels: &[Texels], into: Output) -> Ready {
    let entries: Vec<_> = program
        .bindings()
        .into_iter()
        .map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            // Nodes of a graph may run at the vertices.
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: binding_type(binding, texels),
            count: None,
        })
        .collect();
    let label = Some("ray loop");
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label,
        entries: &entries,
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    // With all checks: indices stay inside, and no loop turns for ever.
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(program.wgsl().into()),
    });
    let blended = |blend: Blend| wgpu::ColorTargetState {
        blend: Some(wgpu::BlendState {
            color: component(blend.color),
            alpha: component(blend.opacity),
        }),
        ..COLOR.into()
    };
    let (entry_point, targets) = match into {
        Output::Color => ("fragment", vec![Some(COLOR.into())]),
        Output::ColorAndDepth => (
            "fragment_with_depth",
            vec![Some(COLOR.into()), Some(DISTANCE.into())],
        ),
        Output::Slices(blend) => ("fragment", vec![Some(blended(blend))]),
    };
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&pipeline_layout),
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
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    });
    Ready { pipeline, layout }
}

fn component(part: BlendPart) -> wgpu::BlendComponent {
    let factor = |factor| match factor {
        Factor::Zero => wgpu::BlendFactor::Zero,
        Factor::One => wgpu::BlendFactor::One,
        Factor::Source => wgpu::BlendFactor::Src,
        Factor::OneMinusSource => wgpu::BlendFactor::OneMinusSrc,
        Factor::SourceOpacity => wgpu::BlendFactor::SrcAlpha,
        Factor::OneMinusSourceOpacity => wgpu::BlendFactor::OneMinusSrcAlpha,
        Factor::Destination => wgpu::BlendFactor::Dst,
        Factor::OneMinusDestination => wgpu::BlendFactor::OneMinusDst,
        Factor::DestinationOpacity => wgpu::BlendFactor::DstAlpha,
        Factor::OneMinusDestinationOpacity => wgpu::BlendFactor::OneMinusDstAlpha,
    };
    wgpu::BlendComponent {
        src_factor: factor(part.source),
        dst_factor: factor(part.destination),
        operation: match part.operation {
            Operation::Add => wgpu::BlendOperation::Add,
            Operation::Subtract => wgpu::BlendOperation::Subtract,
            Operation::ReverseSubtract => wgpu::BlendOperation::ReverseSubtract,
            Operation::Smaller => wgpu::BlendOperation::Min,
            Operation::Larger => wgpu::BlendOperation::Max,
        },
    }
}
