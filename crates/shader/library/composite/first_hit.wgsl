//! The first place where the value reaches a threshold, refined by bisection between the samples
//! around it (a secant could leave the bracket, and would miss the face of a clip), shaded, opaque.
struct Params {
    /// The value of the surface.
    /// default 0.5
    threshold: f32,
}

struct State {
    color: vec3f,
    hit: bool,
}

fn composite_start() -> State {
    return State(vec3f(0.0), false);
}

fn reached(lattice_point: f32) -> bool {
    let position = ray_position(lattice_point);
    let value = reconstruct(position);
    // What is infinite is no value, and reaches nothing.
    return is_finite(value) && value >= params.threshold && !clip_sample(place_mm(position));
}

fn composite_add(state: State, sample: Sample) -> State {
    if !(sample.value >= params.threshold) {
        return state;
    }
    // Before the first sample lies the entry, at which a ray may already be inside.
    let first = sample.lattice_point < 1.0;
    var outside = max(sample.lattice_point - 1.0, 0.0);
    var inside = sample.lattice_point;
    if first && reached(0.0) {
        inside = 0.0;
    } else {
        // 12 halvings: the place is exact to 1/4096 of a step.
        for (var i = 0; i < 12; i++) {
            let middle = 0.5 * (outside + inside);
            if reached(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
    }
    report_hit(inside);
    let position = ray_position(inside);
    let surface = classify(reconstruct(position), position);
    let lit = shade(surface, position, sample.to_eye);
    return State(illustrate(lit.color, position, sample.to_eye), true);
}

fn composite_done(state: State) -> bool {
    return state.hit;
}

fn composite_finish(state: State) -> vec4f {
    return select(vec4f(0.0), vec4f(state.color, 1.0), state.hit);
}
