/// Whether sample `k` is one of `count`.
fn before_end(k: f32, count: f32) -> bool {
    return k < count;
}
