// What every ray loop has: the uniform block, the functions that modules may call, the entry points.
// `docs/plan.md` says what a renderer has to compute.

struct Object {
    /// Rows of affine maps.
    voxel_from_world: array<vec4f, 3>,
    world_from_voxel: array<vec4f, 3>,
    dims: vec3u,
    /// Which of the volumes it shows.
    volume: u32,
    /// Where its bricks begin in the texture of all objects' bricks.
    bricks_first: vec3u,
    /// The entry of the transfer texture at which its table begins; always at the start of a row.
    table_first: u32,
    /// Where its pages begin in the texture of all pages.
    pages_first: vec3u,
    table_entries: u32,
    table_domain: vec2f,
    /// value = slope · texel + intercept
    slope: f32,
    intercept: f32,
    /// The exponent of the opacity correction.
    steps_per_reference: f32,
}

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
    /// Linear, premultiplied.
    background: vec4f,
    size: vec2u,
    /// The pixel of the picture at the corner of the part that is drawn.
    origin: vec2u,
    /// Which of the pictures that are averaged this is.
    number: u32,
    /// Of slices: the number of the one that the first instance draws.
    first_slice: i32,
    /// Of what is drawn into, in pixels.
    viewport: vec2u,
    objects: array<Object, OBJECTS>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
/// Rows of `TABLE_ROW` entries.
@group(0) @binding(4) var transfer: texture_2d<f32>;
/// Per brick of `BRICK` voxels an edge, for all objects: 0 where nothing can be seen.
@group(0) @binding(5) var bricks: texture_3d<u32>;

const TABLE_ROW: u32 = 4096u;
const BRICK: f32 = 8.0;
/// 2⁻¹⁸: what rounding can make of a gradient, as a share of the values that it is made of.
const GRADIENT_ROUNDING: f32 = 3.814697265625e-6;
/// Farther than anything: where nothing was hit, and where no geometry is.
const NOWHERE_MM: f32 = 3.0e38;

// Of this ray: the pixel of the part that is drawn, the lattice's beginning, what was hit.
var<private> pixel_of_part: vec2u;
var<private> entry_mm: f32;
var<private> hit_mm: f32 = NOWHERE_MM;

// By bits: compilers may assume that no number is NaN.
fn is_finite(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7F800000u) != 0x7F800000u;
}

// What brings the square of a vector's length into the range of numbers.
fn scale_for_square(v: vec3f) -> f32 {
    let square = dot(v, v);
    return select(select(1.0, 1e20, square < 1e-30), 1e-20, square > 1e30);
}

fn direction(v: vec3f) -> vec3f {
    let scaled = v * scale_for_square(v);
    let square = dot(scaled, scaled);
    // By bits: above 0, and neither infinite nor NaN.
    let is_one = bitcast<u32>(square) - 1u < 0x7F7FFFFFu;
    return select(vec3f(0.0), scaled * inverseSqrt(square), is_one);
}

fn magnitude(v: vec3f) -> f32 {
    let scale = scale_for_square(v);
    let scaled = v * scale;
    let square = dot(scaled, scaled);
    return select(0.0, sqrt(square) / scale, is_finite(square));
}

fn rows_times(rows: array<vec4f, 3>, p: vec4f) -> vec3f {
    return vec3f(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p));
}

fn dims() -> vec3i {
    return vec3i(frame.objects[object()].dims);
}

fn place_mm(position: vec3f) -> vec3f {
    return rows_times(frame.objects[object()].world_from_voxel, vec4f(position, 1.0));
}

// How far in front of the eye, along the direction of view.
fn depth_mm(position: vec3f) -> f32 {
    return dot(place_mm(position) - frame.eye_mm, frame.forward);
}

fn voxel_of(place_mm: vec3f) -> vec3f {
    return rows_times(frame.objects[object()].voxel_from_world, vec4f(place_mm, 1.0));
}

fn step_mm() -> f32 {
    return frame.step_mm;
}

// Right, up, towards the eye.
fn in_camera(v: vec3f) -> vec3f {
    return vec3f(dot(v, frame.right), dot(v, frame.up), -dot(v, frame.forward));
}

fn table_domain() -> vec2f {
    return frame.objects[object()].table_domain;
}

fn gradient_per_mm(gradient_per_voxel: vec3f) -> vec3f {
    let m = frame.objects[object()].voxel_from_world;
    return m[0].xyz * gradient_per_voxel.x + m[1].xyz * gradient_per_voxel.y + m[2].xyz * gradient_per_voxel.z;
}

fn above_rounding(gradient_per_voxel: vec3f, largest: vec3f) -> vec3f {
    let size = abs(gradient_per_voxel);
    let steepest = max(size.x, max(size.y, size.z));
    let rounding = max(largest.x, max(largest.y, largest.z)) * GRADIENT_ROUNDING;
    return select(vec3f(0.0), gradient_per_voxel, steepest > rounding);
}

fn opacity_of_step(opacity: f32) -> f32 {
    return 1.0 - pow(1.0 - clamp(opacity, 0.0, 1.0), frame.objects[object()].steps_per_reference);
}

fn distance_mm(lattice_point: f32) -> f32 {
    return entry_mm + lattice_point * frame.step_mm;
}

fn report_hit(lattice_point: f32) {
    hit_mm = distance_mm(lattice_point);
}

fn table_entry(index: u32) -> vec4f {
    return textureLoad(transfer, vec2u(index % TABLE_ROW, index / TABLE_ROW), 0);
}

fn table(value: f32) -> Surface {
    let first = table_first();
    let entries = frame.objects[object()].table_entries;
    let domain = frame.objects[object()].table_domain;
    let last = f32(entries - 1u);
    let place = clamp((value - domain.x) * (last / (domain.y - domain.x)), 0.0, last);
    let index = min(u32(place), entries - 2u);
    // Not `mix`: between equal entries this is exactly that entry, so that constant opacities have no gradient.
    let low = table_entry(first + index);
    let entry = low + (place - f32(index)) * (table_entry(first + index + 1u) - low);
    // NaN has no place in the table; what is infinite is at one of its ends.
    let is_lost = is_nan(value);
    return Surface(select(entry.rgb, vec3f(0.0), is_lost), select(entry.a, 0.0, is_lost));
}

// A ray in the voxel space of an object: `along` is the way of one mm.
struct Line {
    start: vec3f,
    along: vec3f,
}

fn line_of(ray: Ray) -> Line {
    let rows = frame.objects[object()].voxel_from_world;
    return Line(rows_times(rows, vec4f(ray.origin_mm, 1.0)), rows_times(rows, vec4f(ray.direction, 0.0)));
}

// Where a ray is inside the sampled extent: half a voxel around the voxel centers.
fn extent_mm(line: Line) -> vec2f {
    let end = vec3f(dims()) - 0.5;
    let low = (vec3f(-0.5) - line.start) / line.along;
    let high = (end - line.start) / line.along;
    // Along an axis that the ray does not move on, it is inside or outside for good.
    let still = abs(line.along) < vec3f(1e-12);
    let is_outside = any(still & ((line.start < vec3f(-0.5)) | (line.start > end)));
    let enter = select(min(low, high), vec3f(-1e30), still);
    let leave = select(max(low, high), vec3f(1e30), still);
    let enter_mm = max(max(enter.x, enter.y), max(enter.z, 0.0));
    let leave_mm = min(leave.x, min(leave.y, leave.z));
    return vec2f(enter_mm, select(leave_mm, enter_mm - 1.0, is_outside));
}

// How many lattice points from `position` on, on the way of `step`, lie in a brick in which nothing
// can be seen.
fn empty_points(position: vec3f, step: vec3f) -> f32 {
    // Bricks hold cells, of which there is one less than voxels.
    let last = vec3f((max(frame.objects[object()].dims, vec3u(2u)) - 2u) / u32(BRICK));
    let brick = clamp(floor(position / BRICK), vec3f(0.0), last);
    if textureLoad(bricks, bricks_first() + vec3u(brick), 0).r != 0u {
        return 0.0;
    }
    // A margin on all faces makes up for rounding; the outermost bricks go on to the border.
    let low = select(brick * BRICK + 0.001, vec3f(-1e9), brick == vec3f(0.0));
    let high = select((brick + 1.0) * BRICK - 0.001, vec3f(1e9), brick == last);
    let face = select(low, high, step > vec3f(0.0));
    let way = select((face - position) / step, vec3f(1e9), abs(step) < vec3f(1e-12));
    return max(floor(min(way.x, min(way.y, way.z))), 0.0) + 1.0;
}

fn ray_of(pixel: vec2u) -> Ray {
    let center = vec2f(pixel) + 0.5;
    let across = (2.0 * center.x / f32(frame.size.x) - 1.0) * frame.aspect;
    let upward = 1.0 - 2.0 * center.y / f32(frame.size.y);
    let offset = (across * frame.right + upward * frame.up) * frame.half_height;
    if frame.is_perspective == 1u {
        return Ray(frame.eye_mm, normalize(frame.forward + offset));
    }
    return Ray(frame.eye_mm + offset, frame.forward);
}

// One triangle over the whole picture.
fn corner(index: u32) -> vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn pixel_at(at: vec4f) -> vec4f {
    pixel_of_part = vec2u(at.xy);
    let seen = march(pixel_of_part + frame.origin);
    return seen + (1.0 - seen.a) * behind();
}

struct PixelWithDepth {
    @location(0) color: vec4f,
    /// Distance of the reported hit from the ray's start, `NOWHERE_MM` without one.
    @location(1) hit_mm: f32,
}
