// A ray caster as a person writes it who needs nothing else: emission and absorption, trilinear, a
// transfer table, central differences, Blinn–Phong under a light at the eye, empty bricks left out.

struct Object {
    voxel_from_world: array<vec4f, 3>,
    world_from_voxel: array<vec4f, 3>,
    dims: vec3u,
    volume: u32,
    bricks_first: vec3u,
    table_first: u32,
    pages_first: vec3u,
    table_entries: u32,
    table_domain: vec2f,
    slope: f32,
    intercept: f32,
    steps_per_reference: f32,
}

struct Frame {
    eye_mm: vec3f,
    step_mm: f32,
    right: vec3f,
    half_height: f32,
    up: vec3f,
    aspect: f32,
    forward: vec3f,
    is_perspective: u32,
    background: vec4f,
    size: vec2u,
    origin: vec2u,
    number: u32,
    object: Object,
}

struct Look {
    @align(16) radiance: vec3f,
    @align(16) diffuse: f32,
    specular: f32,
    shininess: f32,
    @align(16) ambient: f32,
    @align(16) stop_at_transmittance: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> settings: Look;
@group(0) @binding(3) var volume_sampler: sampler;
@group(0) @binding(4) var transfer: texture_2d<f32>;
@group(0) @binding(5) var bricks: texture_3d<u32>;
@group(0) @binding(16) var volume: texture_3d<f32>;

const BRICK: f32 = 8.0;

fn rows_times(rows: array<vec4f, 3>, p: vec4f) -> vec3f {
    return vec3f(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p));
}

fn value_at(position: vec3f) -> f32 {
    let place = (position + 0.5) / vec3f(frame.object.dims);
    return textureSampleLevel(volume, volume_sampler, place, 0.0).r * frame.object.slope + frame.object.intercept;
}

fn entry(index: u32) -> vec4f {
    return textureLoad(transfer, vec2u(index % 4096u, index / 4096u), 0);
}

fn classified(value: f32) -> vec4f {
    let last = f32(frame.object.table_entries - 1u);
    let domain = frame.object.table_domain;
    let place = clamp((value - domain.x) * (last / (domain.y - domain.x)), 0.0, last);
    let index = min(u32(place), frame.object.table_entries - 2u);
    return mix(entry(index), entry(index + 1u), place - f32(index));
}

fn steepness(position: vec3f) -> vec3f {
    let x = vec3f(1.0, 0.0, 0.0);
    let y = vec3f(0.0, 1.0, 0.0);
    let z = vec3f(0.0, 0.0, 1.0);
    let d = 0.5 * vec3f(
        value_at(position + x) - value_at(position - x),
        value_at(position + y) - value_at(position - y),
        value_at(position + z) - value_at(position - z),
    );
    let m = frame.object.voxel_from_world;
    return m[0].xyz * d.x + m[1].xyz * d.y + m[2].xyz * d.z;
}

fn lit(color: vec3f, position: vec3f, to_eye: vec3f) -> vec3f {
    let g = steepness(position);
    let size = length(g);
    if !(size > 0.0) {
        return color;
    }
    let normal = select(g, -g, dot(g, to_eye) < 0.0) / size;
    let to_light = to_eye;
    let cosine = dot(normal, to_light);
    if cosine <= 0.0 {
        return settings.ambient * color;
    }
    let shine = pow(max(dot(normal, normalize(to_light + to_eye)), 0.0), settings.shininess);
    let light = settings.radiance * (settings.diffuse * cosine * color + settings.specular * shine);
    return settings.ambient * color + light;
}

fn empty_points(position: vec3f, step: vec3f) -> f32 {
    let last = vec3f((max(frame.object.dims, vec3u(2u)) - 2u) / u32(BRICK));
    let brick = clamp(floor(position / BRICK), vec3f(0.0), last);
    if textureLoad(bricks, vec3u(brick), 0).r != 0u {
        return 0.0;
    }
    let low = select(brick * BRICK + 0.001, vec3f(-1e9), brick == vec3f(0.0));
    let high = select((brick + 1.0) * BRICK - 0.001, vec3f(1e9), brick == last);
    let face = select(low, high, step > vec3f(0.0));
    let way = select((face - position) / step, vec3f(1e9), abs(step) < vec3f(1e-12));
    return max(floor(min(way.x, min(way.y, way.z))), 0.0) + 1.0;
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let center = vec2f(vec2u(at.xy) + frame.origin) + 0.5;
    let across = (2.0 * center.x / f32(frame.size.x) - 1.0) * frame.aspect;
    let upward = 1.0 - 2.0 * center.y / f32(frame.size.y);
    let direction = normalize(frame.forward + (across * frame.right + upward * frame.up) * frame.half_height);
    let start = rows_times(frame.object.voxel_from_world, vec4f(frame.eye_mm, 1.0));
    let along = rows_times(frame.object.voxel_from_world, vec4f(direction, 0.0));
    let a = (vec3f(-0.5) - start) / along;
    let b = (vec3f(frame.object.dims) - 0.5 - start) / along;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    let leave = min(far.x, min(far.y, far.z));
    let count = ceil((leave - enter) / frame.step_mm - 0.5);
    let first = start + enter * along;
    let step = along * frame.step_mm;
    var color = vec3f(0.0);
    var alpha = 0.0;
    var k = 0.0;
    while k < count {
        let position = first + (k + 0.5) * step;
        let empty = empty_points(position, step);
        if empty > 0.0 {
            k += empty;
            continue;
        }
        let seen = classified(value_at(position));
        if seen.a > 0.0 {
            let opacity = 1.0 - pow(1.0 - seen.a, frame.object.steps_per_reference);
            let share = (1.0 - alpha) * opacity;
            color += share * lit(seen.rgb, position, -direction);
            alpha += share;
            if 1.0 - alpha < settings.stop_at_transmittance {
                break;
            }
        }
        k += 1.0;
    }
    return vec4f(color, alpha) + (1.0 - alpha) * frame.background;
}
