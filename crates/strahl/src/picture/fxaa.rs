//! FXAA: smooths jagged edges of a finished picture without knowing what is on it.
//!
//! T. Lottes, *FXAA*, NVIDIA 2009, in the form of version 3.11 (2011). Works on display numbers, because
//! the eye sees steps in those. Departures: an end of an edge lies between two pixels, so that a long straight
//! edge gets its exact coverage; every pixel on the way to it is looked at; colors are mixed with what they hide, and so
//! is alpha, so that the silhouette of an object becomes smooth and a transparent background does not bleed into it.

/// Contrast below this share of the brightest neighbor is no edge …
const SMALLEST_CONTRAST_SHARE: f32 = 0.125;
/// … nor is one below this.
const SMALLEST_CONTRAST: f32 = 0.0312;
/// How much single pixels that stand out are taken back.
const SINGLE_PIXELS: f32 = 0.75;
/// How far the ends of an edge are looked for, in pixels.
const FARTHEST: i64 = 16;

/// Picture of `width` pixels per row: display colors that are not multiplied by alpha, and alpha.
/// Pixels at no edge are returned as they are.
pub(super) fn smoothed(pixels: &[[f32; 4]], width: usize) -> Vec<[f32; 4]> {
    if pixels.is_empty() || width == 0 {
        return Vec::new();
    }
    let picture = Picture {
        pixels,
        lumas: pixels.iter().map(luma).collect(),
        width: width as i64,
        height: (pixels.len() / width) as i64,
    };
    let at = |i: usize| picture.smoothed((i % width) as i64, (i / width) as i64);
    (0..pixels.len()).map(at).collect()
}

/// Brightness as seen on what is darker than black, so that a black object has an edge, with the weights of ITU-R
/// BT.601, which are for encoded colors.
fn luma([r, g, b, a]: &[f32; 4]) -> f32 {
    a * (0.299 * r + 0.587 * g + 0.114 * b) - (1.0 - a)
}

struct Picture<'a> {
    pixels: &'a [[f32; 4]],
    lumas: Vec<f32>,
    width: i64,
    height: i64,
}

impl Picture<'_> {
    /// Beyond the border the outermost pixel goes on.
    fn index(&self, x: i64, y: i64) -> usize {
        (x.clamp(0, self.width - 1) + self.width * y.clamp(0, self.height - 1)) as usize
    }

    fn luma(&self, x: i64, y: i64) -> f32 {
        self.lumas[self.index(x, y)]
    }

    fn smoothed(&self, x: i64, y: i64) -> [f32; 4] {
        let around = |dx: i64, dy: i64| self.luma(x + dx, y + dy);
        let middle = around(0, 0);
        let (n, s, w, e) = (around(0, -1), around(0, 1), around(-1, 0), around(1, 0));
        let brightest = middle.max(n).max(s).max(w).max(e);
        let darkest = middle.min(n).min(s).min(w).min(e);
        let contrast = brightest - darkest;
        let pixel = self.pixels[self.index(x, y)];
        if contrast < SMALLEST_CONTRAST.max(brightest * SMALLEST_CONTRAST_SHARE) {
            return pixel;
        }
        let (nw, ne, sw, se) = (around(-1, -1), around(1, -1), around(-1, 1), around(1, 1));

        // How far the pixel stands out of the mean of its surroundings.
        let mean = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
        let out = ((mean - middle).abs() / contrast).min(1.0);
        let out = out * out * (3.0 - 2.0 * out);
        let single = out * out * SINGLE_PIXELS;

        let second = |a: f32, b: f32, c: f32| (a - 2.0 * b + c).abs();
        let across_rows = second(nw, w, sw) + 2.0 * second(n, middle, s) + second(ne, e, se);
        let across_columns = second(nw, n, ne) + 2.0 * second(w, middle, e) + second(sw, s, se);
        let is_horizontal = across_rows >= across_columns;
        let (before, after) = if is_horizontal { (n, s) } else { (w, e) };
        let side = if (before - middle).abs() >= (after - middle).abs() {
            -1
        } else {
            1
        };
        let (across, along) = if is_horizontal {
            ((0, side), (1, 0))
        } else {
            ((side, 0), (0, 1))
        };

        // Along the edge, which runs between the pixel and its neighbor across, until the mean of
        // the two sides is another.
        let pair = |i: i64| {
            let (x, y) = (x + i * along.0, y + i * along.1);
            0.5 * (self.luma(x, y) + self.luma(x + across.0, y + across.1))
        };
        let here = pair(0);
        let steepest = (before - middle).abs().max((after - middle).abs());
        let end = |direction: i64| {
            let ends = |i: &i64| (pair(i * direction) - here).abs() >= 0.25 * steepest;
            let i = (1..=FARTHEST).find(ends);
            let distance = i.map_or(FARTHEST as f32, |i| i as f32 - 0.5);
            (distance, pair(i.unwrap_or(FARTHEST) * direction) - here)
        };
        let (backward, forward) = (end(-1), end(1));
        let (distance, change) = if backward.0 < forward.0 {
            backward
        } else {
            forward
        };
        // At the end the edge goes to the other side of this pixel, not away from it.
        let is_cut = (change < 0.0) != (middle - here < 0.0);
        let cut = if is_cut {
            0.5 - distance / (backward.0 + forward.0)
        } else {
            0.0
        };
        let share = cut.max(single);
        let other = self.pixels[self.index(x + across.0, y + across.1)];
        mixed(pixel, other, share)
    }
}

/// The pixel with a share of the other; their colors weigh as much as they hide.
fn mixed(pixel: [f32; 4], other: [f32; 4], share: f32) -> [f32; 4] {
    let (own, others) = (pixel[3] * (1.0 - share), other[3] * share);
    if share <= 0.0 || own + others <= 0.0 {
        return pixel;
    }
    let color = |c: usize| (own * pixel[c] + others * other[c]) / (own + others);
    // Opaque pixels stay exactly so.
    let alpha = pixel[3] + (other[3] - pixel[3]) * share;
    [color(0), color(1), color(2), alpha]
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [f32; 4] = [1.0; 4];
    const BLACK: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

    fn picture(
        width: usize,
        height: usize,
        at: impl Fn(usize, usize) -> [f32; 4],
    ) -> Vec<[f32; 4]> {
        let pixels = 0..width * height;
        pixels.map(|i| at(i % width, i / width)).collect()
    }

    #[test]
    fn flat_pictures_stay_as_they_are() {
        for (width, height) in [(1, 1), (1, 9), (9, 1), (16, 16)] {
            let flat = picture(width, height, |_, _| [0.3, 0.7, 0.1, 0.5]);
            assert_eq!(smoothed(&flat, width), flat);
        }
        // A soft ramp has no edge.
        let ramp = picture(64, 8, |x, _| [x as f32 / 64.0; 4]);
        assert_eq!(smoothed(&ramp, 64), ramp);
        assert_eq!(smoothed(&[], 0), [[0.0; 4]; 0]);
    }

    /// T. Lottes 2009: of a straight edge along the pixels, each side takes 3/4 of the square of a smooth step of the share
    /// by which its neighbors are off, 1/3.
    #[test]
    fn straight_edges_are_blurred_by_a_twentieth() {
        let blur = 0.75 * (3.0f32 / 9.0 - 2.0 / 27.0).powi(2);
        for along_y in [true, false] {
            let across = |x: usize, y: usize| if along_y { x } else { y };
            let expected = picture(32, 32, |x, y| match across(x, y) {
                0..12 => WHITE,
                12 => [1.0 - blur, 1.0 - blur, 1.0 - blur, 1.0],
                13 => [blur, blur, blur, 1.0],
                _ => BLACK,
            });
            let hard = picture(32, 32, |x, y| if across(x, y) < 13 { WHITE } else { BLACK });
            for (i, (found, expected)) in smoothed(&hard, 32).iter().zip(expected).enumerate() {
                assert!((found[0] - expected[0]).abs() < 1e-6, "{i}: {found:?}");
            }
        }
    }

    #[test]
    fn flat_areas_beside_an_edge_stay_as_they_are() {
        let jagged = picture(64, 64, |x, y| if x > y { WHITE } else { BLACK });
        let found = smoothed(&jagged, 64);
        let changed = found.iter().zip(&jagged).filter(|(a, b)| a != b).count();
        assert!(changed > 60, "{changed} pixels along an edge of 64 changed");
        for (i, (found, before)) in found.iter().zip(&jagged).enumerate() {
            let from_edge = (i % 64).abs_diff(i / 64);
            assert!(from_edge <= 2 || found == before, "{i}");
        }
    }

    /// The mean error against the true coverage of the half-plane below a slanted edge.
    #[test]
    fn slanted_edges_come_nearer_to_their_coverage() {
        for slope in [1.0f32, 0.5, 0.25, 0.1, 3.0] {
            let below = |x: f32, y: f32| y - 20.3 > slope * (x - 20.0);
            let hard = picture(40, 40, |x, y| match below(x as f32 + 0.5, y as f32 + 0.5) {
                true => WHITE,
                false => BLACK,
            });
            let truth = picture(40, 40, |x, y| {
                let inside = (0..256).filter(|i| {
                    let part = |k: i32| (k as f32 + 0.5) / 16.0;
                    below(x as f32 + part(i % 16), y as f32 + part(i / 16))
                });
                [inside.count() as f32 / 256.0; 4]
            });
            let error = |picture: &[[f32; 4]]| -> f32 {
                // Away from the border, where an edge has no end.
                let inner = (0..1600)
                    .filter(|i| (8..32).contains(&(i % 40)) && (8..32).contains(&(i / 40)));
                inner.map(|i| (picture[i][0] - truth[i][0]).powi(2)).sum()
            };
            let found = smoothed(&hard, 40);
            let between = found.iter().filter(|p| p[0] > 0.1 && p[0] < 0.9).count();
            assert!(
                between > 20,
                "slope {slope}: {between} pixels between black and white"
            );
            assert!(
                error(&found) < 0.5 * error(&hard),
                "slope {slope}: {} of {}",
                error(&found),
                error(&hard)
            );
        }
    }

    #[test]
    fn turned_pictures_give_turned_results() {
        let jagged = |x: usize, y: usize| {
            if 3 * x > y + 20 {
                WHITE
            } else {
                [0.2, 0.1, 0.4, 1.0]
            }
        };
        let upright = smoothed(&picture(30, 30, jagged), 30);
        let turned = smoothed(&picture(30, 30, |x, y| jagged(y, x)), 30);
        for i in 0..900 {
            let (found, expected) = (turned[i % 30 * 30 + i / 30], upright[i]);
            for c in 0..4 {
                assert!((found[c] - expected[c]).abs() < 1e-6, "{i}");
            }
        }
    }

    /// The colors of half-covered pixels are the object's, and their alpha comes nearer to what it covers of them.
    #[test]
    fn silhouettes_are_smooth_in_alpha_and_keep_their_color() {
        for color in [[1.0, 0.0, 0.0], [0.0; 3], [1.0; 3]] {
            let [r, g, b] = color;
            let covers = |x: f32, y: f32| y - 20.3 > 0.25 * (x - 20.0);
            let hard = picture(40, 40, |x, y| {
                match covers(x as f32 + 0.5, y as f32 + 0.5) {
                    true => [r, g, b, 1.0],
                    false => [0.0; 4],
                }
            });
            let coverage = |i: usize| {
                let (x, y) = ((i % 40) as f32, (i / 40) as f32);
                let part = |k: i32| (k as f32 + 0.5) / 16.0;
                let inside = (0..256).filter(|k| covers(x + part(k % 16), y + part(k / 16)));
                inside.count() as f32 / 256.0
            };
            let inner: Vec<usize> = (0..1600)
                .filter(|i| (8..32).contains(&(i % 40)) && (8..32).contains(&(i / 40)))
                .collect();
            let error = |picture: &[[f32; 4]]| -> f32 {
                let off = |i: &usize| (picture[*i][3] - coverage(*i)).powi(2);
                inner.iter().map(off).sum()
            };
            let found = smoothed(&hard, 40);
            assert!(error(&found) < 0.5 * error(&hard), "{color:?}");
            for pixel in found.iter().filter(|pixel| pixel[3] > 0.0) {
                assert_eq!(pixel[..3], color);
            }
        }
    }
}
