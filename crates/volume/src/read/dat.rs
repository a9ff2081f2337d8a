//! `.dat`: a text header beside a raw file, as OpenQVis, ImageVis3D and Inviwo write it.
//!
//! ```text
//! ObjectFileName: engine.raw      (Inviwo: RawFile)
//! Resolution:     256 256 128
//! SliceThickness: 1.0 1.0 2.0     (Inviwo: Spacing)
//! Format:         UCHAR           CHAR UCHAR SHORT USHORT INT UINT FLOAT DOUBLE, or UINT8 … FLOAT64
//! ObjectModel:    I               colors (RGB, RGBA, …) are not volumes of values
//! GridType:       EQUIDISTANT
//! Endianess:      LITTLE          (Inviwo: ByteOrder: LittleEndian)
//! ByteOffset:     0               bytes before the first sample
//! ```
//!
//! Keys in any case and order, `#` starts a comment. `USHORT` with 12 used bits stays `USHORT`.

use super::block::{Encoding, Endian};
use super::data_files;
use super::header_lines::{self, HeaderLines};
use super::raw::Layout;
use super::sniff::{self, Kind};
use super::{Bytes, Input, LoadedVolume, ReadOptions, unoriented};
use crate::error::{Error, ErrorKind};
use crate::{Metadata, Rescale, SampleType, Volume};

/// The key that names the file with the samples.
const RAW_FILE: &str = "ObjectFileName";

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let header = Header::read(input)?;
    let raw_name = header_lines::required(
        RAW_FILE,
        header.raw_file,
        "it names the file with the samples, such as `ObjectFileName: engine.raw`",
    )?;
    let dims = header_lines::required(
        "Resolution",
        header.dims,
        "three numbers of voxels, such as `Resolution: 256 256 128`",
    )?;
    let sample_type = header_lines::required(
        "Format",
        header.sample_type,
        "the type of a sample, such as `Format: UCHAR`",
    )?;
    let (spacing_mm, has_length_unit) =
        unoriented::spacing_mm(options, header.spacing.map(|spacing| (spacing, false)));
    let grid = unoriented::grid(dims, spacing_mm)?;
    let little = if options.raw.big_endian {
        Endian::Big
    } else {
        Endian::Little
    };
    let layout = Layout {
        dims,
        sample_type,
        endian: header.endian.unwrap_or(little),
        header_bytes: header.header_bytes,
    };

    let mut notes = Vec::new();
    let (raw_name, bytes) = data_files::open(input, RAW_FILE, &raw_name, &mut notes)?;
    let read = |bytes: &dyn Bytes| {
        let packed = raw_name.to_ascii_lowercase().ends_with(".gz")
            && sniff::kind(bytes)? == Some(Kind::Packed(Encoding::Gzip));
        let encoding = if packed {
            Encoding::Gzip
        } else {
            Encoding::Raw
        };
        layout.read(bytes, encoding)
    };
    let samples = read(&*bytes).map_err(|error| error.in_file(&raw_name))?;

    let volume = Volume::new(
        grid,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: ".dat".into(),
            has_length_unit,
            time_points: 1,
            entries: header.entries,
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}

#[derive(Default)]
struct Header {
    raw_file: Option<String>,
    dims: Option<[usize; 3]>,
    spacing: Option<[f64; 3]>,
    sample_type: Option<SampleType>,
    endian: Option<Endian>,
    header_bytes: u64,
    entries: Vec<(String, String)>,
}

impl Header {
    fn read(input: &Input) -> Result<Header, Error> {
        let mut header = Header::default();
        let mut lines = HeaderLines::new(input.bytes);
        while let Some(line) = lines.next_line()? {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let Some((key, value)) = line.split_once(':') else {
                return Err(Error::field(
                    "header line",
                    format!("`{}`", line.chars().take(60).collect::<String>()),
                    "`Key: value`",
                ));
            };
            header.set(key.trim(), value.trim())?;
        }
        Ok(header)
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), Error> {
        match key.to_ascii_lowercase().as_str() {
            "objectfilename" | "rawfile" => self.raw_file = Some(value.to_owned()),
            "resolution" => self.dims = Some(three(key, value)?),
            "slicethickness" | "spacing" => self.spacing = Some(three(key, value)?),
            "format" => self.sample_type = Some(sample_type(key, value)?),
            "objectmodel" => {
                let model = value.to_ascii_uppercase();
                if !matches!(model.as_str(), "I" | "DENSITY" | "") {
                    return Err(ErrorKind::Unsupported {
                        feature: format!("`{key}: {value}`"),
                        instead: "only gray values can be read (`I`); write one channel as a volume of its own".into(),
                    }
                    .into());
                }
            }
            "gridtype" => {
                let grid = value.to_ascii_uppercase();
                if !matches!(grid.as_str(), "EQUIDISTANT" | "UNIFORM" | "") {
                    return Err(ErrorKind::Unsupported {
                        feature: format!("`{key}: {value}`"),
                        instead: "resample to an even grid (`EQUIDISTANT`)".into(),
                    }
                    .into());
                }
            }
            "endianess" | "endianness" | "byteorder" => {
                let order = value.to_ascii_lowercase();
                self.endian = Some(if order.starts_with("big") {
                    Endian::Big
                } else if order.starts_with("little") {
                    Endian::Little
                } else {
                    return Err(Error::field(key, format!("`{value}`"), "LITTLE or BIG"));
                });
            }
            "byteoffset" => {
                self.header_bytes = header_lines::numbers(key, value, 1)?[0];
            }
            _ if value.is_empty() || value.chars().all(|c| c == '-') => {}
            _ => self.entries.push((key.to_owned(), value.to_owned())),
        }
        Ok(())
    }
}

fn three<T: std::str::FromStr + Copy>(key: &str, value: &str) -> Result<[T; 3], Error> {
    let numbers = header_lines::numbers(key, value, 3)?;
    Ok([numbers[0], numbers[1], numbers[2]])
}

fn sample_type(key: &str, value: &str) -> Result<SampleType, Error> {
    // `USHORT_12` says how many of the 16 bits are used.
    let name = value.split('_').next().unwrap_or_default();
    SampleType::from_name(name).ok_or_else(|| {
        Error::field(
            key,
            format!("`{value}`"),
            "UCHAR, CHAR, USHORT, SHORT, UINT, INT, FLOAT or DOUBLE",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples;
    use crate::read::{MemoryFiles, read_file};
    use std::io::Write;

    #[test]
    fn samples_in_a_folder_below_are_those_that_are_named() {
        let files = MemoryFiles::from([
            (
                "head.dat".to_owned(),
                HEADER
                    .replace("C:\\scans\\Head.raw", "data/head.raw")
                    .into_bytes(),
            ),
            ("head.raw".to_owned(), vec![0; SAMPLES.len()]),
            ("data/head.raw".to_owned(), SAMPLES.to_vec()),
        ]);
        let below = read_file("head.dat", &files, &ReadOptions::default()).unwrap();
        let beside = load(HEADER, ("head.raw", &SAMPLES)).unwrap();
        assert_eq!(below.volume.samples(), beside.volume.samples());
        let above = HEADER.replace("C:\\scans\\Head.raw", "../head.raw");
        let error = load(&above, ("head.raw", &SAMPLES))
            .unwrap_err()
            .to_string();
        assert!(error.contains("ObjectFileName is `../head.raw`"), "{error}");
    }

    fn load(header: &str, raw: (&str, &[u8])) -> Result<LoadedVolume, Error> {
        let files = MemoryFiles::from([
            ("head.dat".to_owned(), header.as_bytes().to_vec()),
            (raw.0.to_owned(), raw.1.to_vec()),
        ]);
        read_file("head.dat", &files, &ReadOptions::default())
    }

    const HEADER: &str = "ObjectFileName:\tC:\\scans\\Head.raw\r\nTaggedFileName: ---\r\n\
        Resolution:\t3 2 1\r\nSliceThickness:\t1 1 2.5\r\nFormat:\tUSHORT_12\r\nNbrTags: 0\r\n\
        ObjectType: TEXTURE_VOLUME_OBJECT\r\nObjectModel: I\r\nGridType: EQUIDISTANT\r\n";

    const SAMPLES: [u8; 12] = [1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 0xff, 0x0f];

    #[test]
    fn header_and_sibling() {
        let loaded = load(HEADER, ("head.raw", &SAMPLES)).unwrap();
        let volume = loaded.volume;
        assert_eq!(volume.samples(), &Samples::U16(vec![1, 2, 3, 4, 5, 4095]));
        assert_eq!(volume.grid().dims(), [3, 2, 1]);
        assert_eq!(volume.grid().spacing_mm().z, 2.5);
        assert!(
            volume
                .metadata()
                .entries
                .contains(&("NbrTags".into(), "0".into()))
        );
    }

    #[test]
    fn big_endian_packed_and_with_an_offset() {
        let header = "RawFile: v.raw.gz\nFormat: int16\nResolution: 2 1 1\nByteOrder: BigEndian\nByteOffset: 3\n";
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(&[9, 9, 9, 0, 1, 0xff, 0xfe]).unwrap();
        let gz = gz.finish().unwrap();
        let loaded = load(header, ("v.raw.gz", &gz)).unwrap();
        assert_eq!(loaded.volume.samples(), &Samples::I16(vec![1, -2]));
        for end in 0..gz.len() {
            assert!(load(header, ("v.raw.gz", &gz[..end])).is_err(), "{end}");
        }
    }

    #[test]
    fn messages_name_what_is_wrong() {
        let cases = [
            (
                HEADER.replace("ObjectFileName", "Other"),
                "ObjectFileName is missing",
            ),
            (
                HEADER.replace("Resolution", "Other"),
                "Resolution is missing",
            ),
            (HEADER.replace("Format", "Other"), "Format is missing"),
            (HEADER.replace("3 2 1", "3 2"), "Resolution is `3 2`"),
            (HEADER.replace("3 2 1", "3 0 1"), "dimension y is 0"),
            (HEADER.replace("2.5", "-1"), "spacing along z is -1"),
            (HEADER.replace("2.5", "NaN"), "spacing along z is NaN"),
            (HEADER.replace("USHORT_12", "UCHAR4"), "Format is `UCHAR4`"),
            (
                HEADER.replace("USHORT_12", "UCHAR"),
                "head.raw: file size is 12 bytes",
            ),
            (
                HEADER.replace("USHORT_12", "UCHAR"),
                "fits the types u16, i16",
            ),
            (HEADER.replace(": I", ": RGBA"), "`ObjectModel: RGBA`"),
            (HEADER.replace("EQUIDISTANT", "TETRAHEDRA"), "TETRAHEDRA"),
            (
                HEADER.replace("Head.raw", "Other.raw"),
                "there is no Other.raw",
            ),
            (
                HEADER.replace("NbrTags: 0", "no colon here"),
                "`no colon here`",
            ),
            (
                HEADER.replace("3 2 1", "1000000 1000000 1000000"),
                "head.raw: file size is 12 bytes",
            ),
        ];
        for (header, expected) in cases {
            let message = load(&header, ("head.raw", &SAMPLES))
                .unwrap_err()
                .to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn cut_off_headers_and_samples_are_errors() {
        for end in 0..HEADER.find("NbrTags").unwrap() - 8 {
            let whole_samples = load(&HEADER[..end], ("head.raw", &SAMPLES));
            assert!(whole_samples.is_err(), "header of {end} bytes");
        }
        for end in 0..SAMPLES.len() {
            assert!(load(HEADER, ("head.raw", &SAMPLES[..end])).is_err());
        }
    }
}
