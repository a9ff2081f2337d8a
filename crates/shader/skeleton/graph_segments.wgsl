// What the graph of one object in segments calls. Before each call, `technique_of_run` is the technique that
// is meant.

struct SegmentHere {
    segment: u32,
    position: vec3f,
}

/// Functions of techniques that ask for their segment are meant for this one, until the next is entered. They
/// depend on the position that comes out, so none of them comes earlier.
fn enter_segment(position: vec3f) -> SegmentHere {
    segment_of_run = segment_at(position);
    return SegmentHere(segment_of_run, position);
}

/// None where nothing behind `runs` can be seen.
fn technique_of_new_run(segment: u32, runs: Runs) -> u32 {
    return select(technique_of_segment(segment), HIDDEN, is_complete(runs));
}

/// The importance of the places of a run, with one more.
fn with_place(by_place: f32, position: vec3f) -> f32 {
    return max(by_place, importance_of_place(position));
}

/// With the run of `segment`, if a technique drew it; `by_place` is the importance of its places.
fn with_closed_run(runs: Runs, state: CompositeState, by_place: f32, segment: u32, technique: u32) -> Runs {
    if technique == HIDDEN {
        return runs;
    }
    let here = vec2u(segment_of_run, technique_of_run);
    segment_of_run = segment;
    technique_of_run = technique;
    let closed = with_run(runs, composite_finish(state), segment, by_place);
    segment_of_run = here.x;
    technique_of_run = here.y;
    return closed;
}

fn is_run_done(state: CompositeState, technique: u32) -> bool {
    let here = technique_of_run;
    technique_of_run = technique;
    let is_done = composite_done(state);
    technique_of_run = here;
    return is_done;
}

fn is_technique(technique: u32, number: u32) -> bool {
    return technique == number + 1u;
}
