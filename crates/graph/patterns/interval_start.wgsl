/// Where an interval begins.
/// interval_mm: length.mm
/// result: length.mm
fn interval_start(interval_mm: vec2f) -> f32 {
    return interval_mm.x;
}
