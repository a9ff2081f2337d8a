//! Slot jitter: where in its step the samples of a ray lie.

mod hash;

use strahl_scene::plan::Jitter;

/// The jitter of the pixel in column `x`, row `y`, in [0, 1).
pub fn of(jitter: Jitter, x: u32, y: u32) -> f32 {
    match jitter {
        Jitter::Centre => 0.5,
        Jitter::Hash(seed) => hash::jitter(x, y, seed),
    }
}
