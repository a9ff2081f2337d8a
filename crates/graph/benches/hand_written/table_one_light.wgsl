// Emission and absorption over a table of colors, lit by the lights of the scene with the gradient as normal.

const AMBIENT: f32 = 0.25;
const STOP_AT_TRANSMITTANCE: f32 = 0.00390625;

fn march(pixel: vec2u) -> vec4f {
    let ray = ray_of(pixel);
    let line = line_of(ray);
    let interval = extent_mm(line);
    entry_mm = interval.x;
    let first = line.start + interval.x * line.along;
    let step = line.along * frame.step_mm;
    let count = ceil((interval.y - interval.x) / frame.step_mm - 0.5);
    let to_eye = -ray.direction;
    var color = vec3f(0.0);
    var opacity = 0.0;
    var k = 0.0;
    while k < count {
        let position = first + (k + 0.5) * step;
        let empty = empty_points(position, step);
        k += max(empty, 1.0);
        if empty > 0.0 {
            continue;
        }
        let value = reconstruct(position);
        if !is_value(value) {
            continue;
        }
        let look = classify(value, position);
        if look.opacity > 0.0 {
            let steepest = direction(gradient(position));
            let normal = select(steepest, -steepest, dot(steepest, to_eye) < 0.0);
            var lit = look.color;
            if dot(normal, normal) > 0.0 {
                lit = AMBIENT * lit + lighting(look.color, normal, position, to_eye);
            }
            let share = (1.0 - opacity) * opacity_of_step(look.opacity);
            color += share * lit;
            opacity += share;
            if 1.0 - opacity < STOP_AT_TRANSMITTANCE {
                break;
            }
        }
    }
    return vec4f(color, opacity);
}
