//! How far two pictures are apart, in the numbers that a screen shows.

use anyhow::{Result, ensure};
use std::path::Path;

/// Display values from 0 to 255, RGB, row by row.
pub struct Picture(Vec<u8>);

/// How far pictures are apart, in display values from 0 to 255, over all pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest.
    pub max: u8,
}

impl Picture {
    /// Of 8-bit RGB.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn from_bytes(path: &Path) -> Result<Picture> {
        Ok(Picture(std::fs::read(path)?))
    }

    /// Of little-endian f32 RGBA in linear light, premultiplied over an opaque background; made sRGB as for a
    /// picture file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn from_linear(path: &Path) -> Result<Picture> {
        let bytes = std::fs::read(path)?;
        let (numbers, rest) = bytes.as_chunks::<4>();
        let numbers: Vec<f32> = numbers.iter().map(|b| f32::from_le_bytes(*b)).collect();
        ensure!(
            rest.is_empty() && numbers.len().is_multiple_of(4),
            "{} holds {} bytes, no whole number of pixels",
            path.display(),
            bytes.len()
        );
        let colors = numbers.chunks_exact(4).flat_map(|pixel| &pixel[..3]);
        Ok(Picture(colors.map(|&c| display(c)).collect()))
    }

    /// How far `other` is away.
    ///
    /// # Errors
    /// The pictures have different sizes.
    pub fn difference(&self, other: &Picture) -> Result<Difference> {
        ensure!(
            self.0.len() == other.0.len() && !self.0.is_empty(),
            "pictures of {} and {} numbers cannot be compared",
            self.0.len(),
            other.0.len()
        );
        let apart = || self.0.iter().zip(&other.0).map(|(a, b)| a.abs_diff(*b));
        let squares: f64 = apart().map(|by| f64::from(by) * f64::from(by)).sum();
        Ok(Difference {
            rms: (squares / self.0.len() as f64).sqrt(),
            max: apart().max().unwrap_or(0),
        })
    }
}

/// The curve of sRGB, 0 to 255.
fn display(linear: f32) -> u8 {
    let linear = f64::from(linear);
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    // Rounds, and cuts off what lies outside.
    (255.0 * encoded + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_light_becomes_display_values() {
        // Values of the standard: half gray, the end of its straight part, both ends.
        let pairs = [
            (0.0, 0),
            (0.003_130_8, 10),
            (0.214_041_14, 128),
            (1.0, 255),
            (2.0, 255),
            (-1.0, 0),
        ];
        for (linear, expected) in pairs {
            assert_eq!(display(linear), expected, "{linear}");
        }
    }

    #[test]
    fn differences_are_those_of_the_numbers() {
        let difference = Picture(vec![0, 10, 20, 30]).difference(&Picture(vec![3, 10, 16, 30]));
        assert_eq!(difference.unwrap(), Difference { rms: 2.5, max: 4 });
        assert!(Picture(vec![0]).difference(&Picture(vec![0, 1])).is_err());
    }
}
