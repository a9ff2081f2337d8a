/// Cuts to what lies before opaque geometry at `opaque_mm`; an occluder before the entry leaves
/// nothing.
pub fn clip(opaque_mm: f64, [t0, t1]: [f64; 2]) -> [f64; 2] {
    [t0, t1.min(opaque_mm)]
}
