// All objects at this place, none before another: what passes is the product of what passes each,
// and each gives its color by its opacity.
fn look(sample: Sample) -> Surface {
    var passing = 1.0;
    var color = vec3f(0.0);
    var sum = 0.0;
    for (var i = 0u; i < OBJECTS; i++) {
        if (present & (1u << i)) == 0u {
            continue;
        }
        current = i;
        let position = ray_position(sample.lattice_point);
        if clip_sample(place_mm(position)) {
            continue;
        }
        let value = reconstruct(position);
        if !is_value(value) {
            continue;
        }
        let surface = classify(value, position);
        if !(surface.opacity > 0.0) {
            continue;
        }
        let seen = shade(surface, position, sample.to_eye);
        let opacity = opacity_of_step(seen.opacity);
        passing *= 1.0 - opacity;
        color += opacity * illustrate(seen.color, position, sample.to_eye);
        sum += opacity;
    }
    current = 0u;
    if !(sum > 0.0) {
        return Surface(vec3f(0.0), 0.0);
    }
    return Surface(color / sum, 1.0 - passing);
}
