//! Cel shading, as in drawn films (A. Lake et al. 2000): brightness by the cosine of the angle to the light in a few even steps, and
//! none where the surface turns away from the eye, which draws an outline.
struct Params {
    /// Share of the color that follows the angle to the light.
    /// default 0.8, range 0 to 10
    diffuse: f32,
    /// Steps of brightness.
    /// default 3, range 1 to 32
    bands: f32,
    /// Part of a step over which it turns into the next one.
    /// default 0.1, range 0.01 to 1
    softness: f32,
    /// Cosine of the angle to the eye below which there is an outline; 0 draws none.
    /// default 0.3, range 0 to 1
    outline: f32,
}

fn illuminate(color: vec3f, normal: vec3f, to_eye: vec3f, light: Light) -> vec3f {
    let steps = clamp(dot(normal, light.direction), 0.0, 1.0) * params.bands;
    let whole = floor(steps);
    let rise = clamp((steps - whole - 1.0) / params.softness + 1.0, 0.0, 1.0);
    let level = (whole + rise * rise * (3.0 - 2.0 * rise)) / params.bands;
    // The outline is as soft as a step, around its cosine.
    let inner = clamp((dot(normal, to_eye) - params.outline) / max(params.outline * params.softness, 1e-3) + 1.0, 0.0, 1.0);
    return light.radiance * params.diffuse * level * inner * color;
}
