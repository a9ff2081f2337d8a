//! A debug view: the position of the last sample in the volume, 0 to 1 along each axis, as color.
struct State {
    color: vec3f,
    found: bool,
}

fn composite_start() -> State {
    return State(vec3f(0.0), false);
}

fn composite_add(state: State, sample: Sample) -> State {
    return State(clamp((sample.position + 0.5) / vec3f(dims()), vec3f(0.0), vec3f(1.0)), true);
}

fn composite_done(state: State) -> bool {
    return false;
}

fn composite_finish(state: State) -> vec4f {
    return select(vec4f(0.0), vec4f(state.color, 1.0), state.found);
}
