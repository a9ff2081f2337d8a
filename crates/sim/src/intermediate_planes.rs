//! Perspective in slabs (document §8.2): where rays have spread too far, denser ones are started at an intermediate image
//! plane, and the host lays the pictures of the slabs over each other.
//!
//! Every slab has rays that lie one voxel apart at its back. A ray of a later slab is not sent where the slabs before let
//! too little light pass, which the host knows from the register of terminated rays. Pictures of different density are
//! laid over each other by their nearest pixel.

use crate::counters::Counters;
use crate::observer::{NoObserver, Observer};
use crate::processor::{Progress, Run, run};
use crate::{Error, Frame};

/// Draws a frame in `view.slabs` slabs of equal depth, one after the other: the picture has the density of the last.
///
/// # Errors
/// As [`run`].
pub(crate) fn run_slabs(
    frame: &Frame,
    observer: &mut impl Observer,
    progress: Progress,
) -> Result<Run, Error> {
    let planes = frame.setup.plane_count();
    let slabs = frame.spec.view.slabs;
    let mut frame = frame.clone();
    // The background lies behind the last slab.
    let background = std::mem::replace(&mut frame.spec.look.background, 0.0) as f32;
    let bound = |i: u32| (u64::from(planes) * u64::from(i) / u64::from(slabs)) as u32;
    let threshold = frame.spec.optimisation.termination_threshold as f32;
    let mut observer = Some(observer);
    let mut size = [1, 1];
    let mut color = vec![[0.0f32; 3]];
    let mut passing = vec![1.0f32];
    let mut stalls = vec![0u32];
    let mut changes = vec![0u32];
    let mut clocks_of_part = Vec::new();
    let mut counters = Counters::default();
    let mut last: Option<Run> = None;
    for i in 0..slabs {
        let mut slab = frame.clone();
        slab.setup = frame.setup.slab([bound(i), bound(i + 1)], 1.0);
        // Polygons behind the volume belong to the last slab.
        let behind = if i + 1 == slabs {
            u32::MAX
        } else {
            bound(i + 1)
        };
        slab.rasterise(bound(i)..behind);
        let next = slab.setup.size;
        color = denser(&color, size, next);
        passing = denser(&passing, size, next);
        stalls = denser(&stalls, size, next);
        changes = denser(&changes, size, next);
        size = next;
        // Rows of a setup go from the bottom, those of pictures from the top.
        let rows = passing.rchunks_exact(size[0] as usize).flatten();
        slab.setup.keep(rows.map(|p| *p >= threshold).collect());
        let told =
            |drawn: usize, all: usize| progress(all * i as usize + drawn, all * slabs as usize);
        let drawn = match observer.take() {
            Some(observer) => run(&slab, observer, &told)?,
            None => run(&slab, &mut NoObserver, &told)?,
        };
        for pixel in 0..color.len() {
            let theirs = match &drawn.color {
                Some(theirs) => theirs[pixel],
                None => [drawn.picture[pixel]; 3],
            };
            for (c, theirs) in color[pixel].iter_mut().zip(theirs) {
                *c += passing[pixel] * theirs;
            }
            passing[pixel] *= drawn.passing[pixel];
            stalls[pixel] += drawn.stalls_of_pixel[pixel];
            changes[pixel] += drawn.thesis_changes_of_pixel[pixel];
        }
        counters.add(&drawn.counters);
        clocks_of_part.push(drawn.counters.clocks);
        let is_complete = drawn.is_complete;
        last = Some(drawn);
        if !is_complete {
            break;
        }
    }
    for (pixel, passing) in color.iter_mut().zip(&passing) {
        *pixel = pixel.map(|c| (c + passing * background).min(1.0));
    }
    let is_color = frame.materials.is_some();
    let grey = |p: &[f32; 3]| match is_color {
        true => (p[0] + p[1] + p[2]) / 3.0,
        false => p[0],
    };
    Ok(Run {
        size,
        picture: color.iter().map(grey).collect(),
        color: is_color.then_some(color),
        ended_early: passing.iter().map(|p| *p < threshold).collect(),
        passing,
        stalls_of_pixel: stalls,
        thesis_changes_of_pixel: changes,
        counters,
        clocks_of_part,
        is_complete: last.is_some_and(|run| run.is_complete),
    })
}

/// A picture at another density, by the nearest pixel.
fn denser<T: Copy>(pixels: &[T], from: [u32; 2], to: [u32; 2]) -> Vec<T> {
    let nearest = |i: u32, axis: usize| {
        let at = (u64::from(i) * 2 + 1) * u64::from(from[axis]) / (2 * u64::from(to[axis]));
        at.min(u64::from(from[axis]) - 1) as usize
    };
    let mut all = Vec::with_capacity(to[0] as usize * to[1] as usize);
    for y in 0..to[1] {
        for x in 0..to[0] {
            all.push(pixels[nearest(y, 1) * from[0] as usize + nearest(x, 0)]);
        }
    }
    all
}
