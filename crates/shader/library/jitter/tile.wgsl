//! A tile of noise, repeated over the picture, moved on by the golden ratio for each frame, which
//! fills [0, 1) evenly. The renderer makes the tile: white or blue noise.
fn jitter(pixel: vec2u, frame: u32) -> f32 {
    return fract(tile(pixel) + f32(frame & 0xFFFFu) * 0.618034);
}
