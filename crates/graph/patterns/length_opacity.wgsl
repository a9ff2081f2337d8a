/// The opacity of a length along the ray of that of the reference length: for samples that are not one step apart, such as slices in perspective.
/// opacity: opacity.reference
/// length_mm: length.mm
/// result: opacity.step
fn length_opacity(opacity: f32, length_mm: f32) -> f32 {
    return 1.0 - pow(1.0 - opacity_of_step(opacity), length_mm / step_mm());
}
