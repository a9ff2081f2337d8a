/// The opacity of one step of that of the reference length.
/// opacity: opacity.reference
/// result: opacity.step
fn step_opacity(opacity: f32) -> f32 {
    return opacity_of_step(opacity);
}
