//! The mean of the central differences here and at the eight corners of the cube of one voxel
//! around: 54 reads, smooth.
fn gradient(position: vec3f) -> vec3f {
    var largest = vec3f(0.0);
    var sum = difference(position, &largest);
    for (var corner = 0u; corner < 8u; corner++) {
        let side = vec3f(vec3u(corner & 1u, (corner >> 1u) & 1u, corner >> 2u));
        sum += difference(position + side - 0.5, &largest);
    }
    return gradient_per_mm(above_rounding(sum / 18.0, largest));
}

fn difference(position: vec3f, largest: ptr<function, vec3f>) -> vec3f {
    let ahead = vec3f(
        gradient_input(position + vec3f(1.0, 0.0, 0.0)),
        gradient_input(position + vec3f(0.0, 1.0, 0.0)),
        gradient_input(position + vec3f(0.0, 0.0, 1.0)),
    );
    let behind = vec3f(
        gradient_input(position - vec3f(1.0, 0.0, 0.0)),
        gradient_input(position - vec3f(0.0, 1.0, 0.0)),
        gradient_input(position - vec3f(0.0, 0.0, 1.0)),
    );
    *largest = max(*largest, max(abs(ahead), abs(behind)));
    return ahead - behind;
}
