//! The value itself, as gray and as opacity.
struct Params {
    /// The value that is black and transparent.
    /// default 0
    black: f32,
    /// The value that is white and opaque.
    /// default 1, not black
    white: f32,
}

fn classify(value: f32, position: vec3f) -> Surface {
    let grey = clamp((value - params.black) / (params.white - params.black), 0.0, 1.0);
    return Surface(vec3f(grey), grey);
}
