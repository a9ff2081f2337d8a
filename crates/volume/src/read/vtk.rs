//! Structured points of VTK's legacy files (`.vtk`): a text header, then samples as text or as big-endian bytes.
//!
//! | line                                   | meaning                                                          |
//! |----------------------------------------|------------------------------------------------------------------|
//! | `# vtk DataFile Version 3.0`           | magic                                                            |
//! | a title                                | kept                                                             |
//! | `ASCII` or `BINARY`                    | how samples are written                                          |
//! | `DATASET STRUCTURED_POINTS`            | other data sets are refused                                      |
//! | `DIMENSIONS`, `ORIGIN`, `SPACING`      | points along x, y, z; of the first; between them (also `ASPECT_RATIO`) |
//! | `POINT_DATA n`, `CELL_DATA n`          | what follows belongs to points, or to the cells between them     |
//! | `SCALARS name type [n]`, `LOOKUP_TABLE name` | the samples follow                                         |
//! | `FIELD name n`, then `name 1 n type`   | the samples follow                                               |
//!
//! Axes are taken as left, back, up (LPS), as ITK does.

use super::block::{Block, Encoding, Endian, Trailing};
use super::components::{self, Meaning};
use super::header_lines::{HeaderLines, numbers, required};
use super::stored::Stored;
use super::{Input, LoadedVolume, ReadOptions, unoriented};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Metadata, Rescale, SampleType, Samples, Volume, voxel_count};
use glam::{DAffine3, DVec3};

/// How VTK calls a type.
pub(crate) fn sample_type(name: &str) -> Result<Stored, Error> {
    Ok(match name.to_ascii_lowercase().as_str() {
        "unsigned_char" | "uint8" => Stored::Kept(SampleType::U8),
        "char" | "signed_char" | "int8" => Stored::Kept(SampleType::I8),
        "unsigned_short" | "uint16" => Stored::Kept(SampleType::U16),
        "short" | "int16" => Stored::Kept(SampleType::I16),
        "unsigned_int" | "uint32" => Stored::Kept(SampleType::U32),
        "int" | "int32" => Stored::Kept(SampleType::I32),
        "float" | "float32" => Stored::Kept(SampleType::F32),
        "double" | "float64" => Stored::Kept(SampleType::F64),
        // Written with the width of the machine; today that is 64 bits.
        "long" | "vtktypeint64" | "vtkidtype" | "long_long" | "int64" => Stored::I64,
        "unsigned_long" | "vtktypeuint64" | "unsigned_long_long" | "uint64" => Stored::U64,
        _ => {
            return Err(Error::field(
                "the type of the samples",
                format!("`{name}`"),
                "char, short, int, long (unsigned or not), float or double; bits and texts are not read",
            ));
        }
    })
}

/// The grid of an image: `dims` points, or the cells between them.
pub(crate) fn grid(
    points: [usize; 3],
    is_of_cells: bool,
    origin: DVec3,
    lps_from_voxel: glam::DMat3,
) -> Result<Grid, Error> {
    let mut dims = points;
    let mut first = DVec3::ZERO;
    if is_of_cells {
        for (axis, dim) in dims.iter_mut().enumerate().filter(|(_, dim)| **dim > 1) {
            *dim -= 1;
            first[axis] = 0.5;
        }
    }
    let ras_from_lps = glam::DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    Grid::new(
        dims,
        DAffine3::from_mat3_translation(
            ras_from_lps * lps_from_voxel,
            ras_from_lps * (origin + lps_from_voxel * first),
        ),
    )
}

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let header = Header::parse(input)?;
    let grid = header.grid(options)?;
    let mut notes = header.notes;
    notes.push("VTK files do not state the patient's orientation; the axes are read as left, back, up (LPS), as by ITK".into());
    let count = grid.voxel_count();
    if count != header.count {
        return Err(Error::field(
            "the number of samples",
            header.count,
            format!("{count}, for {:?} voxels", grid.dims()),
        ));
    }
    let choice = components::choice(
        header.components,
        meaning(header.stored),
        options,
        &mut notes,
    )?;
    let count = components::total(count, header.components)?;
    let block = Block {
        encoding: match header.is_text {
            true => Encoding::Ascii,
            false => Encoding::Raw,
        },
        endian: Endian::Big,
        // Other arrays follow.
        trailing: Trailing::Ignored,
        ..Block::raw(input.bytes, header.data)
    };
    let stored = header.stored;
    let samples: Samples = match header.is_text {
        true => stored.kept_of_text(block.read(stored.of_text(), count)?, &mut notes)?,
        false => stored.kept_of_bits(block.read(stored.bits(), count)?, input.bytes, &mut notes)?,
    };
    let samples = components::reduced(samples, header.components, choice);
    let volume = Volume::new(
        grid,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: "VTK".into(),
            has_length_unit: options.spacing_mm.is_some(),
            time_points: 1,
            components: meaning(stored).of(header.components),
            entries: vec![("title".into(), header.title)],
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}

struct Header {
    title: String,
    is_text: bool,
    points: Option<[usize; 3]>,
    origin: [f64; 3],
    spacing: [f64; 3],
    is_of_cells: bool,
    stored: Stored,
    /// Numbers per voxel.
    components: usize,
    /// Voxels said, and where the samples begin.
    count: usize,
    data: u64,
    notes: Vec<String>,
}

impl Header {
    fn parse(input: &Input) -> Result<Header, Error> {
        let mut lines = HeaderLines::new(input.bytes);
        lines.next_line()?;
        let title = lines.next_line()?.unwrap_or_default().trim().to_owned();
        let coding = lines
            .next_line()?
            .unwrap_or_default()
            .trim()
            .to_ascii_uppercase();
        let is_text = match coding.as_str() {
            "ASCII" => true,
            "BINARY" => false,
            _ => {
                return Err(Error::field(
                    "the third line",
                    format!("`{coding}`"),
                    "ASCII or BINARY",
                ));
            }
        };
        let mut header = Header {
            title,
            is_text,
            points: None,
            origin: [0.0; 3],
            spacing: [1.0; 3],
            is_of_cells: false,
            stored: Stored::Kept(SampleType::U8),
            components: 1,
            count: 0,
            data: 0,
            notes: Vec::new(),
        };
        let mut count = None;
        let mut skipped = Vec::new();
        while let Some(line) = lines.next_line()? {
            let line = line.trim();
            let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let triple = |text: &str| numbers::<f64>(key, text, 3).map(|n| [n[0], n[1], n[2]]);
            match key.to_ascii_uppercase().as_str() {
                "DATASET" if rest.trim().eq_ignore_ascii_case("STRUCTURED_POINTS") => {}
                "DATASET" => return Err(other_data_set(rest.trim())),
                "DIMENSIONS" => {
                    let n = numbers::<usize>(key, rest, 3)?;
                    header.points = Some([n[0], n[1], n[2]]);
                }
                "ORIGIN" => header.origin = triple(rest)?,
                "SPACING" | "ASPECT_RATIO" => header.spacing = triple(rest)?,
                "POINT_DATA" | "CELL_DATA" => {
                    header.is_of_cells = key.eq_ignore_ascii_case("CELL_DATA");
                    count = Some(numbers::<usize>(key, rest, 1)?[0]);
                }
                "SCALARS" if count.is_some() => {
                    header.scalars(rest, count, &mut lines)?;
                    break;
                }
                "FIELD" if count.is_some() => {
                    header.field(rest, &mut lines)?;
                    break;
                }
                "VECTORS" if count.is_some() => {
                    header.scalars(&format!("{} 3", rest.trim()), count, &mut lines)?;
                    break;
                }
                "NORMALS" | "TENSORS" | "COLOR_SCALARS" | "TEXTURE_COORDINATES" => {
                    return Err(ErrorKind::Unsupported {
                        feature: key.to_owned(),
                        instead: "write the samples as SCALARS".into(),
                    }
                    .into());
                }
                "FIELD" => skipped.push("FIELD"),
                _ => {}
            }
        }
        if header.data == 0 {
            return Err(ErrorKind::Missing {
                field: "SCALARS".into(),
                allowed: "the samples follow such a line, behind POINT_DATA or CELL_DATA".into(),
            }
            .into());
        }
        if !skipped.is_empty() {
            header
                .notes
                .push("fields of the data set were left out".into());
        }
        Ok(header)
    }

    /// `name type [components]`, perhaps a look-up table, then the samples.
    fn scalars(
        &mut self,
        rest: &str,
        count: Option<usize>,
        lines: &mut HeaderLines,
    ) -> Result<(), Error> {
        let words: Vec<&str> = rest.split_whitespace().collect();
        let (kind, number) = match words[..] {
            [_, kind] => (kind, "1"),
            [_, kind, number] => (kind, number),
            _ => {
                return Err(Error::field(
                    "SCALARS",
                    format!("`{rest}`"),
                    "a name, a type and 1",
                ));
            }
        };
        self.components = component_count(number)?;
        self.stored = sample_type(kind)?;
        self.count = count.unwrap_or(0);
        self.data = lines.position();
        let start = self.data;
        let is_table = lines.next_line()?.is_some_and(|line| {
            line.trim_start()
                .to_ascii_uppercase()
                .starts_with("LOOKUP_TABLE")
        });
        self.data = if is_table { lines.position() } else { start };
        Ok(())
    }

    /// The first array of a field, if it has one number a voxel.
    fn field(&mut self, rest: &str, lines: &mut HeaderLines) -> Result<(), Error> {
        let arrays = rest.split_whitespace().nth(1).unwrap_or("0");
        let mut line = String::new();
        while line.trim().is_empty() {
            line = required("FIELD", lines.next_line()?, "an array behind it")?;
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let [_, number, count, kind] = words[..] else {
            return Err(Error::field(
                "an array of FIELD",
                format!("`{line}`"),
                "a name, the number of components, that of samples, and a type",
            ));
        };
        self.components = component_count(number)?;
        self.stored = sample_type(kind)?;
        self.count = numbers::<usize>("an array of FIELD", count, 1)?[0];
        self.data = lines.position();
        if arrays != "1" {
            self.notes
                .push(format!("{} is the first of {arrays} arrays", words[0]));
        }
        Ok(())
    }

    fn grid(&self, options: &ReadOptions) -> Result<Grid, Error> {
        let points = required("DIMENSIONS", self.points, "the points along x, y and z")?;
        if points.contains(&0) || voxel_count(points).is_none() {
            return Err(Error::field(
                "DIMENSIONS",
                format!("{points:?}"),
                "1 or more each",
            ));
        }
        let (spacing, _) = unoriented::spacing_mm(options, Some((self.spacing, false)));
        if let Some(wrong) = spacing.iter().find(|mm| !(**mm > 0.0 && mm.is_finite())) {
            return Err(Error::field("SPACING", wrong, "numbers above 0"));
        }
        let matrix = glam::DMat3::from_diagonal(DVec3::from(spacing));
        grid(points, self.is_of_cells, self.origin.into(), matrix)
    }
}

/// The numbers of a voxel.
pub(crate) fn component_count(text: &str) -> Result<usize, Error> {
    let count = text.trim().parse().ok().filter(|n| (1..=1024).contains(n));
    count.ok_or_else(|| Error::field("number of components", format!("`{text}`"), "1 to 1024"))
}

/// Bytes are colors, as in ParaView.
pub(crate) fn meaning(stored: Stored) -> Meaning {
    match stored {
        Stored::Kept(SampleType::U8) => Meaning::Color,
        _ => Meaning::Vector,
    }
}

fn other_data_set(name: &str) -> Error {
    ErrorKind::Unsupported {
        feature: format!("the VTK data set {name}"),
        instead: "only STRUCTURED_POINTS lie on an even grid; resample the data in ParaView (Resample To Image)".into(),
    }
    .into()
}
