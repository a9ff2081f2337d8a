//! The picture that every renderer makes.

use crate::linear_from_srgb;
use crate::plan::Compositing;

/// Linear, premultiplied RGBA; row 0 is the top; colors use the sRGB primaries and are not tone
/// mapped yet. The background is already in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 4]>,
}

impl Image {
    /// A transparent black picture.
    pub fn new(width: u32, height: u32) -> Image {
        Image {
            width,
            height,
            pixels: vec![[0.0; 4]; width as usize * height as usize],
        }
    }

    /// A picture of `pixels`, row by row from the top.
    ///
    /// # Panics
    /// If their number is not `width · height`.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 4]>) -> Image {
        assert_eq!(pixels.len(), width as usize * height as usize);
        Image {
            width,
            height,
            pixels,
        }
    }

    /// This picture of samples that were added up as `compositing` says, as linear light. What is not
    /// opaque keeps its alpha; its color is decoded as if it were alone.
    pub fn into_linear(mut self, compositing: Compositing) -> Image {
        if compositing == Compositing::Display {
            for [r, g, b, a] in &mut self.pixels {
                let alpha = *a;
                for part in [r, g, b] {
                    if alpha > 0.0 {
                        let straight = f64::from(*part / alpha).max(0.0);
                        *part = (linear_from_srgb(straight) as f32) * alpha;
                    }
                }
            }
        }
        self
    }

    /// Pixels per row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// All pixels, to be written.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 4]] {
        &mut self.pixels
    }

    /// The pixel in column `x` of row `y`.
    ///
    /// # Panics
    /// If it is outside.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        assert!(x < self.width && y < self.height);
        self.pixels[y as usize * self.width as usize + x as usize]
    }
}
