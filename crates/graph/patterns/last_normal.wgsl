/// The normal of a gradient as long as there is one, else the last one, turned to the eye.
/// gradient_here: gradient.per_mm
/// last: direction.world
/// to_eye: direction.world
fn last_normal(gradient_here: vec3f, last: vec3f, to_eye: vec3f) -> Normals {
    let normal = direction(gradient_here);
    let kept = select(last, normal, dot(normal, normal) > 0.0);
    return Normals(kept, select(kept, -kept, dot(kept, to_eye) < 0.0));
}

struct Normals {
    /// direction.world
    kept: vec3f,
    /// direction.world
    facing: vec3f,
}
