/// Where a lattice point lies.
/// entry: position.voxel
/// lattice_point: lattice_point
/// result: position.voxel
fn position_on_ray(entry: vec3f, step: vec3f, lattice_point: f32) -> vec3f {
    return entry + lattice_point * step;
}
