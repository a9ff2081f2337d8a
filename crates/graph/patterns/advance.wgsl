/// The next sample, over points at which nothing can be seen.
/// empty: default 0
fn advance(k: f32, empty: f32) -> f32 {
    return k + max(empty, 1.0);
}
