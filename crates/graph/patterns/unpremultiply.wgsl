/// Color without the opacity; black where there is none.
/// color: color.premultiplied
/// result: color.linear
fn unpremultiply(color: vec3f, opacity: f32) -> vec3f {
    return select(vec3f(0.0), color / opacity, opacity > 0.0);
}
