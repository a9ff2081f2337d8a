//! The eight voxels around are classified, and the premultiplied colors interpolated: what programs did
//! that classify first, for comparison.
fn classify(value: f32, position: vec3f) -> Surface {
    let clamped = clamp(position, vec3f(0.0), vec3f(dims() - 1));
    let cell = min(vec3i(clamped), max(dims() - 2, vec3i(0)));
    let part = clamped - vec3f(cell);
    var color = vec3f(0.0);
    var opacity = 0.0;
    for (var corner = 0; corner < 8; corner++) {
        let upper = vec3i(corner & 1, (corner >> 1u) & 1, corner >> 2u);
        let surface = table(fetch(cell + upper));
        let share = select(1.0 - part, part, upper == vec3i(1));
        let weight = surface.opacity * share.x * share.y * share.z;
        color += weight * surface.color;
        opacity += weight;
    }
    if !(opacity > 0.0) {
        return Surface(vec3f(0.0), 0.0);
    }
    return Surface(color / opacity, opacity);
}
