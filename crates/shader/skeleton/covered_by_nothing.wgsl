// There is one run.
fn covered() -> f32 {
    return 0.0;
}
