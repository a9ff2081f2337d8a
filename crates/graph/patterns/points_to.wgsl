/// How many lattice points lie on the way to an interval, at least one; 1e9 if it lies behind or is empty.
/// lattice_point: lattice_point
/// backwards: default false, the way is walked towards the eye
fn points_to(lattice_point: f32, interval: vec2f, backwards: bool) -> f32 {
    let way = select(interval.x - lattice_point, lattice_point - interval.y, backwards);
    return select(1e9, max(floor(way), 1.0), way >= 0.0 && interval.x < interval.y);
}
