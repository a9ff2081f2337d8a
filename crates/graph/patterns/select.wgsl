/// One of two numbers, both of which are computed.
fn chosen(a: f32, b: f32, take_b: bool) -> f32 {
    return select(a, b, take_b);
}
