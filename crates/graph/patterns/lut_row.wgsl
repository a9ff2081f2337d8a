/// A table of colors: the value across, between its texels; the row as it is, such as that of a segment.
/// value: value
fn lut_row(image: texture_2d<f32>, value: f32, low: f32, high: f32, row: f32) -> Surface {
    let size = vec2i(textureDimensions(image));
    let position = clamp((value - low) / (high - low), 0.0, 1.0) * f32(size.x - 1);
    let column = i32(position);
    let y = clamp(i32(row + 0.5), 0, size.y - 1);
    let left = textureLoad(image, vec2i(column, y), 0);
    let right = textureLoad(image, vec2i(min(column + 1, size.x - 1), y), 0);
    let entry = mix(left, right, position - f32(column));
    return Surface(entry.rgb, entry.a);
}
