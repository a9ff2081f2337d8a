//! Shadows in a second pass over every tile (document §8.6): light crosses the picture from one side, within the planes of
//! samples, and a buffer of a tile's rays × planes says how much of it arrives at each sample.
//!
//! Before the rays of a tile are sent, its *light rays* are: one for each row of the tile and each plane, of which as many as
//! the tile has rays are in the queue at a time. A light ray visits the columns of the tile, one sample each, at the very
//! positions of the view rays; it may leap and end early. Light that leaves a tile enters the next: tiles go in the direction
//! of the light, and rows × planes words hold the light of the row. From the right, columns are counted backwards, which in
//! the circuit is the complement of their bits.
//!
//! The data path works in order, so what a light ray has written is there when a view ray reads it. Columns without a sample
//! cost no clock: P and L of the view rays are in the parameter RAM.

use crate::fixed_point::{scaled, whole};
use crate::frame::Frame;
use crate::rays::Ray;
use crate::spec::Shadow;
use crate::stages::absorb::Absorber;
use crate::stages::address::AddressGenerator;

/// The light in front of a row of the tile in a plane.
#[derive(Clone, Copy, Debug, Default)]
struct RowLight {
    /// Row of tiles that it belongs to, + 1; any other means that all light is still there.
    tile_row: u32,
    arriving: u32,
    /// Column of the picture, in the direction of the light, from which on all is dark.
    dark_from: u32,
}

/// The buffer, and the light pass of the tile that is under way.
#[derive(Clone, Debug)]
pub(crate) struct ShadowUnit {
    is_from_right: bool,
    /// Columns and rows of a tile; columns and rows of tiles.
    bundle: [u32; 2],
    tiles: [u32; 2],
    width: u32,
    planes: usize,
    /// Bits of a word of the buffer.
    bits: u32,
    buffer: Vec<u16>,
    lights: Vec<RowLight>,
    /// View rays of the tile, by row and column in the direction of the light.
    grid: Vec<Option<Ray>>,
    /// The tile whose light pass is under way: its number, the next plane and the one behind the last.
    pub pass: Option<(usize, u32, u32)>,
}

impl ShadowUnit {
    /// None without shadows.
    pub fn new(frame: &Frame) -> Option<ShadowUnit> {
        let spec = &frame.spec;
        if spec.shadow == Shadow::None {
            return None;
        }
        let bundle = spec.queue.bundle;
        let rays = (bundle[0] * bundle[1]) as usize;
        let planes = frame.setup.plane_count() as usize;
        Some(ShadowUnit {
            is_from_right: spec.shadow == Shadow::FromRight,
            bundle,
            tiles: frame.setup.tiles,
            width: frame.setup.size[0],
            planes,
            bits: spec.widths.shadow,
            buffer: vec![0; rays * planes],
            lights: vec![RowLight::default(); bundle[1] as usize * planes],
            grid: Vec::new(),
            pass: None,
        })
    }

    /// The tile that comes at a place of the order: rows as always, columns in the direction of the light.
    pub fn tile_at(&self, place: usize) -> usize {
        let columns = self.tiles[0] as usize;
        match self.is_from_right {
            false => place,
            true => place / columns * columns + columns - 1 - place % columns,
        }
    }

    /// Begins the light pass of a tile with these rays.
    pub fn begin(&mut self, tile: usize, rays: &[Ray]) {
        let cells = (self.bundle[0] * self.bundle[1]) as usize;
        self.grid.clear();
        self.grid.resize(cells, None);
        for ray in rays {
            let (row, column) = self.place(ray.pixel);
            let at = row * self.bundle[0] as usize + (column % self.bundle[0]) as usize;
            self.grid[at] = Some(*ray);
        }
        let first = rays.iter().map(|r| r.plane).min().unwrap_or(0);
        let behind = rays.iter().map(|r| r.plane + r.remaining).max();
        self.pass = Some((tile, first, behind.unwrap_or(0)));
    }

    /// Row within its tile, and column of the picture in the direction of the light.
    fn place(&self, pixel: u32) -> (usize, u32) {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let column = match self.is_from_right {
            false => x,
            true => self.tiles[0] * self.bundle[0] - 1 - x,
        };
        ((y % self.bundle[1]) as usize, column)
    }

    /// The light rays of the next planes, as many as there are stages, and how many samples they have; of those that are
    /// known to be dark only the samples.
    pub fn next_rays(&mut self) -> (Vec<Ray>, u64) {
        let Some((tile, first, behind)) = self.pass else {
            return (Vec::new(), 0);
        };
        let [columns, rows] = self.bundle;
        let last = (first + columns).min(behind);
        self.pass = Some((tile, last, behind));
        let tile_row = tile as u32 / self.tiles[0] + 1;
        let mut samples = 0;
        let mut rays = Vec::new();
        for plane in first..last {
            for row in 0..rows as usize {
                let row_of = &self.grid[row * columns as usize..][..columns as usize];
                samples += row_of.iter().flatten().filter(|r| is_on(r, plane)).count() as u64;
                let light = &self.lights[row * self.planes + plane as usize];
                let is_dark = light.tile_row == tile_row && light.dark_from != u32::MAX;
                if !is_dark && let Some(ray) = self.next_sample(row, plane, 0) {
                    rays.push(ray);
                }
            }
        }
        (rays, samples)
    }

    /// The light ray of a row and plane at its next sample, from a column of the tile on: `remaining` are the columns left.
    fn next_sample(&self, row: usize, plane: u32, from: u32) -> Option<Ray> {
        let columns = self.bundle[0];
        (from..columns).find_map(|column| {
            let view = self.grid[row * columns as usize + column as usize]?;
            is_on(&view, plane).then(|| Ray {
                position: AddressGenerator::advance(view.position, view.step, plane - view.plane),
                step: [0; 3],
                remaining: columns - column,
                plane,
                pixel: view.pixel,
            })
        })
    }

    /// A light ray some columns farther; none at its end.
    pub fn advance(&self, ray: &Ray, columns: u32) -> Option<Ray> {
        let (row, column) = self.place(ray.pixel);
        self.next_sample(row, ray.plane, column % self.bundle[0] + columns)
    }

    /// A sample of a light ray: what arrives is kept, what passes goes on. Whether the rest is dark.
    pub fn absorb(&mut self, pixel: u32, plane: u32, opacity: u32, absorber: &Absorber) -> bool {
        let (row, column) = self.place(pixel);
        let tile_row = pixel / self.width / self.bundle[1] + 1;
        let light = &mut self.lights[row * self.planes + plane as usize];
        if light.tile_row != tile_row {
            *light = RowLight {
                tile_row,
                arriving: absorber.full(),
                dark_from: u32::MAX,
            };
        }
        if light.dark_from != u32::MAX {
            return true;
        }
        let at = row * self.bundle[0] as usize + (column % self.bundle[0]) as usize;
        self.buffer[at * self.planes + plane as usize] =
            (light.arriving >> (absorber.transmittance - self.bits)) as u16;
        let (_, behind, is_dark) = absorber.absorb(opacity, light.arriving);
        light.arriving = behind;
        if is_dark {
            light.dark_from = column + 1;
        }
        is_dark
    }

    /// The weight of a sample of a view ray in the light that arrives there.
    pub fn lit(&self, pixel: u32, plane: u32, weight: u32) -> u32 {
        let (row, column) = self.place(pixel);
        let tile_row = pixel / self.width / self.bundle[1] + 1;
        let light = &self.lights[row * self.planes + plane as usize];
        if light.tile_row == tile_row && column >= light.dark_from {
            return 0;
        }
        let at = row * self.bundle[0] as usize + (column % self.bundle[0]) as usize;
        let arriving = u32::from(self.buffer[at * self.planes + plane as usize]);
        scaled(weight, whole(arriving, self.bits), self.bits)
    }
}

fn is_on(ray: &Ray, plane: u32) -> bool {
    (ray.plane..ray.plane + ray.remaining).contains(&plane)
}
