/// A hash of column, row and seed in [0, 1), the same on every machine:
/// h = x·0x9E3779B1 ⊕ y·0x85EBCA77 ⊕ seed·0xC2B2AE3D, mixed by C. Wellons' `lowbias32`; the upper
/// 24 bits are the fraction, so that f32 holds it exactly.
pub fn jitter(x: u32, y: u32, seed: u32) -> f32 {
    let mut h =
        x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7FEB_352D);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846C_A68B);
    h ^= h >> 16;
    (h >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    #[test]
    fn spreads_evenly_and_follows_the_seed() {
        let mean = |seed| {
            (0..64 * 64)
                .map(|i| super::jitter(i % 64, i / 64, seed))
                .inspect(|j| assert!((0.0..1.0).contains(j)))
                .sum::<f32>()
                / 4096.0
        };
        for seed in 0..8 {
            assert!(
                (mean(seed) - 0.5).abs() < 0.02,
                "seed {seed}: {}",
                mean(seed)
            );
        }
        assert_ne!(super::jitter(3, 4, 1), super::jitter(3, 4, 2));
    }
}
