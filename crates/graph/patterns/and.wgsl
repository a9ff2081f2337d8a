/// Whether both are true.
fn both(a: bool, b: bool) -> bool {
    return a && b;
}
