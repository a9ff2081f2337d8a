//! PNG: sRGB or a power curve, 8 or 16 bit, alpha not multiplied in.

use super::display::display_pixel;
use super::{Recipe, fxaa};
use crate::Error;
use png::text_metadata::ITXtChunk;
use png::{BitDepth, ColorType, Compression, Decoder, Encoder, EncodingError, ScaledFloat};
use std::io::{self, BufRead, Read, Seek, SeekFrom, Write};
use strahl_scene::plan::{Display, DisplayCurve};
use strahl_scene::{Image, MOST_SCENE_BYTES};

/// Keyword of the iTXt chunk that holds the scene.
const SCENE: &str = "strahl:scene";
/// Keyword of the chunk that says which program made the picture, registered by the standard.
const SOFTWARE: &str = "Software";
/// No program has a longer name.
const MOST_SOFTWARE_BYTES: usize = 4096;
const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

pub(super) fn is_png(start: &[u8]) -> bool {
    start.starts_with(&SIGNATURE)
}

/// Rounds to nearest without dithering, so that equal pixels stay equal. The alpha channel is left
/// out if every pixel is opaque after rounding.
pub(super) fn write(
    image: &Image,
    display: &Display,
    depth: BitDepth,
    recipe: Option<&Recipe>,
    out: impl Write,
) -> Result<(), Error> {
    let levels = match depth {
        BitDepth::Sixteen => 65_535.0f32,
        _ => 255.0,
    };
    let quantize = |v: f32| (v * levels + 0.5) as u16;
    let opaque = display.background.is_some()
        || image
            .pixels()
            .iter()
            .all(|p| quantize(p[3].clamp(0.0, 1.0)) == levels as u16);
    let channels = if opaque { 3 } else { 4 };

    let mut encoder = Encoder::new(out, image.width(), image.height());
    encoder.set_color(if opaque {
        ColorType::Rgb
    } else {
        ColorType::Rgba
    });
    encoder.set_depth(depth);
    encoder.set_compression(Compression::Balanced);
    match display.curve {
        DisplayCurve::Srgb => encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual),
        DisplayCurve::Power { gamma } => {
            encoder.set_source_gamma(ScaledFloat::new(1.0 / gamma));
        }
    }
    if let Some(recipe) = recipe {
        for (keyword, text) in [(SOFTWARE, &recipe.software), (SCENE, &recipe.scene)] {
            encoder
                .add_itxt_chunk(keyword.into(), text.clone())
                .map_err(cannot_write)?;
        }
    }
    let mut writer = encoder.write_header().map_err(cannot_write)?;
    let mut rows = writer.stream_writer().map_err(cannot_write)?;
    let width = image.width().max(1) as usize;
    let encoded = image.pixels().iter().map(|&p| display_pixel(p, display));
    // Row by row, unless an edge may reach over many of them.
    let smoothed = display
        .fxaa
        .then(|| fxaa::smoothed(&encoded.clone().collect::<Vec<_>>(), width));
    let mut encoded: Box<dyn Iterator<Item = [f32; 4]>> = match smoothed {
        Some(smoothed) => Box::new(smoothed.into_iter()),
        None => Box::new(encoded),
    };
    let mut row = Vec::new();
    for _ in 0..image.height() {
        row.clear();
        for pixel in encoded.by_ref().take(width) {
            for value in &pixel[..channels] {
                match depth {
                    BitDepth::Sixteen => row.extend(quantize(*value).to_be_bytes()),
                    _ => row.push(quantize(*value) as u8),
                }
            }
        }
        rows.write_all(&row).map_err(|e| cannot_write(e.into()))?;
    }
    rows.finish().map_err(cannot_write)?;
    writer.finish().map_err(cannot_write)
}

/// Whether a PNG file goes on to its last chunk. What its chunks hold is not looked at.
pub(super) fn is_whole(mut file: impl Read + Seek) -> io::Result<bool> {
    /// No picture has more; whoever writes them wants to be waited for.
    const MOST_CHUNKS: usize = 100_000;
    /// The chunk at the end, which is always the same.
    const END: [u8; 12] = *b"\0\0\0\0IEND\xAE\x42\x60\x82";
    let length = file.seek(SeekFrom::End(0))?;
    let mut at = SIGNATURE.len() as u64;
    // The end alone says enough of files with many chunks.
    if length >= at + 12 {
        let mut end = [0; 12];
        file.seek(SeekFrom::End(-12))?;
        file.read_exact(&mut end)?;
        if end == END {
            return Ok(true);
        }
    }
    for _ in 0..MOST_CHUNKS {
        if at + 12 > length {
            return Ok(false);
        }
        let mut head = [0; 8];
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut head)?;
        let [a, b, c, d, kind @ ..] = head;
        at += 12 + u64::from(u32::from_be_bytes([a, b, c, d]));
        if kind == *b"IEND" {
            return Ok(at <= length);
        }
    }
    Ok(false)
}

/// The recipe in a PNG file, if it has one.
pub(super) fn read_recipe(file: impl BufRead + Seek) -> Result<Option<Recipe>, Error> {
    let reader = Decoder::new(file)
        .read_info()
        .map_err(|e| Error::not_read("PNG", e))?;
    let chunk = |keyword: &str| {
        let chunks = &reader.info().utf8_text;
        chunks
            .iter()
            .find(|chunk| chunk.keyword == keyword)
            .cloned()
    };
    // Unpacked no further than it is read: few bytes can stand for many.
    let text = |mut chunk: ITXtChunk, most: usize| {
        chunk.decompress_text_with_limit(most)?;
        chunk.get_text()
    };
    let Some(scene) = chunk(SCENE) else {
        return Ok(None);
    };
    let scene = text(scene, MOST_SCENE_BYTES).map_err(|_| Error::NoRecipe { file: None })?;
    let software = chunk(SOFTWARE).and_then(|chunk| text(chunk, MOST_SOFTWARE_BYTES).ok());
    Ok(Some(Recipe {
        scene,
        software: software.unwrap_or_default(),
    }))
}

fn cannot_write(error: EncodingError) -> Error {
    Error::not_written("PNG", error)
}
