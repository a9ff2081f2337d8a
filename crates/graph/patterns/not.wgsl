/// Whether it is false.
fn negated(a: bool) -> bool {
    return !a;
}
