//! A volume as a 3-D texture: the best format that the adapter can filter, filled in slabs.

use crate::device::Device;
use crate::error::Error;
use strahl_shader::{PAGE_VOXELS, Texels};
use strahl_volume::{Control, SampleType, Samples, Volume};
use wgpu::TextureFormat;

/// A volume on the device.
#[derive(Debug)]
pub struct VolumeTexture {
    pub view: wgpu::TextureView,
    /// Where its pages are in the texture, if it is an atlas.
    pub pages: Option<Pages>,
    /// That it takes on the device.
    pub bytes: usize,
}

/// The page table of a volume.
#[derive(Debug)]
pub struct Pages {
    pub dims: [u32; 3],
    /// Two numbers per page: `strahl_shader::bindings::PAGES` says what they mean.
    pub entries: Vec<u32>,
}

/// How samples lie in a texture. A stored number is `scale · texel + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Storage {
    pub format: TextureFormat,
    pub texels: Texels,
    /// Whether the texture unit interpolates.
    pub is_filterable: bool,
    pub scale: f32,
    pub shift: f32,
}

/// At most this much is copied at once: each write is staged in memory first.
const SLAB_BYTES: usize = 8 << 20;

impl Storage {
    fn texel_bytes(&self) -> usize {
        self.format.block_copy_size(None).unwrap_or(4) as usize
    }

    /// The same read texel by texel.
    pub fn unfiltered(self) -> Storage {
        Storage {
            texels: Texels::UnfilterableFloat,
            is_filterable: false,
            ..self
        }
    }

    /// The same in an atlas, which no texture unit interpolates.
    pub fn paged(self) -> Storage {
        Storage {
            texels: match self.texels {
                Texels::Unsigned | Texels::UnsignedPages => Texels::UnsignedPages,
                Texels::Signed | Texels::SignedPages => Texels::SignedPages,
                _ => Texels::FloatPages,
            },
            is_filterable: false,
            ..self
        }
    }

    /// The format for samples of this type on this device.
    pub fn of(sample_type: SampleType, device: &Device) -> Storage {
        let features = device.device.features();
        let norm16 = features.contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM);
        let float32 = features.contains(wgpu::Features::FLOAT32_FILTERABLE);
        let storage = |format, texels, is_filterable, scale, shift| Storage {
            format,
            texels,
            is_filterable,
            scale,
            shift,
        };
        match sample_type {
            // Software adapters interpolate 8-bit texels in 8 bits; 16-bit float holds them exactly.
            SampleType::U8 if !device.adapter().is_software => {
                storage(TextureFormat::R8Unorm, Texels::Float, true, 255.0, 0.0)
            }
            SampleType::U8 | SampleType::I8 => {
                storage(TextureFormat::R16Float, Texels::Float, true, 1.0, 0.0)
            }
            SampleType::U16 if norm16 => {
                storage(TextureFormat::R16Unorm, Texels::Float, true, 65_535.0, 0.0)
            }
            // Moved by half the range: signed fractions have two forms of −1.
            SampleType::I16 if norm16 => storage(
                TextureFormat::R16Unorm,
                Texels::Float,
                true,
                65_535.0,
                -32_768.0,
            ),
            SampleType::U16 => storage(TextureFormat::R16Uint, Texels::Unsigned, false, 1.0, 0.0),
            SampleType::I16 => storage(TextureFormat::R16Sint, Texels::Signed, false, 1.0, 0.0),
            SampleType::U32 | SampleType::I32 | SampleType::F32 | SampleType::F64 => {
                let texels = if float32 {
                    Texels::Float
                } else {
                    Texels::UnfilterableFloat
                };
                storage(TextureFormat::R32Float, texels, float32, 1.0, 0.0)
            }
        }
    }
}

impl VolumeTexture {
    /// Whether `volume` is stored in pages because an edge is longer than `most`.
    pub fn is_paged(volume: &Volume, most: u32) -> bool {
        volume.grid().dims().iter().any(|n| *n > most as usize)
    }

    /// Copies the samples to the device: as one texture, or in pages if an edge is longer than `most`.
    pub async fn new(
        device: &Device,
        volume: &Volume,
        most: u32,
        control: &Control,
    ) -> Result<VolumeTexture, Error> {
        if VolumeTexture::is_paged(volume, most) {
            return VolumeTexture::in_pages(device, volume, most, control).await;
        }
        let dims = volume.grid().dims();
        let storage = Storage::of(volume.samples().sample_type(), device);
        let texel_bytes = storage.texel_bytes();
        let [x, y, z] = dims.map(|n| n as u32);
        let texture = texture(device, storage.format, [x, y, z]);
        device.check()?;
        let slice = dims[0] * dims[1];
        // A slice of 16384² voxels is larger than a slab should be, so slabs are made of rows.
        let rows_at_once = (SLAB_BYTES / (dims[0] * texel_bytes)).clamp(1, dims[1]);
        let slices_at_once = (SLAB_BYTES / (slice * texel_bytes)).max(1);
        let mut bytes = Vec::new();
        let mut first_slice = 0;
        while first_slice < dims[2] {
            let slices = slices_at_once.min(dims[2] - first_slice);
            for first_row in (0..dims[1]).step_by(rows_at_once) {
                let rows = rows_at_once.min(dims[1] - first_row);
                let start = first_slice * slice + first_row * dims[0];
                let len = if rows == dims[1] {
                    slices * slice
                } else {
                    rows * dims[0]
                };
                bytes.clear();
                encode(volume.samples(), start, len, storage.format, &mut bytes);
                let origin = [0, first_row as u32, first_slice as u32];
                write(
                    device,
                    &texture,
                    &bytes,
                    origin,
                    [x, rows as u32, slices as u32],
                );
                device.queue.submit([]);
                device.done().await?;
                control.check()?;
            }
            first_slice += slices;
        }
        Ok(VolumeTexture {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            pages: None,
            bytes: slice * dims[2] * texel_bytes,
        })
    }

    /// A volume beyond the largest texture: an atlas of the pages whose voxels differ, and a table that
    /// says where each page is.
    async fn in_pages(
        device: &Device,
        volume: &Volume,
        most: u32,
        control: &Control,
    ) -> Result<VolumeTexture, Error> {
        let dims = volume.grid().dims();
        let storage = Storage::of(volume.samples().sample_type(), device).paged();
        let samples = volume.samples();
        let page = PAGE_VOXELS as usize;
        let table_dims = dims.map(|n| n.div_ceil(page));
        // Ten bits say the place in the atlas along each axis.
        let edge = ((most / PAGE_VOXELS) as usize).clamp(1, 1023);
        let too_large = || Error::TooLarge {
            dims,
            most,
            most_bytes: ((edge * page) as u64).pow(3) * storage.texel_bytes() as u64,
        };
        if table_dims.iter().any(|n| *n > most as usize) {
            return Err(too_large());
        }
        let mut entries = Vec::with_capacity(2 * table_dims.iter().product::<usize>());
        let mut stored = Vec::new();
        for z in 0..table_dims[2] {
            for y in 0..table_dims[1] {
                control.check()?;
                for x in 0..table_dims[0] {
                    let corner = [x * page, y * page, z * page];
                    if let Some(number) = same_number(samples, dims, corner) {
                        let texel = (number as f32 - storage.shift) / storage.scale;
                        entries.extend([1u32 << 31, texel.to_bits()]);
                        continue;
                    }
                    let n = stored.len();
                    let place = [n % edge, n / edge % edge, n / (edge * edge)];
                    if place[2] >= edge {
                        return Err(too_large());
                    }
                    let [u, v, w] = place.map(|n| n as u32);
                    entries.extend([u | v << 10 | w << 20, 0]);
                    stored.push((corner, [u, v, w]));
                }
            }
        }
        let pages = stored.len().max(1);
        let atlas_dims = [
            pages.min(edge),
            pages.div_ceil(edge).min(edge),
            pages.div_ceil(edge * edge),
        ];
        let atlas = texture(
            device,
            storage.format,
            atlas_dims.map(|n| n as u32 * PAGE_VOXELS),
        );
        device.check()?;
        let at_once = (SLAB_BYTES / (page.pow(3) * storage.texel_bytes())).max(1);
        let mut bytes = Vec::new();
        for (i, (corner, place)) in stored.iter().enumerate() {
            bytes.clear();
            let size = [0, 1, 2].map(|a| page.min(dims[a] - corner[a]));
            for z in 0..size[2] {
                for y in 0..size[1] {
                    let [cx, cy, cz] = *corner;
                    let start = cx + dims[0] * (cy + y + dims[1] * (cz + z));
                    encode(samples, start, size[0], storage.format, &mut bytes);
                }
            }
            let origin = place.map(|n| n * PAGE_VOXELS);
            write(device, &atlas, &bytes, origin, size.map(|n| n as u32));
            if i % at_once == at_once - 1 {
                device.queue.submit([]);
                device.done().await?;
                control.check()?;
            }
        }
        device.queue.submit([]);
        device.done().await?;
        Ok(VolumeTexture {
            view: atlas.create_view(&wgpu::TextureViewDescriptor::default()),
            pages: Some(Pages {
                dims: table_dims.map(|n| n as u32),
                entries,
            }),
            bytes: atlas_dims.iter().product::<usize>() * page.pow(3) * storage.texel_bytes(),
        })
    }
}

/// The number that all voxels of the page at `corner` store, if it is one and finite.
fn same_number(samples: &Samples, dims: [usize; 3], corner: [usize; 3]) -> Option<f64> {
    let end = [0, 1, 2].map(|a| dims[a].min(corner[a] + PAGE_VOXELS as usize));
    let index = |x: usize, y: usize, z: usize| x + dims[0] * (y + dims[1] * z);
    let [x, y, z] = corner;
    let first = samples.get(index(x, y, z));
    let is_same = (z..end[2])
        .all(|z| (y..end[1]).all(|y| (x..end[0]).all(|x| samples.get(index(x, y, z)) == first)));
    (is_same && first.is_finite()).then_some(first)
}

fn texture(device: &Device, format: TextureFormat, [x, y, z]: [u32; 3]) -> wgpu::Texture {
    device.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("volume"),
        size: wgpu::Extent3d {
            width: x,
            height: y,
            depth_or_array_layers: z,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Writes a block of texels.
fn write(
    device: &Device,
    texture: &wgpu::Texture,
    bytes: &[u8],
    [x, y, z]: [u32; 3],
    [width, height, depth]: [u32; 3],
) {
    let texel_bytes = texture.format().block_copy_size(None).unwrap_or(4);
    device.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x, y, z },
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * texel_bytes),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: depth,
        },
    );
}

/// The bytes of texels `start..start + len`, little-endian.
fn encode(samples: &Samples, start: usize, len: usize, format: TextureFormat, into: &mut Vec<u8>) {
    let range = start..start + len;
    match samples {
        Samples::U8(s) if format == TextureFormat::R8Unorm => into.extend_from_slice(&s[range]),
        Samples::U8(s) => halves(s[range].iter().map(|&v| f32::from(v)), into),
        Samples::I8(s) => halves(s[range].iter().map(|&v| f32::from(v)), into),
        Samples::U16(s) => into.extend_from_slice(bytemuck::cast_slice(&s[range])),
        Samples::I16(s) if format == TextureFormat::R16Unorm => {
            let moved = s[range].iter().map(|&v| (v as u16) ^ 0x8000);
            into.extend(moved.flat_map(u16::to_le_bytes));
        }
        Samples::I16(s) => into.extend_from_slice(bytemuck::cast_slice(&s[range])),
        Samples::U32(s) => floats(s[range].iter().map(|&v| v as f32), into),
        Samples::I32(s) => floats(s[range].iter().map(|&v| v as f32), into),
        Samples::F32(s) => floats(s[range].iter().copied(), into),
        Samples::F64(s) => floats(s[range].iter().map(|&v| v as f32), into),
    }
}

fn floats(values: impl Iterator<Item = f32>, into: &mut Vec<u8>) {
    into.extend(values.flat_map(f32::to_le_bytes));
}

/// Whole numbers below 2048 are exact as 16-bit float; these are below 256.
fn halves(values: impl Iterator<Item = f32>, into: &mut Vec<u8>) {
    into.extend(values.flat_map(|v| half(v).to_le_bytes()));
}

/// A whole number of −2048 to 2048 as 16-bit float.
fn half(value: f32) -> u16 {
    let bits = value.to_bits();
    let sign = ((bits >> 16) & 0x8000) as u16;
    if value == 0.0 {
        return sign;
    }
    let exponent = ((bits >> 23) & 0xFF) as i32 - 127 + 15;
    sign | ((exponent as u16) << 10) | ((bits >> 13) & 0x3FF) as u16
}

#[cfg(test)]
mod tests {
    #[test]
    fn small_whole_numbers_are_exact_as_half_floats() {
        let value = |bits: u16| {
            let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
            match (bits >> 10) & 31 {
                0 => 0.0,
                e => sign * (1.0 + f64::from(bits & 1023) / 1024.0) * 2f64.powi(i32::from(e) - 15),
            }
        };
        for n in -256..=256 {
            assert_eq!(value(super::half(n as f32)), f64::from(n));
        }
    }
}
