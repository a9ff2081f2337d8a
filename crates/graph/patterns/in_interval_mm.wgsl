/// Whether a distance lies in an interval of the ray, whose end does not belong to it.
/// distance_mm: length.mm
/// interval_mm: length.mm
fn in_interval_mm(distance_mm: f32, interval_mm: vec2f) -> bool {
    return distance_mm >= interval_mm.x && distance_mm < interval_mm.y;
}
