//! The part of the picture that is drawn at once, and its way back.

use crate::device::Device;
use crate::error::Error;
use crate::pipelines::{COLOR, DISTANCE};
use crate::signal::Signal;
use std::time::{Duration, Instant};
use strahl_volume::Control;

/// Edge of a part in pixels.
pub const PART: u32 = 512;

/// How long one submission should take: far below the seconds after which drivers reset a device, and so short that
/// nobody who cancels a picture waits for one.
const BUDGET: Duration = Duration::from_millis(12);

/// A texture of the size of a part.
#[derive(Debug)]
pub struct Plane {
    texture: wgpu::Texture,
    pub view: wgpu::TextureView,
    texel_bytes: u32,
}

impl Plane {
    pub fn new(device: &Device, label: &str, format: wgpu::TextureFormat) -> Plane {
        let texture = device.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width: PART,
                height: PART,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Plane {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            texture,
            texel_bytes: format.block_copy_size(None).unwrap_or(4),
        }
    }

    /// As what is drawn into, beside what is there.
    fn attachment(&self) -> Option<wgpu::RenderPassColorAttachment<'_>> {
        Some(wgpu::RenderPassColorAttachment {
            view: &self.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Load,
                store: wgpu::StoreOp::Store,
            },
        })
    }

    /// The first `height` rows.
    pub async fn read(&self, device: &Device, height: u32) -> Result<Rows, Error> {
        let bytes_per_row = PART * self.texel_bytes;
        let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture part"),
            size: u64::from(bytes_per_row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(bytes_per_row),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d {
                width: PART,
                height,
                depth_or_array_layers: 1,
            },
        );
        device.queue.submit([encoder.finish()]);
        let signal = Signal::default();
        let of_buffer = signal.clone();
        let mapped = move |result: Result<(), wgpu::BufferAsyncError>| {
            of_buffer.give(result.map_err(|why| why.to_string()));
        };
        buffer.slice(..).map_async(wgpu::MapMode::Read, mapped);
        device.done().await?;
        signal.await.map_err(Error::Driver)?;
        let mapped = buffer.slice(..).get_mapped_range();
        let mapped = mapped.map_err(|why| Error::Driver(why.to_string()))?;
        let mut numbers = vec![0.0f32; mapped.len() / 4];
        bytemuck::cast_slice_mut(&mut numbers).copy_from_slice(&mapped);
        Ok(Rows {
            numbers,
            channels: (self.texel_bytes / 4) as usize,
        })
    }
}

/// Rows of a part, read back.
pub struct Rows {
    numbers: Vec<f32>,
    channels: usize,
}

impl Rows {
    /// The first `width` texels of row `y`, channel by channel.
    pub fn row(&self, y: u32, width: u32) -> &[f32] {
        let start = y as usize * PART as usize * self.channels;
        &self.numbers[start..start + width as usize * self.channels]
    }
}

/// What the ray loop draws into.
#[derive(Debug)]
pub struct Target {
    pub color: Plane,
    pub depth: Option<Plane>,
    /// Rows that one submission draws; follows the time that they take.
    rows: u32,
    /// Slices that one submission draws; so, too.
    slices: u32,
}

impl Target {
    pub fn new(device: &Device) -> Target {
        Target {
            color: Plane::new(device, "picture part", COLOR),
            depth: None,
            // The first submission finds out how fast the device is.
            rows: 16,
            slices: 1,
        }
    }

    /// Makes room for distances.
    pub fn with_depth(&mut self, device: &Device) {
        self.depth
            .get_or_insert_with(|| Plane::new(device, "depth part", DISTANCE));
    }

    /// Draws `width` × `height` pixels strip by strip.
    pub async fn draw(
        &mut self,
        device: &Device,
        pipeline: &wgpu::RenderPipeline,
        bindings: &wgpu::BindGroup,
        [width, height]: [u32; 2],
        with_depth: bool,
        control: &Control,
    ) -> Result<(), Error> {
        let mut top = 0;
        while top < height {
            control.check()?;
            let rows = self.rows.min(height - top);
            let start = Instant::now();
            self.strip(device, pipeline, bindings, [width, top, rows], with_depth);
            device.done().await?;
            let took = start.elapsed();
            if took > BUDGET && self.rows > 1 {
                self.rows /= 2;
            } else if took < BUDGET / 4 && self.rows < PART {
                self.rows *= 2;
            }
            top += rows;
        }
        Ok(())
    }

    /// Draws slices of `width` × `height` pixels, blended into `start`. `at_slice` is told, before they are drawn,
    /// how many slices there are before those of the next submission.
    #[expect(clippy::too_many_arguments, reason = "what slices are drawn with")]
    pub async fn draw_slices(
        &mut self,
        device: &Device,
        pipeline: &wgpu::RenderPipeline,
        bindings: &wgpu::BindGroup,
        [width, height]: [u32; 2],
        (count, start): (u32, [f32; 4]),
        mut at_slice: impl FnMut(u32),
        control: &Control,
    ) -> Result<(), Error> {
        let [r, g, b, a] = start.map(f64::from);
        let mut load = wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a });
        let mut drawn = 0;
        while drawn < count || drawn == 0 {
            control.check()?;
            let slices = self.slices.min(count - drawn);
            let begun = Instant::now();
            at_slice(drawn);
            let mut attachment = self.color.attachment();
            if let Some(attachment) = &mut attachment {
                attachment.ops.load = load;
            }
            load = wgpu::LoadOp::Load;
            let mut encoder = device.device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("slices"),
                    color_attachments: &[attachment],
                    depth_stencil_attachment: None,
                    timestamp_writes: None,
                    occlusion_query_set: None,
                    multiview_mask: None,
                });
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, bindings, &[]);
                pass.set_scissor_rect(0, 0, width, height);
                // Instances are blended in their order.
                pass.draw(0..3, 0..slices);
            }
            device.queue.submit([encoder.finish()]);
            device.done().await?;
            let took = begun.elapsed();
            if took > BUDGET && self.slices > 1 {
                self.slices /= 2;
            } else if took < BUDGET / 4 && self.slices < 1 << 16 {
                self.slices *= 2;
            }
            drawn += slices;
            if slices == 0 {
                break;
            }
        }
        Ok(())
    }

    fn strip(
        &self,
        device: &Device,
        pipeline: &wgpu::RenderPipeline,
        bindings: &wgpu::BindGroup,
        [width, top, rows]: [u32; 3],
        with_depth: bool,
    ) {
        let mut attachments = vec![self.color.attachment()];
        if with_depth && let Some(depth) = &self.depth {
            attachments.push(depth.attachment());
        }
        let mut encoder = device.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("ray loop"),
                color_attachments: &attachments,
                depth_stencil_attachment: None,
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bindings, &[]);
            pass.set_scissor_rect(0, top, width, rows);
            pass.draw(0..3, 0..1);
        }
        device.queue.submit([encoder.finish()]);
    }
}
