fn is_value(value: f32) -> bool {
    return is_finite(value);
}

// By bits, as `is_finite`.
fn is_nan(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7FFFFFFFu) > 0x7F800000u;
}
