// What the graph of several objects calls. Before each call, `current` is the object that is meant.

var<private> current: u32 = 0u;
var<private> entries_in_voxel: array<vec3f, OBJECTS>;
var<private> steps_in_voxel: array<vec3f, OBJECTS>;

fn object() -> u32 {
    return current;
}

fn table_first() -> u32 {
    return frame.objects[current].table_first;
}

fn bricks_first() -> vec3u {
    return frame.objects[current].bricks_first;
}

fn ray_position(lattice_point: f32) -> vec3f {
    return entries_in_voxel[current] + lattice_point * steps_in_voxel[current];
}

fn kept_entry() -> vec3f {
    return entries_in_voxel[current];
}

fn kept_step() -> vec3f {
    return steps_in_voxel[current];
}

fn keep_line(line: Line) {
    entries_in_voxel[current] = line.start + entry_mm * line.along;
    steps_in_voxel[current] = line.along * frame.step_mm;
}
