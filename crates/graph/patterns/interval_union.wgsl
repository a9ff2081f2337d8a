/// From where the first of several intervals begins to where the last ends; empty ones do not count.
/// interval_mm: length.mm
/// others_mm: length.mm, default (3.0e38, -3.0e38)
/// result: length.mm
fn interval_union(interval_mm: vec2f, others_mm: vec2f) -> vec2f {
    let both = vec2f(min(others_mm.x, interval_mm.x), max(others_mm.y, interval_mm.y));
    return select(others_mm, both, interval_mm.x < interval_mm.y);
}
