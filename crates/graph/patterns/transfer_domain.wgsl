/// The values at which the scene's transfer function begins and ends.
fn transfer_domain() -> Domain {
    let domain = table_domain();
    return Domain(domain.x, domain.y);
}

struct Domain {
    /// value
    low: f32,
    /// value
    high: f32,
}
