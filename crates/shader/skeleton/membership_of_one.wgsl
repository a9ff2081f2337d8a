fn membership(position: vec3f) -> f32 {
    return 1.0;
}
