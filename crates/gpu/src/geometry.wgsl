// Opaque meshes, rasterized: their color under the lights, and how far along the pixel's ray they lie.

struct View {
    eye_mm: vec3f,
    /// Tangent of half the view angle, or half the height of the picture in mm.
    half_height: f32,
    right: vec3f,
    aspect: f32,
    up: vec3f,
    is_perspective: u32,
    forward: vec3f,
    /// Nothing nearer is drawn.
    near_mm: f32,
    size: vec2f,
    /// The pixel of the picture at the corner of the part.
    origin: vec2f,
    /// Nothing is farther.
    far_mm: f32,
    part: f32,
}

struct Mesh {
    world_from_mesh: array<vec4f, 3>,
    /// The inverse transpose of its linear part.
    normal_map: array<vec4f, 3>,
    color: vec4f,
}

/// Direction and 0, place and reach, or nothing and −1 for the eye; then the radiance.
struct Source {
    place: vec4f,
    radiance: vec4f,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> mesh: Mesh;
@group(0) @binding(2) var<uniform> sources: array<Source, SOURCES>;

const AMBIENT: f32 = 0.25;
const DIFFUSE: f32 = 0.75;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) place_mm: vec3f,
    @location(1) normal: vec3f,
}

struct Pixel {
    @location(0) color: vec4f,
    @location(1) distance_mm: f32,
}

fn rows_times(rows: array<vec4f, 3>, p: vec4f) -> vec3f {
    return vec3f(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p));
}

@vertex
fn vertex(@location(0) position: vec3f, @location(1) normal: vec3f) -> Corner {
    let place_mm = rows_times(mesh.world_from_mesh, vec4f(position, 1.0));
    let way = place_mm - view.eye_mm;
    let ahead = dot(way, view.forward);
    let x = dot(way, view.right) / (view.half_height * view.aspect);
    let y = dot(way, view.up) / view.half_height;
    var w = 1.0;
    // Reversed: 1 is near, where numbers are densest.
    var z = 1.0 - ahead / view.far_mm;
    if view.is_perspective == 1u {
        w = ahead;
        z = view.near_mm;
    }
    // From the picture to the part.
    let scale = view.size / view.part;
    let corner = (view.size - 2.0 * view.origin) / view.part;
    let clip = vec4f(x * scale.x + (corner.x - 1.0) * w, y * scale.y + (1.0 - corner.y) * w, z, w);
    return Corner(clip, place_mm, rows_times(mesh.normal_map, vec4f(normal, 0.0)));
}

@fragment
fn fragment(corner: Corner) -> Pixel {
    let way = corner.place_mm - view.eye_mm;
    var distance_mm = dot(way, view.forward);
    var ahead = view.forward;
    if view.is_perspective == 1u {
        distance_mm = length(way);
        ahead = way / distance_mm;
    }
    var normal = -ahead;
    let size = length(corner.normal);
    if size > 0.0 {
        normal = corner.normal / size;
    }
    if dot(normal, ahead) > 0.0 {
        normal = -normal;
    }
    var light = vec3f(AMBIENT);
    for (var i = 0u; i < SOURCES; i++) {
        let source = sources[i];
        var to_light = source.place.xyz;
        var fall = 1.0;
        if source.place.w < 0.0 {
            to_light = -ahead;
        } else if source.place.w > 0.0 {
            to_light = source.place.xyz - corner.place_mm;
            let away = max(length(to_light), 0.001 * source.place.w);
            to_light /= away;
            fall = (source.place.w / away) * (source.place.w / away);
        }
        light += source.radiance.rgb * (DIFFUSE * fall * max(dot(normal, to_light), 0.0));
    }
    return Pixel(vec4f(light * mesh.color.rgb, 1.0), distance_mm);
}
