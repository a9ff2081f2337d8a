//! A hash of column, row, seed and frame: C. Wellons' `lowbias32`. The upper 24 bits are the
//! fraction, which f32 holds exactly.
struct Params {
    /// Other seeds give other patterns.
    /// default 0
    seed: u32,
}

fn jitter(pixel: vec2u, frame: u32) -> f32 {
    var h = (pixel.x * 0x9E3779B1u) ^ (pixel.y * 0x85EBCA77u) ^ ((params.seed + frame) * 0xC2B2AE3Du);
    h ^= h >> 16u;
    h *= 0x7FEB352Du;
    h ^= h >> 15u;
    h *= 0x846CA68Bu;
    h ^= h >> 16u;
    return f32(h >> 8u) / 16777216.0;
}
