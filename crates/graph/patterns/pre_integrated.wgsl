/// Color and opacity of one step from the value at its front to that at its back, from a pre-integrated table
/// (K. Engel, M. Kraus, T. Ertl 2001).
/// front: value
/// back: value
fn pre_integrated(front: f32, back: f32, integrals: texture_2d<f32>, low: f32, high: f32) -> Step {
    let last = vec2i(textureDimensions(integrals)) - 1;
    let place = (vec2f(front, back) - low) / (high - low);
    let position = clamp(place, vec2f(0.0), vec2f(1.0)) * vec2f(last);
    let corner = vec2i(position);
    let next = min(corner + 1, last);
    let part = position - vec2f(corner);
    let above = mix(textureLoad(integrals, corner, 0), textureLoad(integrals, vec2i(next.x, corner.y), 0), part.x);
    let below = mix(textureLoad(integrals, vec2i(corner.x, next.y), 0), textureLoad(integrals, next, 0), part.x);
    let entry = mix(above, below, part.y);
    return Step(entry.rgb, entry.a);
}

struct Step {
    /// color.premultiplied
    color: vec3f,
    /// opacity.step
    opacity: f32,
}
