//! Palettes (TIFF 6.0, section 5): ColorMap holds the reds of all indices, then the greens, then the blues, in 16 bits
//! each. Colors of 8 bits are what programs make of them: the high byte, or the number itself if none is above 255.

use crate::error::{Error, ErrorKind};
use crate::read::components::{self, Choice};
use crate::{Components, Samples, memory};

/// The colors of the indices of a page.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Palette {
    colors: Vec<[u8; 3]>,
}

impl Palette {
    /// The palette of a ColorMap for indices of `bits`.
    pub(super) fn new(map: &[u64], bits: u32, field: &str) -> Result<Palette, Error> {
        let entries = 1usize << bits.min(16);
        if bits > 16 || map.len() != 3 * entries {
            return Err(Error::field(
                field,
                format!("of {} numbers", map.len()),
                format!("of {} numbers for indices of up to 16 bits", 3 * entries),
            ));
        }
        let shift = if map.iter().any(|number| *number > 255) {
            8
        } else {
            0
        };
        let color = |index: usize| [0, 1, 2].map(|i| (map[i * entries + index] >> shift) as u8);
        Ok(Palette {
            colors: (0..entries).map(color).collect(),
        })
    }

    /// The numbers that a pixel stands for: one if all colors are grays.
    pub(super) fn components(&self) -> Components {
        components::of_palette(&self.colors)
    }

    /// The chosen number of every pixel, whose indices these are.
    pub(super) fn applied(&self, indices: Samples, choice: Choice) -> Result<Samples, Error> {
        let colors = Samples::U8(self.colors.as_flattened().to_vec());
        let Samples::U8(table) = components::reduced(colors, 3, choice) else {
            return Err(not_indices());
        };
        match indices {
            Samples::U8(mut indices) => {
                for index in &mut indices {
                    *index = table[usize::from(*index)];
                }
                Ok(Samples::U8(indices))
            }
            Samples::U16(indices) => {
                let mut numbers: Vec<u8> = memory::reserved(indices.len())?;
                numbers.extend(indices.iter().map(|index| table[usize::from(*index)]));
                Ok(Samples::U8(numbers))
            }
            _ => Err(not_indices()),
        }
    }
}

fn not_indices() -> Error {
    ErrorKind::Unsupported {
        feature: "a palette whose indices are not unsigned numbers of up to 16 bits".into(),
        instead: "save the picture in RGB".into(),
    }
    .into()
}
