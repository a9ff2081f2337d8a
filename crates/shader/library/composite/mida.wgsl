//! Maximum intensity difference accumulation (S. Bruckner and E. Gröller 2009): where the ray
//! meets a value larger than all before, what lies in front fades by the difference. `blend` goes
//! from front-to-back compositing over the method itself to the maximum.
struct Params {
    /// The value that counts as 0.
    /// default 0
    low: f32,
    /// The value that counts as 1.
    /// default 1, not low
    high: f32,
    /// -1 is front-to-back compositing, 0 the method itself, 1 the largest value alone.
    /// default 0, range -1 to 1
    blend: f32,
    /// The ray ends when less than this share of light still passes and no larger value can come.
    /// default 0.00390625, range 0 to 1
    stop_at_transmittance: f32,
}

struct State {
    color: vec3f,
    alpha: f32,
    largest: f32,
    // The sample at which the largest share was first reached.
    value: f32,
    position: vec3f,
    to_eye: vec3f,
}

fn composite_start() -> State {
    return State(vec3f(0.0), 0.0, 0.0, 0.0, vec3f(0.0), vec3f(0.0));
}

fn composite_add(state: State, sample: Sample) -> State {
    let share = clamp((sample.value - params.low) / (params.high - params.low), 0.0, 1.0);
    let rise = max(share - state.largest, 0.0);
    let kept = 1.0 - rise * (1.0 + min(params.blend, 0.0));
    var next = state;
    next.color = kept * state.color;
    next.alpha = kept * state.alpha;
    if share > state.largest {
        next.largest = share;
        next.value = sample.value;
        next.position = sample.position;
        next.to_eye = sample.to_eye;
    }
    let surface = classify(sample.value, sample.position);
    if surface.opacity > 0.0 {
        let seen = shade(surface, sample.position, sample.to_eye);
        let weight = (1.0 - next.alpha) * opacity_of_step(seen.opacity);
        next.color += weight * illustrate(seen.color, sample.position, sample.to_eye);
        next.alpha += weight;
    }
    return next;
}

fn composite_done(state: State) -> bool {
    return 1.0 - state.alpha < params.stop_at_transmittance && (state.largest >= 1.0 || params.blend == -1.0);
}

fn composite_finish(state: State) -> vec4f {
    let summed = vec4f(state.color, state.alpha);
    if params.blend <= 0.0 {
        return summed;
    }
    var maximum = vec4f(0.0);
    if state.largest > 0.0 {
        let seen = shade(classify(state.value, state.position), state.position, state.to_eye);
        let color = illustrate(seen.color, state.position, state.to_eye);
        maximum = vec4f(color * seen.opacity, seen.opacity);
    }
    return (1.0 - params.blend) * summed + params.blend * maximum;
}
