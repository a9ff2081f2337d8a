//! The transfer function with its opacity scaled by the steepness of the value there: a
//! two-dimensional transfer function (value × gradient magnitude) as a product, which brings out
//! borders between materials (M. Levoy 1988).
struct Params {
    /// The gradient magnitude below which everything is transparent.
    /// default 0, range 0 to 1e30
    low_per_mm: f32,
    /// The gradient magnitude above which the opacity of the transfer function holds.
    /// default 100, range 0 to 1e30, above low_per_mm
    high_per_mm: f32,
}

fn classify(value: f32, position: vec3f) -> Surface {
    var surface = table(value);
    if surface.opacity > 0.0 {
        let above = magnitude(gradient(position)) - params.low_per_mm;
        surface.opacity *= clamp(above / max(params.high_per_mm - params.low_per_mm, 1e-30), 0.0, 1.0);
    }
    return surface;
}
