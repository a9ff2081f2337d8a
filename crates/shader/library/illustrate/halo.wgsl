//! Dark behind the edges of what lies in front, so that one sees which of two bodies is nearer: the darker, the more of a ring
//! around the line to the eye is covered by what is opaque there. At a straight edge that is half of it.
struct Params {
    /// How far halos reach beyond an edge.
    /// default 4, range 1e-6 to 1e6
    width_mm: f32,
    /// How far behind an edge halos fall.
    /// default 40, range 1e-6 to 1e6
    reach_mm: f32,
    /// Share of the color that a halo takes away where half of the ring is covered.
    /// default 0.9, range 0 to 1
    strength: f32,
    /// At how many places along the way in front something is looked for.
    /// default 24, range 1 to 64
    steps: u32,
}

// Places around a line: every other one lies at half the width, where thin things are.
const PLACES: u32 = 8u;

fn illustrate(color: vec3f, position: vec3f, to_eye: vec3f) -> vec3f {
    let place = place_mm(position);
    // Any two directions across.
    let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(to_eye.x) > 0.6);
    let right = direction(cross(to_eye, axis));
    let up = cross(right, to_eye);
    var covered = 0.0;
    for (var i = 0u; i < PLACES; i++) {
        let angle = f32(i) * (6.283185307179586 / f32(PLACES));
        let radius = params.width_mm * select(1.0, 0.5, (i & 1u) == 1u);
        let across = radius * (cos(angle) * right + sin(angle) * up);
        var densest = 0.0;
        for (var k = 1u; k <= params.steps; k++) {
            // Nearer than it is wide lies the surface itself, if it is slanted.
            let ahead = params.width_mm + params.reach_mm * f32(k) / f32(params.steps);
            let beside = voxel_of(place + across + ahead * to_eye);
            if all(beside >= vec3f(-0.5)) && all(beside <= vec3f(dims()) - 0.5) {
                let seen = classify(reconstruct(beside), beside);
                densest = max(densest, seen.opacity * membership(beside));
            }
        }
        covered += densest;
    }
    return color * (1.0 - params.strength * min(2.0 * covered / f32(PLACES), 1.0));
}
