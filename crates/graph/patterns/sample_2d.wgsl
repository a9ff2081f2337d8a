/// A table between its texels, clamped at the border; `place` is 0 to 1.
fn sample_2d(image: texture_2d<f32>, place: vec2f) -> vec4f {
    let last = vec2i(textureDimensions(image)) - 1;
    let position = clamp(place * vec2f(last + 1) - 0.5, vec2f(0.0), vec2f(last));
    let low = vec2i(position);
    let high = min(low + 1, last);
    let part = position - vec2f(low);
    let above = mix(textureLoad(image, low, 0), textureLoad(image, vec2i(high.x, low.y), 0), part.x);
    let below = mix(textureLoad(image, vec2i(low.x, high.y), 0), textureLoad(image, high, 0), part.x);
    return mix(above, below, part.y);
}
