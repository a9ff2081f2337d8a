fn texel(voxel: vec3i) -> f32 {
    let inside = clamp(voxel, vec3i(0), dims() - 1);
    return stored(inside) * frame.objects[object()].slope + frame.objects[object()].intercept;
}
