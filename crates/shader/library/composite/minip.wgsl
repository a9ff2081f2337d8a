//! The smallest value of the ray, classified and shaded once; NaN is no value.
struct State {
    value: f32,
    position: vec3f,
    to_eye: vec3f,
    found: bool,
}

fn composite_start() -> State {
    return State(0.0, vec3f(0.0), vec3f(0.0), false);
}

fn composite_add(state: State, sample: Sample) -> State {
    if sample.value == sample.value && (!state.found || sample.value < state.value) {
        return State(sample.value, sample.position, sample.to_eye, true);
    }
    return state;
}

fn composite_done(state: State) -> bool {
    return false;
}

fn composite_finish(state: State) -> vec4f {
    if !state.found {
        return vec4f(0.0);
    }
    let seen = shade(classify(state.value, state.position), state.position, state.to_eye);
    let color = illustrate(seen.color, state.position, state.to_eye);
    return vec4f(color * seen.opacity, seen.opacity);
}
