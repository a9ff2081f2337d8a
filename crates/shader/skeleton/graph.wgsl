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

fn sampled_extent_mm(origin_mm: vec3f, direction: vec3f) -> vec2f {
    return extent_mm(line_of(Ray(origin_mm, direction)));
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
    let line = line_of(Ray(origin_mm, direction));
    entry_mm = entry_at_mm;
    keep_line(line);
    let count = ceil((interval_mm.y - entry_at_mm) / frame.step_mm - jitter);
    return LatticeOfRay(line.start + entry_at_mm * line.along, line.along * frame.step_mm, count);
}
