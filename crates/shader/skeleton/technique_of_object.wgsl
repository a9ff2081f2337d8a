fn technique() -> u32 {
    return object();
}
