//! Headerless samples, their layout said by the user or by the habit
//! `name_256x256x128_uint8.raw`.
//!
//! | offset       | bytes           | what                                              |
//! |--------------|-----------------|---------------------------------------------------|
//! | 0            | header bytes    | left out (0 if not said)                          |
//! | header bytes | nx·ny·nz·size   | samples, x fastest, little endian if not said     |
//!
//! In the name, sizes are three whole numbers joined by `x`; the type is any word that
//! [`SampleType::from_name`] knows, alone or with `be` or `le` behind it (`int16be`, `u16_be`).

use super::block::{Block, Encoding, Endian, Trailing};
use super::{Bytes, Input, LoadedVolume, RawLayout, ReadOptions, unoriented};
use crate::error::{Error, ErrorKind, Remedy};
use crate::{Metadata, Rescale, SampleType, Samples, Volume, voxel_count};

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let of_name = layout_of_name(input.name).unwrap_or_default();
    let said = &options.raw;
    let len = input.bytes.len().saturating_sub(said.header_bytes);
    let sample_type = said.sample_type.or(of_name.sample_type);
    let Some(dims) = said.dims.or(of_name.dims) else {
        return Err(missing_dims(sample_type, len));
    };
    let Some(sample_type) = sample_type else {
        return Err(missing_type(dims, len));
    };
    let layout = Layout {
        dims,
        sample_type,
        endian: if said.big_endian || of_name.big_endian {
            Endian::Big
        } else {
            Endian::Little
        },
        header_bytes: said.header_bytes,
    };
    let (spacing_mm, has_length_unit) = unoriented::spacing_mm(options, None);
    let grid = unoriented::grid(dims, spacing_mm)?;
    let volume = Volume::new(
        grid,
        layout.read(input.bytes, Encoding::Raw)?,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: "raw".into(),
            has_length_unit,
            time_points: 1,
            ..Metadata::default()
        },
    )?;
    let mut notes = Vec::new();
    if said.dims.is_none() || said.sample_type.is_none() {
        let [x, y, z] = dims;
        notes.push(format!(
            "layout taken from the file's name: {x}x{y}x{z} {sample_type}{}",
            if sample_type.size() == 1 {
                ""
            } else if layout.endian == Endian::Big {
                ", big endian"
            } else {
                ", little endian"
            }
        ));
    }
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}

/// Everything that has to be known about headerless samples.
pub(crate) struct Layout {
    pub(crate) dims: [usize; 3],
    pub(crate) sample_type: SampleType,
    pub(crate) endian: Endian,
    pub(crate) header_bytes: u64,
}

impl Layout {
    /// The samples, if `bytes` holds exactly these.
    ///
    /// # Errors
    /// Another size: the message says which sizes fit. Or as [`Block::read`].
    pub(crate) fn read(&self, bytes: &dyn Bytes, encoding: Encoding) -> Result<Samples, Error> {
        let count = voxel_count(self.dims).unwrap_or(usize::MAX);
        let size = self.sample_type.size() as u64;
        let expected = (count as u64).saturating_mul(size);
        let found = bytes.len().saturating_sub(self.header_bytes);
        if encoding == Encoding::Raw && expected != found {
            return Err(self.wrong_size(count as u64, expected, bytes.len()));
        }
        let block = Block {
            encoding,
            skip: self.header_bytes,
            endian: self.endian,
            trailing: Trailing::Refused,
            ..Block::raw(bytes, 0)
        };
        block.read(self.sample_type, count)
    }

    fn wrong_size(&self, count: u64, expected: u64, file_bytes: u64) -> Error {
        let [x, y, z] = self.dims;
        let header = match self.header_bytes {
            0 => String::new(),
            n => format!(" after a header of {n} bytes"),
        };
        let found = file_bytes.saturating_sub(self.header_bytes);
        let types = types_of_size(found, count);
        let (advice, remedy) = if !types.is_empty() {
            let advice = format!("; the size fits the types {types}");
            (advice, Some(Remedy::Type))
        } else if found > expected {
            let header = file_bytes - expected;
            let advice = format!("; a header of {header} bytes may stand before them");
            (advice, Some(Remedy::HeaderBytes(header)))
        } else {
            (String::new(), None)
        };
        let error = Error::field(
            "file size",
            format!("{file_bytes} bytes"),
            format!(
                "{} bytes for {x}x{y}x{z} samples of {}{header}{advice}",
                expected.saturating_add(self.header_bytes),
                self.sample_type
            ),
        );
        match remedy {
            Some(remedy) => error.with_remedy(remedy),
            None => error,
        }
    }
}

/// The names of all types of which `count` samples take exactly `bytes`.
fn types_of_size(bytes: u64, count: u64) -> String {
    SampleType::ALL
        .iter()
        .filter(|t| count.checked_mul(t.size() as u64) == Some(bytes))
        .map(|t| t.name())
        .collect::<Vec<_>>()
        .join(", ")
}

fn missing_dims(sample_type: Option<SampleType>, bytes: u64) -> Error {
    let cube = SampleType::ALL
        .iter()
        .filter(|&&t| sample_type.is_none_or(|said| said == t))
        .find_map(|t| {
            let samples = bytes / t.size() as u64;
            let edge = (samples as f64).cbrt().round() as u64;
            let fits = edge > 1 && edge.pow(3) * t.size() as u64 == bytes;
            fits.then(|| format!("; its {bytes} bytes would fit {edge}x{edge}x{edge} {t}"))
        });
    Error::from(ErrorKind::Missing {
        field: "the size of the headerless samples".into(),
        allowed: format!(
            "give size and type, or name the file like `name_256x256x128_uint8.raw`{}",
            cube.unwrap_or_default()
        ),
    })
    .with_remedy(Remedy::DimsAndType)
}

fn missing_type(dims: [usize; 3], bytes: u64) -> Error {
    let [x, y, z] = dims;
    let types = voxel_count(dims).map(|count| types_of_size(bytes, count as u64));
    let fits = match types {
        Some(types) if !types.is_empty() => {
            format!("; for {x}x{y}x{z} the file's size fits {types}")
        }
        _ => format!("; for {x}x{y}x{z} the file's size, {bytes} bytes, fits no type"),
    };
    Error::from(ErrorKind::Missing {
        field: "the type of the headerless samples".into(),
        allowed: format!(
            "give u8 (or u16, i16, f32, …), or name the file like `name_{x}x{y}x{z}_uint8.raw`{fits}"
        ),
    })
    .with_remedy(Remedy::Type)
}

/// The layout that a file name says, if it says at least the sizes.
pub(crate) fn layout_of_name(name: &str) -> Option<RawLayout> {
    let (dims, start, end) = dims_in(name)?;
    let mut layout = RawLayout {
        dims: Some(dims),
        ..RawLayout::default()
    };
    // What stands behind the sizes describes the samples; what stands before may be prose.
    for part in [&name[end..], &name[..start]] {
        for word in part.split(|c: char| !c.is_ascii_alphanumeric()) {
            let word = word.to_ascii_lowercase();
            if layout.sample_type.is_none() {
                let (stem, big) = match word.strip_suffix("be") {
                    Some(stem) if !stem.is_empty() => (stem, true),
                    _ => (word.strip_suffix("le").unwrap_or(&word), false),
                };
                let stem = if stem == "8bit" { "u8" } else { stem };
                // `double` ends in `le` itself.
                layout.sample_type =
                    SampleType::from_name(&word).or_else(|| SampleType::from_name(stem));
                layout.big_endian |= big && layout.sample_type.is_some();
            }
            layout.big_endian |= matches!(&*word, "be" | "msb" | "big" | "bigendian")
                && part.len() == name.len() - end;
        }
    }
    Some(layout)
}

/// Three whole numbers joined by `x`, with their place in the name.
fn dims_in(name: &str) -> Option<([usize; 3], usize, usize)> {
    let bytes = name.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        if !bytes[at].is_ascii_digit() {
            at += 1;
            continue;
        }
        let start = at;
        let mut sizes: Vec<Option<usize>> = Vec::new();
        loop {
            let digits = bytes[at..]
                .iter()
                .take_while(|c| c.is_ascii_digit())
                .count();
            sizes.push(name[at..at + digits].parse().ok());
            at += digits;
            let joined = matches!(bytes.get(at), Some(b'x' | b'X'))
                && bytes.get(at + 1).is_some_and(u8::is_ascii_digit);
            if !joined {
                break;
            }
            at += 1;
        }
        if let [Some(x), Some(y), Some(z)] = sizes[..] {
            return Some(([x, y, z], start, at));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::{MemoryFiles, read_file};

    fn load(name: &str, data: &[u8], options: &ReadOptions) -> Result<LoadedVolume, Error> {
        let files = MemoryFiles::from([(name.to_owned(), data.to_vec())]);
        read_file(name, &files, options)
    }

    #[test]
    fn names_say_the_layout() {
        let cases = [
            (
                "bonsai_256x256x128_uint8.raw",
                [256, 256, 128],
                Some(SampleType::U8),
                false,
            ),
            (
                "foot-64X32x16-int16.raw",
                [64, 32, 16],
                Some(SampleType::I16),
                false,
            ),
            (
                "a_b_4x5x6_float.bin",
                [4, 5, 6],
                Some(SampleType::F32),
                false,
            ),
            (
                "m_4x5x6_uint16_be.raw",
                [4, 5, 6],
                Some(SampleType::U16),
                true,
            ),
            (
                "m_4x5x6_int16be.raw",
                [4, 5, 6],
                Some(SampleType::I16),
                true,
            ),
            ("m_4x5x6_u16le.raw", [4, 5, 6], Some(SampleType::U16), false),
            (
                "m_4x5x6_double.raw",
                [4, 5, 6],
                Some(SampleType::F64),
                false,
            ),
            ("u8_4x5x6.raw", [4, 5, 6], Some(SampleType::U8), false),
            (
                "short_story_4x5x6_f32.raw",
                [4, 5, 6],
                Some(SampleType::F32),
                false,
            ),
            ("big_4x5x6_i16.raw", [4, 5, 6], Some(SampleType::I16), false),
            ("m4x5x6.raw", [4, 5, 6], None, false),
            (
                "m_2x2_4x5x6_1.5x1.5x2_8bit.raw",
                [4, 5, 6],
                Some(SampleType::U8),
                false,
            ),
        ];
        for (name, dims, sample_type, big_endian) in cases {
            let layout = layout_of_name(name).expect(name);
            assert_eq!(layout.dims, Some(dims), "{name}");
            assert_eq!(layout.sample_type, sample_type, "{name}");
            assert_eq!(layout.big_endian, big_endian, "{name}");
        }
        for name in [
            "scan.raw",
            "scan_4x5.raw",
            "scan_4x5x6x7_u8.raw",
            "x4xx5x6.raw",
            "99999999999999999999x2x2_u8.raw",
            "ä_8bit.raw",
        ] {
            assert_eq!(layout_of_name(name), None, "{name}");
        }
    }

    #[test]
    fn options_go_before_the_name() {
        let data: Vec<u8> = [7u8, 7].into_iter().chain(0..12).collect();
        let options = ReadOptions {
            raw: RawLayout {
                dims: Some([3, 2, 1]),
                sample_type: Some(SampleType::U16),
                big_endian: true,
                header_bytes: 2,
            },
            spacing_mm: Some([0.5, 0.5, 2.0]),
            ..ReadOptions::default()
        };
        let loaded = load("x_12x1x1_u8.raw", &data, &options).unwrap();
        assert_eq!(
            loaded.volume.samples(),
            &Samples::U16(vec![1, 0x203, 0x405, 0x607, 0x809, 0xa0b])
        );
        assert_eq!(loaded.volume.grid().spacing_mm().z, 2.0);
        assert!(loaded.volume.metadata().has_length_unit);
        assert!(loaded.notes.is_empty());

        let loaded = load("x_2x2x3_u8.raw", &data[2..], &ReadOptions::default()).unwrap();
        assert_eq!(loaded.volume.grid().dims(), [2, 2, 3]);
        assert_eq!(loaded.volume.value(1, 1, 2), 11.0);
        assert!(!loaded.volume.metadata().has_length_unit);
        assert!(loaded.notes[0].contains("2x2x3 u8"), "{:?}", loaded.notes);
    }

    #[test]
    fn what_is_missing_is_asked_for() {
        let none = ReadOptions::default();
        let (layout, kind) = (Some(Remedy::DimsAndType), Some(Remedy::Type));
        let header = Some(Remedy::HeaderBytes(6));
        let edge = 1_048_576;
        let cases = [
            ("scan.raw", 27, "give size and type", layout),
            ("scan.raw", 27, "27 bytes would fit 3x3x3 u8", layout),
            ("scan.raw", 216, "216 bytes would fit 6x6x6 u8", layout),
            ("scan_4x3x2.raw", 48, "give u8 (or u16", kind),
            ("scan_4x3x2.raw", 48, "size fits u16, i16", kind),
            ("scan_4x3x2.raw", 50, "50 bytes, fits no type", kind),
            (
                "scan_4x3x2_u8.raw",
                48,
                "24 bytes for 4x3x2 samples of u8",
                kind,
            ),
            ("scan_4x3x2_u8.raw", 48, "fits the types u16, i16", kind),
            (
                "scan_4x3x2_u8.raw",
                30,
                "a header of 6 bytes may stand",
                header,
            ),
            ("scan_4x3x2_u8.raw", 20, "file size is 20 bytes", None),
            ("scan_4x0x2_u8.raw", 0, "dimension y is 0", None),
            (
                &format!("scan_{edge}x{edge}x{edge}_f64.raw"),
                3,
                "file size is 3 bytes",
                None,
            ),
        ];
        for (name, bytes, expected, remedy) in cases {
            let error = load(name, &vec![0; bytes], &none).unwrap_err();
            let message = error.to_string();
            assert!(message.contains(expected), "{message}");
            assert!(message.starts_with(name), "{message}");
            assert_eq!(error.remedy(), remedy, "{message}");
        }
    }
}
