//! PVM volumes of the V^3 package (S. Roettger), versions 1 to 3, plain or DDS-compressed.
//!
//! ```text
//! "PVM\n"                              "PVM2\n" or "PVM3\n"
//! "<width> <height> <depth>\n"         "<width> <height> <depth>\n"
//!                                      "<scale x> <scale y> <scale z>\n"
//! "<components>\n"                     "<components>\n"
//! width · height · depth · components bytes, x fastest; 2 components are one 16-bit number, the
//! most significant byte first
//! PVM3: four texts, each ended by a zero byte: description, courtesy, parameter, comment
//! ```
//!
//! The scale is relative: a spacing without a unit.

mod dds;

use super::block::{Block, Endian};
use super::{Bytes, Input, LoadedVolume, ReadOptions, unoriented};
use crate::error::{Error, ErrorKind};
use crate::{Metadata, Rescale, SampleType, Samples, Volume, memory, voxel_count};
use dds::Stream;

/// No header is longer: the writers print it into 256 bytes.
const LONGEST_HEADER: usize = 1024;

/// Descriptions are kept up to here; the writers allow 256 bytes for each.
const LONGEST_TEXTS: u64 = 1 << 16;

const TEXTS: [&str; 4] = ["description", "courtesy", "parameter", "comment"];

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let content = match Stream::open(input.bytes)? {
        Some(stream) => Content::open(stream)?,
        None => Content::Plain(input.bytes),
    };
    let header = Header::parse(&content.head()?)?;
    let total = content.len();
    let expected = header.sample_bytes;
    let start = header.bytes as u64;
    let found = total.saturating_sub(start);
    if found < expected {
        return Err(ErrorKind::Truncated {
            what: "the sample data".into(),
            expected,
            found,
        }
        .into());
    }
    let (samples, texts) = content.samples(&header)?;

    let mut notes = Vec::new();
    let mut entries = Vec::new();
    if header.version == 3 {
        for (key, text) in TEXTS.iter().zip(texts.split(|&c| c == 0)) {
            let text = String::from_utf8_lossy(text).trim().to_owned();
            if !text.is_empty() {
                entries.push((key.to_string(), text));
            }
        }
    } else if found > expected {
        notes.push(format!(
            "{} bytes after the samples are ignored",
            found - expected
        ));
    }
    let (spacing_mm, has_length_unit) =
        unoriented::spacing_mm(options, header.scale.map(|scale| (scale, false)));
    let volume = Volume::new(
        unoriented::grid(header.dims, spacing_mm)?,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: format!("PVM version {}", header.version),
            has_length_unit,
            time_points: 1,
            entries,
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}

#[derive(Debug)]
struct Header {
    version: u32,
    dims: [usize; 3],
    scale: Option<[f64; 3]>,
    sample_type: SampleType,
    /// Bytes of all samples.
    sample_bytes: u64,
    /// Bytes of the header itself.
    bytes: usize,
}

impl Header {
    fn parse(head: &[u8]) -> Result<Header, Error> {
        let mut at = 0;
        let mut line = |field: &str| -> Result<&str, Error> {
            let rest = &head[at..];
            let end = rest.iter().position(|&c| c == b'\n').ok_or_else(|| {
                Error::from(ErrorKind::Missing {
                    field: format!("the header line `{field}`"),
                    allowed: "a PVM header is lines of text: magic, sizes, (scales,) components"
                        .into(),
                })
            })?;
            at += end + 1;
            std::str::from_utf8(&rest[..end])
                .map(str::trim)
                .map_err(|_| Error::field(field, rest[..end].escape_ascii(), "text"))
        };
        let magic = line("magic")?;
        let version = match magic {
            "PVM" => 1,
            "PVM2" => 2,
            "PVM3" => 3,
            _ => {
                return Err(Error::field(
                    "magic",
                    format!("`{}`", magic.escape_debug()),
                    "PVM, PVM2 or PVM3",
                ));
            }
        };
        let sizes = line("width height depth")?;
        let dims = numbers::<usize>(sizes)
            .filter(|dims| dims.iter().all(|&n| n > 0))
            .ok_or_else(|| {
                Error::field(
                    "width height depth",
                    format!("`{sizes}`"),
                    "three whole numbers above 0",
                )
            })?;
        let scale = if version == 1 {
            None
        } else {
            let scales = line("scale")?;
            let scale = numbers::<f64>(scales)
                .filter(|scale| scale.iter().all(|s| s.is_finite() && *s > 0.0))
                .ok_or_else(|| {
                    Error::field("scale", format!("`{scales}`"), "three numbers above 0")
                })?;
            Some(scale)
        };
        let components = line("components")?;
        let sample_type = match components {
            "1" => SampleType::U8,
            "2" => SampleType::U16,
            "3" | "4" => {
                return Err(ErrorKind::Unsupported {
                    feature: format!("a PVM volume of colors ({components} components)"),
                    instead: "write one channel as a volume of its own".into(),
                }
                .into());
            }
            _ => {
                return Err(Error::field(
                    "components",
                    format!("`{components}`"),
                    "1 (8-bit samples) or 2 (16-bit samples)",
                ));
            }
        };
        let sample_bytes = voxel_count(dims)
            .and_then(|n| n.checked_mul(sample_type.size()))
            .ok_or_else(|| {
                Error::field(
                    "width height depth",
                    format!("`{sizes}`"),
                    "fewer voxels than this machine can address",
                )
            })? as u64;
        Ok(Header {
            version,
            dims,
            scale,
            sample_type,
            sample_bytes,
            bytes: at,
        })
    }
}

fn numbers<T: std::str::FromStr>(line: &str) -> Option<[T; 3]> {
    let numbers: Vec<T> = line
        .split_ascii_whitespace()
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    numbers.try_into().ok()
}

/// Header, samples and texts, compressed or not.
enum Content<'a> {
    Plain(&'a dyn Bytes),
    Packed { stream: Stream<'a>, total: u64 },
}

impl<'a> Content<'a> {
    fn open(stream: Stream<'a>) -> Result<Content<'a>, Error> {
        let total = stream.decoded_len()?;
        Ok(Content::Packed { stream, total })
    }

    fn len(&self) -> u64 {
        match self {
            Content::Plain(bytes) => bytes.len(),
            Content::Packed { total, .. } => *total,
        }
    }

    fn head(&self) -> Result<Vec<u8>, Error> {
        let mut head = vec![0; self.len().min(LONGEST_HEADER as u64) as usize];
        match self {
            Content::Plain(bytes) => bytes.read_at(0, &mut head)?,
            Content::Packed { stream, total } => {
                // With interleaved planes the header's second half lies in the middle of the stream.
                let mut missing = head.len();
                stream.decode(*total, |place, byte| {
                    if let Some(slot) = head.get_mut(place as usize) {
                        *slot = byte;
                        missing -= 1;
                    }
                    missing > 0
                })?;
            }
        }
        Ok(head)
    }

    /// The samples, and what comes after them as far as it is kept. The caller has checked that
    /// there is as much data as the header says.
    fn samples(&self, header: &Header) -> Result<(Samples, Vec<u8>), Error> {
        let start = header.bytes as u64;
        let end = start + header.sample_bytes;
        let count = header.dims.iter().product();
        let mut texts = vec![0; (self.len() - end).min(LONGEST_TEXTS) as usize];
        match self {
            Content::Plain(bytes) => {
                let block = Block {
                    endian: Endian::Big,
                    ..Block::raw(*bytes, start)
                };
                let samples = block.read(header.sample_type, count)?;
                bytes.read_at(end, &mut texts)?;
                Ok((samples, texts))
            }
            Content::Packed { stream, total } => {
                // The bytes go straight to where the samples stay; the file really holds them all.
                stream.keep(header.sample_bytes)?;
                let mut small = Vec::new();
                let mut wide = Vec::new();
                let bytes: &mut [u8] = match header.sample_type {
                    SampleType::U8 => {
                        small = memory::zeroed::<u8>(count)?;
                        &mut small
                    }
                    _ => {
                        wide = memory::zeroed::<u16>(count)?;
                        bytemuck::cast_slice_mut(&mut wide)
                    }
                };
                stream.decode(*total, |place, byte| {
                    if place >= start {
                        let place = (place - start) as usize;
                        if let Some(slot) = bytes.get_mut(place) {
                            *slot = byte;
                        } else if let Some(slot) = texts.get_mut(place - bytes.len()) {
                            *slot = byte;
                        }
                    }
                    true
                })?;
                for sample in &mut wide {
                    *sample = u16::from_be(*sample);
                }
                let samples = match header.sample_type {
                    SampleType::U8 => Samples::U8(small),
                    _ => Samples::U16(wide),
                };
                Ok((samples, texts))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::MemoryFiles;
    use proptest::prelude::*;

    fn load(file: &[u8]) -> Result<LoadedVolume, Error> {
        let input = Input {
            name: "test.pvm",
            bytes: &file,
            files: &MemoryFiles::new(),
        };
        read(&input, &ReadOptions::default())
    }

    fn wide_samples() -> Vec<u16> {
        (0..7 * 5 * 3).map(|i| (i * i % 4096) as u16).collect()
    }

    /// A version 3 file of 7×5×3 16-bit samples, not compressed.
    fn wide_file() -> Vec<u8> {
        let mut file = b"PVM3\n7 5 3\n0.5 0.5 1.25\n2\n".to_vec();
        file.extend(wide_samples().iter().flat_map(|s| s.to_be_bytes()));
        file.extend(b"a head\0courtesy of someone\0\0scanned twice\0");
        file
    }

    #[test]
    fn version_3_plain_and_compressed_are_the_same() {
        let plain = wide_file();
        for file in [
            plain.clone(),
            dds::encode::dds(&plain, 2, 7, false, 127),
            dds::encode::dds(&plain, 2, 7, true, 127),
            dds::encode::dds(&plain, 1, 14, false, 3),
        ] {
            let loaded = load(&file).unwrap();
            let volume = loaded.volume;
            assert_eq!(volume.samples(), &Samples::U16(wide_samples()));
            assert_eq!(volume.grid().dims(), [7, 5, 3]);
            let spacing = volume.grid().spacing_mm();
            assert_eq!(spacing, glam::DVec3::new(0.5, 0.5, 1.25));
            let entry = |key: &str, text: &str| (key.to_owned(), text.to_owned());
            assert_eq!(
                volume.metadata().entries,
                [
                    entry("description", "a head"),
                    entry("courtesy", "courtesy of someone"),
                    entry("comment", "scanned twice"),
                ]
            );
            assert!(loaded.notes.is_empty());
        }
    }

    #[test]
    fn versions_1_and_2() {
        let samples: Vec<u8> = (0..24).collect();
        let mut file = b"PVM\n4 3 2\n1\n".to_vec();
        file.extend(&samples);
        let loaded = load(&dds::encode::dds(&file, 1, 4, false, 127)).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::U8(samples.clone()));
        assert_eq!(loaded.volume.metadata().format, "PVM version 1");

        let mut file = b"PVM2\n4 3 2\n1 1 2.5\n1\n".to_vec();
        file.extend(&samples);
        file.push(9);
        let loaded = load(&dds::encode::dds(&file, 1, 4, false, 127)).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::U8(samples));
        assert_eq!(loaded.volume.grid().spacing_mm().z, 2.5);
        assert_eq!(loaded.notes, ["1 bytes after the samples are ignored"]);
    }

    #[test]
    fn headers_that_cannot_be_are_named() {
        let cases = [
            ("PVM\n0 3 2\n1\n", "width height depth is `0 3 2`"),
            ("PVM\n4 3\n1\n", "width height depth is `4 3`"),
            ("PVM\n-4 3 2\n1\n", "width height depth is `-4 3 2`"),
            ("PVM\n99999999999 99999999999 99999999999\n1\n", "address"),
            ("PVM\n65535 65535 65535\n1\n", "281462092005375 bytes"),
            ("PVM2\n4 3 2\n1 0 1\n1\n", "scale is `1 0 1`"),
            ("PVM2\n4 3 2\n1 nan 1\n1\n", "scale is `1 nan 1`"),
            ("PVM\n4 3 2\n3\n", "colors"),
            ("PVM\n4 3 2\n7\n", "components is `7`"),
            ("PVM\n4 3 2", "missing"),
            ("PVM4\n4 3 2\n1\n", "magic is `PVM4`"),
        ];
        for (file, expected) in cases {
            for file in [
                file.as_bytes().to_vec(),
                dds::encode::dds(file.as_bytes(), 1, 4, false, 127),
            ] {
                let message = load(&file).unwrap_err().to_string();
                assert!(message.contains(expected), "{message}");
            }
        }
    }

    #[test]
    fn cut_off_at_every_length_is_an_error() {
        let plain = wide_file();
        let texts = plain.len() - 42;
        for end in 0..texts {
            assert!(load(&plain[..end]).is_err(), "plain, {end} bytes");
        }
        let packed = dds::encode::dds(&plain[..texts], 2, 7, false, 127);
        for end in 0..packed.len() {
            assert!(load(&packed[..end]).is_err(), "packed, {end} bytes");
        }
    }

    proptest! {
        #[test]
        fn damaged_files_never_panic(
            at in proptest::collection::vec((0usize..400, any::<u8>()), 1..8),
            interleave in 1usize..=2,
        ) {
            let mut file = dds::encode::dds(&wide_file(), interleave, 7, false, 127);
            for (at, byte) in at {
                let len = file.len();
                file[at % len] = byte;
            }
            let _ = load(&file);
        }
    }
}
