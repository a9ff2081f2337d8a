//! The transfer function of the scene: color and opacity by value.
fn classify(value: f32, position: vec3f) -> Surface {
    return table(value);
}
