//! What MetaMorph writes into its stacks (`.stk`): the planes of a stack follow one another behind one directory.
//!
//! | tag   | what                                                                                        |
//! |-------|---------------------------------------------------------------------------------------------|
//! | 33628 | UIC1: pairs of u32, key and value: 3 whether calibrated, 4 and 5 distances along x and y (position of a fraction), 6 unit (position of a length and a text) |
//! | 33629 | UIC2: six u32 per plane; the first two are the distance to the plane before, as a fraction  |
//!
//! The count of UIC2 is the number of planes, whatever type its entry says.

use super::lengths::mm_per;
use super::source::{Source, integer};
use crate::error::Error;

/// What a file says of its planes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MetaMorph {
    /// How many there are.
    pub(super) planes: usize,
    /// Distances along x, y, z in `unit`, where they are known.
    distances: [Option<f64>; 3],
    unit: String,
    is_uneven: bool,
}

/// An entry of the directory: how many elements, and where they lie.
pub(super) type Place = (u64, u64);

const MOST_PLANES: u64 = 1 << 20;

impl MetaMorph {
    /// `None` for a file without the tags.
    ///
    /// # Errors
    /// Entries that lie outside of the file.
    pub(super) fn read(
        source: &Source,
        uic1: Option<Place>,
        uic2: Option<Place>,
    ) -> Result<Option<MetaMorph>, Error> {
        let Some((planes, at)) = uic2 else {
            return Ok(None);
        };
        if !(1..=MOST_PLANES).contains(&planes) {
            return Err(Error::field(
                "the number of planes (tag 33629)",
                planes,
                format!("1 to {MOST_PLANES}"),
            ));
        }
        let table = source.fetch(at, 24 * planes, "MetaMorph's table of planes")?;
        let heights: Vec<Option<f64>> = table
            .chunks_exact(24)
            .map(|plane| fraction(source, &plane[..8]))
            .collect();
        let mut found = MetaMorph {
            planes: planes as usize,
            distances: [None, None, heights[heights.len().min(2) - 1]],
            unit: String::new(),
            is_uneven: heights
                .get(2..)
                .is_some_and(|rest| rest.iter().any(|height| *height != heights[1])),
        };
        if let Some((pairs, at)) = uic1 {
            found.calibrate(source, pairs, at)?;
        }
        Ok(Some(found))
    }

    fn calibrate(&mut self, source: &Source, pairs: u64, at: u64) -> Result<(), Error> {
        let table = source.fetch(at, pairs.min(256) * 8, "MetaMorph's table of settings")?;
        let what = "MetaMorph's calibration";
        for pair in table.chunks_exact(8) {
            let key = integer(&pair[..4], source.endian);
            let value = integer(&pair[4..], source.endian);
            match key {
                // Not calibrated: what follows means nothing.
                3 if value == 0 => return Ok(()),
                4 | 5 => {
                    let stored = source.fetch(value, 8, what)?;
                    self.distances[key as usize - 4] = fraction(source, &stored);
                }
                6 => {
                    let length = integer(&source.fetch(value, 4, what)?, source.endian);
                    let text = source.fetch(value + 4, length.min(64), what)?;
                    let text = String::from_utf8_lossy(&text);
                    self.unit = text.trim_matches(['\0', ' ']).to_owned();
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Distance between voxel centers and whether it has a length unit, if anything is said of it.
    pub(super) fn spacing_mm(&self, notes: &mut Vec<String>) -> Option<([f64; 3], bool)> {
        let [x, y, z] = self.distances;
        x.or(y).or(z)?;
        if self.is_uneven {
            notes.push(
                "MetaMorph's planes are not evenly apart; the first distance is taken".into(),
            );
        }
        if x.or(y).is_none() {
            notes.push(
                "MetaMorph states the distance of planes but not of pixels; 1 is used for pixels"
                    .into(),
            );
        }
        let unit_mm = match self.unit.as_str() {
            "um" | "microns" => Some(1e-3),
            other => mm_per(other),
        };
        let flat = x.or(y).unwrap_or(1.0);
        let spacing = [x.unwrap_or(flat), y.unwrap_or(flat), z.unwrap_or(flat)];
        Some((
            spacing.map(|distance| distance * unit_mm.unwrap_or(1.0)),
            unit_mm.is_some(),
        ))
    }
}

/// A length as numerator and denominator.
fn fraction(source: &Source, bytes: &[u8]) -> Option<f64> {
    let [up, down] = [&bytes[..4], &bytes[4..]].map(|n| integer(n, source.endian) as f64);
    Some(up / down).filter(|length| length.is_finite() && *length > 0.0)
}
