//! Lines along contours, of the same width in mm on bodies of any curvature (G. Kindlmann, R. Whitaker, T. Tasdizen and
//! T. Möller, Curvature-based transfer functions for direct volume rendering, 2003): dark where
//! |N·V| < √(T·κ·(2 − T·κ)), with the width T and the curvature κ of the surface towards the eye, from the normals on both sides
//! of the place.
struct Params {
    /// The width of the lines in the picture.
    /// default 1, range 1e-6 to 1e6
    width_mm: f32,
    /// How far apart the normals are taken.
    /// default 1, range 1e-6 to 1e6
    reach_mm: f32,
    /// Share of the color that lines take away.
    /// default 0.9, range 0 to 1
    strength: f32,
    /// Share of the line over which it fades.
    /// default 0.3, range 0.01 to 1
    softness: f32,
}

fn illustrate(color: vec3f, position: vec3f, to_eye: vec3f) -> vec3f {
    let normal = direction(gradient(position));
    if dot(normal, normal) == 0.0 {
        return color;
    }
    let facing = dot(normal, to_eye);
    let along = direction(to_eye - facing * normal);
    let place = place_mm(position);
    let apart = 0.5 * params.reach_mm * along;
    let before = direction(gradient(voxel_of(place - apart)));
    let behind = direction(gradient(voxel_of(place + apart)));
    let curvature = abs(dot(behind - before, along)) / params.reach_mm;
    let bent = min(params.width_mm * curvature, 1.0);
    let limit = sqrt(bent * (2.0 - bent));
    let inside = clamp((limit - abs(facing)) / max(params.softness * limit, 1e-6), 0.0, 1.0);
    return color * (1.0 - params.strength * inside);
}
