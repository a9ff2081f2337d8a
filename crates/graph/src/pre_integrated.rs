//! Pre-integrated transfer functions: color and opacity of one step from the values at its ends.

use strahl_program::Table2d;
use strahl_scene::transfer::TransferTable;

/// Columns and rows of the largest table.
pub const MOST_EDGE: u32 = 4096;

/// The table of the pattern `pre_integrated` over `edge` × `edge` values from the transfer function's first to
/// its last: front value across, back value down; color multiplied by opacity, opacity of a step of `step_mm`.
///
/// K. Engel, M. Kraus, T. Ertl, High-Quality Pre-Integrated Volume Rendering (2001), by integral functions, which
/// leave out that a step darkens itself (their equation 8): with τ = −ln(1 − α)/d₀, and T, K the integrals of τ and
/// τ·c over values, opacity is 1 − exp(−d·ΔT/Δv) and color d·ΔK/Δv. Where a step darkens itself much, that color
/// would be brighter than anything in it; here it is the mean color ΔK/ΔT times the opacity, which is the same as
/// long as steps are thin. Integrals of the linear pieces are taken by Simpson's rule over sixteen parts.
pub fn pre_integrated(table: &TransferTable, step_mm: f64, edge: u32) -> Table2d {
    let edge = edge.clamp(2, MOST_EDGE);
    let [low, high] = table.domain().map(f64::from);
    let value = |i: f64| low + (high - low) * i / f64::from(edge - 1);
    // Absorption per mm and what it gives off, at a value.
    let at = |value: f64| -> [f64; 4] {
        let [r, g, b, opacity] = table.at(value as f32).map(f64::from);
        // What is solid is as solid as a step can show.
        let tau = -(1.0 - opacity.min(1.0 - 1e-9)).ln() / f64::from(table.reference_mm());
        [tau * r, tau * g, tau * b, tau]
    };
    const PARTS: usize = 16;
    // Integrals from the first value up to each, in steps of columns.
    let mut integrals = vec![[0.0; 4]];
    for i in 1..edge {
        let mut sum = integrals[i as usize - 1];
        for part in 0..PARTS {
            let place = |share: f64| f64::from(i - 1) + (part as f64 + share) / PARTS as f64;
            let (a, m, b) = (
                at(value(place(0.0))),
                at(value(place(0.5))),
                at(value(place(1.0))),
            );
            for c in 0..4 {
                sum[c] += (a[c] + 4.0 * m[c] + b[c]) / (6.0 * PARTS as f64);
            }
        }
        integrals.push(sum);
    }
    let mut texels = Vec::with_capacity((edge * edge) as usize);
    for back in 0..edge {
        for front in 0..edge {
            let mean: [f64; 4] = if front == back {
                at(value(f64::from(front)))
            } else {
                let steps = f64::from(back) - f64::from(front);
                std::array::from_fn(|c| {
                    (integrals[back as usize][c] - integrals[front as usize][c]) / steps
                })
            };
            let opacity = 1.0 - (-step_mm * mean[3]).exp();
            let share = if mean[3] > 0.0 {
                opacity / mean[3]
            } else {
                0.0
            };
            texels.push(
                [mean[0] * share, mean[1] * share, mean[2] * share, opacity].map(|v| v as f32),
            );
        }
    }
    Table2d {
        width: edge,
        height: edge,
        texels,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp: τ and color by hand, against sums over ten thousand parts.
    #[test]
    fn entries_are_integrals() {
        let entries = vec![
            [1.0, 0.0, 0.2, 0.0],
            [0.0, 1.0, 0.2, 0.8],
            [0.3, 0.3, 0.3, 0.1],
        ];
        let table = TransferTable::new([-100.0, 300.0], 2.0, entries);
        let made = pre_integrated(&table, 0.7, 33);
        for (front, back) in [(0u32, 32u32), (5, 6), (20, 3), (9, 9), (32, 31)] {
            let value = |i: f64| (-100.0 + 400.0 * i / 32.0) as f32;
            let n = 10_000;
            let (mut tau, mut color) = (0.0, [0.0; 3]);
            for k in 0..n {
                let share = (f64::from(k) + 0.5) / f64::from(n);
                let at = table.at(value(
                    f64::from(front) + share * (f64::from(back) - f64::from(front)),
                ));
                let t = -(1.0 - f64::from(at[3])).ln() / 2.0 / f64::from(n);
                tau += t;
                for c in 0..3 {
                    color[c] += t * f64::from(at[c]);
                }
            }
            let opacity = 1.0 - (-0.7 * tau).exp();
            let texel = made.texels[(back * 33 + front) as usize];
            assert!(
                (f64::from(texel[3]) - opacity).abs() < 1e-5,
                "{front} {back}: {texel:?}"
            );
            for c in 0..3 {
                let wanted = if tau > 0.0 {
                    color[c] / tau * opacity
                } else {
                    0.0
                };
                assert!(
                    (f64::from(texel[c]) - wanted).abs() < 1e-4,
                    "{front} {back}: {texel:?} {wanted}"
                );
            }
        }
    }

    /// Twice the step passes the square of what one passes.
    #[test]
    fn opacity_knows_the_step() {
        let table = TransferTable::new([0.0, 1.0], 1.0, vec![[1.0; 4], [1.0, 1.0, 1.0, 0.5]]);
        let (one, two) = (
            pre_integrated(&table, 0.5, 9),
            pre_integrated(&table, 1.0, 9),
        );
        for (a, b) in one.texels.iter().zip(&two.texels) {
            assert!((((1.0 - a[3]).powi(2)) - (1.0 - b[3])).abs() < 1e-6);
        }
    }
}
