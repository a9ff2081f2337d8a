/// A whole number as a number.
fn number_of_index(index: u32) -> f32 {
    return f32(index);
}
