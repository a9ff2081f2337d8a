//! A debug view: the normal at the first sample that is not transparent, (n + 1)/2.
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
    return State(0.5 * direction(gradient(sample.position)) + 0.5, true);
}

fn composite_done(state: State) -> bool {
    return state.found;
}

fn composite_finish(state: State) -> vec4f {
    return select(vec4f(0.0), vec4f(state.color, 1.0), state.found);
}
