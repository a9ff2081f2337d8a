fn look(sample: Sample) -> Surface {
    let surface = classify(sample.value, sample.position);
    var seen = Surface(vec3f(0.0), 0.0);
    if surface.opacity > 0.0 {
        seen = shade(surface, sample.position, sample.to_eye);
        seen.color = illustrate(seen.color, sample.position, sample.to_eye);
        seen.opacity = opacity_of_step(seen.opacity);
    }
    return seen;
}
