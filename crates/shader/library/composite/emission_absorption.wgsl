//! Emission and absorption, front to back (N. Max 1995).
struct Params {
    /// The ray ends when less than this share of light still passes; 0 never ends it.
    /// default 0.00390625, range 0 to 1
    stop_at_transmittance: f32,
}

struct State {
    color: vec3f,
    alpha: f32,
}

fn composite_start() -> State {
    return State(vec3f(0.0), 0.0);
}

fn composite_add(state: State, sample: Sample) -> State {
    let seen = look(sample);
    let share = (1.0 - state.alpha) * seen.opacity;
    return State(state.color + share * seen.color, state.alpha + share);
}

fn composite_done(state: State) -> bool {
    return 1.0 - state.alpha < params.stop_at_transmittance;
}

fn composite_finish(state: State) -> vec4f {
    return vec4f(state.color, state.alpha);
}
