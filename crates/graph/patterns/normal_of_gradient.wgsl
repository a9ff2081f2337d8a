/// The direction of a gradient, turned to the eye; 0 where there is none.
/// gradient_here: gradient.per_mm
/// to_eye: direction.world
/// result: direction.world
fn normal_of_gradient(gradient_here: vec3f, to_eye: vec3f) -> vec3f {
    let normal = direction(gradient_here);
    return select(normal, -normal, dot(normal, to_eye) < 0.0);
}
