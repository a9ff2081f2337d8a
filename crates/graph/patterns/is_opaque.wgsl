//! Whether less light than this still passes.
struct Params {
    /// The ray ends when less than this share of light still passes; 0 never ends it.
    /// default 0.00390625, range 0 to 1
    stop_at_transmittance: f32,
}

fn is_opaque(opacity: f32) -> bool {
    return 1.0 - opacity < params.stop_at_transmittance;
}
