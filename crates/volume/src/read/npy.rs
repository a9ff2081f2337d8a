//! NumPy arrays (`.npy`, format versions 1.0, 2.0, 3.0).
//!
//! | offset | bytes | what                                                            |
//! |--------|-------|-----------------------------------------------------------------|
//! | 0      | 6     | 93 `NUMPY`                                                      |
//! | 6      | 2     | version: major, minor                                           |
//! | 8      | 2     | version 1: header length n, u16 little endian                   |
//! | 8      | 4     | versions 2, 3: header length n, u32 little endian               |
//! | 10, 12 | n     | `{'descr': '<i2', 'fortran_order': False, 'shape': (9, 8, 7), }` |
//! | …      |       | samples                                                         |
//!
//! The axis that lies closest together in memory is x, the next y, then z, then time: an array in
//! C order (NumPy's own) has the shape (z, y, x) or (time, z, y, x), one in Fortran order (which is
//! what nibabel hands out) has (x, y, z) or (x, y, z, time).

use super::block::{Block, Endian, Trailing};
use super::stored::Stored;
use super::{Bytes, Input, LoadedVolume, ReadOptions, unoriented};
use crate::error::{Error, ErrorKind};
use crate::{Metadata, Rescale, SampleType, Volume, voxel_count};

/// What NumPy itself still reads without being asked twice is 10,000 characters.
const LONGEST_HEADER: u64 = 1 << 16;

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let header = Header::read(input.bytes)?;
    let mut notes = Vec::new();
    let (dims, time_points) = header.dims(&mut notes)?;
    let too_large = || {
        Error::field(
            "shape",
            header.shape_text(),
            "fewer samples than this machine can address",
        )
    };
    let count = voxel_count(dims).ok_or_else(too_large)?;
    let volume_bytes = (count as u64)
        .checked_mul(header.dtype.stored.bits().size() as u64)
        .ok_or_else(too_large)?;
    let expected = volume_bytes
        .checked_mul(time_points as u64)
        .ok_or_else(too_large)?;
    let found = input.bytes.len().saturating_sub(header.data_offset);
    if found < expected {
        return Err(ErrorKind::Truncated {
            what: "the array".into(),
            expected,
            found,
        }
        .into());
    }
    if options.time_index >= time_points {
        return Err(Error::field(
            "time point",
            options.time_index,
            format!("0 to {} (shape {})", time_points - 1, header.shape_text()),
        ));
    }
    let block = Block {
        endian: header.dtype.endian,
        trailing: Trailing::Ignored,
        ..Block::raw(
            input.bytes,
            header.data_offset + volume_bytes * options.time_index as u64,
        )
    };
    let stored = header.dtype.stored;
    let samples =
        stored.kept_of_bits(block.read(stored.bits(), count)?, input.bytes, &mut notes)?;
    let (spacing_mm, has_length_unit) = unoriented::spacing_mm(options, None);
    let volume = Volume::new(
        unoriented::grid(dims, spacing_mm)?,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: "NumPy npy".into(),
            has_length_unit,
            time_points,
            time_index: options.time_index,
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}

/// How many axes the array has that begins with these bytes, if they are an array.
pub(crate) fn axes(start: &[u8]) -> Option<usize> {
    let header = Header::read(&start).ok()?;
    Some(header.shape.len())
}

#[derive(Clone, Debug, PartialEq)]
struct Header {
    dtype: DType,
    fortran_order: bool,
    shape: Vec<usize>,
    data_offset: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct DType {
    stored: Stored,
    endian: Endian,
}

impl Header {
    fn read(bytes: &dyn Bytes) -> Result<Header, Error> {
        let mut start = [0; 12];
        let available = bytes.len().min(12) as usize;
        bytes.read_at(0, &mut start[..available])?;
        let cut_off = |expected| {
            Error::from(ErrorKind::Truncated {
                what: "the npy header".into(),
                expected,
                found: bytes.len(),
            })
        };
        if !start.starts_with(b"\x93NUMPY") {
            return Err(Error::field(
                "magic",
                start[..6].escape_ascii(),
                "\\x93NUMPY",
            ));
        }
        if available < 10 {
            return Err(cut_off(10));
        }
        let (length, at) = match start[6] {
            1 => (u64::from(u16::from_le_bytes([start[8], start[9]])), 10),
            2 | 3 if available < 12 => return Err(cut_off(12)),
            2 | 3 => {
                let length = u32::from_le_bytes([start[8], start[9], start[10], start[11]]);
                (u64::from(length), 12)
            }
            major => {
                return Err(Error::field(
                    "npy version",
                    format!("{major}.{}", start[7]),
                    "1.0, 2.0 or 3.0",
                ));
            }
        };
        if length > LONGEST_HEADER {
            return Err(Error::field(
                "header length",
                length,
                format!("at most {LONGEST_HEADER}"),
            ));
        }
        if at + length > bytes.len() {
            return Err(cut_off(at + length));
        }
        let mut text = vec![0; length as usize];
        bytes.read_at(at, &mut text)?;
        let text = String::from_utf8_lossy(&text);
        let mut header = parse_header(&text)?;
        header.data_offset = at + length;
        Ok(header)
    }

    /// (x, y, z) and the number of time points.
    fn dims(&self, notes: &mut Vec<String>) -> Result<([usize; 3], usize), Error> {
        if let Some(axis) = self.shape.iter().position(|&n| n == 0) {
            return Err(Error::field(
                "shape",
                self.shape_text(),
                format!("at least 1 along every axis; axis {axis} is empty"),
            ));
        }
        // Closest in memory first.
        let mut axes = self.shape.clone();
        if self.fortran_order {
            notes.push(format!(
                "the array is in Fortran order: its shape {} is taken as (x, y, z)",
                self.shape_text()
            ));
        } else {
            axes.reverse();
        }
        match axes[..] {
            [x, y] => {
                notes.push(format!(
                    "the array has two axes, shape {}: taken as one slice",
                    self.shape_text()
                ));
                Ok(([x, y, 1], 1))
            }
            [x, y, z] => Ok(([x, y, z], 1)),
            [x, y, z, time] => Ok(([x, y, z], time)),
            _ => Err(Error::field(
                "number of axes",
                format!("{} (shape {})", self.shape.len(), self.shape_text()),
                "3, an array (z, y, x); or 4, (time, z, y, x); pick or reshape to that in NumPy",
            )),
        }
    }

    fn shape_text(&self) -> String {
        let sizes: Vec<String> = self.shape.iter().map(usize::to_string).collect();
        format!("({})", sizes.join(", "))
    }
}

/// The dictionary of the header. `data_offset` is left 0.
fn parse_header(text: &str) -> Result<Header, Error> {
    let mut literal = Literal { rest: text };
    let (mut dtype, mut fortran_order, mut shape) = (None, None, None);
    literal.expect('{')?;
    while !literal.take('}') {
        let key = literal.string()?;
        literal.expect(':')?;
        match key {
            "descr" => dtype = Some(literal.dtype()?),
            "fortran_order" => fortran_order = Some(literal.boolean()?),
            "shape" => shape = Some(literal.tuple()?),
            _ => {
                return Err(Error::field(
                    "header key",
                    format!("'{}'", key.escape_debug()),
                    "'descr', 'fortran_order' and 'shape'",
                ));
            }
        }
        if !literal.take(',') {
            literal.expect('}')?;
            break;
        }
    }
    let missing = |field: &str| {
        Error::from(ErrorKind::Missing {
            field: format!("'{field}'"),
            allowed: "an npy header has 'descr', 'fortran_order' and 'shape'".into(),
        })
    };
    Ok(Header {
        dtype: dtype.ok_or_else(|| missing("descr"))?,
        fortran_order: fortran_order.ok_or_else(|| missing("fortran_order"))?,
        shape: shape.ok_or_else(|| missing("shape"))?,
        data_offset: 0,
    })
}

/// Python literals, as far as NumPy writes them.
struct Literal<'a> {
    rest: &'a str,
}

impl<'a> Literal<'a> {
    fn skip_space(&mut self) {
        self.rest = self.rest.trim_start();
    }

    /// Takes `c` if it is next.
    fn take(&mut self, c: char) -> bool {
        self.skip_space();
        match self.rest.strip_prefix(c) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn expect(&mut self, c: char) -> Result<(), Error> {
        if self.take(c) {
            Ok(())
        } else {
            Err(self.wrong("header", format!("`{c}`")))
        }
    }

    fn wrong(&self, field: &str, allowed: impl Into<String>) -> Error {
        let next: String = self.rest.chars().take(24).collect();
        Error::field(
            field,
            format!("`{}`", next.trim_end().escape_debug()),
            allowed,
        )
    }

    fn string(&mut self) -> Result<&'a str, Error> {
        self.skip_space();
        let quote = self.rest.chars().next().filter(|c| matches!(c, '\'' | '"'));
        let text = quote.and_then(|quote| {
            let inside = &self.rest[1..];
            let end = inside.find(quote)?;
            self.rest = &inside[end + 1..];
            Some(&inside[..end])
        });
        text.ok_or_else(|| self.wrong("header", "a text between quotes"))
    }

    fn boolean(&mut self) -> Result<bool, Error> {
        self.skip_space();
        for (word, value) in [("True", true), ("False", false)] {
            if let Some(rest) = self.rest.strip_prefix(word) {
                self.rest = rest;
                return Ok(value);
            }
        }
        Err(self.wrong("fortran_order", "True or False"))
    }

    fn tuple(&mut self) -> Result<Vec<usize>, Error> {
        let mut sizes = Vec::new();
        self.expect('(')?;
        while !self.take(')') {
            self.skip_space();
            let digits = self
                .rest
                .find(|c: char| !c.is_ascii_digit())
                .unwrap_or(self.rest.len());
            let Ok(size) = self.rest[..digits].parse() else {
                return Err(self.wrong("shape", "whole numbers in parentheses, such as (9, 8, 7)"));
            };
            sizes.push(size);
            if sizes.len() > 32 {
                return Err(self.wrong("shape", "at most 32 axes"));
            }
            // Python 2 wrote long integers as `7L`.
            self.rest = &self.rest[digits..];
            self.take('L');
            if !self.take(',') {
                self.expect(')')?;
                break;
            }
        }
        Ok(sizes)
    }

    fn dtype(&mut self) -> Result<DType, Error> {
        self.skip_space();
        if self.rest.starts_with('[') {
            return Err(ErrorKind::Unsupported {
                feature: "an array of records".into(),
                instead: "save one field of it".into(),
            }
            .into());
        }
        let descr = self.string()?;
        let wrong = || {
            Error::field(
                "descr",
                format!("'{}'", descr.escape_debug()),
                "a NumPy number type such as '|u1', '<i2' or '>f4'",
            )
        };
        let mut kind = descr;
        let mut endian = Endian::Little;
        match descr.chars().next() {
            Some('>') => (endian, kind) = (Endian::Big, &descr[1..]),
            Some('<' | '|') => kind = &descr[1..],
            Some('=') => (endian, kind) = (Endian::NATIVE, &descr[1..]),
            _ => {}
        }
        let kept = match kind {
            "i8" => {
                return Ok(DType {
                    stored: Stored::I64,
                    endian,
                });
            }
            "u8" => {
                return Ok(DType {
                    stored: Stored::U64,
                    endian,
                });
            }
            "f2" | "e" => {
                return Ok(DType {
                    stored: Stored::F16,
                    endian,
                });
            }
            "u1" | "b1" | "?" => SampleType::U8,
            "i1" => SampleType::I8,
            "u2" => SampleType::U16,
            "i2" => SampleType::I16,
            "u4" => SampleType::U32,
            "i4" => SampleType::I32,
            "f4" => SampleType::F32,
            "f8" => SampleType::F64,
            "f12" | "f16" => return Err(convert(descr, "float64")),
            "c8" | "c16" => {
                return Err(ErrorKind::Unsupported {
                    feature: format!("complex samples ('{descr}')"),
                    instead: "save the magnitude: numpy.save(file, abs(array))".into(),
                }
                .into());
            }
            _ => return Err(wrong()),
        };
        let stored = Stored::Kept(kept);
        Ok(DType { stored, endian })
    }
}

fn convert(descr: &str, to: &str) -> Error {
    let example = to.split(' ').next().unwrap_or(to);
    ErrorKind::Unsupported {
        feature: format!("the sample type '{descr}'"),
        instead: format!("convert to {to} first: numpy.save(file, array.astype('{example}'))"),
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples;
    use crate::read::MemoryFiles;
    use proptest::prelude::*;

    fn load_at(file: &[u8], time_index: usize) -> Result<LoadedVolume, Error> {
        let input = Input {
            name: "test.npy",
            bytes: &file,
            files: &MemoryFiles::new(),
        };
        let options = ReadOptions {
            time_index,
            ..ReadOptions::default()
        };
        read(&input, &options)
    }

    fn load(file: &[u8]) -> Result<LoadedVolume, Error> {
        load_at(file, 0)
    }

    fn file(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let mut file = b"\x93NUMPY".to_vec();
        file.extend([version, 0]);
        match version {
            1 => file.extend((header.len() as u16).to_le_bytes()),
            _ => file.extend((header.len() as u32).to_le_bytes()),
        }
        file.extend(header.as_bytes());
        file.extend(data);
        file
    }

    fn header(descr: &str, fortran: bool, shape: &str) -> String {
        let fortran = if fortran { "True" } else { "False" };
        format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}    \n")
    }

    #[test]
    fn every_version_and_byte_order() {
        for version in 1..=3 {
            for (descr, bytes) in [("<i2", [1, 0, 0xfe, 0xff]), (">i2", [0, 1, 0xff, 0xfe])] {
                let file = file(version, &header(descr, false, "(1, 1, 2)"), &bytes);
                let loaded = load(&file).unwrap();
                assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, -2]));
                assert!(loaded.notes.is_empty());
            }
        }
    }

    #[test]
    fn every_type() {
        let cases: [(&str, Vec<u8>, Samples); 12] = [
            ("|u1", vec![200], Samples::U8(vec![200])),
            ("|b1", vec![1], Samples::U8(vec![1])),
            ("|i1", vec![0xff], Samples::I8(vec![-1])),
            ("<u2", vec![1, 2], Samples::U16(vec![513])),
            (
                "=u2",
                513u16.to_ne_bytes().to_vec(),
                Samples::U16(vec![513]),
            ),
            ("<u4", vec![1, 2, 0, 0], Samples::U32(vec![513])),
            (">i4", vec![0xff; 4], Samples::I32(vec![-1])),
            (
                ">f4",
                1.5f32.to_be_bytes().to_vec(),
                Samples::F32(vec![1.5]),
            ),
            (
                "<f8",
                (-0.1f64).to_le_bytes().to_vec(),
                Samples::F64(vec![-0.1]),
            ),
            (
                ">i8",
                (-7i64).to_be_bytes().to_vec(),
                Samples::I32(vec![-7]),
            ),
            (
                "<u8",
                (1u64 << 40).to_le_bytes().to_vec(),
                Samples::F64(vec![1_099_511_627_776.0]),
            ),
            ("<f2", vec![0x00, 0xBE], Samples::F32(vec![-1.5])),
        ];
        for (descr, bytes, samples) in cases {
            let file = file(1, &header(descr, false, "(1, 1, 1)"), &bytes);
            assert_eq!(load(&file).unwrap().volume.samples(), &samples, "{descr}");
        }
        for (descr, advice) in [
            ("<c8", "magnitude"),
            ("<U7", "NumPy number type"),
            ("|O", "NumPy number type"),
        ] {
            let file = file(1, &header(descr, false, "(1, 1, 1)"), &[0; 32]);
            let message = load(&file).unwrap_err().to_string();
            assert!(message.contains(advice), "{message}");
        }
        let records = "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1, 1, 1)}";
        let message = load(&file(1, records, &[0; 4])).unwrap_err().to_string();
        assert!(message.contains("records"), "{message}");
    }

    #[test]
    fn x_is_the_axis_closest_in_memory() {
        let data: Vec<u8> = (0..24).collect();
        let c = load(&file(1, &header("|u1", false, "(2, 3, 4)"), &data)).unwrap();
        let fortran = load(&file(1, &header("|u1", true, "(4, 3, 2)"), &data)).unwrap();
        assert_eq!(c.volume.grid().dims(), [4, 3, 2]);
        assert_eq!(fortran.volume.grid().dims(), [4, 3, 2]);
        assert_eq!(c.volume.samples(), fortran.volume.samples());
        assert_eq!(c.volume.value(1, 0, 0), 1.0);
        assert!(fortran.notes[0].contains("Fortran"), "{:?}", fortran.notes);
    }

    #[test]
    fn axes_beyond_three() {
        let data: Vec<u8> = (0..24).collect();
        for (fortran, shape) in [(false, "(2, 2, 2, 3)"), (true, "(3, 2, 2, 2)")] {
            let file = file(1, &header("|u1", fortran, shape), &data);
            let second = load_at(&file, 1).unwrap();
            assert_eq!(second.volume.grid().dims(), [3, 2, 2]);
            assert_eq!(second.volume.value(0, 0, 0), 12.0);
            assert_eq!(second.volume.metadata().time_points, 2);
            let message = load_at(&file, 2).unwrap_err().to_string();
            assert!(
                message.contains("time point is 2; allowed: 0 to 1"),
                "{message}"
            );
        }
        let flat = load(&file(1, &header("|u1", false, "(4, 6)"), &data)).unwrap();
        assert_eq!(flat.volume.grid().dims(), [6, 4, 1]);
        assert!(flat.notes[0].contains("one slice"));
        for shape in ["()", "(24,)", "(1, 2, 3, 2, 2)"] {
            let message = load(&file(1, &header("|u1", false, shape), &data))
                .unwrap_err()
                .to_string();
            assert!(message.contains("number of axes"), "{message}");
        }
    }

    #[test]
    fn claims_beyond_the_file_are_refused() {
        for shape in [
            "(2, 3, 5)",
            "(1000000, 1000000, 1000000)",
            "(4294967296, 4294967296, 4294967296)",
            "(99999999999999999999, 1, 1)",
            "(0, 3, 4)",
            "(4611686018427387904, 1, 1)",
            "(-1, 3, 4)",
        ] {
            assert!(
                load(&file(1, &header("<f8", false, shape), &[0; 24])).is_err(),
                "{shape}"
            );
        }
        let mut long = file(2, &header("|u1", false, "(1, 1, 1)"), &[0]);
        long[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(
            load(&long)
                .unwrap_err()
                .to_string()
                .contains("header length")
        );
    }

    #[test]
    fn cut_off_at_every_length_is_an_error() {
        let whole = file(1, &header("<i2", false, "(2, 2, 2)"), &[0; 16]);
        for end in 0..whole.len() {
            assert!(load(&whole[..end]).is_err(), "{end} bytes");
        }
        assert!(load(&whole).is_ok());
    }

    proptest! {
        #[test]
        fn headers_in_any_python_dress_say_the_same(
            shape in proptest::collection::vec(0usize..1 << 40, 0..6),
            fortran: bool,
            big: bool,
            order in Just(["descr", "fortran_order", "shape"]).prop_shuffle(),
            space in prop_oneof![Just(""), Just(" "), Just("\n  ")],
            quote in prop_oneof![Just('\''), Just('"')],
            trailing: bool,
            long: bool,
        ) {
            let sizes: Vec<String> = shape
                .iter()
                .map(|n| format!("{n}{}", if long { "L" } else { "" }))
                .collect();
            let comma = if sizes.len() == 1 || trailing && !sizes.is_empty() { "," } else { "" };
            let value = |key: &str| match key {
                "descr" => format!("{quote}{}i2{quote}", if big { '>' } else { '<' }),
                "shape" => format!("({}{comma}{space})", sizes.join(&format!(",{space}"))),
                _ => if fortran { "True".to_owned() } else { "False".to_owned() },
            };
            let fields: Vec<String> = order
                .iter()
                .map(|key| format!("{quote}{key}{quote}{space}:{space}{}", value(key)))
                .collect();
            let end = if trailing { "," } else { "" };
            let text = format!("{{{}{end}{space}}}{space}", fields.join(&format!(",{space}")));
            let expected = Header {
                dtype: DType {
                    stored: Stored::Kept(SampleType::I16),
                    endian: if big { Endian::Big } else { Endian::Little },
                },
                fortran_order: fortran,
                shape,
                data_offset: 0,
            };
            prop_assert_eq!(parse_header(&text).unwrap(), expected);
        }

        #[test]
        fn any_header_text_is_read_or_refused(text in "[{}()',:<>|a-z0-9 L]{0,80}|.{0,60}") {
            let _ = parse_header(&text);
        }

        #[test]
        fn damaged_files_never_panic(
            at in proptest::collection::vec((0usize..200, any::<u8>()), 1..6),
        ) {
            let mut file = file(1, &header("<i2", false, "(2, 2, 2)"), &[0; 16]);
            for (at, byte) in at {
                let len = file.len();
                file[at % len] = byte;
            }
            let _ = load(&file);
        }
    }
}
