//! Golden pictures: small PNG files that a person has looked at.
//!
//! They guard what the truth cannot: that a scene still means what it meant (camera, transfer function,
//! colors), as the truth starts from the Plan. Stored as 8-bit sRGB with straight alpha, so that any
//! viewer shows them.

use std::error::Error;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use strahl_scene::Image;

/// How many levels of 255 a channel may differ: one from rounding to 8 bits, one from what phantoms and
/// renderers in single precision may differ between machines.
pub const TOLERANCE: u8 = 2;

/// A picture as it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Golden {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// sRGB and straight alpha, row by row from the top.
    pub pixels: Vec<[u8; 4]>,
}

impl Golden {
    /// `image` in 8 bits.
    pub fn of(image: &Image) -> Golden {
        let stored = |&[r, g, b, a]: &[f32; 4]| {
            let straight = |c: f32| if a > 0.0 { srgb(c / a) } else { 0 };
            let alpha = (a.clamp(0.0, 1.0) * 255.0).round() as u8;
            [straight(r), straight(g), straight(b), alpha]
        };
        Golden {
            width: image.width(),
            height: image.height(),
            pixels: image.pixels().iter().map(stored).collect(),
        }
    }

    /// The picture in a PNG file that [`Golden::write`] has made.
    ///
    /// # Errors
    /// If it cannot be read, or is not 8-bit RGBA.
    pub fn read(path: &Path) -> Result<Golden, Box<dyn Error>> {
        let file = BufReader::new(File::open(path)?);
        let mut reader = png::Decoder::new(file).read_info()?;
        let size = reader.output_buffer_size().ok_or("too large")?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes)?;
        if (info.color_type, info.bit_depth) != (png::ColorType::Rgba, png::BitDepth::Eight) {
            return Err("not 8-bit RGBA".into());
        }
        Ok(Golden {
            width: info.width,
            height: info.height,
            pixels: bytes.as_chunks().0.to_vec(),
        })
    }

    /// Writes a PNG file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        fs::create_dir_all(path.parent().ok_or("no folder")?)?;
        let mut encoder = png::Encoder::new(File::create(path)?, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        Ok(writer.finish()?)
    }

    /// The difference to `other` per pixel and channel, gray in the middle; `None` within [`TOLERANCE`].
    pub fn difference(&self, other: &Golden) -> Option<Golden> {
        let pixels = self.pixels.iter().zip(&other.pixels);
        let close = |(a, b): (&[u8; 4], &[u8; 4])| {
            // The color of what cannot be seen does not matter.
            let invisible = a[3] <= TOLERANCE && b[3] <= TOLERANCE;
            invisible || a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= TOLERANCE)
        };
        let same_size = (self.width, self.height) == (other.width, other.height);
        if same_size && pixels.clone().all(close) {
            return None;
        }
        let apart = |(a, b): (&[u8; 4], &[u8; 4])| {
            let channel = |c: usize| (128 + (i32::from(a[c]) - i32::from(b[c])) * 4).clamp(0, 255);
            [channel(0) as u8, channel(1) as u8, channel(2) as u8, 255]
        };
        Some(Golden {
            width: self.width,
            height: self.height,
            pixels: if same_size {
                pixels.map(apart).collect()
            } else {
                vec![[255, 0, 255, 255]; self.pixels.len()]
            },
        })
    }
}

/// Where the golden picture of a scene is kept.
pub fn path(scene: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("goldens")
        .join(format!("{scene}.png"))
}

/// IEC 61966-2-1, rounded to 8 bits.
fn srgb(linear: f32) -> u8 {
    let linear = f64::from(linear).clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0).round() as u8
}
