/// Numbers from 0 to 1, repeated over the picture.
@group(0) @binding(6) var noise_tile: texture_2d<f32>;

fn tile(pixel: vec2u) -> f32 {
    return textureLoad(noise_tile, pixel % textureDimensions(noise_tile), 0).r;
}
