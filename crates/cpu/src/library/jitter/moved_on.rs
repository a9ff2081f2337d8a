/// `value` moved on by the golden ratio for each frame, which fills [0, 1) evenly.
pub fn moved_on(value: f32, frame: u32) -> f32 {
    let moved = value + (frame & 0xFFFF) as f32 * 0.618_034;
    moved - moved.floor()
}
