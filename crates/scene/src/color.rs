//! Display colors and their way to linear light.

use crate::plan::Compositing;
#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
#[cfg(feature = "schema")]
use std::borrow::Cow;
use std::fmt;

/// A color as people say it: sRGB, red, green, blue from 0 to 1.
///
/// In a scene it is written `"#rrggbb"`, `"#rgb"` or `[red, green, blue]` with numbers from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color(pub [f64; 3]);

impl Color {
    /// White.
    pub const WHITE: Color = Color([1.0; 3]);
    /// Black.
    pub const BLACK: Color = Color([0.0; 3]);

    /// The color written `#rrggbb` or `#rgb`.
    ///
    /// # Errors
    /// What is wrong with the text, in words.
    pub fn from_hex(text: &str) -> Result<Color, String> {
        let wrong = || format!("{text:?} is not a color; write \"#rrggbb\" or [red, green, blue]");
        let digits = text.strip_prefix('#').ok_or_else(wrong)?;
        if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(wrong());
        }
        let part = |from: usize, length: usize| {
            let value = u32::from_str_radix(&digits[from..from + length], 16).unwrap_or(0);
            f64::from(if length == 1 { value * 17 } else { value }) / 255.0
        };
        match digits.len() {
            3 => Ok(Color([part(0, 1), part(1, 1), part(2, 1)])),
            6 => Ok(Color([part(0, 2), part(2, 2), part(4, 2)])),
            _ => Err(wrong()),
        }
    }

    /// `#rrggbb`, if each part is a whole number of 255ths.
    pub fn to_hex(self) -> Option<String> {
        let mut hex = String::from("#");
        for part in self.0 {
            let byte = (part * 255.0).round();
            if !(0.0..=255.0).contains(&byte) || byte / 255.0 != part {
                return None;
            }
            hex.push_str(&format!("{:02x}", byte as u8));
        }
        Some(hex)
    }

    /// Linear light, the form that plans and pictures use.
    pub fn linear(self) -> [f32; 3] {
        self.0.map(|part| linear_from_srgb(part) as f32)
    }

    /// In the numbers in which a plan adds colors up.
    pub(crate) fn in_space(self, compositing: Compositing) -> [f32; 3] {
        match compositing {
            Compositing::Linear => self.linear(),
            Compositing::Display => self.0.map(|part| part as f32),
        }
    }
}

/// The sRGB decoding of IEC 61966-2-1 for one part from 0 to 1.
pub fn linear_from_srgb(srgb: f64) -> f64 {
    if srgb <= 0.04045 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.to_hex() {
            Some(hex) => serializer.serialize_str(&hex),
            None => self.0.serialize(serializer),
        }
    }
}

struct ColorVisitor;

impl<'de> de::Visitor<'de> for ColorVisitor {
    type Value = Color;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a color: \"#rrggbb\" or [red, green, blue] from 0 to 1")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Color, E> {
        Color::from_hex(text).map_err(E::custom)
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, mut parts: A) -> Result<Color, A::Error> {
        let mut rgb = [0.0; 3];
        for (i, part) in rgb.iter_mut().enumerate() {
            *part = parts
                .next_element()?
                .ok_or_else(|| de::Error::invalid_length(i, &self))?;
        }
        if parts.next_element::<de::IgnoredAny>()?.is_some() {
            return Err(de::Error::invalid_length(4, &self));
        }
        Ok(Color(rgb))
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Color, D::Error> {
        deserializer.deserialize_any(ColorVisitor)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Color {
    fn schema_name() -> Cow<'static, str> {
        "Color".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "sRGB color: \"#rrggbb\", \"#rgb\" or [red, green, blue] from 0 to 1",
            "anyOf": [
                { "type": "string", "pattern": "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$" },
                {
                    "type": "array", "minItems": 3, "maxItems": 3,
                    "items": { "type": "number", "minimum": 0, "maximum": 1 }
                }
            ]
        })
    }
}

/// What is behind everything: a color, or nothing (`"transparent"`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// The picture keeps its alpha.
    Transparent,
    /// An opaque color.
    Color(Color),
}

impl Background {
    /// Premultiplied RGBA in the numbers in which a plan adds colors up.
    pub(crate) fn in_space(self, compositing: Compositing) -> [f32; 4] {
        match self {
            Background::Transparent => [0.0; 4],
            Background::Color(color) => {
                let [r, g, b] = color.in_space(compositing);
                [r, g, b, 1.0]
            }
        }
    }
}

impl std::str::FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Background, String> {
        match text {
            "transparent" => Ok(Background::Transparent),
            "black" => Ok(Background::Color(Color::BLACK)),
            "white" => Ok(Background::Color(Color::WHITE)),
            _ => Color::from_hex(text)
                .map(Background::Color)
                .map_err(|_| {
                    format!("{text:?} is not a background; write \"#rrggbb\", \"black\", \"white\" or \"transparent\"")
                }),
        }
    }
}

impl Serialize for Background {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Background::Transparent => serializer.serialize_str("transparent"),
            Background::Color(color) => color.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Background, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Background;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str(
                    "\"#rrggbb\", [red, green, blue], \"black\", \"white\" or \"transparent\"",
                )
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Background, E> {
                text.parse().map_err(E::custom)
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, parts: A) -> Result<Background, A::Error> {
                de::Visitor::visit_seq(ColorVisitor, parts).map(Background::Color)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Background {
    fn schema_name() -> Cow<'static, str> {
        "Background".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let color = generator.subschema_for::<Color>();
        json_schema!({
            "description": "A color, or \"transparent\"",
            "anyOf": [{ "enum": ["transparent", "black", "white"] }, color]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_and_numbers_say_the_same() {
        let a: Color = serde_json::from_str("\"#ff8000\"").unwrap();
        let b: Color = serde_json::from_str("[1, 0.5019607843137255, 0]").unwrap();
        assert_eq!(a, b);
        assert_eq!(a.to_hex().unwrap(), "#ff8000");
        assert_eq!(
            Color::from_hex("#f80").unwrap().to_hex().unwrap(),
            "#ff8800"
        );
        for bad in ["ff8000", "#ff80", "#gg8000", "#", "", "#é1", "#ff80001"] {
            assert!(Color::from_hex(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn srgb_decodes_as_the_standard_says() {
        // 0.5 sRGB is 21.4 % of the light; the two pieces meet at 0.04045.
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
        assert!((linear_from_srgb(0.04045) - linear_from_srgb(0.04045 + 1e-12)).abs() < 1e-7);
        assert_eq!(linear_from_srgb(1.0), 1.0);
    }
}
