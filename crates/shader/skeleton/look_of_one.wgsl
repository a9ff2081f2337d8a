fn look(sample: Sample) -> Surface {
    let surface = classify(sample.value, sample.position);
    if !(surface.opacity > 0.0) {
        return Surface(vec3f(0.0), 0.0);
    }
    let seen = shade(surface, sample.position, sample.to_eye);
    return Surface(seen.color, opacity_of_step(seen.opacity));
}
