//! What lies farther away looks more like a color: that of haze or, if it is dark, of a fading light.
struct Params {
    /// Share of the color of what lies farthest.
    /// default 0.75, range 0 to 1
    strength: f32,
    /// The depth in front of the eye, along the direction of view, up to which nothing changes …
    /// default 0, range -1e12 to 1e12
    nearest_mm: f32,
    /// … and the one from which on it changes no more.
    /// default 1, range -1e12 to 1e12, not nearest_mm
    farthest_mm: f32,
    /// The red part of that color, in linear light.
    /// default 0, range 0 to 1
    red: f32,
    /// The green part.
    /// default 0, range 0 to 1
    green: f32,
    /// The blue part.
    /// default 0, range 0 to 1
    blue: f32,
}

fn illustrate(color: vec3f, position: vec3f, to_eye: vec3f) -> vec3f {
    let way = depth_mm(position) - params.nearest_mm;
    let far = clamp(way / (params.farthest_mm - params.nearest_mm), 0.0, 1.0);
    return mix(color, vec3f(params.red, params.green, params.blue), params.strength * far);
}
