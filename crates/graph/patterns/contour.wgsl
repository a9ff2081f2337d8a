//! A line of even thickness where the surface turns away from the eye (G. Kindlmann et al. 2003).
struct Params {
    /// Thickness of the line.
    /// default 1.5, range 0.001 to 1000, unit mm
    thickness_mm: f32,
    /// Its color.
    /// default (0, 0, 0), range 0 to 1
    line: vec3f,
}

/// color: color.linear
/// normal: direction.world
/// to_eye: direction.world
/// result: color.linear
fn contour(color: vec3f, normal: vec3f, to_eye: vec3f, curvature_per_mm: f32) -> vec3f {
    let turn = clamp(params.thickness_mm * curvature_per_mm, 0.0, 1.0);
    let border = sqrt(turn * (2.0 - turn));
    let facing = abs(dot(normal, to_eye));
    let is_line = dot(normal, normal) > 0.0 && facing < border;
    return select(color, params.line, is_line);
}
