/// sum / number.
/// result: value
fn mean(sum: f32, number: f32) -> f32 {
    return sum / number;
}
