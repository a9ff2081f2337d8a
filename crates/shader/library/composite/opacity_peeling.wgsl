//! Opacity peeling (C. Rezk-Salama and A. Kolb 2006): emission and absorption that begins anew where the ray leaves
//! something opaque, so that one sees what it hides: bone under skin of the same values, what is inside bone. A layer ends at
//! the first nearly clear sample behind enough opacity; lattice points without a sample are clear.
struct Params {
    /// Which layer is shown: 0 is what hides the others.
    /// default 1, range 0 to 16
    layer: u32,
    /// A layer can end when it hides more than this share of what lies behind it.
    /// default 0.8, range 0 to 1
    opaque_above: f32,
    /// A sample of this opacity (of the reference length) or less is nearly clear.
    /// default 0.3, range 0 to 1
    clear_below: f32,
    /// The ray ends when less than this share of light still passes the layer that is shown; 0 never ends it.
    /// default 0.00390625, range 0 to 1
    stop_at_transmittance: f32,
}

struct State {
    color: vec3f,
    alpha: f32,
    layer: u32,
    has_ended: bool,
    lattice_point: f32,
}

fn composite_start() -> State {
    return State(vec3f(0.0), 0.0, 0u, false, 0.0);
}

fn composite_add(state: State, sample: Sample) -> State {
    let seen = look(sample);
    // Points that skipping or a clip has left out would have been clear.
    let is_clear = seen.opacity <= opacity_of_step(params.clear_below)
        || sample.lattice_point - state.lattice_point > 1.5;
    var next = state;
    next.lattice_point = sample.lattice_point;
    if is_clear && state.alpha > params.opaque_above {
        if state.layer == params.layer {
            next.has_ended = true;
            return next;
        }
        next.layer += 1u;
        next.color = vec3f(0.0);
        next.alpha = 0.0;
    }
    let share = (1.0 - next.alpha) * seen.opacity;
    next.color += share * seen.color;
    next.alpha += share;
    return next;
}

fn composite_done(state: State) -> bool {
    let is_opaque = 1.0 - state.alpha < params.stop_at_transmittance;
    return state.has_ended || (is_opaque && state.layer == params.layer);
}

fn composite_finish(state: State) -> vec4f {
    return select(vec4f(0.0), vec4f(state.color, state.alpha), state.layer == params.layer);
}
