use super::moved_on::moved_on;

/// fract(cos(11.55·x + 42.123·y)·35684.525), the trigonometric hash of older shaders.
pub fn jitter(x: u32, y: u32, frame: u32) -> f32 {
    let wave = (x as f32 * 11.55 + y as f32 * 42.123).cos() * 35_684.525;
    moved_on(wave - wave.floor(), frame)
}
