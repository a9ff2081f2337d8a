// What the graph of one object calls.

var<private> entry_in_voxel: vec3f;
var<private> step_in_voxel: vec3f;

fn object() -> u32 {
    return 0u;
}

// The table and the bricks of the only object begin at 0.
fn table_first() -> u32 {
    return 0u;
}

fn bricks_first() -> vec3u {
    return vec3u(0u);
}

fn ray_position(lattice_point: f32) -> vec3f {
    return entry_in_voxel + lattice_point * step_in_voxel;
}

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
