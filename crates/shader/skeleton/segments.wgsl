// The loop over one object in segments: samples of one segment in a row are a run, which its technique
// makes into one sample; runs add up front to back.

@group(0) @binding(14) var labels: texture_3d<u32>;
/// Rows of `TABLE_ROW` entries.
@group(0) @binding(15) var segments: texture_2d<u32>;

const HIDDEN: u32 = 0u;
const NO_SEGMENT: u32 = 0xFFFFFFFFu;
/// In voxels: what rounding may move a place beyond the extent.
const ROUNDING: f32 = 0.01;

var<private> entry_in_voxel: vec3f;
var<private> step_in_voxel: vec3f;
/// Of the run: `HIDDEN` as well where nothing of it is left to be added.
var<private> technique_of_run: u32 = HIDDEN;

fn technique() -> u32 {
    return technique_of_run;
}

fn object() -> u32 {
    return 0u;
}

fn table_first() -> u32 {
    return u32(technique_numbers(0u).x);
}

fn bricks_first() -> vec3u {
    return vec3u(0u);
}

fn ray_position(lattice_point: f32) -> vec3f {
    return entry_in_voxel + lattice_point * step_in_voxel;
}

// The first texels of the tables say where the label volume lies.
fn segment_at(position: vec3f) -> u32 {
    let p = vec4f(position, 1.0);
    let place = vec3f(dot(table_entry(0u), p), dot(table_entry(1u), p), dot(table_entry(2u), p));
    let end = vec3f(textureDimensions(labels)) - 0.5;
    if any(place < vec3f(-0.5 - ROUNDING)) || any(place > end + ROUNDING) {
        return u32(table_entry(3u).x);
    }
    let voxel = clamp(vec3i(floor(place + 0.5)), vec3i(0), vec3i(end));
    return textureLoad(labels, voxel, 0).r;
}

fn technique_of_segment(segment: u32) -> u32 {
    return textureLoad(segments, vec2u(segment % TABLE_ROW, segment / TABLE_ROW), 0).r;
}

fn with_run(seen: vec4f, run: vec4f) -> vec4f {
    return seen + (1.0 - seen.a) * run;
}

fn is_opaque(seen: vec4f) -> bool {
    let passing = 1.0 - seen.a;
    return passing < table_entry(3u).y || passing <= 0.0;
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

    var seen = vec4f(0.0);
    var segment_of_run = NO_SEGMENT;
    var state = composite_start();
    for (var k = 0.0; k < count; k += 1.0) {
        let lattice_point = in_order(k, count) + first;
        let position = ray_position(lattice_point);
        let segment = segment_at(position);
        if segment != segment_of_run {
            if technique_of_run != HIDDEN {
                seen = with_run(seen, composite_finish(state));
            }
            segment_of_run = segment;
            technique_of_run = technique_of_segment(segment);
            if is_opaque(seen) {
                technique_of_run = HIDDEN;
                break;
            }
            state = composite_start();
        }
        if technique_of_run == HIDDEN || clip_sample(place_mm(position)) {
            continue;
        }
        let value = reconstruct(position);
        // A sample without a value counts for no composite.
        if !is_value(value) {
            continue;
        }
        state = composite_add(state, Sample(value, lattice_point, position, to_eye));
        if composite_done(state) {
            seen = with_run(seen, composite_finish(state));
            technique_of_run = HIDDEN;
            if is_opaque(seen) {
                break;
            }
        }
    }
    if technique_of_run != HIDDEN {
        seen = with_run(seen, composite_finish(state));
    }
    return seen;
}
