/// The normal curvature of the isosurface in the direction of the eye, per mm (G. Kindlmann et al. 2003), by differences
/// of the gradient.
/// position: position.voxel
/// gradient_here: gradient.per_mm
/// to_eye: direction.world
fn curvature(position: vec3f, gradient_here: vec3f, to_eye: vec3f) -> f32 {
    let steep = magnitude(gradient_here);
    let normal = direction(gradient_here);
    let along = to_eye - dot(to_eye, normal) * normal;
    let tangent = direction(along);
    // One voxel that way, in voxel space.
    let origin = place_mm(position);
    let axes = array<vec3f, 3>(
        place_mm(position + vec3f(1.0, 0.0, 0.0)) - origin,
        place_mm(position + vec3f(0.0, 1.0, 0.0)) - origin,
        place_mm(position + vec3f(0.0, 0.0, 1.0)) - origin,
    );
    let way = vec3f(
        dot(tangent, axes[0]) / dot(axes[0], axes[0]),
        dot(tangent, axes[1]) / dot(axes[1], axes[1]),
        dot(tangent, axes[2]) / dot(axes[2], axes[2]),
    );
    let step = way / max(magnitude(way), 1e-20);
    let way_mm = magnitude(place_mm(position + step) - origin);
    let turn = gradient(position + step) - gradient(position - step);
    return select(0.0, abs(dot(turn, tangent)) / (2.0 * way_mm * steep), steep > 0.0 && way_mm > 0.0);
}
