// Values of a mask by place, as importance from 0 to 1.
struct ImportanceVolume {
    /// Rows of the map from the world to the cube from -0.5 to 0.5 that holds the mask.
    unit_from_world: array<vec4f, 3>,
    /// The numbers of the mask's texture that count as 0 and as 1.
    range: vec2f,
    mask: u32,
    /// 1 if there is such a volume.
    is_there: u32,
}

@group(0) @binding(2) var<uniform> importance_volume: ImportanceVolume;

fn importance_at(position: vec3f) -> f32 {
    let unit = rows_times(importance_volume.unit_from_world, vec4f(place_mm(position), 1.0));
    if importance_volume.is_there == 0u || any(abs(unit) > vec3f(0.5)) {
        return 0.0;
    }
    let range = importance_volume.range;
    let number = mask(importance_volume.mask, unit + 0.5);
    let share = (number - range.x) / (range.y - range.x);
    return select(0.0, clamp(share, 0.0, 1.0), is_finite(share));
}
