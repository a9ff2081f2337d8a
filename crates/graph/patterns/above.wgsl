/// Whether `a` is larger than `b`.
/// b: default 0
fn above(a: f32, b: f32) -> bool {
    return a > b;
}
