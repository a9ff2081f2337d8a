// Color and opacity of each step from a pre-integrated table over the values at its front and back.

@group(0) @binding(32) var integrals: texture_2d<f32>;

const STOP_AT_TRANSMITTANCE: f32 = 0.00390625;

fn march(pixel: vec2u) -> vec4f {
    let line = line_of(ray_of(pixel));
    let interval = extent_mm(line);
    entry_mm = interval.x;
    let first = line.start + interval.x * line.along;
    let step = line.along * frame.step_mm;
    let count = ceil((interval.y - interval.x) / frame.step_mm - 0.5);
    let domain = table_domain();
    var color = vec3f(0.0);
    var opacity = 0.0;
    var k = 0.0;
    while k < count {
        let position = first + (k + 0.5) * step;
        k += 1.0;
        let front = reconstruct(position);
        if !is_value(front) {
            continue;
        }
        let back = reconstruct(position + step);
        let last = vec2i(textureDimensions(integrals)) - 1;
        let share = (vec2f(front, back) - domain.x) / (domain.y - domain.x);
        let place = clamp(share, vec2f(0.0), vec2f(1.0)) * vec2f(last);
        let corner = vec2i(place);
        let next = min(corner + 1, last);
        let part = place - vec2f(corner);
        let entry = mix(
            mix(textureLoad(integrals, corner, 0), textureLoad(integrals, vec2i(next.x, corner.y), 0), part.x),
            mix(textureLoad(integrals, vec2i(corner.x, next.y), 0), textureLoad(integrals, next, 0), part.x),
            part.y,
        );
        if entry.a > 0.0 {
            let passing = 1.0 - opacity;
            color += passing * entry.rgb;
            opacity += passing * entry.a;
            if 1.0 - opacity < STOP_AT_TRANSMITTANCE {
                break;
            }
        }
    }
    return vec4f(color, opacity);
}
