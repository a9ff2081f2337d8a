//! A debug view: the gradient at the first sample that is not transparent, (g mm + 1)/2.
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
    return State(clamp(0.5 * gradient(sample.position) + 0.5, vec3f(0.0), vec3f(1.0)), true);
}

fn composite_done(state: State) -> bool {
    return state.found;
}

fn composite_finish(state: State) -> vec4f {
    return select(vec4f(0.0), vec4f(state.color, 1.0), state.found);
}
