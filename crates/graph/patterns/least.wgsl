/// The smaller of two numbers.
fn least(a: f32, b: f32) -> f32 {
    return min(a, b);
}
