//! Linear in x, y, z, by the texture unit: one read. Its weights have 8 bits on many devices.
fn reconstruct(position: vec3f) -> f32 {
    return texel_linear(position);
}
