/// A mask of the scene at a place, 0 to 1 over its extent: what lies between texels is interpolated.
/// place: position.texture
/// index: default 0
fn mask_value(index: u32, place: vec3f) -> f32 {
    return mask(index, place);
}
