//! Tiles of the picture over all cores.

use crate::error::Error;
use crate::lanes::{LANES, PACKET};
use crate::levels::{Level, vectorized};
use crate::march::{Counts, OfRuns};
use crate::raster::Raster;
use crate::ray_packet::RayPacket;
use crate::scenery::Scenery;
use rayon::prelude::*;
use strahl_volume::Parts;

/// What the pixels of a raster hold before its colours are made linear.
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

/// Draws the pixels of `raster` in the current thread pool. Each pixel depends on its own ray only, so that
/// neither the size of tiles nor their order nor the number of threads can change one. Every tile is one of `parts`.
pub fn draw<S: Level>(
    scenery: &Scenery<S>,
    raster: Raster,
    edge: u32,
    parts: &Parts,
) -> Result<Drawn, Error> {
    let plan = scenery.plan;
    let [width, height] = raster.size(plan);
    if width == 0 || height == 0 {
        return Ok(Drawn {
            pixels: Vec::new(),
            depth_mm: Vec::new(),
            counts: Counts::default(),
        });
    }
    let mut pixels = vec![[0.0; 4]; width * height];
    let mut depth_mm = if plan.with_depth {
        vec![f32::INFINITY; width * height]
    } else {
        Vec::new()
    };
    let tiles = tiles(&mut pixels, &mut depth_mm, width, edge as usize);
    let counts = tiles
        .into_par_iter()
        // Tiles differ by far in what they cost: whoever is done first must find one that is left.
        .with_max_len(1)
        .map(|tile| {
            let counts = vectorized::<S, _>(
                #[inline(always)]
                || draw_tile(scenery, raster, tile, parts),
            );
            parts.done(1)?;
            Ok(counts)
        })
        .try_reduce(Counts::default, |one, other| {
            Ok::<_, Error>(one.plus(other))
        })?;
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
fn draw_tile<S: Level>(
    scenery: &Scenery<S>,
    raster: Raster,
    mut tile: Tile,
    parts: &Parts,
) -> Counts {
    let mut counts = Counts::default();
    let mut rays = RayPacket::empty(scenery.objects.len());
    let mut of_runs = OfRuns::none();
    let (width, height) = (tile.rows[0].len() as u32, tile.rows.len() as u32);
    let end = [tile.x + width, tile.y + height];
    let frames = scenery.plan.lattice.frames;
    let mut sums = [[0.0f64; 4]; LANES];
    for y in (0..height).step_by(PACKET[1]) {
        for x in (0..width).step_by(PACKET[0]) {
            let place = [x as usize, y as usize];
            for frame in 0..frames {
                if parts.is_cancelled() {
                    return counts;
                }
                rays.aim(scenery, raster, [tile.x + x, tile.y + y], end, frame);
                let seen = scenery.march(&rays, &mut of_runs, &mut counts);
                if frame == 0 && !tile.depth_rows.is_empty() {
                    write(&seen.depth_mm, &mut tile.depth_rows, place);
                }
                if frames == 1 {
                    write(&seen.pixels, &mut tile.rows, place);
                    continue;
                }
                for (sum, pixel) in sums.iter_mut().zip(seen.pixels) {
                    for (sum, c) in sum.iter_mut().zip(pixel) {
                        let so_far = if frame == 0 { 0.0 } else { *sum };
                        *sum = so_far + f64::from(c);
                    }
                }
            }
            if frames > 1 {
                let mean = sums.map(|sum| sum.map(|sum| (sum / f64::from(frames)) as f32));
                write(&mean, &mut tile.rows, place);
            }
        }
    }
    counts
}

/// Writes the lanes of a packet to the rows of a tile, as far as they lie in it.
#[inline(always)]
fn write<T: Copy>(lanes: &[T; LANES], rows: &mut [&mut [T]], [x, y]: [usize; 2]) {
    for (lanes, row) in lanes.chunks_exact(PACKET[0]).zip(&mut rows[y..]) {
        let row = &mut row[x..];
        let columns = row.len().min(PACKET[0]);
        row[..columns].copy_from_slice(&lanes[..columns]);
    }
}
