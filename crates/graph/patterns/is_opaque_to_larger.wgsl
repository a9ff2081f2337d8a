//! Whether less light than this still passes, and no larger value can come.
struct Params {
    /// The ray ends when less than this share of light still passes.
    /// default 0.00390625, range 0 to 1
    stop_at_transmittance: f32,
    /// As in `fade`.
    /// default 0, range -1 to 0
    blend: f32,
}

fn is_opaque_to_larger(opacity: f32, largest: f32) -> bool {
    return 1.0 - opacity < params.stop_at_transmittance && (largest >= 1.0 || params.blend == -1.0);
}
