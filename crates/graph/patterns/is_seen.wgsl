/// Whether no empty points begin here.
fn is_seen(empty: f32) -> bool {
    return !(empty > 0.0);
}
