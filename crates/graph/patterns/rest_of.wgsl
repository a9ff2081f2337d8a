/// What is left of 1.
fn rest_of(a: f32) -> f32 {
    return 1.0 - a;
}
