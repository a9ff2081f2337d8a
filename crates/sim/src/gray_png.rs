//! PNG files of pictures and of maps of counts.

use crate::Error;
use crate::processor::Run;

/// A grey picture of numbers from 0 to 1; `bits` is 8 or 16.
///
/// # Errors
/// If it cannot be encoded.
pub fn encode(size: [u32; 2], pixels: &[f32], bits: u32) -> Result<Vec<u8>, Error> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size[0], size[1]);
    encoder.set_color(png::ColorType::Grayscale);
    let bytes: Vec<u8> = if bits == 16 {
        encoder.set_depth(png::BitDepth::Sixteen);
        let words = pixels
            .iter()
            .map(|p| (p.clamp(0.0, 1.0) * 65535.0).round() as u16);
        words.flat_map(u16::to_be_bytes).collect()
    } else {
        encoder.set_depth(png::BitDepth::Eight);
        pixels
            .iter()
            .map(|p| (p.clamp(0.0, 1.0) * 255.0).round() as u8)
            .collect()
    };
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(file)
}

/// A picture of three channels from 0 to 1.
///
/// # Errors
/// If it cannot be encoded.
pub fn encode_rgb(size: [u32; 2], pixels: &[[f32; 3]]) -> Result<Vec<u8>, Error> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    let bytes: Vec<u8> = pixels
        .iter()
        .flat_map(|p| p.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8))
        .collect();
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(file)
}

/// Counts per pixel as colours from black over red and yellow to white, white being the largest count or `white`.
///
/// # Errors
/// If it cannot be encoded.
pub fn encode_counts(size: [u32; 2], counts: &[u32], white: Option<u32>) -> Result<Vec<u8>, Error> {
    let top = white
        .unwrap_or_else(|| counts.iter().copied().max().unwrap_or(0))
        .max(1) as f32;
    let pixels: Vec<[f32; 3]> = counts
        .iter()
        .map(|c| {
            let part = 3.0 * (*c as f32 / top).min(1.0);
            [part, part - 1.0, part - 2.0]
        })
        .collect();
    encode_rgb(size, &pixels)
}

impl Run {
    /// The picture as PNG of 8 or 16 bits; in colour always 8.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn png(&self, bits: u32) -> Result<Vec<u8>, Error> {
        match &self.color {
            Some(color) => encode_rgb(self.size, color),
            None => encode(self.size, &self.picture, bits),
        }
    }
}
