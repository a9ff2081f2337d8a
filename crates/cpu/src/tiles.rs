//! Tiles of the picture over all cores.

use crate::lanes::PACKET;
use crate::library::fetch::Fetch;
use crate::march::{Counts, Slots};
use crate::ray::RayPacket;
use crate::{Error, Progress};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use strahl_scene::{Image, plan::Plan};

/// A rectangle of the picture that one task draws: its rows, each a part of a row of the picture.
struct Tile<'i> {
    x: u32,
    y: u32,
    rows: Vec<&'i mut [[f32; 4]]>,
}

/// Draws all tiles in the current thread pool. Each pixel depends on its own ray only, so that
/// neither the size of tiles nor their order nor the number of threads can change one.
pub fn draw<F: Fetch>(
    plan: &Plan,
    slots: &Slots,
    fetch: &F,
    edge: u32,
    progress: Progress,
) -> Result<(Image, Counts), Error> {
    let mut image = Image::new(plan.width, plan.height);
    let tiles = tiles(&mut image, edge);
    let total = tiles.len();
    let drawn = AtomicUsize::new(0);
    let cancelled = AtomicBool::new(false);
    let counts = tiles
        .into_par_iter()
        .map(|tile| {
            if cancelled.load(Ordering::Relaxed) {
                return Counts::default();
            }
            let counts = draw_tile(plan, slots, fetch, tile);
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
    Ok((image, counts))
}

fn tiles(image: &mut Image, edge: u32) -> Vec<Tile<'_>> {
    let width = image.width() as usize;
    let edge = edge as usize;
    let mut tiles = Vec::new();
    for (band, rows) in image.pixels_mut().chunks_mut(width * edge).enumerate() {
        let first = tiles.len();
        for column in 0..width.div_ceil(edge) {
            tiles.push(Tile {
                x: (column * edge) as u32,
                y: (band * edge) as u32,
                rows: Vec::with_capacity(edge),
            });
        }
        for row in rows.chunks_mut(width) {
            for (tile, part) in tiles[first..].iter_mut().zip(row.chunks_mut(edge)) {
                tile.rows.push(part);
            }
        }
    }
    tiles
}

fn draw_tile<F: Fetch>(plan: &Plan, slots: &Slots, fetch: &F, mut tile: Tile) -> Counts {
    let mut counts = Counts::default();
    let (width, height) = (tile.rows[0].len() as u32, tile.rows.len() as u32);
    for y in (0..height).step_by(PACKET[1]) {
        for x in (0..width).step_by(PACKET[0]) {
            let (x_end, y_end) = (tile.x + width, tile.y + height);
            let rays = RayPacket::new(plan, tile.x + x, tile.y + y, x_end, y_end);
            let pixels = slots.march(fetch, &rays, &mut counts);
            for (lane, pixel) in pixels.iter().enumerate() {
                if rays.pixels[lane] {
                    let (column, row) = (lane % PACKET[0], lane / PACKET[0]);
                    tile.rows[y as usize + row][x as usize + column] = *pixel;
                }
            }
        }
    }
    counts
}
