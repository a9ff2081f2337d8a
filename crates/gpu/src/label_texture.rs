//! Label volumes on the device.

use crate::device::Device;
use crate::error::Error;
use strahl_volume::{LabelIds, LabelNumbers};

/// The numbers of a label volume's segments as a texture.
#[derive(Debug)]
pub struct LabelTexture {
    pub view: wgpu::TextureView,
    /// The id of each number.
    pub ids: Vec<u32>,
    /// On the device.
    pub bytes: usize,
}

impl LabelTexture {
    /// Copies `numbers` of a label volume of `dims` voxels; the device takes at most `most` along an axis.
    pub fn new(
        device: &Device,
        dims: [usize; 3],
        numbers: &LabelNumbers,
        most: u32,
    ) -> Result<LabelTexture, Error> {
        if dims.iter().any(|n| *n > most as usize) {
            return Err(Error::LabelsTooLarge { dims, most });
        }
        let LabelNumbers { ids, numbers, .. } = numbers;
        let (format, bytes): (_, &[u8]) = match numbers {
            LabelIds::U8(numbers) => (wgpu::TextureFormat::R8Uint, numbers),
            LabelIds::U16(numbers) => (wgpu::TextureFormat::R16Uint, bytemuck::cast_slice(numbers)),
            LabelIds::U32(numbers) => (wgpu::TextureFormat::R32Uint, bytemuck::cast_slice(numbers)),
        };
        let [width, height, depth_or_array_layers] = dims.map(|n| n as u32);
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers,
        };
        let texture = device.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("labels"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        device.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * format.block_copy_size(None).unwrap_or(1)),
                rows_per_image: Some(height),
            },
            size,
        );
        device.check()?;
        Ok(LabelTexture {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            ids: ids.clone(),
            bytes: bytes.len(),
        })
    }
}
