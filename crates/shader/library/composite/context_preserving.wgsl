//! Context-preserving rendering (S. Bruckner, S. Grimm, A. Kanitsar and M. E. Gröller 2005): where a surface is flat, brightly
//! lit, near and not yet covered, it becomes transparent, so that one sees the inside; contours and what lies far stay. Colors
//! are those of the transfer function times the light on white.
struct Params {
    /// How deep one sees into the object: about the depth of a cut plane. 0 fades by the gradient alone.
    /// default 3, range 0 to 100
    cut_depth: f32,
    /// How sharp the cut is; 0 fades by the gradient alone.
    /// default 0.6, range 0 to 20
    cut_sharpness: f32,
    /// The gradient magnitude that leaves the opacity as it is.
    /// default 100, range 1e-30 to 1e30
    full_per_mm: f32,
    /// The distance along the ray that counts as near …
    /// default 0, range 0 to 1e12
    nearest_mm: f32,
    /// … and the one that counts as far.
    /// default 1, range 0 to 1e12, not nearest_mm
    farthest_mm: f32,
    /// The ray ends when less than this share of light still passes; 0 never ends it.
    /// default 0.00390625, range 0 to 1
    stop_at_transmittance: f32,
    /// What covers a place: 0 what lies before it in its segment, 1 all that lies before it on the ray.
    /// default 0, range 0 to 1
    covered_by: u32,
}

struct State {
    color: vec3f,
    alpha: f32,
}

fn composite_start() -> State {
    return State(vec3f(0.0), 0.0);
}

// x^e for x of 0 or more, 1 for e of 0.
fn power(x: f32, e: f32) -> f32 {
    if e <= 0.0 {
        return 1.0;
    }
    return select(0.0, min(pow(max(x, 1e-30), e), 1e30), x > 0.0);
}

fn composite_add(state: State, sample: Sample) -> State {
    let surface = classify(sample.value, sample.position);
    if surface.opacity <= 0.0 {
        return state;
    }
    let lit = shade(Surface(vec3f(1.0), surface.opacity), sample.position, sample.to_eye);
    let light = max(dot(lit.color, vec3f(0.2126, 0.7152, 0.0722)), 0.0);
    let steepness = clamp(magnitude(gradient(sample.position)) / params.full_per_mm, 0.0, 1.0);
    let way = distance_mm(sample.lattice_point) - params.nearest_mm;
    let far = clamp(way / (params.farthest_mm - params.nearest_mm), 0.0, 1.0);
    let before = select(0.0, covered(), params.covered_by == 1u);
    let cut = params.cut_depth * light * (1.0 - far) * (1.0 - state.alpha) * (1.0 - before);
    let kept = power(steepness, power(cut, params.cut_sharpness));
    let share = (1.0 - state.alpha) * opacity_of_step(lit.opacity * kept);
    let color = illustrate(surface.color * lit.color, sample.position, sample.to_eye);
    return State(state.color + share * color, state.alpha + share);
}

fn composite_done(state: State) -> bool {
    return 1.0 - state.alpha < params.stop_at_transmittance;
}

fn composite_finish(state: State) -> vec4f {
    return vec4f(state.color, state.alpha);
}
