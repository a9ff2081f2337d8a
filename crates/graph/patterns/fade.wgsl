//! Maximum intensity difference accumulation (S. Bruckner and E. Gröller 2009): what lies in front fades
//! where a value is larger than all before.
struct Params {
    /// The value that counts as 0.
    /// default 0
    low: f32,
    /// The value that counts as 1.
    /// default 1
    high: f32,
    /// -1 is front-to-back compositing, 0 the method itself.
    /// default 0, range -1 to 0
    blend: f32,
}

/// value: value
/// sum_color: color.premultiplied
fn fade(value: f32, sum_color: vec3f, sum_opacity: f32, largest: f32) -> Faded {
    let share = clamp((value - params.low) / (params.high - params.low), 0.0, 1.0);
    let rise = max(share - largest, 0.0);
    let kept = 1.0 - rise * (1.0 + params.blend);
    return Faded(kept * sum_color, kept * sum_opacity, max(share, largest));
}

struct Faded {
    /// color.premultiplied
    color: vec3f,
    opacity: f32,
    largest: f32,
}
