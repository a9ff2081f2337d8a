/// Whether one is true.
fn either(a: bool, b: bool) -> bool {
    return a || b;
}
