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
