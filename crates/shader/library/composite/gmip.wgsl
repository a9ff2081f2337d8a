//! The steepest place of the ray, as gray.
struct Params {
    /// The gradient magnitude that is white.
    /// default 100, range 1e-30 to 1e30
    white_per_mm: f32,
}

struct State {
    steepest_per_mm: f32,
    found: bool,
}

fn composite_start() -> State {
    return State(0.0, false);
}

fn composite_add(state: State, sample: Sample) -> State {
    return State(max(state.steepest_per_mm, magnitude(gradient(sample.position))), true);
}

fn composite_done(state: State) -> bool {
    return false;
}

fn composite_finish(state: State) -> vec4f {
    if !state.found {
        return vec4f(0.0);
    }
    return vec4f(vec3f(clamp(state.steepest_per_mm / params.white_per_mm, 0.0, 1.0)), 1.0);
}
