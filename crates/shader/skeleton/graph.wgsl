// Where the nodes of a graph begin: the ray of a pixel, and its lattice in an object.

struct RayOfPixel {
    pixel: vec2u,
    /// Which of the pictures that are averaged.
    frame: u32,
    origin_mm: vec3f,
    direction: vec3f,
    to_eye: vec3f,
}

fn ray_of_pixel(pixel: vec2u) -> RayOfPixel {
    let ray = ray_of(pixel);
    return RayOfPixel(pixel, frame.number, ray.origin_mm, ray.direction, -ray.direction);
}

fn line_of_ray(origin_mm: vec3f, direction: vec3f) -> Line {
    return line_of(Ray(origin_mm, direction));
}

fn sampled_extent_mm(origin_mm: vec3f, direction: vec3f) -> vec2f {
    return extent_mm(line_of_ray(origin_mm, direction));
}

fn clipped_ray_mm(origin_mm: vec3f, direction: vec3f, interval_mm: vec2f) -> vec2f {
    return clip_ray(Ray(origin_mm, direction), interval_mm);
}

struct LatticeOfRay {
    /// Voxel space: where lattice coordinate 0 lies, and the way from one point to the next.
    entry: vec3f,
    step: vec3f,
    /// Lattice points.
    count: f32,
}

/// The lattice begins at `entry_at_mm`, and ends before `interval_mm.y`.
fn lattice_of_ray(origin_mm: vec3f, direction: vec3f, interval_mm: vec2f, entry_at_mm: f32, jitter: f32) -> LatticeOfRay {
    return lattice_of_line(line_of_ray(origin_mm, direction), interval_mm, entry_at_mm, jitter);
}

fn lattice_of_line(line: Line, interval_mm: vec2f, entry_at_mm: f32, jitter: f32) -> LatticeOfRay {
    entry_mm = entry_at_mm;
    keep_line(line);
    let count = ceil((interval_mm.y - entry_at_mm) / frame.step_mm - jitter);
    return LatticeOfRay(kept_entry(), kept_step(), count);
}

// Of a slice: how far it lies in front of the eye along the view axis. Where no slices are drawn it stays 0.
var<private> slice_mm: f32 = 0.0;

struct SliceOfPixel {
    pixel: vec2u,
    /// The point of the slice that the pixel sees.
    place_mm: vec3f,
    /// Along the pixel's ray, from its start.
    distance_mm: f32,
    /// Along the ray, to the next slice.
    length_mm: f32,
    /// The point in voxel space.
    position: vec3f,
    /// Whether it lies in the sampled extent of the object.
    is_inside: bool,
    origin_mm: vec3f,
    direction: vec3f,
    to_eye: vec3f,
}

fn slice_of_pixel(pixel: vec2u) -> SliceOfPixel {
    let ray = ray_of(pixel);
    // Rays of an orthographic picture go along the view axis; others go a longer way.
    let way = 1.0 / dot(ray.direction, frame.forward);
    let distance_mm = slice_mm * way;
    let line = line_of(ray);
    let inside_mm = extent_mm(line);
    let is_inside = distance_mm >= inside_mm.x && distance_mm < inside_mm.y;
    return SliceOfPixel(
        pixel,
        ray.origin_mm + distance_mm * ray.direction,
        distance_mm,
        frame.step_mm * way,
        line.start + distance_mm * line.along,
        is_inside,
        ray.origin_mm,
        ray.direction,
        -ray.direction,
    );
}

fn slice_distance_mm() -> f32 {
    return slice_mm;
}

struct CornerOfPicture {
    /// From the upper left end of the picture, in its width and height. Corners lie outside.
    picture: vec2f,
    place_mm: vec3f,
    /// Not normalized: one mm along the view axis.
    along: vec3f,
}

fn corner_of_picture(index: u32) -> CornerOfPicture {
    let place = corner(index).xy;
    let pixel = vec2f(frame.origin) + (0.5 + vec2f(0.5, -0.5) * place) * vec2f(frame.viewport);
    let picture = pixel / vec2f(frame.size);
    let across = (2.0 * picture.x - 1.0) * frame.aspect;
    let upward = 1.0 - 2.0 * picture.y;
    let offset = (across * frame.right + upward * frame.up) * frame.half_height;
    if frame.is_perspective == 1u {
        let along = frame.forward + offset;
        return CornerOfPicture(picture, frame.eye_mm + slice_mm * along, along);
    }
    return CornerOfPicture(picture, frame.eye_mm + offset + slice_mm * frame.forward, frame.forward);
}
