//! Slot jitter: where in its step the samples of a ray lie.

mod hash;
mod moved_on;
mod sine_hash;
mod tile;

use std::sync::Arc;
use strahl_scene::NoiseTile;
use strahl_scene::plan::Jitter;
use strahl_volume::{Cancelled, Control, Store};

/// The jitter of a Plan, with what it reads.
pub enum Jitters {
    Center,
    Hash(u32),
    SineHash,
    Tile(Arc<NoiseTile>),
}

impl Jitters {
    /// `jitter`, with the tile that it reads if it reads one: found in `store`, or made.
    pub fn find(jitter: Jitter, store: &Store, control: &Control) -> Result<Jitters, Cancelled> {
        let tile = NoiseTile::find(jitter, store, control)?;
        Ok(match (tile, jitter) {
            (Some(tile), _) => Jitters::Tile(tile),
            (None, Jitter::Hash(seed)) => Jitters::Hash(seed),
            (None, Jitter::SineHash) => Jitters::SineHash,
            (None, _) => Jitters::Center,
        })
    }

    /// The jitter of the pixel in column `x`, row `y` of a frame, in [0, 1).
    pub fn at(&self, x: u32, y: u32, frame: u32) -> f32 {
        match self {
            Jitters::Center => 0.5,
            Jitters::Hash(seed) => hash::jitter(x, y, seed.wrapping_add(frame)),
            Jitters::SineHash => sine_hash::jitter(x, y, frame),
            Jitters::Tile(tile) => tile::jitter(tile, x, y, frame),
        }
    }
}
