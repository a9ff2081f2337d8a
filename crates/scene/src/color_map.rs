//! Built-in color maps.

use crate::Color;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A built-in color map: 0 to 1 → sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ColorMap {
    /// Black to white.
    #[serde(alias = "gray")]
    Grey,
    /// White to black, like film on a light box.
    #[serde(alias = "inverted-gray")]
    InvertedGrey,
    /// Dark violet, green, yellow; even in lightness.
    Viridis,
    /// Black, purple, cream; even in lightness.
    Magma,
    /// Black, red, yellow; even in lightness.
    Inferno,
    /// Blue, red, yellow; even in lightness.
    Plasma,
    /// Blue to yellow; looks the same to most people with color blindness.
    Cividis,
    /// Rainbow with smooth lightness.
    Turbo,
    /// Black, red, yellow, white, like glowing metal.
    Hot,
    /// Black to white with a blue tint in the middle.
    Bone,
    /// Blue, light gray, red: for values around a center.
    CoolWarm,
    /// Dark red flesh to ivory: tissue and bone.
    Tissue,
}

impl ColorMap {
    /// Every map, in the order of the documentation.
    pub const ALL: [ColorMap; 12] = [
        ColorMap::Grey,
        ColorMap::InvertedGrey,
        ColorMap::Viridis,
        ColorMap::Magma,
        ColorMap::Inferno,
        ColorMap::Plasma,
        ColorMap::Cividis,
        ColorMap::Turbo,
        ColorMap::Hot,
        ColorMap::Bone,
        ColorMap::CoolWarm,
        ColorMap::Tissue,
    ];

    /// The name used in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            ColorMap::Grey => "grey",
            ColorMap::InvertedGrey => "inverted-grey",
            ColorMap::Viridis => "viridis",
            ColorMap::Magma => "magma",
            ColorMap::Inferno => "inferno",
            ColorMap::Plasma => "plasma",
            ColorMap::Cividis => "cividis",
            ColorMap::Turbo => "turbo",
            ColorMap::Hot => "hot",
            ColorMap::Bone => "bone",
            ColorMap::CoolWarm => "cool-warm",
            ColorMap::Tissue => "tissue",
        }
    }

    /// The color at `position`, clamped to 0 to 1.
    pub fn at(self, position: f64) -> Color {
        let position = position.clamp(0.0, 1.0);
        let continuous = |gradient: colorous::Gradient| {
            let color = gradient.eval_continuous(position);
            Color([color.r, color.g, color.b].map(|part| f64::from(part) / 255.0))
        };
        match self {
            ColorMap::Grey => Color([position; 3]),
            ColorMap::InvertedGrey => Color([1.0 - position; 3]),
            ColorMap::Viridis => continuous(colorous::VIRIDIS),
            ColorMap::Magma => continuous(colorous::MAGMA),
            ColorMap::Inferno => continuous(colorous::INFERNO),
            ColorMap::Plasma => continuous(colorous::PLASMA),
            ColorMap::Cividis => continuous(colorous::CIVIDIS),
            ColorMap::Turbo => continuous(colorous::TURBO),
            ColorMap::Hot => Color([
                (position * 2.7).min(1.0),
                (position * 2.7 - 1.0).clamp(0.0, 1.0),
                (position * 4.0 - 3.0).clamp(0.0, 1.0),
            ]),
            ColorMap::Bone => piecewise(
                &[
                    (0.0, [0.0, 0.0, 0.0]),
                    (0.375, [0.33, 0.33, 0.45]),
                    (0.75, [0.65, 0.78, 0.78]),
                    (1.0, [1.0, 1.0, 1.0]),
                ],
                position,
            ),
            ColorMap::CoolWarm => piecewise(
                &[
                    (0.0, [0.23, 0.30, 0.75]),
                    (0.25, [0.55, 0.69, 1.0]),
                    (0.5, [0.87, 0.87, 0.87]),
                    (0.75, [0.96, 0.60, 0.48]),
                    (1.0, [0.71, 0.02, 0.15]),
                ],
                position,
            ),
            ColorMap::Tissue => piecewise(
                &[
                    (0.0, [0.25, 0.05, 0.03]),
                    (0.35, [0.72, 0.32, 0.22]),
                    (0.65, [0.92, 0.72, 0.52]),
                    (1.0, [1.0, 0.97, 0.90]),
                ],
                position,
            ),
        }
    }
}

impl std::str::FromStr for ColorMap {
    type Err = String;

    fn from_str(name: &str) -> Result<ColorMap, String> {
        let wanted = name.replace("gray", "grey");
        ColorMap::ALL
            .into_iter()
            .find(|map| map.name() == wanted)
            .ok_or_else(|| {
                let names: Vec<_> = ColorMap::ALL.iter().map(|map| map.name()).collect();
                format!(
                    "{name:?} is not a color map; known are {}",
                    names.join(", ")
                )
            })
    }
}

fn piecewise(points: &[(f64, [f64; 3])], position: f64) -> Color {
    let next = points
        .iter()
        .position(|point| point.0 >= position)
        .unwrap_or(points.len() - 1)
        .max(1);
    let (a, b) = (points[next - 1], points[next]);
    let part = (position - a.0) / (b.0 - a.0);
    Color(std::array::from_fn(|c| a.1[c] + (b.1[c] - a.1[c]) * part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_their_names_and_stay_in_range() {
        for map in ColorMap::ALL {
            assert_eq!(map.name().parse(), Ok(map));
            assert_eq!(
                serde_json::to_string(&map).unwrap(),
                format!("{:?}", map.name())
            );
            for i in 0..=100 {
                for part in map.at(f64::from(i) / 100.0).0 {
                    assert!((0.0..=1.0).contains(&part));
                }
            }
        }
        assert_eq!(ColorMap::Grey.at(0.25), Color([0.25; 3]));
        assert_eq!(ColorMap::Viridis.at(0.0).to_hex().unwrap(), "#440154");
    }
}
