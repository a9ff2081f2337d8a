//! Slot jitter: where in its step the samples of a ray lie.

mod hash;
mod moved_on;
mod sine_hash;
mod tile;

use strahl_scene::NoiseTile;
use strahl_scene::plan::{Jitter, Plan};

/// The jitter of a Plan, with what it reads.
pub enum Jitters {
    Centre,
    Hash(u32),
    SineHash,
    Tile(NoiseTile),
}

impl Jitters {
    /// The jitter of `plan`, with the `tile` that it reads if it reads one.
    pub fn new(plan: &Plan, tile: Option<&NoiseTile>) -> Jitters {
        match (plan.lattice.jitter, tile) {
            (_, Some(tile)) => Jitters::Tile(tile.clone()),
            (Jitter::Hash(seed), None) => Jitters::Hash(seed),
            (Jitter::SineHash, None) => Jitters::SineHash,
            (Jitter::Centre | Jitter::WhiteTile(_) | Jitter::BlueTile(_), None) => Jitters::Centre,
        }
    }

    /// The jitter of the pixel in column `x`, row `y` of a frame, in [0, 1).
    pub fn at(&self, x: u32, y: u32, frame: u32) -> f32 {
        match self {
            Jitters::Centre => 0.5,
            Jitters::Hash(seed) => hash::jitter(x, y, seed.wrapping_add(frame)),
            Jitters::SineHash => sine_hash::jitter(x, y, frame),
            Jitters::Tile(tile) => tile::jitter(tile, x, y, frame),
        }
    }
}
