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
    /// The jitter of `plan`.
    pub fn new(plan: &Plan) -> Jitters {
        match plan.lattice.jitter {
            Jitter::Centre => Jitters::Centre,
            Jitter::Hash(seed) => Jitters::Hash(seed),
            Jitter::SineHash => Jitters::SineHash,
            Jitter::WhiteTile(seed) => Jitters::Tile(NoiseTile::white(seed)),
            Jitter::BlueTile(seed) => Jitters::Tile(NoiseTile::blue(seed)),
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
