//! Tiles of the picture over all cores.

use crate::error::Error;
use crate::lanes::{LANES, PACKET};
use crate::levels::{Level, vectorized};
use crate::march::{Counts, RayMemory, RunBounds};
use crate::raster::Raster;
use crate::ray_packet::RayPacket;
use crate::ray_state::RayState;
use crate::ray_states::RayStates;
use crate::scenery::Scenery;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use strahl_volume::{Parts, cores};

/// What the pixels of a raster hold before its colors are made linear.
pub struct DrawnRaster {
    /// Premultiplied, row by row from the top.
    pub pixels: Vec<[f32; 4]>,
    /// Distance of the hit in the first frame, in mm; empty if nobody asked.
    pub depth_mm: Vec<f32>,
    pub counts: Counts,
}

/// A rectangle of the picture that one task draws: its rows, each a part of a row of the picture.
struct Tile<'i> {
    /// Column and row of the picture where it begins.
    corner: [usize; 2],
    rows: Vec<&'i mut [[f32; 4]]>,
    depth_rows: Vec<&'i mut [f32]>,
}

/// Draws the pixels of `raster` in the current thread pool; with `states`, of rays that have come as far as they say. Each
/// pixel depends on its own ray only, so that neither the size of tiles nor their order nor the number of threads can
/// change one. Every tile is one of `parts`.
pub fn draw<S: Level>(
    scenery: &Scenery<S>,
    raster: Raster,
    edge: u32,
    states: Option<&RayStates>,
    parts: &Parts,
) -> Result<DrawnRaster, Error> {
    let plan = scenery.plan;
    let [width, height] = raster.size(plan);
    if width == 0 || height == 0 {
        return Ok(DrawnRaster {
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
    let edges = [edge as usize; 2];
    let mut depth_rows = rectangles(&mut depth_mm, width, edges).into_iter();
    let tiles = rectangles(&mut pixels, width, edges).into_iter();
    let tiles = tiles.map(|(corner, rows)| Tile {
        corner,
        rows,
        depth_rows: depth_rows.next().map_or(Vec::new(), |(_, rows)| rows),
    });
    let counts = for_all(tiles.collect(), parts, |tile| {
        vectorized::<S, _>(
            #[inline(always)]
            || draw_tile(scenery, raster, states, tile, parts),
        )
    })?;
    Ok(DrawnRaster {
        pixels,
        depth_mm,
        counts,
    })
}

/// Moves the rays `states` through `interval` of the lattice. Every tile is one of `parts`.
pub fn march<S: Level>(
    scenery: &Scenery<S>,
    interval: &Range<u32>,
    edge: u32,
    states: &mut RayStates,
    parts: &Parts,
) -> Result<(), Error> {
    let [width, _] = Raster::ALL.size(scenery.plan);
    let frames = states.frames();
    let edges = [edge as usize * frames, edge as usize];
    let tiles = rectangles(states.states_mut(), width * frames, edges);
    for_all(tiles, parts, |([x, y], mut rows)| {
        march_tile(scenery, interval, [x / frames, y], &mut rows, parts);
        Counts::default()
    })?;
    Ok(())
}

/// What `draw` counts of all tiles.
fn for_all<T: Send>(
    tiles: Vec<T>,
    parts: &Parts,
    draw: impl Fn(T) -> Counts + Sync,
) -> Result<Counts, Error> {
    let sum = Mutex::new(Counts::default());
    cores::try_for_each(
        tiles,
        || (),
        |(), tile| {
            let counts = draw(tile);
            let mut sum = sum.lock().unwrap_or_else(PoisonError::into_inner);
            *sum = sum.plus(counts);
            Ok::<_, Error>(parts.done(1)?)
        },
    )?;
    Ok(sum.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Cells of a picture, row by row with `width` each, cut into rectangles of `edges` cells, each with its corner.
fn rectangles<T>(
    cells: &mut [T],
    width: usize,
    edges: [usize; 2],
) -> Vec<([usize; 2], Vec<&mut [T]>)> {
    // A tile may be asked for that is larger than the picture.
    let height = cells.len() / width;
    let edges = [edges[0].min(width), edges[1].min(height.max(1))];
    let mut all = Vec::new();
    for (band, rows) in cells.chunks_mut(width * edges[1]).enumerate() {
        let first = all.len();
        for column in 0..width.div_ceil(edges[0]) {
            let corner = [column * edges[0], band * edges[1]];
            all.push((corner, Vec::with_capacity(edges[1])));
        }
        for row in rows.chunks_mut(width) {
            for ((_, rows), part) in all[first..].iter_mut().zip(row.chunks_mut(edges[0])) {
                rows.push(part);
            }
        }
    }
    all
}

#[inline(always)]
fn draw_tile<S: Level>(
    scenery: &Scenery<S>,
    raster: Raster,
    states: Option<&RayStates>,
    mut tile: Tile,
    parts: &Parts,
) -> Counts {
    let mut counts = Counts::default();
    let mut rays = RayPacket::empty(scenery.plan.layers.len());
    let (mut of_runs, mut memory) = (RunBounds::none(), RayMemory::none());
    let (width, height) = (tile.rows[0].len(), tile.rows.len());
    let [x0, y0] = tile.corner;
    let end = [(x0 + width) as u32, (y0 + height) as u32];
    let frames = scenery.plan.lattice.frames;
    // As what is behind nothing, without a sign of 0.
    let nothing = scenery.plan.background.map(|c| 0.0 + c);
    let is_outside = |first: [u32; 2], size: [usize; 2]| {
        let last = [first[0] + size[0] as u32 - 1, first[1] + size[1] as u32 - 1];
        let outline = scenery.outline.as_ref().filter(|_| states.is_none());
        outline.is_some_and(|outline| outline.misses(raster.pixel(first), raster.pixel(last)))
    };
    if is_outside([x0 as u32, y0 as u32], [width, height]) {
        tile.rows.iter_mut().for_each(|row| row.fill(nothing));
        return counts;
    }
    let mut sums = [[0.0f64; 4]; LANES];
    for y in (0..height).step_by(PACKET[1]) {
        for x in (0..width).step_by(PACKET[0]) {
            let place = [x, y];
            let corner = [(x0 + x) as u32, (y0 + y) as u32];
            if is_outside(corner, PACKET) {
                write(&[nothing; LANES], &mut tile.rows, place);
                continue;
            }
            for frame in 0..frames {
                if parts.is_cancelled() {
                    return counts;
                }
                rays.aim(scenery, raster, corner, end, frame);
                let seen = match states {
                    None => scenery.march(&rays, &mut of_runs, &mut memory, &mut counts),
                    Some(states) => {
                        let states = states.of_packet(corner, end, frame);
                        scenery.seen(&rays, &states, &mut memory, &mut counts)
                    }
                };
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

/// Moves the rays of a tile, of which each row has those of all frames of a pixel beside one another.
fn march_tile<S: Level>(
    scenery: &Scenery<S>,
    interval: &Range<u32>,
    [x0, y0]: [usize; 2],
    rows: &mut [&mut [RayState]],
    parts: &Parts,
) {
    let frames = scenery.plan.lattice.frames as usize;
    let mut rays = RayPacket::empty(scenery.plan.layers.len());
    let mut memory = RayMemory::none();
    let (width, height) = (rows[0].len() / frames, rows.len());
    let end = [(x0 + width) as u32, (y0 + height) as u32];
    for y in (0..height).step_by(PACKET[1]) {
        for x in (0..width).step_by(PACKET[0]) {
            let corner = [(x0 + x) as u32, (y0 + y) as u32];
            let (columns, lines) = (PACKET[0].min(width - x), PACKET[1].min(height - y));
            for frame in 0..frames {
                if parts.is_cancelled() {
                    return;
                }
                rays.aim(scenery, Raster::ALL, corner, end, frame as u32);
                let mut states = [RayState::default(); LANES];
                for (row, states) in rows[y..y + lines].iter().zip(states.chunks_mut(PACKET[0])) {
                    for (column, state) in states[..columns].iter_mut().enumerate() {
                        *state = row[(x + column) * frames + frame];
                    }
                }
                scenery.march_through(&rays, interval, &mut states, &mut memory);
                for (row, states) in rows[y..y + lines].iter_mut().zip(states.chunks(PACKET[0])) {
                    for (column, state) in states[..columns].iter().enumerate() {
                        row[(x + column) * frames + frame] = *state;
                    }
                }
            }
        }
    }
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
