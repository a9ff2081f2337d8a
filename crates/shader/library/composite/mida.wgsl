//! Maximum intensity difference accumulation (S. Bruckner and E. Gröller 2009): where the ray
//! meets a value larger than all before, what lies in front fades by the difference. Between
//! front-to-back compositing and the maximum.
struct Params {
    /// The value that counts as 0.
    /// default 0
    low: f32,
    /// The value that counts as 1.
    /// default 1, not low
    high: f32,
    /// -1 is front-to-back compositing, 0 the method itself.
    /// default 0, range -1 to 0
    blend: f32,
    /// The ray ends when less than this share of light still passes and no larger value can come.
    /// default 0.00390625, range 0 to 1
    stop_at_transmittance: f32,
}

struct State {
    color: vec3f,
    alpha: f32,
    largest: f32,
}

fn composite_start() -> State {
    return State(vec3f(0.0), 0.0, 0.0);
}

fn composite_add(state: State, sample: Sample) -> State {
    let share = clamp((sample.value - params.low) / (params.high - params.low), 0.0, 1.0);
    let rise = max(share - state.largest, 0.0);
    let kept = 1.0 - rise * (1.0 + params.blend);
    var next = State(kept * state.color, kept * state.alpha, max(share, state.largest));
    let surface = classify(sample.value, sample.position);
    if surface.opacity > 0.0 {
        let seen = shade(surface, sample.position, sample.to_eye);
        let weight = (1.0 - next.alpha) * opacity_of_step(seen.opacity);
        next.color += weight * seen.color;
        next.alpha += weight;
    }
    return next;
}

fn composite_done(state: State) -> bool {
    return 1.0 - state.alpha < params.stop_at_transmittance && (state.largest >= 1.0 || params.blend == -1.0);
}

fn composite_finish(state: State) -> vec4f {
    return vec4f(state.color, state.alpha);
}
