//! Linear light → the numbers of a picture file: exposure, tone map, sRGB.

use strahl_scene::plan::{Display, ToneMap};

/// Relative luminance of linear sRGB, ITU-R BT.709.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A pixel as PNG wants it: sRGB-encoded colour that is not multiplied by alpha, and alpha, all in
/// 0..=1.
///
/// The steps are, in this order: divide by alpha, multiply by the exposure, tone map, encode. The
/// division comes first so that the colour of a half-transparent pixel is the one that the same
/// material has where it is opaque. What is not finite becomes 0.
pub(super) fn display_pixel([r, g, b, a]: [f32; 4], display: &Display) -> [f32; 4] {
    let alpha = if a.is_finite() {
        a.clamp(0.0, 1.0)
    } else {
        0.0
    };
    if alpha == 0.0 {
        return [0.0; 4];
    }
    let light = [r, g, b].map(|c| {
        let c = c / alpha * display.exposure;
        if c.is_finite() { c.max(0.0) } else { 0.0 }
    });
    let [r, g, b] = tone_map(light, display.tone_map).map(srgb_from_linear);
    [r, g, b, alpha]
}

fn tone_map(light: [f32; 3], tone_map: ToneMap) -> [f32; 3] {
    match tone_map {
        ToneMap::Clamp => light,
        ToneMap::Reinhard => {
            let luminance: f32 = (0..3).map(|c| light[c] * LUMINANCE[c]).sum();
            light.map(|c| c / (1.0 + luminance))
        }
    }
}

/// The transfer function of IEC 61966-2-1; what is outside 0..=1 is clamped.
pub(super) fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Display = Display {
        exposure: 1.0,
        tone_map: ToneMap::Clamp,
    };

    #[test]
    fn known_values_of_srgb() {
        // Values of IEC 61966-2-1 as published in many tables, in 8-bit steps.
        for (linear, encoded) in [
            (0.0, 0.0),
            (0.0031308, 0.04045),
            (0.0021269, 0.02748),
            (0.18, 0.46135),
            (0.21404, 0.5),
            (0.5, 0.73536),
            (1.0, 1.0),
        ] {
            let found = srgb_from_linear(linear);
            assert!(
                (found - encoded).abs() < 2e-5,
                "{linear}: {found}, not {encoded}"
            );
        }
        assert_eq!(srgb_from_linear(7.0), srgb_from_linear(1.0));
        assert_eq!(srgb_from_linear(-1.0), 0.0);
    }

    #[test]
    fn colour_does_not_depend_on_alpha() {
        let opaque = display_pixel([0.5, 0.25, 0.125, 1.0], &PLAIN);
        let thin = display_pixel([0.05, 0.025, 0.0125, 0.1], &PLAIN);
        for c in 0..3 {
            assert!((opaque[c] - thin[c]).abs() < 1e-6);
        }
        assert_eq!(thin[3], 0.1);
    }

    #[test]
    fn exposure_comes_before_the_tone_map() {
        let display = Display {
            exposure: 2.0,
            tone_map: ToneMap::Reinhard,
        };
        // Grey 0.5 · 2 = 1, and 1 / (1 + 1) = 0.5.
        let pixel = display_pixel([0.5, 0.5, 0.5, 1.0], &display);
        assert!((pixel[0] - 0.735_36).abs() < 2e-5, "{pixel:?}");
        let bright = display_pixel([500.0, 500.0, 500.0, 1.0], &display);
        assert!(bright[0] < 1.0 && bright[0] > 0.99);
    }

    #[test]
    fn numbers_that_are_none_become_black() {
        assert_eq!(
            display_pixel([f32::NAN, f32::INFINITY, -1.0, 1.0], &PLAIN),
            [0.0, 0.0, 0.0, 1.0]
        );
        assert_eq!(display_pixel([0.5, 0.5, 0.5, f32::NAN], &PLAIN), [0.0; 4]);
        assert_eq!(display_pixel([0.5, 0.5, 0.5, 0.0], &PLAIN), [0.0; 4]);
    }
}
