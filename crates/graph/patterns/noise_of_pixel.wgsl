//! A number from 0 to 1 for each pixel, sample and seed.
struct Params {
    /// Other seeds give other numbers.
    /// default 0
    seed: u32,
}

/// k: default 0
fn noise_of_pixel(pixel: vec2u, k: f32) -> f32 {
    // PCG of three words (M. Jarzynski and M. Olano 2020).
    var v = vec3u(pixel, u32(k) + params.seed * 747796405u) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    return f32(v.x >> 8u) / 16777216.0;
}
