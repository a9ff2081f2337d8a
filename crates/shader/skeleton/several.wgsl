// The loop over several objects, which all share one lattice: it begins where the ray meets the
// first of them. An object takes part at the lattice points inside its own interval.

var<private> current: u32 = 0u;
var<private> entries_in_voxel: array<vec3f, OBJECTS>;
var<private> steps_in_voxel: array<vec3f, OBJECTS>;
/// First and last lattice coordinate of each object; the last does not belong to it.
var<private> intervals: array<vec2f, OBJECTS>;
/// A bit for each object that may be seen at the lattice point of now.
var<private> present: u32;

fn object() -> u32 {
    return current;
}

fn table_first() -> u32 {
    return frame.objects[current].table_first;
}

fn bricks_first() -> vec3u {
    return frame.objects[current].bricks_first;
}

fn ray_position(lattice_point: f32) -> vec3f {
    return entries_in_voxel[current] + lattice_point * steps_in_voxel[current];
}

// The lattice points from `lattice_point` on at which nobody can be seen; 0 if somebody may be
// seen here, who then is `present`.
fn nobody_points(lattice_point: f32) -> f32 {
    var fewest = 1e9;
    present = 0u;
    for (var i = 0u; i < OBJECTS; i++) {
        let interval = intervals[i];
        if lattice_point >= interval.x && lattice_point < interval.y {
            current = i;
            let empty = empty_points(ray_position(lattice_point), onward(steps_in_voxel[i]));
            present |= select(0u, 1u << i, empty == 0.0);
            fewest = min(fewest, empty);
        } else if interval.x < interval.y {
            // Less than the way to the object; what lies behind the ray does not come again.
            let way = way_to(interval, lattice_point);
            fewest = min(fewest, select(1e9, max(floor(way), 1.0), way >= 0.0));
        }
    }
    current = 0u;
    return fewest;
}

fn march(pixel: vec2u) -> vec4f {
    let ray = ray_of(pixel);
    let first = jitter(pixel, frame.number);
    var whole_mm = vec2f(NOWHERE_MM, -NOWHERE_MM);
    for (var i = 0u; i < OBJECTS; i++) {
        current = i;
        let interval_mm = clip_ray(ray, extent_mm(line_of(ray)));
        intervals[i] = interval_mm;
        if interval_mm.x < interval_mm.y {
            whole_mm = vec2f(min(whole_mm.x, interval_mm.x), max(whole_mm.y, interval_mm.y));
        }
    }
    entry_mm = whole_mm.x;
    for (var i = 0u; i < OBJECTS; i++) {
        current = i;
        let line = line_of(ray);
        entries_in_voxel[i] = line.start + entry_mm * line.along;
        steps_in_voxel[i] = line.along * frame.step_mm;
        intervals[i] = (intervals[i] - entry_mm) / frame.step_mm;
    }
    current = 0u;
    let count = ceil((whole_mm.y - entry_mm) / frame.step_mm - first);
    let to_eye = -ray.direction;

    var state = composite_start();
    var k = 0.0;
    while k < count {
        let lattice_point = in_order(k, count) + first;
        let nobody = nobody_points(lattice_point);
        if nobody > 0.0 {
            k += nobody;
            continue;
        }
        // Each object has a value and a position of its own; `look` finds them.
        state = composite_add(state, Sample(0.0, lattice_point, vec3f(0.0), to_eye));
        if composite_done(state) {
            break;
        }
        k += 1.0;
    }
    return composite_finish(state);
}
