// Types that every module may use.

/// Color in linear light, not multiplied by the opacity, and the opacity of the reference length.
struct Surface {
    color: vec3f,
    opacity: f32,
}

/// Light that reaches a place.
struct Light {
    /// Unit vector towards the light, world space.
    direction: vec3f,
    /// Linear RGB.
    radiance: vec3f,
}

/// A ray in world space, mm from its start.
struct Ray {
    origin_mm: vec3f,
    /// Unit length.
    direction: vec3f,
}

/// A lattice point at which the volume was reconstructed.
struct Sample {
    value: f32,
    /// Lattice coordinate: the number of the point plus the jitter.
    lattice_point: f32,
    /// Voxel space.
    position: vec3f,
    /// Unit vector towards the eye, world space.
    to_eye: vec3f,
}
