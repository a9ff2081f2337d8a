//! Which pixels of a picture are drawn.

use strahl_scene::plan::Plan;

/// The pixels of a picture that are drawn: every `stride`-th column and row, beginning with `first`.
#[derive(Clone, Copy, Debug)]
pub struct Raster {
    /// Column and row.
    pub first: [u32; 2],
    /// In columns and rows, ≥ 1.
    pub stride: [u32; 2],
}

impl Raster {
    /// Every pixel.
    pub const ALL: Raster = Raster {
        first: [0, 0],
        stride: [1, 1],
    };

    /// Number of columns and rows of these pixels in a picture of `plan`; 0 if it is too small to have any.
    pub fn size(&self, plan: &Plan) -> [usize; 2] {
        let number = |pixels: u32, axis: usize| {
            let behind = pixels.saturating_sub(self.first[axis]);
            behind.div_ceil(self.stride[axis]) as usize
        };
        [number(plan.width, 0), number(plan.height, 1)]
    }

    /// Column and row of the picture of one of these pixels.
    pub fn pixel(&self, [x, y]: [u32; 2]) -> [u32; 2] {
        let Raster { first, stride } = self;
        [first[0] + x * stride[0], first[1] + y * stride[1]]
    }

    /// Number of tiles with this edge.
    pub fn tiles(&self, plan: &Plan, edge: u32) -> usize {
        let [width, height] = self.size(plan);
        width.div_ceil(edge as usize) * height.div_ceil(edge as usize)
    }
}
