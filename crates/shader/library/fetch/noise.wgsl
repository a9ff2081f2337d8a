//! Value noise instead of what is stored: random numbers on a lattice, joined by cubics without overshoot
//! (3t² − 2t³), each octave of half the size and half the strength; 0 to 1.
struct Params {
    /// Voxels from one random number to the next, of the coarsest octave.
    /// default 16, range 0.01 to 100000
    cell_voxels: f32,
    /// Octaves.
    /// default 4, range 1 to 8
    octaves: u32,
    /// Other seeds give other noise.
    /// default 0
    seed: u32,
}

// C. Wellons' `lowbias32`.
fn random(place: vec3u, seed: u32) -> f32 {
    var h = (place.x * 0x9E3779B1u) ^ (place.y * 0x85EBCA77u) ^ (place.z * 0x27D4EB2Fu) ^ (seed * 0xC2B2AE3Du);
    h ^= h >> 16u;
    h *= 0x7FEB352Du;
    h ^= h >> 15u;
    h *= 0x846CA68Bu;
    h ^= h >> 16u;
    return f32(h >> 8u) / 16777216.0;
}

fn row(corner: vec3u, t: f32, seed: u32) -> f32 {
    return mix(random(corner, seed), random(corner + vec3u(1u, 0u, 0u), seed), t);
}

fn plane(corner: vec3u, t: vec2f, seed: u32) -> f32 {
    return mix(row(corner, t.x, seed), row(corner + vec3u(0u, 1u, 0u), t.x, seed), t.y);
}

fn octave_at(place: vec3f, seed: u32) -> f32 {
    let corner = floor(place);
    let t = place - corner;
    let eased = t * t * (3.0 - 2.0 * t);
    let low = vec3u(corner);
    return mix(plane(low, eased.xy, seed), plane(low + vec3u(0u, 0u, 1u), eased.xy, seed), eased.z);
}

fn fetch(voxel: vec3i) -> f32 {
    let inside = vec3f(clamp(voxel, vec3i(0), dims() - 1));
    var sum = 0.0;
    var strength = 1.0;
    var total = 0.0;
    var cell = params.cell_voxels;
    for (var octave = 0u; octave < params.octaves; octave++) {
        sum += strength * octave_at(inside / cell, params.seed + octave);
        total += strength;
        strength *= 0.5;
        cell *= 0.5;
    }
    return sum / total;
}
