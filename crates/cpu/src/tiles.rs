//! Tiles of the picture over all cores.

use crate::lanes::PACKET;
use crate::levels::{Level, vectorized};
use crate::march::Counts;
use crate::ray::RayPacket;
use crate::scenery::Scenery;
use crate::{Error, Progress};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What the pixels of a picture hold before its colours are made linear.
pub struct Drawn {
    /// Premultiplied, row by row from the top.
    pub pixels: Vec<[f32; 4]>,
    /// Distance of the hit in the first frame, in mm; empty if nobody asked.
    pub depth_mm: Vec<f32>,
    pub counts: Counts,
}

/// A rectangle of the picture that one task draws: its rows, each a part of a row of the picture.
struct Tile<'i> {
    x: u32,
    y: u32,
    rows: Vec<&'i mut [[f32; 4]]>,
    depth_rows: Vec<&'i mut [f32]>,
}

/// Draws all tiles in the current thread pool. Each pixel depends on its own ray only, so that
/// neither the size of tiles nor their order nor the number of threads can change one.
pub fn draw<S: Level>(scenery: &Scenery<S>, edge: u32, progress: Progress) -> Result<Drawn, Error> {
    let plan = scenery.plan;
    let (width, height) = (plan.width as usize, plan.height as usize);
    let mut pixels = vec![[0.0; 4]; width * height];
    let mut depth_mm = if plan.with_depth {
        vec![f32::INFINITY; width * height]
    } else {
        Vec::new()
    };
    let tiles = tiles(&mut pixels, &mut depth_mm, width, edge as usize);
    let total = tiles.len();
    let drawn = AtomicUsize::new(0);
    let cancelled = AtomicBool::new(false);
    let counts = tiles
        .into_par_iter()
        .map(|tile| {
            if cancelled.load(Ordering::Relaxed) {
                return Counts::default();
            }
            let counts = vectorized::<S, _>(
                #[inline(always)]
                || draw_tile(scenery, tile),
            );
            let drawn = drawn.fetch_add(1, Ordering::Relaxed) + 1;
            if let ControlFlow::Break(()) = progress(drawn, total) {
                cancelled.store(true, Ordering::Relaxed);
            }
            counts
        })
        .reduce(Counts::default, Counts::plus);
    if cancelled.into_inner() {
        return Err(Error::Cancelled);
    }
    Ok(Drawn {
        pixels,
        depth_mm,
        counts,
    })
}

fn tiles<'i>(
    pixels: &'i mut [[f32; 4]],
    depth_mm: &'i mut [f32],
    width: usize,
    edge: usize,
) -> Vec<Tile<'i>> {
    let mut tiles = Vec::new();
    let mut depth_rows = depth_mm.chunks_mut(width);
    for (band, rows) in pixels.chunks_mut(width * edge).enumerate() {
        let first = tiles.len();
        for column in 0..width.div_ceil(edge) {
            tiles.push(Tile {
                x: (column * edge) as u32,
                y: (band * edge) as u32,
                rows: Vec::with_capacity(edge),
                depth_rows: Vec::new(),
            });
        }
        for row in rows.chunks_mut(width) {
            for (tile, part) in tiles[first..].iter_mut().zip(row.chunks_mut(edge)) {
                tile.rows.push(part);
            }
            if let Some(depth_row) = depth_rows.next() {
                for (tile, part) in tiles[first..].iter_mut().zip(depth_row.chunks_mut(edge)) {
                    tile.depth_rows.push(part);
                }
            }
        }
    }
    tiles
}

#[inline(always)]
fn draw_tile<S: Level>(scenery: &Scenery<S>, mut tile: Tile) -> Counts {
    let mut counts = Counts::default();
    let mut rays = RayPacket::empty(scenery.objects.len());
    let (width, height) = (tile.rows[0].len() as u32, tile.rows.len() as u32);
    let end = [tile.x + width, tile.y + height];
    let frames = scenery.plan.lattice.frames;
    for y in (0..height).step_by(PACKET[1]) {
        for x in (0..width).step_by(PACKET[0]) {
            let mut sums = [[0.0f64; 4]; crate::lanes::LANES];
            for frame in 0..frames {
                rays.aim(scenery, [tile.x + x, tile.y + y], end, frame);
                let seen = scenery.march(&rays, &mut counts);
                for lane in (0..seen.pixels.len()).filter(|&lane| rays.pixels[lane]) {
                    let column = x as usize + lane % PACKET[0];
                    let row = y as usize + lane / PACKET[0];
                    if frames == 1 {
                        tile.rows[row][column] = seen.pixels[lane];
                    } else {
                        let channels = sums[lane].iter_mut().zip(seen.pixels[lane]);
                        channels.for_each(|(sum, c)| *sum += f64::from(c));
                        tile.rows[row][column] =
                            sums[lane].map(|sum| (sum / f64::from(frame + 1)) as f32);
                    }
                    if let (0, Some(depth_row)) = (frame, tile.depth_rows.get_mut(row)) {
                        depth_row[column] = seen.depth_mm[lane];
                    }
                }
            }
        }
    }
    counts
}
