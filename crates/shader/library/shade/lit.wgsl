//! Ambient light, multiplied by the surface color, and all lights, with the gradient as normal.
//! Without a gradient the color stays as it is.
struct Params {
    /// Share of the color that is there without light.
    /// default 0.25, range 0 to 10
    ambient: f32,
}

fn shade(surface: Surface, position: vec3f, to_eye: vec3f) -> Surface {
    let normal = direction(gradient(position));
    var seen = surface;
    if dot(normal, normal) > 0.0 {
        seen = illuminated(surface, normal, position, to_eye);
    }
    return seen;
}

fn illuminated(surface: Surface, normal: vec3f, position: vec3f, to_eye: vec3f) -> Surface {
    // Turned towards the eye: whether the gradient points into the material or out of it depends
    // on the data.
    let facing = select(normal, -normal, dot(normal, to_eye) < 0.0);
    let color = params.ambient * surface.color + lighting(surface.color, facing, position, to_eye);
    return Surface(color, surface.opacity);
}
