/// Of the part that is drawn: how far along the ray of each pixel opaque geometry lies.
@group(0) @binding(7) var opaque_geometry: texture_2d<f32>;

fn opaque_mm() -> f32 {
    return textureLoad(opaque_geometry, pixel_of_part, 0).r;
}
