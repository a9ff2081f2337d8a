// The one ray loop. What it calls by the name of a slot is linked in; `docs/plan.md` says what a
// renderer has to compute.

struct Frame {
    eye_mm: vec3f,
    step_mm: f32,
    right: vec3f,
    /// Tangent of half the view angle, or half the height of the picture in mm.
    half_height: f32,
    up: vec3f,
    aspect: f32,
    forward: vec3f,
    is_perspective: u32,
    /// Rows of affine maps.
    voxel_from_world: array<vec4f, 3>,
    world_from_voxel: array<vec4f, 3>,
    /// Linear, premultiplied.
    background: vec4f,
    dims: vec3u,
    /// Which of the pictures that are averaged this is.
    number: u32,
    size: vec2u,
    /// The pixel of the picture at the corner of the part that is drawn.
    origin: vec2u,
    /// The exponent of the opacity correction.
    steps_per_reference: f32,
    /// Entries in the transfer table.
    table_entries: u32,
    table_domain: vec2f,
    /// value = slope · texel + intercept
    slope: f32,
    intercept: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(3) var volume_sampler: sampler;
/// Rows of `TABLE_ROW` entries.
@group(0) @binding(4) var transfer: texture_2d<f32>;
/// Per brick of `BRICK` voxels an edge: 0 where nothing can be seen.
@group(0) @binding(5) var bricks: texture_3d<u32>;

const TABLE_ROW: u32 = 4096u;
const BRICK: f32 = 8.0;

// What functions may ask about the ray.
var<private> entry_in_voxel: vec3f;
var<private> step_in_voxel: vec3f;

fn row_of(rows: array<vec4f, 3>, p: vec4f) -> vec3f {
    return vec3f(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p));
}

fn dims() -> vec3i {
    return vec3i(frame.dims);
}

fn place_mm(position: vec3f) -> vec3f {
    return row_of(frame.world_from_voxel, vec4f(position, 1.0));
}

fn gradient_per_mm(gradient_per_voxel: vec3f) -> vec3f {
    let m = frame.voxel_from_world;
    return m[0].xyz * gradient_per_voxel.x + m[1].xyz * gradient_per_voxel.y + m[2].xyz * gradient_per_voxel.z;
}

fn opacity_of_step(opacity: f32) -> f32 {
    if frame.steps_per_reference == 1.0 {
        return opacity;
    }
    return 1.0 - pow(1.0 - opacity, frame.steps_per_reference);
}

fn ray_position(lattice_point: f32) -> vec3f {
    return entry_in_voxel + lattice_point * step_in_voxel;
}

fn table_entry(index: u32) -> vec4f {
    return textureLoad(transfer, vec2u(index % TABLE_ROW, index / TABLE_ROW), 0);
}

fn table(value: f32) -> Surface {
    let last = f32(frame.table_entries - 1u);
    let width = frame.table_domain.y - frame.table_domain.x;
    let place = (value - frame.table_domain.x) * (last / width);
    if !(abs(place) <= 3.4e38) && value != value {
        return Surface(vec3f(0.0), 0.0);
    }
    let clamped = clamp(place, 0.0, last);
    let index = min(u32(clamped), frame.table_entries - 2u);
    let entry = mix(table_entry(index), table_entry(index + 1u), clamped - f32(index));
    return Surface(entry.rgb, entry.a);
}

// How many lattice points from `position` on lie in a brick in which nothing can be seen.
fn empty_points(position: vec3f) -> f32 {
    let last = vec3f(textureDimensions(bricks) - 1u);
    let brick = clamp(floor(position / BRICK), vec3f(0.0), last);
    if textureLoad(bricks, vec3i(brick), 0).r != 0u {
        return 0.0;
    }
    // A margin on all faces makes up for rounding; the outermost bricks go on to the border.
    let low = select(brick * BRICK + 0.001, vec3f(-1e9), brick == vec3f(0.0));
    let high = select((brick + 1.0) * BRICK - 0.001, vec3f(1e9), brick == last);
    let face = select(low, high, step_in_voxel > vec3f(0.0));
    let way = select((face - position) / step_in_voxel, vec3f(1e9), abs(step_in_voxel) < vec3f(1e-12));
    return max(floor(min(way.x, min(way.y, way.z))), 0.0) + 1.0;
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle over the whole picture.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(at.xy) + frame.origin;
    let centre = vec2f(pixel) + 0.5;
    let across = (2.0 * centre.x / f32(frame.size.x) - 1.0) * frame.aspect;
    let upward = 1.0 - 2.0 * centre.y / f32(frame.size.y);
    let offset = (across * frame.right + upward * frame.up) * frame.half_height;
    var ray: Ray;
    if frame.is_perspective == 1u {
        ray = Ray(frame.eye_mm, normalize(frame.forward + offset));
    } else {
        ray = Ray(frame.eye_mm + offset, frame.forward);
    }

    // The sampled extent: half a voxel around the voxel centres.
    let start = row_of(frame.voxel_from_world, vec4f(ray.origin_mm, 1.0));
    let along = row_of(frame.voxel_from_world, vec4f(ray.direction, 0.0));
    let low = (vec3f(-0.5) - start) / along;
    let high = (vec3f(frame.dims) - 0.5 - start) / along;
    // Along an axis that the ray does not move on, it is inside or outside for good.
    let still = abs(along) < vec3f(1e-12);
    let is_outside = any(still & ((start < vec3f(-0.5)) | (start > vec3f(frame.dims) - 0.5)));
    let enter = select(min(low, high), vec3f(-1e30), still);
    let leave = select(max(low, high), vec3f(1e30), still);
    var interval_mm = vec2f(
        max(max(enter.x, enter.y), max(enter.z, 0.0)),
        min(leave.x, min(leave.y, leave.z)),
    );
    if is_outside {
        interval_mm.y = interval_mm.x - 1.0;
    }
    interval_mm = clip_ray(ray, interval_mm);
    let first = jitter(pixel, frame.number);
    let count = ceil((interval_mm.y - interval_mm.x) / frame.step_mm - first);
    entry_in_voxel = start + interval_mm.x * along;
    step_in_voxel = along * frame.step_mm;
    let to_eye = -ray.direction;

    var state = composite_start();
    var k = 0.0;
    while k < count {
        let position = ray_position(k + first);
        let empty = empty_points(position);
        if empty > 0.0 {
            k += empty;
            continue;
        }
        if !clip_sample(place_mm(position)) {
            let sample = Sample(reconstruct(position), k + first, position, to_eye);
            state = composite_add(state, sample);
            if composite_done(state) {
                break;
            }
        }
        k += 1.0;
    }
    let seen = composite_finish(state);
    return seen + (1.0 - seen.a) * frame.background;
}
