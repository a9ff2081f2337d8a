//! Gray above a threshold, nothing below. Unlike a first hit, the ray goes on.
struct Params {
    /// Values up to this are transparent.
    /// default 0
    threshold: f32,
    /// The value that is black.
    /// default 0
    black: f32,
    /// The value that is white and opaque.
    /// default 1, not black
    white: f32,
}

fn classify(value: f32, position: vec3f) -> Surface {
    if !(value > params.threshold) {
        return Surface(vec3f(0.0), 0.0);
    }
    let grey = clamp((value - params.black) / (params.white - params.black), 0.0, 1.0);
    return Surface(vec3f(grey), grey);
}
