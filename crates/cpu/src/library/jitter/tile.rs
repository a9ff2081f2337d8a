use super::moved_on::moved_on;
use strahl_scene::NoiseTile;

/// A tile of noise, repeated over the picture.
pub fn jitter(tile: &NoiseTile, x: u32, y: u32, frame: u32) -> f32 {
    moved_on(tile.at(x, y), frame)
}
