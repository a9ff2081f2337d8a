/// The distance between samples.
/// result: length.mm
fn distance_of_samples() -> f32 {
    return step_mm();
}
