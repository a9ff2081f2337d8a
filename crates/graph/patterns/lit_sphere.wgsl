/// The color of a sphere of the material under its light, where the normal points the same way (S. Bruckner and
/// E. Gröller 2007). `normal` is in the camera's axes: right, up, towards the eye.
/// color: color.linear
/// result: color.linear
/// is_meant: default true
fn lit_sphere(color: vec3f, normal: vec3f, sphere: texture_2d<f32>, is_meant: bool) -> vec3f {
    var seen = color;
    if is_meant && dot(normal, normal) > 0.0 {
        let place = vec2f(0.5 + 0.5 * normal.x, 0.5 - 0.5 * normal.y);
        let last = vec2i(textureDimensions(sphere)) - 1;
        let position = clamp(place * vec2f(last + 1) - 0.5, vec2f(0.0), vec2f(last));
        let low = vec2i(position);
        let high = min(low + 1, last);
        let part = position - vec2f(low);
        let above = mix(textureLoad(sphere, low, 0).rgb, textureLoad(sphere, vec2i(high.x, low.y), 0).rgb, part.x);
        let below = mix(textureLoad(sphere, vec2i(low.x, high.y), 0).rgb, textureLoad(sphere, high, 0).rgb, part.x);
        seen = mix(above, below, part.y);
    }
    return seen;
}
