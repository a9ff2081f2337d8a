@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return corner(index);
}

@fragment
fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return pixel_at(at);
}

@fragment
fn fragment_with_depth(@builtin(position) at: vec4f) -> PixelWithDepth {
    let color = pixel_at(at);
    return PixelWithDepth(color, hit_mm);
}
