// The loop over one object in segments.

fn march(pixel: vec2u) -> vec4f {
    let ray = ray_of(pixel);
    let line = line_of(ray);
    let interval_mm = clip_ray(ray, extent_mm(line));
    let first = jitter(pixel, frame.number);
    let count = ceil((interval_mm.y - interval_mm.x) / frame.step_mm - first);
    entry_mm = interval_mm.x;
    entry_in_voxel = line.start + interval_mm.x * line.along;
    step_in_voxel = line.along * frame.step_mm;
    let to_eye = -ray.direction;

    var runs = no_runs();
    segment_of_run = NO_SEGMENT;
    var by_place = 0.0;
    var state = composite_start();
    for (var k = 0.0; k < count; k += 1.0) {
        let lattice_point = in_order(k, count) + first;
        let position = ray_position(lattice_point);
        let segment = segment_at(position);
        if segment != segment_of_run {
            if technique_of_run != HIDDEN {
                runs = with_run(runs, composite_finish(state), segment_of_run, by_place);
            }
            segment_of_run = segment;
            technique_of_run = technique_of_segment(segment);
            runs = entered(runs, segment);
            if is_complete(runs) {
                technique_of_run = HIDDEN;
                break;
            }
            state = composite_start();
            alpha_before = opacity_before(runs);
            by_place = 0.0;
        }
        if technique_of_run == HIDDEN || clip_sample(place_mm(position)) {
            continue;
        }
        let value = reconstruct(position);
        // A sample without a value counts for no composite.
        if !is_value(value) {
            continue;
        }
        let before_mm = hit_mm;
        state = composite_add(state, Sample(value, lattice_point, position, to_eye));
        keep_first_hit(before_mm);
        by_place = max(by_place, importance_of_place(position));
        if composite_done(state) {
            runs = with_run(runs, composite_finish(state), segment_of_run, by_place);
            technique_of_run = HIDDEN;
            if is_complete(runs) {
                break;
            }
        }
    }
    if technique_of_run != HIDDEN {
        runs = with_run(runs, composite_finish(state), segment_of_run, by_place);
    }
    return pixel_of(runs);
}
