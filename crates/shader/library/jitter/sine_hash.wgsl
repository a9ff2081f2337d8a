//! The trigonometric hash of older shaders, moved on by the golden ratio for each frame. It depends on
//! how a machine computes cosines; `hash` does not.
fn jitter(pixel: vec2u, frame: u32) -> f32 {
    let wave = cos(f32(pixel.x) * 11.55 + f32(pixel.y) * 42.123) * 35684.525;
    return fract(fract(wave) + f32(frame & 0xFFFFu) * 0.618034);
}
