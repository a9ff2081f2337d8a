//! A debug view: how far from the eye the first sample that is not transparent lies, as gray.
struct Params {
    /// The distance that is black.
    /// default 0, unit mm
    near_mm: f32,
    /// The distance that is white.
    /// default 1000, unit mm, not near_mm
    far_mm: f32,
}

struct State {
    color: vec3f,
    found: bool,
}

fn composite_start() -> State {
    return State(vec3f(0.0), false);
}

fn composite_add(state: State, sample: Sample) -> State {
    if !(classify(sample.value, sample.position).opacity > 0.0) {
        return state;
    }
    return State(vec3f(clamp((distance_mm(sample.lattice_point) - params.near_mm) / (params.far_mm - params.near_mm), 0.0, 1.0)), true);
}

fn composite_done(state: State) -> bool {
    return state.found;
}

fn composite_finish(state: State) -> vec4f {
    return select(vec4f(0.0), vec4f(state.color, 1.0), state.found);
}
