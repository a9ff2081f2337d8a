//! Picture files: PNG for display, EXR for further processing. Both contain their scene.
//!
//! A renderer's [`Image`] is linear and premultiplied. PNG gets display numbers: color divided by
//! alpha, times the exposure, tone mapped, encoded in sRGB or by a power, edges smoothed if wanted,
//! rounded without dithering, with an `sRGB` or `gAMA` chunk that says so. EXR gets the light as it is:
//! linear, premultiplied, without exposure and tone map; and the depth, if there is one.

mod carried;
mod display;
#[cfg(feature = "exr")]
mod exr;
#[cfg(not(feature = "exr"))]
#[path = "picture/without_exr.rs"]
mod exr;
mod fxaa;
mod png;
mod recipe;

use crate::Error;
use crate::confinement::open_regular;
use std::io::{BufReader, Read, Seek, Write};
use std::path::Path;
use strahl_scene::{Image, plan::Display};

pub use carried::CarriedFiles;
#[cfg(feature = "graph")]
pub(crate) use carried::MOST_CARRIED_BYTES;
pub use recipe::{MadeFrom, Recipe, SOFTWARE};

/// How a picture is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// PNG with 8 bits per channel.
    Png8,
    /// PNG with 16 bits per channel.
    Png16,
    /// OpenEXR with 16-bit floating-point channels.
    ExrHalf,
    /// OpenEXR with 32-bit floating-point channels.
    ExrFloat,
}

impl Encoding {
    /// The encoding for a file name: 8-bit `.png` or 32-bit `.exr`, unless `bits` is set (8 or
    /// 16 for PNG, 16 or 32 for EXR).
    ///
    /// # Errors
    /// Any other name or number of bits.
    pub fn for_path(path: &Path, bits: Option<u32>) -> Result<Encoding, Error> {
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase());
        match (extension.as_deref(), bits) {
            (Some("png"), None | Some(8)) => Ok(Encoding::Png8),
            (Some("png"), Some(16)) => Ok(Encoding::Png16),
            (Some("png"), Some(bits)) => Err(Error::not_usable(
                path,
                format!("PNG has no {bits}-bit channels; 8 and 16 are possible"),
            )),
            (Some("exr"), _) if !cfg!(feature = "exr") => Err(Error::not_usable(
                path,
                "EXR is not part of this build; build with the feature `exr`, or write .png",
            )),
            (Some("exr"), Some(16)) => Ok(Encoding::ExrHalf),
            (Some("exr"), None | Some(32)) => Ok(Encoding::ExrFloat),
            (Some("exr"), Some(bits)) => Err(Error::not_usable(
                path,
                format!("EXR is not written with {bits}-bit channels; 16 and 32 are possible"),
            )),
            _ => Err(Error::not_usable(
                path,
                "a picture's name has to end in .png or .exr",
            )),
        }
    }
}

impl Recipe {
    /// The recipe in the picture file at `path`; `None` if the file is not PNG or EXR, or has
    /// no recipe.
    ///
    /// # Errors
    /// If the file cannot be read, is a damaged PNG or EXR file, or has a scene that is damaged or longer than any is.
    pub fn of_file(path: &Path) -> Result<Option<Recipe>, Error> {
        let file = open_regular(path).map_err(|source| Error::path(path, source))?;
        Recipe::of(BufReader::new(file)).map_err(|error| match error {
            error @ Error::NotRead { .. } => Error::not_usable(path, error.to_string()),
            Error::NoRecipe { .. } => Error::NoRecipe {
                file: Some(path.to_owned()),
            },
            other => other,
        })
    }

    fn of(mut file: BufReader<impl Read + Seek>) -> Result<Option<Recipe>, Error> {
        let mut start = Vec::new();
        let read = (&mut file).take(8).read_to_end(&mut start);
        read.and_then(|_| file.rewind())
            .map_err(|e| Error::not_read("picture", e))?;
        if png::is_png(&start) {
            png::read_recipe(file)
        } else if exr::is_exr(&start) {
            exr::read_recipe(file)
        } else {
            Ok(None)
        }
    }
}

/// Whether the file at `path` is a PNG that ends before its last chunk.
pub(crate) fn is_cut_off(path: &Path) -> Result<bool, Error> {
    let fail = |source| Error::path(path, source);
    let mut file = BufReader::new(open_regular(path).map_err(fail)?);
    let mut start = Vec::new();
    let read = (&mut file).take(8).read_to_end(&mut start);
    read.map_err(fail)?;
    Ok(png::is_png(&start) && !png::is_whole(file).map_err(fail)?)
}

/// Writes `image` to `out`, which should be buffered. `display` matters for PNG only.
///
/// `depth_mm` is the depth of each pixel, measured from the start of its ray, row by row from
/// the top, and infinite without a hit. EXR stores it as 32-bit channel `Z`.
///
/// # Errors
/// If `out` cannot be written; a depth for PNG, or of another number of pixels.
pub fn write_picture(
    image: &Image,
    depth_mm: Option<&[f32]>,
    display: &Display,
    encoding: Encoding,
    recipe: Option<&Recipe>,
    out: impl Write + Seek,
) -> Result<(), Error> {
    if let Some(depth_mm) = depth_mm {
        if matches!(encoding, Encoding::Png8 | Encoding::Png16) {
            return Err(Error::NoDepth);
        }
        if depth_mm.len() != image.pixels().len() {
            return Err(Error::DepthSize {
                numbers: depth_mm.len(),
                pixels: image.pixels().len(),
            });
        }
    }
    match encoding {
        Encoding::Png8 => png::write(image, display, ::png::BitDepth::Eight, recipe, out),
        Encoding::Png16 => png::write(image, display, ::png::BitDepth::Sixteen, recipe, out),
        Encoding::ExrHalf => exr::write(image, display.background, depth_mm, true, recipe, out),
        Encoding::ExrFloat => exr::write(image, display.background, depth_mm, false, recipe, out),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::prelude::{ReadChannels, ReadLayers};
    use std::io::Cursor;
    use strahl_scene::plan::DisplayCurve;

    const PLAIN: Display = Display::PLAIN;
    const ALL: [Encoding; 4] = [
        Encoding::Png8,
        Encoding::Png16,
        Encoding::ExrHalf,
        Encoding::ExrFloat,
    ];

    fn written(image: &Image, encoding: Encoding, recipe: Option<&Recipe>) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        write_picture(image, None, &PLAIN, encoding, recipe, &mut out).unwrap();
        out.into_inner()
    }

    fn decoded(png: &[u8]) -> (::png::OutputInfo, Vec<u8>) {
        let mut reader = ::png::Decoder::new(Cursor::new(png)).read_info().unwrap();
        assert!(reader.info().srgb.is_some());
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info, pixels)
    }

    /// Two by two: opaque red at half light, white; half-transparent green, nothing.
    fn sample() -> Image {
        let pixels = vec![
            [0.5, 0.0, 0.0, 1.0],
            [1.0, 1.0, 1.0, 1.0],
            [0.0, 0.25, 0.0, 0.5],
            [0.0, 0.0, 0.0, 0.0],
        ];
        Image::from_pixels(2, 2, pixels)
    }

    #[test]
    fn eight_bit_png_with_alpha() {
        let (info, pixels) = decoded(&written(&sample(), Encoding::Png8, None));
        assert_eq!((info.width, info.height), (2, 2));
        assert_eq!(info.color_type, ::png::ColorType::Rgba);
        // sRGB of linear 0.5 is 0.73536: 187.5 of 255.
        let expected = [
            [188, 0, 0, 255],
            [255, 255, 255, 255],
            [0, 188, 0, 128],
            [0, 0, 0, 0],
        ];
        assert_eq!(pixels, expected.concat());
    }

    #[test]
    fn an_opaque_png_has_no_alpha_channel() {
        let image = Image::from_pixels(2, 1, vec![[0.5, 0.5, 0.5, 0.999_9], [2.0, -1.0, 0.0, 1.0]]);
        let (info, pixels) = decoded(&written(&image, Encoding::Png8, None));
        assert_eq!(info.color_type, ::png::ColorType::Rgb);
        assert_eq!(pixels, [188, 188, 188, 255, 0, 0]);
    }

    #[test]
    fn sixteen_bit_png_is_big_endian_and_finer() {
        let (info, pixels) = decoded(&written(&sample(), Encoding::Png16, None));
        assert_eq!(info.bit_depth, ::png::BitDepth::Sixteen);
        let red = u16::from_be_bytes([pixels[0], pixels[1]]);
        assert!(
            (f64::from(red) / 65_535.0 - 0.735_357).abs() < 1e-5,
            "{red}"
        );
        let alpha = u16::from_be_bytes([pixels[16 + 6], pixels[16 + 7]]);
        assert_eq!(alpha, 32_768);
    }

    #[test]
    fn exr_keeps_light_as_it_is() {
        let mut image = sample();
        image.pixels_mut()[1] = [7.5, -0.25, 1e-3, 1.0];
        for (encoding, tolerance) in [(Encoding::ExrFloat, 0.0), (Encoding::ExrHalf, 1e-3)] {
            let file = written(&image, encoding, None);
            let read = ::exr::prelude::read()
                .no_deep_data()
                .largest_resolution_level()
                .rgba_channels(
                    |size, _| (size.width(), vec![[0.0f32; 4]; size.area()]),
                    |(width, pixels), at, (r, g, b, a): (f32, f32, f32, f32)| {
                        pixels[at.1 * *width + at.0] = [r, g, b, a];
                    },
                )
                .first_valid_layer()
                .all_attributes()
                .from_buffered(Cursor::new(file))
                .unwrap();
            let (_, pixels) = read.layer_data.channel_data.pixels;
            for (found, expected) in pixels.iter().zip(image.pixels()) {
                for c in 0..4 {
                    let limit = tolerance * expected[c].abs();
                    assert!(
                        (found[c] - expected[c]).abs() <= limit,
                        "{found:?} {expected:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn exr_holds_depth_beside_the_light() {
        let depth_mm = [1.5, 700.25, f32::INFINITY, 1e-3];
        for encoding in [Encoding::ExrFloat, Encoding::ExrHalf] {
            let mut out = Cursor::new(Vec::new());
            write_picture(&sample(), Some(&depth_mm), &PLAIN, encoding, None, &mut out).unwrap();
            let read = ::exr::prelude::read()
                .no_deep_data()
                .largest_resolution_level()
                .all_channels()
                .first_valid_layer()
                .all_attributes()
                .from_buffered(Cursor::new(out.into_inner()))
                .unwrap();
            let channels = &read.layer_data.channel_data.list;
            let names: Vec<_> = channels.iter().map(|c| c.name.to_string()).collect();
            assert_eq!(names, ["A", "B", "G", "R", "Z"]);
            let found: Vec<f32> = channels[4].sample_data.values_as_f32().collect();
            assert_eq!(found, depth_mm);
            let red: Vec<f32> = channels[3].sample_data.values_as_f32().collect();
            assert_eq!(red, [0.5, 1.0, 0.0, 0.0]);
        }
        let error = |depth: &[f32], encoding| {
            let out = Cursor::new(Vec::new());
            let written = write_picture(&sample(), Some(depth), &PLAIN, encoding, None, out);
            written.unwrap_err().to_string()
        };
        assert!(error(&depth_mm, Encoding::Png8).contains("a name that ends in .exr"));
        let found = error(&depth_mm[1..], Encoding::ExrFloat);
        assert!(
            found.contains("3 numbers") && found.contains("4 pixels"),
            "{found}"
        );
    }

    fn written_for(image: &Image, display: Display) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        write_picture(image, None, &display, Encoding::Png8, None, &mut out).unwrap();
        out.into_inner()
    }

    #[test]
    fn a_power_curve_is_told_in_the_file() {
        let display = Display {
            curve: DisplayCurve::Power { gamma: 2.0 },
            ..PLAIN
        };
        let file = written_for(&sample(), display);
        let mut reader = ::png::Decoder::new(Cursor::new(file)).read_info().unwrap();
        assert!(reader.info().srgb.is_none());
        let gamma = reader.info().gama_chunk.unwrap();
        assert_eq!(gamma.into_value(), 0.5);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        // The root of one half.
        assert_eq!(pixels[0], 180);
    }

    #[test]
    fn fxaa_smooths_edges_and_nothing_else() {
        let fxaa = Display {
            fxaa: true,
            ..PLAIN
        };
        let flat = Image::from_pixels(40, 30, vec![[0.1, 0.3, 0.2, 0.7]; 1200]);
        assert_eq!(written_for(&flat, fxaa), written_for(&flat, PLAIN));
        let half = |i: usize| if i % 40 > i / 40 { 1.0 } else { 0.0 };
        let pixels = (0..1200).map(|i| [half(i), half(i), half(i), 1.0]);
        let edge = Image::from_pixels(40, 30, pixels.collect());
        let levels = |display| {
            let (_, pixels) = decoded(&written_for(&edge, display));
            pixels.iter().filter(|p| (1..255).contains(*p)).count()
        };
        assert_eq!(levels(PLAIN), 0);
        assert!(levels(fxaa) > 3 * 25, "{}", levels(fxaa));
    }

    #[test]
    fn the_scene_comes_back_from_every_encoding() {
        let recipe = Recipe::new(r#"{"format": 1, "title": "Schädel"}"#);
        for encoding in ALL {
            let file = written(&sample(), encoding, Some(&recipe));
            let found = Recipe::of(BufReader::new(Cursor::new(file)))
                .unwrap()
                .unwrap();
            assert_eq!(found.software, recipe.software);
            let value = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
            assert_eq!(value(&found.scene), value(&recipe.scene), "{encoding:?}");
        }
    }

    #[test]
    fn files_without_a_scene_have_none() {
        for encoding in ALL {
            let file = written(&sample(), encoding, None);
            assert_eq!(Recipe::of(BufReader::new(Cursor::new(file))).unwrap(), None);
        }
        for other in [&b""[..], b"\x89PN", b"NRRD0004\n"] {
            assert_eq!(
                Recipe::of(BufReader::new(Cursor::new(other))).unwrap(),
                None
            );
        }
        let damaged = &written(&sample(), Encoding::Png8, None)[..20];
        assert!(Recipe::of(BufReader::new(Cursor::new(damaged))).is_err());
    }

    #[test]
    fn a_png_that_is_cut_off_is_told_from_a_whole_one() {
        let whole = written(&sample(), Encoding::Png8, Some(&Recipe::new("{}")));
        let is_whole = |bytes: &[u8]| png::is_whole(Cursor::new(bytes)).unwrap();
        assert!(is_whole(&whole));
        for length in 8..whole.len() {
            assert!(!is_whole(&whole[..length]), "{length}");
        }
        // Something behind the end, as some programs leave it.
        assert!(is_whole(&[&whole[..], b"more"].concat()));
        // Chunks that claim more than there is, and more chunks than any picture has.
        let claims = [&whole[..8], &[0xFF; 4], b"IDAT"].concat();
        assert!(!is_whole(&claims));
        let chunk = [0, 0, 0, 0, b't', b'E', b'X', b't', 0, 0, 0, 0];
        assert!(!is_whole(&[&whole[..8], &chunk.repeat(200_000)].concat()));
    }

    #[test]
    fn the_same_picture_is_the_same_bytes() {
        let recipe = Recipe::new("{}");
        for encoding in ALL {
            let file = || written(&sample(), encoding, Some(&recipe));
            assert_eq!(file(), file());
        }
    }

    #[test]
    fn names_and_bits_pick_the_encoding() {
        let pick = |name: &str, bits| Encoding::for_path(Path::new(name), bits);
        assert_eq!(pick("a.png", None).unwrap(), Encoding::Png8);
        assert_eq!(pick("a.PNG", Some(16)).unwrap(), Encoding::Png16);
        assert_eq!(pick("a.exr", None).unwrap(), Encoding::ExrFloat);
        assert_eq!(pick("a.exr", Some(16)).unwrap(), Encoding::ExrHalf);
        for (name, bits) in [
            ("a.png", Some(32)),
            ("a.exr", Some(8)),
            ("a.jpg", None),
            ("png", None),
        ] {
            assert!(pick(name, bits).is_err(), "{name} {bits:?}");
        }
    }
}
