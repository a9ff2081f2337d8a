//! The part of the picture that is drawn at once, and its way back.

use crate::device::Device;
use crate::error::Error;
use crate::pipelines::TARGET;
use std::time::{Duration, Instant};

/// Edge of a part in pixels.
pub const PART: u32 = 512;

/// Bytes of a pixel.
const PIXEL_BYTES: u32 = 16;

/// How long one submission should take: far below the seconds after which drivers reset a device.
const BUDGET: Duration = Duration::from_millis(100);

/// A texture to draw into and a buffer to read it from.
#[derive(Debug)]
pub struct Target {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    buffer: wgpu::Buffer,
    /// Rows that one submission draws; follows the time that they take.
    rows: u32,
}

impl Target {
    pub fn new(device: &Device) -> Target {
        let texture = device.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture part"),
            size: wgpu::Extent3d {
                width: PART,
                height: PART,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TARGET,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Target {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            texture,
            buffer: device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture part"),
                size: u64::from(PART * PART * PIXEL_BYTES),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            }),
            // The first submission finds out how fast the device is.
            rows: 16,
        }
    }

    /// Draws `width` × `height` pixels strip by strip and gives each row to `row`.
    pub fn draw(
        &mut self,
        device: &Device,
        pipeline: &wgpu::RenderPipeline,
        bindings: &wgpu::BindGroup,
        [width, height]: [u32; 2],
        mut row: impl FnMut(u32, &[[f32; 4]]),
    ) -> Result<(), Error> {
        let mut top = 0;
        while top < height {
            let rows = self.rows.min(height - top);
            let start = Instant::now();
            self.strip(device, pipeline, bindings, [width, top, rows]);
            device.wait()?;
            let took = start.elapsed();
            if took > BUDGET && self.rows > 1 {
                self.rows /= 2;
            } else if took < BUDGET / 4 && self.rows < PART {
                self.rows *= 2;
            }
            top += rows;
        }
        self.read(device, [width, height], &mut row)
    }

    fn strip(
        &self,
        device: &Device,
        pipeline: &wgpu::RenderPipeline,
        bindings: &wgpu::BindGroup,
        [width, top, rows]: [u32; 3],
    ) {
        let mut encoder = device.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("ray loop"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &self.view,
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
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bindings, &[]);
            pass.set_scissor_rect(0, top, width, rows);
            pass.draw(0..3, 0..1);
        }
        device.queue.submit([encoder.finish()]);
    }

    fn read(
        &self,
        device: &Device,
        [width, height]: [u32; 2],
        row: &mut impl FnMut(u32, &[[f32; 4]]),
    ) -> Result<(), Error> {
        let bytes_per_row = PART * PIXEL_BYTES;
        let mut encoder = device.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.buffer,
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
        let (sender, receiver) = std::sync::mpsc::channel();
        self.buffer
            .slice(..)
            .map_async(wgpu::MapMode::Read, move |result| {
                // Nobody listens only if the call below has failed.
                let _ = sender.send(result);
            });
        device.wait()?;
        match receiver.recv() {
            Ok(Ok(())) => {}
            Ok(Err(why)) => return Err(Error::Driver(why.to_string())),
            Err(why) => return Err(Error::Driver(why.to_string())),
        }
        {
            let mapped = self.buffer.slice(..).get_mapped_range();
            let mapped = mapped.map_err(|why| Error::Driver(why.to_string()))?;
            let mut pixels = vec![[0.0f32; 4]; width as usize];
            for y in 0..height {
                let start = (y * bytes_per_row) as usize;
                let bytes = &mapped[start..start + pixels.len() * PIXEL_BYTES as usize];
                bytemuck::cast_slice_mut(&mut pixels).copy_from_slice(bytes);
                row(y, &pixels);
            }
        }
        self.buffer.unmap();
        Ok(())
    }
}
