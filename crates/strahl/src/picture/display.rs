//! Linear light → the numbers of a picture file: exposure, tone map, sRGB or a power.

use strahl_scene::linear_from_srgb;
use strahl_scene::plan::{Display, DisplayCurve, ToneMap};

/// Relative luminance of linear sRGB, ITU-R BT.709.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A pixel as PNG wants it: encoded color that is not multiplied by alpha, and alpha, all in
/// 0..=1.
///
/// The steps are, in this order: divide by alpha, multiply by the exposure, tone map, encode, invert. The
/// division comes first so that the color of a half-transparent pixel is the one that the same
/// material has where it is opaque. What is not finite becomes 0. A background of the display comes behind the tone
/// map, in the light that is encoded, so that it has its own color.
pub(super) fn display_pixel(pixel: [f32; 4], display: &Display) -> [f32; 4] {
    let [r, g, b, a] = positive(pixel, display);
    match display.invert && a > 0.0 {
        true => [1.0 - r, 1.0 - g, 1.0 - b, a],
        false => [r, g, b, a],
    }
}

/// The same before it becomes its negative.
fn positive([r, g, b, a]: [f32; 4], display: &Display) -> [f32; 4] {
    let alpha = if a.is_finite() {
        a.clamp(0.0, 1.0)
    } else {
        0.0
    };
    if alpha == 0.0 {
        return match display.background {
            None => [0.0; 4],
            Some(behind) => {
                let [r, g, b] = behind.map(srgb_from_linear);
                [r, g, b, 1.0]
            }
        };
    }
    let light = [r, g, b].map(|c| {
        let c = c / alpha * display.exposure;
        if c.is_finite() { c.max(0.0) } else { 0.0 }
    });
    let light = tone_map(light, display.tone_map);
    let [r, g, b] = match display.background {
        None => light.map(|light| encoded(light, display.curve)),
        Some(behind) => std::array::from_fn(|c| {
            // The light that the curve makes the background's color of.
            let behind = decoded(srgb_from_linear(behind[c]), display.curve);
            encoded(
                alpha * light[c].min(1.0) + (1.0 - alpha) * behind,
                display.curve,
            )
        }),
    };
    [r, g, b, display.background.map_or(alpha, |_| 1.0)]
}

fn encoded(light: f32, curve: DisplayCurve) -> f32 {
    match curve {
        DisplayCurve::Srgb => srgb_from_linear(light),
        DisplayCurve::Power { gamma } => light.clamp(0.0, 1.0).powf(1.0 / gamma),
    }
}

fn decoded(encoded: f32, curve: DisplayCurve) -> f32 {
    match curve {
        DisplayCurve::Srgb => linear_from_srgb(f64::from(encoded)) as f32,
        DisplayCurve::Power { gamma } => encoded.powf(gamma),
    }
}

/// Light beyond this is as bright as this, so that no square overflows.
const BRIGHTEST: f32 = 1e6;

fn tone_map(light: [f32; 3], tone_map: ToneMap) -> [f32; 3] {
    let luminance = || -> f32 {
        let luminance: f32 = (0..3).map(|c| light[c] * LUMINANCE[c]).sum();
        luminance.min(BRIGHTEST)
    };
    match tone_map {
        ToneMap::Clamp => light,
        // E. Reinhard et al., Photographic tone reproduction for digital images, 2002, equations 3 and 4.
        ToneMap::Reinhard => {
            let factor = 1.0 / (1.0 + luminance());
            light.map(|c| c * factor)
        }
        ToneMap::ReinhardExtended { white } => {
            let luminance = luminance();
            let factor = (1.0 + luminance / (white * white)) / (1.0 + luminance);
            light.map(|c| c * factor)
        }
        // K. Narkowicz, ACES filmic tone mapping curve, 2016.
        ToneMap::Aces => light.map(|c| {
            let c = c.min(BRIGHTEST);
            c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14)
        }),
        ToneMap::Hable { white } => {
            let scale = 1.0 / hable(white);
            light.map(|c| hable(c.min(BRIGHTEST)) * scale)
        }
    }
}

/// J. Hable, Uncharted 2: HDR lighting, Game Developers Conference 2010; without his factor of 2 on the
/// light, which is an exposure.
fn hable(x: f32) -> f32 {
    const SHOULDER_STRENGTH: f32 = 0.15;
    const LINEAR_STRENGTH: f32 = 0.5;
    const LINEAR_ANGLE: f32 = 0.1;
    const TOE_STRENGTH: f32 = 0.2;
    const TOE_NUMERATOR: f32 = 0.02;
    const TOE_DENOMINATOR: f32 = 0.3;
    let top =
        x * (SHOULDER_STRENGTH * x + LINEAR_ANGLE * LINEAR_STRENGTH) + TOE_STRENGTH * TOE_NUMERATOR;
    let bottom = x * (SHOULDER_STRENGTH * x + LINEAR_STRENGTH) + TOE_STRENGTH * TOE_DENOMINATOR;
    top / bottom - TOE_NUMERATOR / TOE_DENOMINATOR
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

    const PLAIN: Display = Display::PLAIN;

    #[test]
    fn a_negative_has_the_other_numbers_and_the_same_opacity() {
        let negative = Display {
            invert: true,
            ..PLAIN
        };
        let found = display_pixel([0.0, 1.0, 0.0, 1.0], &negative);
        let off = (0..4).map(|c| (found[c] - [1.0, 0.0, 1.0, 1.0][c]).abs());
        assert!(off.fold(0.0, f32::max) < 1e-6, "{found:?}");
        let grey = 0.5 * linear_from_srgb(0.25) as f32;
        let found = display_pixel([grey, grey, grey, 0.5], &negative);
        let is_near = found[..3].iter().all(|c| (c - 0.75).abs() < 1e-5);
        assert!(is_near && found[3] == 0.5, "{found:?}");
        // What is not there is no white.
        assert_eq!(display_pixel([0.0; 4], &negative), [0.0; 4]);
        let behind = Display {
            background: Some([0.0; 3]),
            ..negative
        };
        assert_eq!(display_pixel([0.0; 4], &behind), [1.0; 4]);
    }

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
    fn color_does_not_depend_on_alpha() {
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
            ..PLAIN
        };
        // Gray 0.5 · 2 = 1, and 1 / (1 + 1) = 0.5.
        let pixel = display_pixel([0.5, 0.5, 0.5, 1.0], &display);
        assert!((pixel[0] - 0.735_36).abs() < 2e-5, "{pixel:?}");
        let bright = display_pixel([500.0, 500.0, 500.0, 1.0], &display);
        assert!(bright[0] < 1.0 && bright[0] > 0.99);
    }

    fn grey(light: f32, map: ToneMap) -> f32 {
        tone_map([light; 3], map)[0]
    }

    const MAPS: [ToneMap; 5] = [
        ToneMap::Clamp,
        ToneMap::Reinhard,
        ToneMap::ReinhardExtended { white: 4.0 },
        ToneMap::Aces,
        ToneMap::Hable { white: 11.2 },
    ];

    #[test]
    fn tone_maps_rise_from_black_and_stay_finite() {
        for map in MAPS {
            assert!(grey(0.0, map).abs() < 1e-6, "{map:?}");
            let lights = (1..400).map(|i| 1.05f32.powi(i - 200));
            let greys: Vec<f32> = lights.map(|light| grey(light, map)).collect();
            assert!(greys.is_sorted(), "{map:?}");
            let brightest = tone_map([f32::MAX, 1.0, 0.0], map);
            assert!(
                brightest.iter().all(|c| c.is_finite() && *c >= 0.0),
                "{map:?}"
            );
        }
    }

    /// Numbers worked out by hand from the published formulas.
    #[test]
    fn tone_maps_meet_their_formulas() {
        let near = |found: f32, expected: f32| {
            assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
        };
        near(grey(3.0, ToneMap::Reinhard), 0.75);
        // The white point becomes white, and 1 becomes (1 + 1/16)/2.
        near(grey(4.0, ToneMap::ReinhardExtended { white: 4.0 }), 1.0);
        near(
            grey(1.0, ToneMap::ReinhardExtended { white: 4.0 }),
            0.531_25,
        );
        near(grey(1.0, ToneMap::Aces), 2.54 / 3.16);
        near(grey(0.18, ToneMap::Aces), 0.086_724 / 0.324_932);
        near(grey(11.2, ToneMap::Hable { white: 11.2 }), 1.0);
        // f(1) = 0.204/0.71 − 1/15, f(11.2) = 19.380/24.476 − 1/15.
        near(grey(1.0, ToneMap::Hable { white: 11.2 }), 0.304_300);
        // Reinhard's keep the ratios of the channels; what is not gray is no exception.
        let [r, g, b] = tone_map([2.0, 1.0, 0.5], ToneMap::ReinhardExtended { white: 3.0 });
        near(r / g, 2.0);
        near(g / b, 2.0);
    }

    #[test]
    fn a_power_stands_for_the_curve_of_srgb() {
        let gamma = |gamma: f32| Display {
            curve: DisplayCurve::Power { gamma },
            ..PLAIN
        };
        let pixel = [0.25, 1.0, 4.0, 1.0];
        assert_eq!(display_pixel(pixel, &gamma(1.0)), [0.25, 1.0, 1.0, 1.0]);
        assert_eq!(display_pixel(pixel, &gamma(2.0)), [0.5, 1.0, 1.0, 1.0]);
        // 2.2 is near sRGB, and never the same in the dark.
        let near = display_pixel([0.2; 4], &gamma(2.2))[0] - display_pixel([0.2; 4], &PLAIN)[0];
        assert!(near.abs() < 0.01, "{near}");
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
