//! A debug view: the gradient magnitude at the first sample that is not transparent, as gray.
struct Params {
    /// The magnitude that is white.
    /// default 100, range 1e-30 to 1e30
    white_per_mm: f32,
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
    return State(vec3f(clamp(magnitude(gradient(sample.position)) / params.white_per_mm, 0.0, 1.0)), true);
}

fn composite_done(state: State) -> bool {
    return state.found;
}

fn composite_finish(state: State) -> vec4f {
    return select(vec4f(0.0), vec4f(state.color, 1.0), state.found);
}
