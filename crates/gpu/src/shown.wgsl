// Brings a part of the picture into a texture that somebody else shows, and adds up frames before that.

struct Show {
    // The pixel of the picture at the corner of the part, and what its numbers are multiplied by.
    origin: vec2<f32>,
    weight: f32,
    // Whether colors are sRGB-encoded numbers.
    is_encoded: u32,
}

@group(0) @binding(0) var<uniform> how: Show;
@group(0) @binding(1) var part: texture_2d<f32>;
@group(0) @binding(2) var before: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    let place = vec2<f32>(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    return vec4<f32>(place, 0.0, 1.0);
}

fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        return encoded / 12.92;
    }
    return pow((encoded + 0.055) / 1.055, 2.4);
}

@fragment
fn fragment(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(place.xy - how.origin);
    let sum = (textureLoad(part, pixel, 0) + textureLoad(before, pixel, 0)) * how.weight;
    if how.is_encoded == 0u || sum.a <= 0.0 {
        return sum;
    }
    let color = max(sum.rgb / sum.a, vec3<f32>(0.0));
    return vec4<f32>(vec3<f32>(linear(color.r), linear(color.g), linear(color.b)) * sum.a, sum.a);
}
