//! Perspective in slabs (document §8.2): where rays have spread too far, denser ones are started at an intermediate image
//! plane, and the host lays the pictures of the slabs over each other.
//!
//! Every slab has rays that lie one voxel apart at its back. A ray of a later slab is not sent where the slabs before let
//! too little light pass, which the host knows from the register of terminated rays. Pictures of different density are
//! laid over each other by their nearest pixel.

use crate::counters::Counters;
use crate::processor::{Progress, run};
use crate::spec::{Projection, Spec};
use crate::volume_store::VolumeStore;
use crate::{Error, Frame, Nobody};

/// What drawing in slabs leaves.
#[derive(Clone, Debug)]
pub struct Slabs {
    /// Pixels per row and rows of the densest slab, which is the last.
    pub size: [u32; 2],
    /// The picture, 0 to 1, first row at the top.
    pub picture: Vec<f32>,
    /// Counts of each slab, nearest first.
    pub slabs: Vec<Counters>,
    /// All counts together; slabs are drawn one after the other.
    pub counters: Counters,
    /// Whether all slabs are complete.
    pub is_complete: bool,
}

/// Draws a frame in `slabs` slabs of equal depth.
///
/// # Errors
/// If the view is not in perspective, there are no slabs, or as [`Frame::new`].
pub fn run_slabs(
    spec: &Spec,
    volume: &VolumeStore,
    slabs: u32,
    progress: Progress,
) -> Result<Slabs, Error> {
    if spec.view.projection == Projection::Parallel {
        let problem = "parallel rays do not spread: set it to perspective";
        return Err(Error::field("view.projection", "parallel", problem));
    }
    let mut spec = spec.clone();
    // The background lies behind the last slab.
    let background = std::mem::replace(&mut spec.look.background, 0.0) as f32;
    let frame = Frame::new(&spec, volume)?;
    let planes = frame.setup.plane_count();
    if slabs == 0 || slabs > planes {
        return Err(Error::field(
            "slabs",
            slabs,
            format!("they must be 1 to {planes}"),
        ));
    }
    let bound = |i: u32| (u64::from(planes) * u64::from(i) / u64::from(slabs)) as u32;
    let threshold = spec.optimisation.termination_threshold as f32;
    let mut size = [1, 1];
    let mut picture = vec![0.0f32];
    let mut passing = vec![1.0f32];
    let mut counted = Vec::new();
    let mut counters = Counters::default();
    let mut is_complete = true;
    for i in 0..slabs {
        let mut slab = frame.clone();
        slab.setup = frame.setup.slab([bound(i), bound(i + 1)], 1.0);
        let next = slab.setup.size;
        picture = denser(&picture, size, next);
        passing = denser(&passing, size, next);
        size = next;
        // Rows of a setup go from the bottom, those of pictures from the top.
        let rows = passing.rchunks_exact(size[0] as usize).flatten();
        slab.setup.keep(rows.map(|p| *p >= threshold).collect());
        let drawn = run(&slab, &mut Nobody, progress)?;
        for pixel in 0..picture.len() {
            picture[pixel] += passing[pixel] * drawn.picture[pixel];
            passing[pixel] *= drawn.passing[pixel];
        }
        counters.add(&drawn.counters);
        counted.push(drawn.counters);
        is_complete &= drawn.is_complete;
        if !is_complete {
            break;
        }
    }
    for (pixel, passing) in picture.iter_mut().zip(passing) {
        *pixel = (*pixel + passing * background).min(1.0);
    }
    Ok(Slabs {
        size,
        picture,
        slabs: counted,
        counters,
        is_complete,
    })
}

/// A picture at another density, by the nearest pixel.
fn denser(pixels: &[f32], from: [u32; 2], to: [u32; 2]) -> Vec<f32> {
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
