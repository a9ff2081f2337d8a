//! As `lit`, but where there is no gradient the last normal of the ray counts, so that the inside
//! of a material looks like its surface.
struct Params {
    /// Share of the color that is there without light.
    /// default 0.25, range 0 to 10
    ambient: f32,
}

var<private> last_normal: vec3f = vec3f(0.0);

fn shade(surface: Surface, position: vec3f, to_eye: vec3f) -> Surface {
    let normal = direction(gradient(position));
    if dot(normal, normal) > 0.0 {
        last_normal = normal;
    }
    if dot(last_normal, last_normal) == 0.0 {
        return surface;
    }
    return illuminated(surface, last_normal, position, to_eye);
}

fn illuminated(surface: Surface, normal: vec3f, position: vec3f, to_eye: vec3f) -> Surface {
    // Turned towards the eye: whether the gradient points into the material or out of it depends
    // on the data.
    let facing = select(normal, -normal, dot(normal, to_eye) < 0.0);
    let color = params.ambient * surface.color + lighting(surface.color, facing, position, to_eye);
    return Surface(color, surface.opacity);
}
