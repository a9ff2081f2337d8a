// The loop over one object.

var<private> entry_in_voxel: vec3f;
var<private> step_in_voxel: vec3f;

fn object() -> u32 {
    return 0u;
}

// The table and the bricks of the only object begin at 0.
fn table_first() -> u32 {
    return 0u;
}

fn bricks_first() -> vec3u {
    return vec3u(0u);
}

fn ray_position(lattice_point: f32) -> vec3f {
    return entry_in_voxel + lattice_point * step_in_voxel;
}

fn march(pixel: vec2u) -> vec4f {
    let ray = ray_of(pixel);
    let line = line_of(ray);
    let interval_mm = clip_ray(ray, extent_mm(line));
    let first = jitter(pixel, frame.number);
    let count = ceil((interval_mm.y - interval_mm.x) / frame.step_mm - first);
    entry_mm = interval_mm.x;
    entry_in_voxel = line.start + interval_mm.x * line.along;
    step_in_voxel = line.along * frame.step_mm;
    let to_eye = -ray.direction;

    var state = composite_start();
    var k = 0.0;
    while k < count {
        let lattice_point = in_order(k, count) + first;
        let position = ray_position(lattice_point);
        let empty = empty_points(position, onward(step_in_voxel));
        if empty > 0.0 {
            k += empty;
            continue;
        }
        if !clip_sample(place_mm(position)) {
            let value = reconstruct(position);
            // A sample without a value counts for no composite.
            if is_value(value) {
                state = composite_add(state, Sample(value, lattice_point, position, to_eye));
                if composite_done(state) {
                    break;
                }
            }
        }
        k += 1.0;
    }
    return composite_finish(state);
}
