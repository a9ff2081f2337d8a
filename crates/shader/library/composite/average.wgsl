//! The mean value of the ray, classified once, as an X-ray film; NaN is no value.
struct State {
    sum: f32,
    number: f32,
    position: vec3f,
}

fn composite_start() -> State {
    return State(0.0, 0.0, vec3f(0.0));
}

fn composite_add(state: State, sample: Sample) -> State {
    if sample.value != sample.value {
        return state;
    }
    return State(state.sum + sample.value, state.number + 1.0, sample.position);
}

fn composite_done(state: State) -> bool {
    return false;
}

fn composite_finish(state: State) -> vec4f {
    if state.number == 0.0 {
        return vec4f(0.0);
    }
    let surface = classify(state.sum / state.number, state.position);
    return vec4f(surface.color * surface.opacity, surface.opacity);
}
