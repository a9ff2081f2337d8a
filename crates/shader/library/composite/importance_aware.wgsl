//! Importance-aware compositing (F. de Moura Pinto and C. M. D. S. Freitas 2010): a sample that is more important than what
//! lies before it shines through, by as much as its importance asks; the opacity of the ray stays that of emission and
//! absorption. Where less than 1/256 of light still passes, samples that ask for no more than that are left out; the ray
//! ends there when nothing that could come asks for more.
struct Params {
    /// What is important: 0 steep places, 1 silhouettes, 2 places that a light at the eye lights badly, 3 large values, 4
    /// everything alike, 5 what the importance volume of the scene says.
    /// default 0, range 0 to 5
    measure: u32,
    /// How important it is: of two that differ by 1, the more important one gets 63 % of the light at least, by 3 95 %.
    /// default 3, range 0 to 50
    gain: f32,
    /// Silhouettes: exponent of the gradient. Lighting: exponent of the highlight.
    /// default 0.4, range 0 to 100
    first: f32,
    /// Silhouettes: the slant at which they begin, 0 to 1. Lighting: exponent of the diffuse part.
    /// default 0.2, range 0 to 100
    second: f32,
    /// Silhouettes: the slant at which they are complete; below `second` they are what faces the eye. Lighting: exponent of
    /// the gradient's part.
    /// default 0.6, range 0 to 100
    third: f32,
    /// The gradient magnitude that counts as 1.
    /// default 100, range 1e-30 to 1e30
    full_per_mm: f32,
    /// The value that counts as 0 …
    /// default 0
    low: f32,
    /// … and as 1.
    /// default 1, not low
    high: f32,
}

struct State {
    color: vec3f,
    alpha: f32,
    importance: f32,
}

// Below this share of light nothing is seen. A sample asks for 1 - exp(-rise) of it, which is below its rise.
const LEAST_LIGHT = 0.00390625;

fn composite_start() -> State {
    return State(vec3f(0.0), 0.0, 0.0);
}

// x^e for x from 0 to 1, 1 for e of 0.
fn power(x: f32, e: f32) -> f32 {
    if e <= 0.0 {
        return 1.0;
    }
    return select(0.0, pow(max(x, 1e-30), e), x > 0.0);
}

fn importance(sample: Sample) -> f32 {
    if params.measure == 4u {
        return 1.0;
    }
    if params.measure == 5u {
        return importance_at(sample.position);
    }
    if params.measure == 3u {
        return clamp((sample.value - params.low) / (params.high - params.low), 0.0, 1.0);
    }
    let change = gradient(sample.position);
    let steepness = clamp(magnitude(change) / params.full_per_mm, 0.0, 1.0);
    if params.measure == 0u {
        return steepness;
    }
    let facing = min(abs(dot(direction(change), sample.to_eye)), 1.0);
    if params.measure == 2u {
        return 3.0 - power(facing, params.first) - power(facing, params.second) - power(1.0 - steepness, params.third);
    }
    let slant = 1.0 - facing;
    let width = params.third - params.second;
    let is_beyond = select(0.0, 1.0, slant >= params.second);
    let ramp = clamp(select((slant - params.second) / width, is_beyond, width == 0.0), 0.0, 1.0);
    return power(steepness, params.first) * ramp * ramp * (3.0 - 2.0 * ramp);
}

fn composite_add(state: State, sample: Sample) -> State {
    let seen = look(sample);
    if seen.opacity <= 0.0 {
        return state;
    }
    let own = params.gain * importance(sample);
    let rise = own - state.importance;
    if 1.0 - state.alpha < LEAST_LIGHT && rise < LEAST_LIGHT {
        return state;
    }
    var kept = 1.0;
    if rise > 0.0 {
        let visibility = 1.0 - exp(-rise);
        if 1.0 - state.alpha < visibility {
            kept = (1.0 - visibility) / state.alpha;
        }
    }
    let passing = 1.0 - seen.opacity;
    let modulated = kept * state.alpha * passing + seen.opacity;
    let alpha = state.alpha * passing + seen.opacity;
    let color = kept * state.color + (1.0 - kept * state.alpha) * seen.opacity * seen.color;
    let accumulated = own + log(seen.opacity + passing * exp(min(-rise, 0.0)));
    return State(
        color * (alpha / modulated),
        alpha,
        select(state.importance, max(state.importance, accumulated), rise > 0.0),
    );
}

fn composite_done(state: State) -> bool {
    let most = select(1.0, 3.0, params.measure == 2u);
    return 1.0 - state.alpha < LEAST_LIGHT && params.gain * most - state.importance < LEAST_LIGHT;
}

fn composite_finish(state: State) -> vec4f {
    return vec4f(state.color, state.alpha);
}
