// Emission and absorption over a table of colors, unlit, with early termination and empty bricks left out.

const STOP_AT_TRANSMITTANCE: f32 = 0.00390625;

fn march(pixel: vec2u) -> vec4f {
    let line = line_of(ray_of(pixel));
    let interval = extent_mm(line);
    entry_mm = interval.x;
    let first = line.start + interval.x * line.along;
    let step = line.along * frame.step_mm;
    let count = ceil((interval.y - interval.x) / frame.step_mm - 0.5);
    var color = vec3f(0.0);
    var opacity = 0.0;
    var k = 0.0;
    while k < count {
        let position = first + (k + 0.5) * step;
        let empty = empty_points(position, step);
        if !(empty > 0.0) {
            let look = classify(reconstruct(position), position);
            let share = (1.0 - opacity) * opacity_of_step(look.opacity);
            color += share * look.color;
            opacity += share;
        }
        if 1.0 - opacity < STOP_AT_TRANSMITTANCE {
            break;
        }
        k += max(empty, 1.0);
    }
    return vec4f(color, opacity);
}
