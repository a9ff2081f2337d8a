//! OpenEXR: linear light before exposure and tone map, premultiplied as the format wants.

use super::Recipe;
use crate::Error;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image as ExrImage, Layer,
    LayerAttributes, MetaData, SmallVec, Text, WritableImage, f16,
};
use std::fmt::Write as _;
use std::io::{Read, Seek, Write};
use strahl_scene::Image;

/// Name of the attribute that holds the scene.
const SCENE: &str = "strahl:scene";
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

pub(super) fn is_exr(start: &[u8]) -> bool {
    start.starts_with(&MAGIC)
}

/// Channels R, G, B, A in 32 or (`half`) 16 bit, compressed without loss; half stops at 65,504. An opaque
/// `background`, in linear light, is put behind the image. With `depth_mm`, a channel Z in 32 bit, as the format's conventions call it.
pub(super) fn write(
    image: &Image,
    background: Option<[f32; 3]>,
    depth_mm: Option<&[f32]>,
    half: bool,
    recipe: Option<&Recipe>,
    out: impl Write + Seek,
) -> Result<(), Error> {
    let size = (image.width() as usize, image.height() as usize);
    let limit = f16::MAX.to_f32();
    let color = |c: usize| {
        let behind = background.map_or(0.0, |[r, g, b]| [r, g, b, 1.0][c]);
        let pixels = image.pixels().iter();
        let numbers = pixels.map(move |pixel| match background {
            Some(_) => pixel[c] + (1.0 - pixel[3]) * behind,
            None => pixel[c],
        });
        if half {
            FlatSamples::F16(
                numbers
                    .map(|n| f16::from_f32(n.clamp(-limit, limit)))
                    .collect(),
            )
        } else {
            FlatSamples::F32(numbers.collect())
        }
    };
    let names = ["R", "G", "B", "A"].into_iter().enumerate();
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = names
        .map(|(c, name)| AnyChannel::new(name, color(c)))
        .collect();
    if let Some(depth_mm) = depth_mm {
        channels.push(AnyChannel::new("Z", FlatSamples::F32(depth_mm.to_vec())));
    }
    let channels = AnyChannels::sort(channels);
    let layer = Layer::new(size, attributes(recipe), Encoding::SMALL_LOSSLESS, channels);
    ExrImage::from_layer(layer)
        .write()
        .to_buffered(out)
        .map_err(|e| Error::not_written("EXR", e))
}

fn attributes(recipe: Option<&Recipe>) -> LayerAttributes {
    let mut attributes = LayerAttributes::default();
    if let Some(recipe) = recipe {
        attributes.software_name = Text::new_or_none(&recipe.software);
        attributes.other.insert(
            Text::from(SCENE),
            AttributeValue::Text(Text::from(ascii_json(&recipe.scene).as_str())),
        );
    }
    attributes
}

/// The recipe in an EXR file, if it has one.
pub(super) fn read_recipe(file: impl Read) -> Result<Option<Recipe>, Error> {
    let meta = MetaData::read_from_buffered(file, false).map_err(|e| Error::not_read("EXR", e))?;
    Ok(meta.headers.first().and_then(|header| {
        let attributes = &header.own_attributes;
        match attributes.other.get(&Text::from(SCENE))? {
            AttributeValue::Text(scene) => Some(Recipe {
                scene: scene.to_string(),
                software: attributes
                    .software_name
                    .as_ref()
                    .map(Text::to_string)
                    .unwrap_or_default(),
            }),
            _ => None,
        }
    }))
}

/// The same JSON in ASCII, for the format's text is of single bytes without a stated code page.
/// What is not ASCII can only stand in strings, where JSON allows `\uXXXX`.
fn ascii_json(json: &str) -> String {
    let mut ascii = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            ascii.push(c);
        } else {
            for unit in c.encode_utf16(&mut [0; 2]) {
                let _ = write!(ascii, "\\u{unit:04x}");
            }
        }
    }
    ascii
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_beyond_ascii_survives_as_json() {
        let json = r#"{"name": "Schädel 頭 🦷"}"#;
        let ascii = ascii_json(json);
        assert!(ascii.is_ascii());
        let value = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
        assert_eq!(value(&ascii), value(json));
    }
}
