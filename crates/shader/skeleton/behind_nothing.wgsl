fn behind() -> vec4f {
    return frame.background;
}
