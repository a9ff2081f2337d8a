/// Of the part that is drawn: opaque geometry before the background.
@group(0) @binding(13) var opaque_color: texture_2d<f32>;

fn behind() -> vec4f {
    return textureLoad(opaque_color, pixel_of_part, 0);
}
