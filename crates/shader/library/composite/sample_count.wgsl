//! A debug view: how many samples the ray takes, as gray.
struct Params {
    /// The number that is white.
    /// default 500, range 1 to 1e9
    white: f32,
}

struct State {
    number: f32,
}

fn composite_start() -> State {
    return State(0.0);
}

fn composite_add(state: State, sample: Sample) -> State {
    return State(state.number + 1.0);
}

fn composite_done(state: State) -> bool {
    return false;
}

fn composite_finish(state: State) -> vec4f {
    if state.number == 0.0 {
        return vec4f(0.0);
    }
    return vec4f(vec3f(clamp(state.number / params.white, 0.0, 1.0)), 1.0);
}
