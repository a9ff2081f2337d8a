//! Emission and absorption from the last sample to the first; no ray ends early.
const BACK_TO_FRONT: bool = true;

struct State {
    color: vec3f,
    alpha: f32,
}

fn composite_start() -> State {
    return State(vec3f(0.0), 0.0);
}

fn composite_add(state: State, sample: Sample) -> State {
    let seen = look(sample);
    if !(seen.opacity > 0.0) {
        return state;
    }
    return State(
        mix(state.color, seen.color, seen.opacity),
        mix(state.alpha, 1.0, seen.opacity),
    );
}

fn composite_done(state: State) -> bool {
    return false;
}

fn composite_finish(state: State) -> vec4f {
    return vec4f(state.color, state.alpha);
}
