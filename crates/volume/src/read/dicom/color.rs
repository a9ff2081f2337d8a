//! Pixels of color (PS3.3, C.7.6.3.1): red, green and blue, luminance with two differences, or indices of a palette.

use super::elements::DataSet;
use super::palette_segments::Segments;
use super::tags::{self, Tag, field_name, missing};
use crate::error::{Error, ErrorKind};
use crate::read::components::{self, Meaning};
use crate::{Components, Sample, SampleType};

/// What the stored numbers of a pixel are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Color {
    /// One number: the value.
    Gray,
    /// Red, green and blue.
    Rgb {
        /// All reds of a frame come first, then all greens, then all blues.
        is_planar: bool,
    },
    /// Luminance (Y) and differences of blue and red from it, each about the middle of the range.
    Ybr {
        /// All numbers of one kind come first.
        is_planar: bool,
    },
    /// The same; two neighbors of a row share their differences: Y, Y, blue, red.
    Ybr422,
    /// One number: an index of a palette.
    Palette {
        /// The type of its colors.
        sample_type: SampleType,
        /// The numbers of a color.
        components: Components,
    },
}

impl Color {
    /// What PhotometricInterpretation says. Indices of a palette count as values if `keeps_indices`.
    ///
    /// # Errors
    /// A space of colors that is not read, or a number of samples that does not fit.
    pub(super) fn of(set: &DataSet, keeps_indices: bool) -> Result<Color, Error> {
        let photometric = set.text(tags::PHOTOMETRIC_INTERPRETATION);
        let photometric = photometric.as_deref();
        let samples = set.u16(tags::SAMPLES_PER_PIXEL).unwrap_or(1);
        let is_planar = match set.u16(tags::PLANAR_CONFIGURATION) {
            None | Some(0) => false,
            Some(1) => true,
            Some(other) => {
                let allowed = "0 (pixel by pixel) or 1 (plane by plane)";
                return Err(Error::field(
                    field_name(tags::PLANAR_CONFIGURATION),
                    other,
                    allowed,
                ));
            }
        };
        Ok(match (photometric, samples) {
            (None | Some("MONOCHROME1" | "MONOCHROME2"), 1) => Color::Gray,
            (Some("PALETTE COLOR"), 1) if keeps_indices => Color::Gray,
            (Some("PALETTE COLOR"), 1) => {
                let palette = Palette::of(set)?;
                Color::Palette {
                    sample_type: palette.sample_type,
                    components: components::of_palette(&palette.colors),
                }
            }
            // JPEG 2000 undoes the two transforms itself.
            (Some("RGB" | "YBR_ICT" | "YBR_RCT"), 3) => Color::Rgb { is_planar },
            (Some("YBR_FULL"), 3) => Color::Ybr { is_planar },
            (Some("YBR_FULL_422"), 3) => Color::Ybr422,
            _ => {
                return Err(ErrorKind::Unsupported {
                    feature: format!(
                        "{} with {samples} samples per pixel",
                        photometric.unwrap_or("color")
                    ),
                    instead: "save the images in gray (MONOCHROME2), RGB, YBR_FULL, YBR_FULL_422 or PALETTE COLOR"
                        .into(),
                }
                .into());
            }
        })
    }

    /// What a pixel is, once it is decoded.
    pub(super) fn components(self) -> Components {
        match self {
            Color::Gray => Components::default(),
            Color::Palette { components, .. } => components,
            Color::Rgb { .. } | Color::Ybr { .. } | Color::Ybr422 => Meaning::Color.of(3),
        }
    }

    /// Stored numbers of a pixel that are decoded.
    pub(super) fn stored_numbers(self) -> usize {
        match self {
            Color::Gray | Color::Palette { .. } => 1,
            Color::Rgb { .. } | Color::Ybr { .. } | Color::Ybr422 => 3,
        }
    }
}

/// Red, green and blue of Y, Cb and Cr (PS3.3, C.7.6.3.1.2), whose range has `bits`.
pub(super) fn to_rgb<T: Sample>(numbers: &mut [T], bits: u32) {
    let (half, most) = (2f64.powi(bits as i32 - 1), 2f64.powi(bits as i32) - 1.0);
    // The weights of red, green and blue in Y are 0.299, 0.587 and 0.114.
    for pixel in numbers.chunks_exact_mut(3) {
        let [y, blue, red] = [0, 1, 2].map(|i| pixel[i].to_f64());
        let (blue, red) = (1.772 * (blue - half), 1.402 * (red - half));
        let green = y - (0.114 * blue + 0.299 * red) / 0.587;
        for (into, color) in pixel.iter_mut().zip([y + red, green, y + blue]) {
            *into = T::from_f64(color.round().clamp(0.0, most));
        }
    }
}

/// Y, Cb and Cr of every pixel, of pairs of pixels with Y, Y, Cb and Cr.
pub(super) fn of_pairs<T: Sample>(pairs: &[T], numbers: &mut [T]) {
    for (pair, pixels) in pairs.chunks_exact(4).zip(numbers.chunks_exact_mut(6)) {
        let [first, second, blue, red] = [0, 1, 2, 3].map(|i| pair[i]);
        pixels.copy_from_slice(&[first, blue, red, second, blue, red]);
    }
}

/// The numbers of every pixel side by side, of planes that lie one behind the other.
pub(super) fn of_planes<T: Sample>(planes: &[T], numbers: &mut [T]) {
    let pixels = planes.len() / 3;
    for (i, pixel) in numbers.chunks_exact_mut(3).enumerate() {
        pixel.copy_from_slice(&[planes[i], planes[pixels + i], planes[2 * pixels + i]]);
    }
}

/// The colors of indices (PS3.3, C.7.9).
pub(super) struct Palette {
    /// The index of the first color; smaller ones have the first color too, larger ones the last.
    first: usize,
    /// Red, green and blue.
    colors: Vec<[u16; 3]>,
    /// The type that holds a color.
    pub(super) sample_type: SampleType,
}

impl Palette {
    /// The palette of an image.
    ///
    /// # Errors
    /// Tables that are not there, that are damaged, or that do not fit together.
    pub(super) fn of(set: &DataSet) -> Result<Palette, Error> {
        let red = Table::of(
            set,
            tags::RED_PALETTE_DESCRIPTOR,
            tags::RED_PALETTE_DATA,
            tags::SEGMENTED_RED_PALETTE_DATA,
        )?;
        let green = Table::of(
            set,
            tags::GREEN_PALETTE_DESCRIPTOR,
            tags::GREEN_PALETTE_DATA,
            tags::SEGMENTED_GREEN_PALETTE_DATA,
        )?;
        let blue = Table::of(
            set,
            tags::BLUE_PALETTE_DESCRIPTOR,
            tags::BLUE_PALETTE_DATA,
            tags::SEGMENTED_BLUE_PALETTE_DATA,
        )?;
        for (descriptor, table) in [
            (tags::GREEN_PALETTE_DESCRIPTOR, &green),
            (tags::BLUE_PALETTE_DESCRIPTOR, &blue),
        ] {
            if table.shape() != red.shape() {
                return Err(Error::field(
                    field_name(descriptor),
                    table.shape(),
                    format!("that of red: {}", red.shape()),
                ));
            }
        }
        let colors = red.colors.iter().zip(&green.colors).zip(&blue.colors);
        Ok(Palette {
            first: red.first,
            colors: colors.map(|((r, g), b)| [*r, *g, *b]).collect(),
            sample_type: match red.is_wide {
                true => SampleType::U16,
                false => SampleType::U8,
            },
        })
    }

    /// The color of an index.
    pub(super) fn color(&self, index: usize) -> [u16; 3] {
        let last = self.colors.len() - 1;
        self.colors[index.saturating_sub(self.first).min(last)]
    }
}

/// The bytes of words, the low one first.
fn bytes_of(words: &[u16]) -> impl Iterator<Item = u16> {
    words.iter().flat_map(|word| [word & 0xFF, word >> 8])
}

/// The numbers of one color.
struct Table {
    first: usize,
    colors: Vec<u16>,
    /// Whether they have 16 bits.
    is_wide: bool,
}

impl Table {
    fn of(set: &DataSet, descriptor: Tag, data: Tag, segmented: Tag) -> Result<Table, Error> {
        let described = set.u16s(descriptor);
        let Some([entries, first, bits]) = described.as_deref().and_then(|all| all.first_chunk())
        else {
            return Err(missing(
                descriptor,
                "the number of colors, the first index and the bits",
            ));
        };
        let entries = match *entries {
            0 => 1 << 16,
            n => usize::from(n),
        };
        let (colors, is_wide) = match (set.u16s(data), set.u16s(segmented)) {
            (Some(words), _) => Table::plain(&words, entries, data)?,
            (None, Some(words)) => Table::of_segments(&words, entries, *bits, segmented)?,
            (None, None) => return Err(missing(data, "a table of the palette")),
        };
        Ok(Table {
            first: usize::from(*first),
            colors,
            is_wide,
        })
    }

    /// The colors of a table without segments, and whether they have 16 bits.
    fn plain(words: &[u16], entries: usize, data: Tag) -> Result<(Vec<u16>, bool), Error> {
        // What the descriptor says of the bits is often wrong; the length of the table is not.
        if words.len() == entries {
            return Ok((words.to_vec(), true));
        }
        if words.len() == entries.div_ceil(2) {
            return Ok((bytes_of(words).take(entries).collect(), false));
        }
        Err(Error::field(
            field_name(data),
            format!("of {} bytes", 2 * words.len()),
            format!("of {entries} numbers of 8 or 16 bits"),
        ))
    }

    /// The same of a table in segments, whose numbers have `bits`.
    fn of_segments(
        words: &[u16],
        entries: usize,
        bits: u16,
        segmented: Tag,
    ) -> Result<(Vec<u16>, bool), Error> {
        let are_wide = bits > 8;
        let bytes: Vec<u16>;
        let numbers = match are_wide {
            true => words,
            false => {
                bytes = bytes_of(words).collect();
                &bytes
            }
        };
        let segments = Segments { numbers, are_wide };
        let colors = segments.colors(entries).map_err(|why| {
            let found = format!("of {} bytes: {why}", 2 * words.len());
            let allowed = format!("segments of {bits} bits that make {entries} colors");
            Error::field(field_name(segmented), found, allowed)
        })?;
        Ok((colors, are_wide))
    }

    /// What the tables of the three colors have in common.
    fn shape(&self) -> String {
        let bits = if self.is_wide { 16 } else { 8 };
        let (entries, first) = (self.colors.len(), self.first);
        format!("{entries} numbers of {bits} bits from index {first} on")
    }
}
