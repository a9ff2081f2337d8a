/// Whether two whole numbers differ.
fn differs(a: u32, b: u32) -> bool {
    return a != b;
}
