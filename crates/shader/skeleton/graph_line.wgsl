// The line of the one object, which nodes find and functions read.

fn kept_entry() -> vec3f {
    return entry_in_voxel;
}

fn kept_step() -> vec3f {
    return step_in_voxel;
}

fn keep_line(line: Line) {
    entry_in_voxel = line.start + entry_mm * line.along;
    step_in_voxel = line.along * frame.step_mm;
}
