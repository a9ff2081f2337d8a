/// Whether `a` is at least `b`.
fn reaches(a: f32, b: f32) -> bool {
    return a >= b;
}
