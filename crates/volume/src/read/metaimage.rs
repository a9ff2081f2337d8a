//! MetaImage: `.mha` (header and samples in one file) and `.mhd` (a header that names files).
//!
//! A text header of `Key = value` lines; `ElementDataFile` ends it.
//!
//! | key                                            | taken as                                       |
//! |------------------------------------------------|------------------------------------------------|
//! | `NDims`, `DimSize`                             | lengths of the axes, fastest first; the 4th is time |
//! | `ElementType`                                  | `MET_UCHAR`, `MET_SHORT`, …; `MET_LONG` has 4 bytes |
//! | `BinaryData`                                   | `False`: numbers as text (default `True`)      |
//! | `BinaryDataByteOrderMSB`, `ElementByteOrderMSB`| `True`: big endian (default `False`)           |
//! | `CompressedData`                               | `True`: zlib (or gzip)                         |
//! | `TransformMatrix`, `Orientation`, `Rotation`   | row i is the direction of grid axis i in LPS   |
//! | `Offset`, `Position`, `Origin`                 | of the first voxel's center in LPS             |
//! | `ElementSpacing`, `ElementSize`                | distance of voxels; the first given counts     |
//! | `DistanceUnits`                                | mm (default), cm, um                           |
//! | `ElementToIntensityFunctionSlope`, `…Offset`   | value = slope · stored + offset                |
//! | `HeaderSize`                                   | bytes before the samples; −1: samples at the end |
//! | `Modality`                                     | `MET_MOD_CT`, …                                |
//! | `ElementNumberOfChannels`                      | numbers per voxel, side by side                |
//! | `ElementDataFile`                              | `LOCAL`; a name; `LIST [n]` and names to the end; `pattern first last step` |
//!
//! Other keys are kept as they are. As in ITK, `CenterOfRotation` and `AnatomicalOrientation` change
//! nothing: the matrix already says all.

use super::block::{Encoding, Endian};
use super::components::{self, Meaning};
use super::data_files::{self, ByteSkip, Place, Storage};
use super::header_lines::{HeaderLines, numbers, required};
use super::nrrd::modality_of;
use super::stored::Stored;
use super::{Input, LoadedVolume, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Metadata, Rescale, SampleType, Volume};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeMap;

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let header = Header::parse(input)?;
    let stored = header.sample_type()?;
    let mut notes = Vec::new();
    let channels = header
        .number::<usize>("ElementNumberOfChannels")?
        .unwrap_or(1);
    if channels == 0 {
        return Err(Error::field(
            "ElementNumberOfChannels",
            channels,
            "1 or more",
        ));
    }
    let meaning = match stored {
        Stored::Kept(SampleType::U8) => Meaning::Color,
        _ => Meaning::Vector,
    };
    let choice = components::choice(channels, meaning, options, &mut notes)?;
    let sizes = header.sizes()?;
    let dims = std::array::from_fn(|axis| sizes.get(axis).copied().unwrap_or(1));
    let time_points = sizes.get(3).copied().unwrap_or(1);
    let grid = Grid::new(dims, header.world_from_voxel(sizes.len())?)?;
    if options.time_index >= time_points {
        return Err(Error::field(
            "time point",
            options.time_index,
            match time_points {
                1 => "0: the file holds a single volume".to_owned(),
                n => format!("0 to {}", n - 1),
            },
        ));
    }
    let count = components::total(grid.voxel_count(), channels)?;
    let total = count
        .checked_mul(time_points)
        .filter(|&n| n <= isize::MAX as usize)
        .ok_or_else(|| {
            Error::field(
                "DimSize",
                format!("{sizes:?}"),
                "fewer samples than this machine can address",
            )
        })?;
    let start = options.time_index * count;
    let range = start..start + count;
    let samples = header
        .storage()?
        .read(input, stored, total, range, &mut notes)?;
    let samples = components::reduced(samples, channels, choice);

    let rescale = Rescale::new(
        header
            .number("ElementToIntensityFunctionSlope")?
            .unwrap_or(1.0),
        header
            .number("ElementToIntensityFunctionOffset")?
            .unwrap_or(0.0),
    );
    let metadata = Metadata {
        components: meaning.of(channels),
        ..header.metadata(input.name, time_points, options.time_index)
    };
    Ok(LoadedVolume {
        volume: Volume::new(grid, samples, rescale, metadata)?,
        labels: None,
        notes,
    })
}

struct Header {
    /// By lower-case key.
    fields: BTreeMap<String, String>,
    /// As written, for the keys that are only kept.
    entries: Vec<(String, String)>,
    /// Position behind `ElementDataFile`.
    end: u64,
    /// The names after `ElementDataFile = LIST`.
    listed: Vec<String>,
}

impl Header {
    fn parse(input: &Input) -> Result<Header, Error> {
        const KNOWN: [&str; 24] = [
            "objecttype",
            "ndims",
            "dimsize",
            "elementtype",
            "binarydata",
            "binarydatabyteordermsb",
            "elementbyteordermsb",
            "compresseddata",
            "compresseddatasize",
            "transformmatrix",
            "orientation",
            "rotation",
            "offset",
            "position",
            "origin",
            "elementspacing",
            "elementsize",
            "distanceunits",
            "elementtointensityfunctionslope",
            "elementtointensityfunctionoffset",
            "headersize",
            "modality",
            "elementnumberofchannels",
            "elementdatafile",
        ];
        let mut lines = HeaderLines::new(input.bytes);
        let mut header = Header {
            fields: BTreeMap::new(),
            entries: Vec::new(),
            end: 0,
            listed: Vec::new(),
        };
        while let Some(line) = lines.next_line()? {
            if line.trim().is_empty() {
                continue;
            }
            let Some((key, value)) = line.split_once(['=', ':']) else {
                return Err(Error::field(
                    "a header line",
                    format!("`{}`", line.chars().take(60).collect::<String>()),
                    "`Key = value`; `ElementDataFile` ends the header",
                ));
            };
            let (key, value) = (key.trim(), value.trim());
            let lower = key.to_ascii_lowercase();
            if !KNOWN.contains(&lower.as_str()) {
                header.entries.push((key.to_owned(), value.to_owned()));
                continue;
            }
            let is_last = lower == "elementdatafile";
            match header.fields.insert(lower, value.to_owned()) {
                Some(before) if before != value => {
                    return Err(Error::field(
                        key,
                        format!("given twice, as `{before}` and as `{value}`"),
                        "each key once",
                    ));
                }
                _ => {}
            }
            if is_last {
                header.end = lines.position();
                if value
                    .split_whitespace()
                    .next()
                    .is_some_and(|word| word.eq_ignore_ascii_case("LIST"))
                {
                    while let Some(line) = lines.next_line()? {
                        if !line.trim().is_empty() {
                            header.listed.push(line.trim().to_owned());
                        }
                    }
                }
                break;
            }
        }
        if let Some(kind) = header.get("ObjectType")
            && !kind.eq_ignore_ascii_case("Image")
        {
            return Err(Error::field("ObjectType", format!("`{kind}`"), "Image"));
        }
        Ok(header)
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.fields
            .get(&key.to_ascii_lowercase())
            .map(String::as_str)
    }

    /// The first of several names for the same thing that is given.
    fn first<'a>(&self, keys: &[&'a str]) -> Option<(&'a str, &str)> {
        keys.iter().find_map(|&key| Some((key, self.get(key)?)))
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<Option<T>, Error> {
        match self.get(key) {
            Some(text) => Ok(numbers(key, text, 1)?.pop()),
            None => Ok(None),
        }
    }

    fn truth(&self, key: &str) -> Result<Option<bool>, Error> {
        match self.get(key).map(str::to_ascii_lowercase).as_deref() {
            None => Ok(None),
            Some("true" | "t" | "yes" | "1") => Ok(Some(true)),
            Some("false" | "f" | "no" | "0") => Ok(Some(false)),
            Some(other) => Err(Error::field(key, format!("`{other}`"), "True or False")),
        }
    }

    fn sizes(&self) -> Result<Vec<usize>, Error> {
        let rank = required("NDims", self.number::<usize>("NDims")?, "2, 3 or 4")?;
        if !(2..=4).contains(&rank) {
            return Err(Error::field("NDims", rank, "2, 3 or 4"));
        }
        let text = required("DimSize", self.get("DimSize"), "the length of each axis")?;
        let sizes = numbers::<usize>("DimSize", text, rank)?;
        if sizes.contains(&0) {
            return Err(Error::field(
                "DimSize",
                format!("{sizes:?}"),
                "1 or more each",
            ));
        }
        Ok(sizes)
    }

    fn sample_type(&self) -> Result<Stored, Error> {
        let text = required("ElementType", self.get("ElementType"), "such as MET_SHORT")?;
        Ok(Stored::Kept(match text.to_ascii_uppercase().as_str() {
            "MET_CHAR" => SampleType::I8,
            "MET_UCHAR" => SampleType::U8,
            "MET_SHORT" => SampleType::I16,
            "MET_USHORT" => SampleType::U16,
            "MET_INT" | "MET_LONG" => SampleType::I32,
            "MET_UINT" | "MET_ULONG" => SampleType::U32,
            "MET_FLOAT" => SampleType::F32,
            "MET_DOUBLE" => SampleType::F64,
            "MET_LONG_LONG" => return Ok(Stored::I64),
            "MET_ULONG_LONG" => return Ok(Stored::U64),
            _ => {
                return Err(Error::field(
                    "ElementType",
                    format!("`{text}`"),
                    "MET_CHAR, MET_UCHAR, MET_SHORT, MET_USHORT, MET_INT, MET_UINT, MET_FLOAT or MET_DOUBLE",
                ));
            }
        }))
    }

    fn world_from_voxel(&self, rank: usize) -> Result<DAffine3, Error> {
        let places = rank.min(3);
        let mut directions = DMat3::IDENTITY;
        if let Some((key, text)) = self.first(&["TransformMatrix", "Orientation", "Rotation"]) {
            let matrix = numbers::<f64>(key, text, rank * rank)?;
            for axis in 0..places {
                for component in 0..places {
                    directions.col_mut(axis)[component] = matrix[axis * rank + component];
                }
            }
        }
        let mut spacing = DVec3::ONE;
        if let Some((key, text)) = self.first(&["ElementSpacing", "ElementSize"]) {
            let numbers = numbers::<f64>(key, text, rank)?;
            for axis in 0..places {
                spacing[axis] = numbers[axis];
            }
        }
        let mut offset = DVec3::ZERO;
        if let Some((key, text)) = self.first(&["Offset", "Position", "Origin"]) {
            let numbers = numbers::<f64>(key, text, rank)?;
            for axis in 0..places {
                offset[axis] = numbers[axis];
            }
        }
        let unit = match self
            .get("DistanceUnits")
            .map(str::to_ascii_lowercase)
            .as_deref()
        {
            None | Some("mm" | "?") => 1.0,
            Some("cm") => 10.0,
            Some("um") => 1e-3,
            Some(other) => {
                return Err(Error::field(
                    "DistanceUnits",
                    format!("`{other}`"),
                    "mm, cm or um",
                ));
            }
        };
        let ras_from_lps = DMat3::from_diagonal(DVec3::new(-unit, -unit, unit));
        Ok(DAffine3::from_mat3_translation(
            ras_from_lps * directions * DMat3::from_diagonal(spacing),
            ras_from_lps * offset,
        ))
    }

    fn storage(&self) -> Result<Storage, Error> {
        let is_binary = self.truth("BinaryData")?.unwrap_or(true);
        let is_packed = self.truth("CompressedData")?.unwrap_or(false);
        let big = self.truth("BinaryDataByteOrderMSB")?;
        let big = big.or(self.truth("ElementByteOrderMSB")?).unwrap_or(false);
        let encoding = match (is_binary, is_packed) {
            (true, false) => Encoding::Raw,
            (true, true) => Encoding::Zlib,
            (false, false) => Encoding::Ascii,
            (false, true) => {
                return Err(ErrorKind::Unsupported {
                    feature: "CompressedData = True with BinaryData = False".into(),
                    instead: "write compressed samples as binary".into(),
                }
                .into());
            }
        };
        let byte_skip = match self.number::<i64>("HeaderSize")?.unwrap_or(0) {
            -1 if encoding == Encoding::Raw => ByteSkip::AllButTheEnd,
            size => ByteSkip::Front(u64::try_from(size).map_err(|_| {
                Error::field(
                    "HeaderSize",
                    size,
                    "0 or more; −1 (samples at the end) for binary data that is not compressed",
                )
            })?),
        };
        Ok(Storage {
            place: self.place()?,
            field: "ElementDataFile",
            encoding,
            endian: if big { Endian::Big } else { Endian::Little },
            line_skip: 0,
            byte_skip,
        })
    }

    fn place(&self) -> Result<Place, Error> {
        let text = required(
            "ElementDataFile",
            self.get("ElementDataFile").filter(|text| !text.is_empty()),
            "LOCAL, a file name, LIST, or a pattern with first, last and step",
        )?;
        let words: Vec<&str> = text.split_whitespace().collect();
        if text.eq_ignore_ascii_case("LOCAL") {
            return Ok(Place::After(self.end));
        }
        if words[0].eq_ignore_ascii_case("LIST") {
            return Ok(Place::Files(self.listed.clone()));
        }
        if let [pattern, first, last, step] = words[..]
            && pattern.contains('%')
        {
            let field = "ElementDataFile";
            let span = numbers::<i64>(field, &format!("{first} {last} {step}"), 3)?;
            return Ok(Place::Files(data_files::numbered(
                field, pattern, span[0], span[1], span[2],
            )?));
        }
        Ok(Place::Files(vec![text.to_owned()]))
    }

    fn metadata(&self, name: &str, time_points: usize, time_index: usize) -> Metadata {
        let modality = self
            .get("Modality")
            .and_then(|text| modality_of(text.trim_start_matches("MET_MOD_")));
        Metadata {
            name: name.to_owned(),
            format: "MetaImage".into(),
            modality,
            has_length_unit: self
                .first(&["DistanceUnits", "ElementSpacing", "ElementSize"])
                .is_some(),
            time_points,
            time_index,
            entries: self.entries.clone(),
            ..Metadata::default()
        }
    }
}
