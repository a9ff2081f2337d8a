//! NRRD, versions 1 to 5, attached and detached.
//!
//! A text header, then (attached) an empty line and the samples:
//!
//! | line             | meaning                                                               |
//! |------------------|-----------------------------------------------------------------------|
//! | `NRRD000N`       | magic and version                                                     |
//! | `# …`            | comment                                                               |
//! | `field: value`   | one of the fields below, in any case                                  |
//! | `key:=value`     | free entry                                                            |
//! | empty            | end of the header                                                     |
//!
//! | field                                 | taken as                                          |
//! |---------------------------------------|---------------------------------------------------|
//! | `dimension`, `sizes`                  | lengths of the axes, fastest first                |
//! | `type`, `encoding`, `endian`          | of the samples; endian needed above 8 bits        |
//! | `data file`                           | a name; `LIST [n]` and names to the end of file; `pattern first last step [n]` |
//! | `line skip`, `byte skip`              | before the samples (bytes after unpacking; −1: samples at the end) |
//! | `space`, `space dimension`            | what the world's axes mean; patient spaces are turned into RAS |
//! | `space directions`, `space origin`    | columns of the affine; `none` or NaN for axes that are no place |
//! | `space units`, `units`                | of the world's or the grid's axes                 |
//! | `spacings`, `axis mins`, `axis maxs`, `centerings` | places of grids without a space      |
//! | `kinds`                               | which axes are places                             |
//! | `content`, `sample units`             | kept                                              |
//!
//! One axis may be a list or time (any position); `ReadOptions::time_index` picks from it. Keys
//! `SegmentN_…` (3D Slicer's `.seg.nrrd`) describe labels, see `nrrd/segments.rs`.

mod segments;

use super::block::{Encoding, Endian};
use super::components::{self, Choice, Meaning};
use super::data_files::{self, ByteSkip, Place, Storage};
use super::header_lines::{HeaderLines, numbers, required};
use super::stored::Stored;
use super::{Input, LoadedVolume, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Metadata, Modality, Rescale, SampleType, Samples, Volume, with_samples};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeMap;

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let header = Header::parse(input)?;
    let mut notes = Vec::new();

    let stored = header.sample_type()?;
    let axes = header.axes(&mut notes)?;
    let grid = header.grid(&axes, &mut notes)?;
    let frames = axes.frames();
    let segments = segments::all(&header.keys, frames)?;
    let has_layers = !segments.is_empty() && frames > 1;
    // Layers are read together, or one of them as a component.
    let (frame, what, options) = match options.component {
        _ if !has_layers => (options.time_index, "time point", options.clone()),
        None => return layers(input, &header, &axes, grid, &segments, options, notes),
        Some(layer) => {
            no_time(options)?;
            let component = None;
            let options = ReadOptions {
                component,
                ..options.clone()
            };
            (layer, "component", options)
        }
    };
    if frame >= frames {
        return Err(Error::field(
            what,
            frame,
            match frames {
                1 => "0: the file holds a single volume".to_owned(),
                n => format!("0 to {}", n - 1),
            },
        ));
    }
    let (components, meaning) = match axes.component_axis {
        Some((axis, meaning)) => (axes.sizes[axis], meaning),
        None => (1, Meaning::Vector),
    };
    let choice = components::choice(components, meaning, &options, &mut notes)?;
    let count = components::total(grid.voxel_count(), components)?;
    let total = count
        .checked_mul(frames)
        .filter(|&n| n <= isize::MAX as usize)
        .ok_or_else(|| Error::field("sizes", header.text("sizes"), "fewer samples"))?;

    let storage = header.storage(stored)?;
    let samples = match axes.frame_axis {
        // Frames follow one another: only the wanted one is read.
        Some(axis) if axis + 1 == axes.sizes.len() => {
            let start = frame * count;
            storage.read(input, stored, total, start..start + count, &mut notes)?
        }
        Some(axis) => {
            let before = axes.sizes[..axis].iter().product();
            let mut samples = storage.read(input, stored, total, 0..total, &mut notes)?;
            with_samples!(&mut samples, s => pick(s, before, frames, frame));
            samples
        }
        None => storage.read(input, stored, total, 0..total, &mut notes)?,
    };

    let samples = match axes.component_axis {
        Some((axis, _)) => one_number(samples, &axes, axis, choice)?,
        None => samples,
    };
    let labels = segments::of_layer(&segments, frame, &mut notes);
    let metadata = Metadata {
        components: meaning.of(components),
        ..header.metadata(input.name, &axes, frame)
    };
    Ok(LoadedVolume {
        volume: Volume::new(grid, samples, Rescale::IDENTITY, metadata)?,
        labels,
        notes,
    })
}

/// The labels of all layers of a segmentation.
fn layers(
    input: &Input,
    header: &Header,
    axes: &Axes,
    grid: Grid,
    segments: &[segments::Segment],
    options: &ReadOptions,
    mut notes: Vec<String>,
) -> Result<LoadedVolume, Error> {
    let stored = header.sample_type()?;
    no_time(options)?;
    if let Some((axis, _)) = axes.component_axis {
        let allowed = "no axis beside the layers of a segmentation";
        return Err(Error::field(
            format!("kind of axis {axis}"),
            "several numbers",
            allowed,
        ));
    }
    let total = components::total(grid.voxel_count(), axes.frames())?;
    let storage = header.storage(stored)?;
    let samples = storage.read(input, stored, total, 0..total, &mut notes)?;
    let before = match axes.frame_axis {
        Some(axis) => axes.sizes[..axis].iter().product(),
        None => 1,
    };
    let layers = segments::Layers {
        samples: &samples,
        count: axes.frames(),
        before,
    };
    let (samples, labels) = layers.combined(segments, &mut notes)?;
    let metadata = Metadata {
        time_points: 1,
        ..header.metadata(input.name, axes, 0)
    };
    Ok(LoadedVolume {
        volume: Volume::new(grid, samples, Rescale::IDENTITY, metadata)?,
        labels: Some(labels),
        notes,
    })
}

fn no_time(options: &ReadOptions) -> Result<(), Error> {
    let allowed = "0: layers are read together, or one of them as a component";
    match options.time_index {
        0 => Ok(()),
        index => Err(Error::field("time point", index, allowed)),
    }
}

/// The chosen number of every voxel, of those along an axis. The frame has been picked.
fn one_number(
    mut samples: Samples,
    axes: &Axes,
    axis: usize,
    choice: Choice,
) -> Result<Samples, Error> {
    let frame = |i: &usize| Some(*i) != axes.frame_axis;
    let before: usize = (0..axis).filter(frame).map(|i| axes.sizes[i]).product();
    let length = axes.sizes[axis];
    match choice {
        _ if before == 1 => Ok(components::reduced(samples, length, choice)),
        Choice::One(component) => {
            with_samples!(&mut samples, s => pick(s, before, length, component));
            Ok(samples)
        }
        Choice::Luminance => Err(ErrorKind::Unsupported {
            feature: format!("color along axis {axis}"),
            instead: "pick one of its components, or write colors as the first axis".into(),
        }
        .into()),
    }
}

/// Keeps every sample whose index along one axis (of `length`, `before` samples apart) is `index`.
/// In place: a sample never moves back past one that is still wanted.
fn pick<T: Copy>(samples: &mut Vec<T>, before: usize, length: usize, index: usize) {
    let kept = samples.len() / length;
    for to in 0..kept {
        let (outer, inner) = (to / before, to % before);
        samples[to] = samples[inner + before * (index + length * outer)];
    }
    samples.truncate(kept);
    samples.shrink_to_fit();
}

struct Header {
    /// By lower-case name without blanks.
    fields: BTreeMap<String, String>,
    keys: Vec<(String, String)>,
    /// Where the samples begin if they are in the same file.
    end: u64,
    /// The names after `data file: LIST`.
    listed: Vec<String>,
}

/// What the axes of the array mean.
struct Axes {
    sizes: Vec<usize>,
    /// Which axes are x, y, z.
    places: Vec<usize>,
    /// Which axis is time or a list, if one is.
    frame_axis: Option<usize>,
    /// Which axis holds the numbers of a voxel, if one does, and what they are.
    component_axis: Option<(usize, Meaning)>,
}

impl Axes {
    fn frames(&self) -> usize {
        self.frame_axis.map_or(1, |axis| self.sizes[axis])
    }
}

impl Header {
    fn parse(input: &Input) -> Result<Header, Error> {
        const FIELDS: [&str; 31] = [
            "dimension",
            "type",
            "blocksize",
            "encoding",
            "endian",
            "content",
            "min",
            "max",
            "oldmin",
            "oldmax",
            "datafile",
            "lineskip",
            "byteskip",
            "number",
            "sampleunits",
            "space",
            "spacedimension",
            "spaceunits",
            "spaceorigin",
            "spacedirections",
            "measurementframe",
            "sizes",
            "spacings",
            "thicknesses",
            "axismins",
            "axismaxs",
            "centers",
            "centerings",
            "labels",
            "units",
            "kinds",
        ];
        let mut lines = HeaderLines::new(input.bytes);
        let magic = lines.next_line()?.unwrap_or_default();
        if !matches!(
            magic.trim_end(),
            "NRRD0001" | "NRRD0002" | "NRRD0003" | "NRRD0004" | "NRRD0005"
        ) {
            return Err(Error::field(
                "the first line",
                format!("`{}`", magic.chars().take(20).collect::<String>()),
                "`NRRD0001` to `NRRD0005`",
            ));
        }
        let mut header = Header {
            fields: BTreeMap::new(),
            keys: Vec::new(),
            end: 0,
            listed: Vec::new(),
        };
        let mut ended = false;
        while let Some(line) = lines.next_line()? {
            if line.is_empty() {
                ended = true;
                break;
            }
            if line.starts_with('#') {
                continue;
            }
            // A field is followed by ": ", a key by ":="; both may occur in values.
            let Some(colon) = line.find(':') else {
                return Err(Error::field(
                    "a header line",
                    format!("`{}`", line.chars().take(60).collect::<String>()),
                    "`field: value`, `key:=value`, or `# comment`",
                ));
            };
            let (name, value) = (&line[..colon], &line[colon + 1..]);
            if let Some(value) = value.strip_prefix('=') {
                header.keys.push((unescaped(name), unescaped(value)));
                continue;
            }
            let short: String = name.chars().filter(|c| !c.is_whitespace()).collect();
            let short = short.to_ascii_lowercase();
            if !FIELDS.contains(&short.as_str()) {
                return Err(Error::field(
                    "a header line",
                    format!("`{name}:`"),
                    "a field of the NRRD standard (free entries are written `key:=value`)",
                ));
            }
            let value = value.trim().to_owned();
            let is_list = short == "datafile" && value.to_ascii_uppercase().starts_with("LIST");
            if header.fields.insert(short, value).is_some() {
                return Err(Error::field(name, "given twice", "each field once"));
            }
            if is_list {
                while let Some(line) = lines.next_line()? {
                    if !line.trim().is_empty() {
                        header.listed.push(line.trim().to_owned());
                    }
                }
                break;
            }
        }
        header.end = lines.position();
        if !ended && !header.fields.contains_key("datafile") {
            return Err(ErrorKind::Missing {
                field: "the empty line that ends the header".into(),
                allowed: "then the samples, or a field `data file` with their place".into(),
            }
            .into());
        }
        Ok(header)
    }

    fn get(&self, field: &str) -> Option<&str> {
        self.fields.get(field).map(String::as_str)
    }

    fn text(&self, field: &str) -> String {
        self.get(field).unwrap_or_default().to_owned()
    }

    fn sample_type(&self) -> Result<Stored, Error> {
        let text = required("type", self.get("type"), "such as `uint8` or `short`")?;
        let words: Vec<&str> = text.split_whitespace().collect();
        let name = words.join(" ").to_ascii_lowercase();
        let short = name.trim_end_matches("_t");
        Ok(Stored::Kept(match short {
            "signed char" | "int8" => SampleType::I8,
            "uchar" | "unsigned char" | "uint8" => SampleType::U8,
            "short" | "short int" | "signed short" | "signed short int" | "int16" => {
                SampleType::I16
            }
            "ushort" | "unsigned short" | "unsigned short int" | "uint16" => SampleType::U16,
            "int" | "signed int" | "int32" => SampleType::I32,
            "uint" | "unsigned int" | "uint32" => SampleType::U32,
            "float" => SampleType::F32,
            "double" => SampleType::F64,
            "block" => {
                return Err(ErrorKind::Unsupported {
                    feature: "type block".into(),
                    instead: "write the samples as numbers".into(),
                }
                .into());
            }
            "longlong"
            | "long long"
            | "long long int"
            | "signed long long"
            | "signed long long int"
            | "int64" => return Ok(Stored::I64),
            "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" => {
                return Ok(Stored::U64);
            }
            _ => {
                return Err(Error::field(
                    "type",
                    format!("`{text}`"),
                    "int8, uint8, int16, uint16, int32, uint32, int64, uint64, float or double (or their C names)",
                ));
            }
        }))
    }

    fn sizes(&self) -> Result<Vec<usize>, Error> {
        let dimension = required("dimension", self.get("dimension"), "the number of axes")?;
        let dimension = numbers::<usize>("dimension", dimension, 1)?[0];
        if !(1..=16).contains(&dimension) {
            return Err(Error::field("dimension", dimension, "1 to 16"));
        }
        let sizes = required("sizes", self.get("sizes"), "the length of each axis")?;
        let sizes = numbers::<usize>("sizes", sizes, dimension)?;
        if sizes.contains(&0) {
            return Err(Error::field(
                "sizes",
                format!("{sizes:?}"),
                "1 or more each",
            ));
        }
        Ok(sizes)
    }

    /// One vector (or `none`) per axis.
    fn directions(&self, axes: usize) -> Result<Option<Vec<Option<DVec3>>>, Error> {
        let Some(text) = self.get("spacedirections") else {
            return Ok(None);
        };
        let vectors = vectors("space directions", text, self.space_dimension()?)?;
        if vectors.len() != axes {
            return Err(Error::field(
                "space directions",
                format!("`{text}`"),
                format!("{axes} vectors, one per axis, `none` for axes that are no place"),
            ));
        }
        Ok(Some(vectors))
    }

    fn axes(&self, notes: &mut Vec<String>) -> Result<Axes, Error> {
        let sizes = self.sizes()?;
        let kinds: Vec<String> = match self.get("kinds") {
            Some(text) => {
                let kinds: Vec<String> = text
                    .split_whitespace()
                    .map(str::to_ascii_lowercase)
                    .collect();
                if kinds.len() != sizes.len() {
                    return Err(Error::field(
                        "kinds",
                        format!("`{text}`"),
                        format!("{} words, one per axis", sizes.len()),
                    ));
                }
                kinds
            }
            None => vec!["???".into(); sizes.len()],
        };
        let directions = self.directions(sizes.len())?;
        let mut places: Vec<usize> = match &directions {
            Some(directions) => (0..sizes.len())
                .filter(|&i| directions[i].is_some())
                .collect(),
            None => {
                let known = |i: &usize| matches!(kinds[*i].as_str(), "domain" | "space");
                let known: Vec<usize> = (0..sizes.len()).filter(known).collect();
                if known.is_empty() {
                    let open = |i: &usize| matches!(kinds[*i].as_str(), "???" | "none");
                    (0..sizes.len()).filter(open).take(3).collect()
                } else {
                    known
                }
            }
        };
        // A fourth axis that no direction tells from the others: images of four dimensions, as ITK writes them.
        if let [x, y, z, last] = places[..]
            && directions.is_none()
        {
            notes.push(format!("axis {last} is taken as time"));
            places = vec![x, y, z];
        }
        if !(2..=3).contains(&places.len()) {
            return Err(ErrorKind::Unsupported {
                feature: format!(
                    "an array with {} axes that are places (sizes {sizes:?})",
                    places.len()
                ),
                instead: "two or three are: give `space directions` or `kinds`".into(),
            }
            .into());
        }
        let mut frame_axis = None;
        let mut component_axis = None;
        for axis in (0..sizes.len()).filter(|axis| !places.contains(axis) && sizes[*axis] > 1) {
            let kind = kinds[axis].as_str();
            // Axes that could be places and lie in none of the three directions are moments.
            let is_list = matches!(kind, "list" | "time" | "???" | "none" | "domain" | "space");
            let several_numbers = !is_list;
            if several_numbers && component_axis.is_none() {
                let is_color = matches!(kind, "rgb-color" | "rgba-color");
                let meaning = match is_color {
                    true => Meaning::Color,
                    false => Meaning::Vector,
                };
                component_axis = Some((axis, meaning));
                continue;
            }
            if several_numbers || frame_axis.is_some() {
                return Err(ErrorKind::Unsupported {
                    feature: format!(
                        "axis {axis} of {} entries (kind `{kind}`), several numbers per voxel,",
                        sizes[axis]
                    ),
                    instead: "write one number per voxel; a list or time axis may be there once"
                        .into(),
                }
                .into());
            }
            frame_axis = Some(axis);
        }
        Ok(Axes {
            sizes,
            places,
            frame_axis,
            component_axis,
        })
    }

    /// How many numbers a vector of the world has.
    fn space_dimension(&self) -> Result<usize, Error> {
        match (self.get("space"), self.get("spacedimension")) {
            (Some(space), _) => {
                let with_time = space.to_ascii_lowercase().ends_with("-time")
                    || matches!(
                        space.to_ascii_uppercase().as_str(),
                        "RAST" | "LAST" | "LPST"
                    );
                Ok(if with_time { 4 } else { 3 })
            }
            (None, Some(dimension)) => {
                let dimension = numbers::<usize>("space dimension", dimension, 1)?[0];
                if !(2..=4).contains(&dimension) {
                    return Err(Error::field("space dimension", dimension, "2 to 4"));
                }
                Ok(dimension)
            }
            (None, None) => Ok(3),
        }
    }

    fn grid(&self, axes: &Axes, notes: &mut Vec<String>) -> Result<Grid, Error> {
        let mut dims = [1; 3];
        for (dim, &axis) in dims.iter_mut().zip(&axes.places) {
            *dim = axes.sizes[axis];
        }
        // Overflow shows before anything is computed from the product.
        axes.sizes
            .iter()
            .try_fold(1usize, |n, &size| n.checked_mul(size))
            .filter(|&n| n <= isize::MAX as usize)
            .ok_or_else(|| {
                Error::field(
                    "sizes",
                    format!("{:?}", axes.sizes),
                    "fewer samples than this machine can address",
                )
            })?;
        let world_from_voxel = match self.directions(axes.sizes.len())? {
            Some(directions) => {
                let columns: Vec<DVec3> = directions.into_iter().flatten().collect();
                self.placed(&columns, notes)?
            }
            None => self.unplaced(axes, notes)?,
        };
        Grid::new(dims, world_from_voxel)
    }

    /// The affine of a grid whose axes are vectors of the world.
    fn placed(&self, columns: &[DVec3], notes: &mut Vec<String>) -> Result<DAffine3, Error> {
        let origin = match self.get("spaceorigin") {
            Some(text) => match vectors("space origin", text, self.space_dimension()?)?[..] {
                [Some(origin)] => origin,
                [None] => {
                    notes.push("`space origin` is not known (NaN); 0 is taken".into());
                    DVec3::ZERO
                }
                _ => {
                    return Err(Error::field(
                        "space origin",
                        format!("`{text}`"),
                        "one vector",
                    ));
                }
            },
            None => DVec3::ZERO,
        };
        // A single slice is as thick as 1.
        let third = columns.get(2).copied();
        let third = third.unwrap_or_else(|| columns[0].cross(columns[1]).normalize_or_zero());
        let matrix = DMat3::from_cols(columns[0], columns[1], third);

        let space = self.text("space").to_ascii_lowercase();
        let sign = match space.trim_end_matches("-time") {
            "right-anterior-superior" | "ras" | "rast" => DVec3::ONE,
            "left-anterior-superior" | "las" | "last" => DVec3::new(-1.0, 1.0, 1.0),
            "left-posterior-superior" | "lps" | "lpst" => DVec3::new(-1.0, -1.0, 1.0),
            "" => {
                notes.push(
                    "no `space` is given; its axes are taken as left, back, up (LPS), as ITK does"
                        .into(),
                );
                DVec3::new(-1.0, -1.0, 1.0)
            }
            "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => {
                notes.push(format!(
                    "space {space} does not state the patient's orientation; its axes are read as left, back, up (LPS), as by ITK"
                ));
                DVec3::new(-1.0, -1.0, 1.0)
            }
            _ => {
                return Err(Error::field(
                    "space",
                    format!("`{space}`"),
                    "right-anterior-superior, left-anterior-superior, left-posterior-superior, scanner-xyz, 3D-right-handed or 3D-left-handed",
                ));
            }
        };
        let units = match self.get("spaceunits") {
            Some(text) => quoted_words(text),
            None => Vec::new(),
        };
        let mut scale = DVec3::ONE;
        for (axis, unit) in units.iter().take(3).enumerate() {
            scale[axis] = unit_mm(unit, notes).unwrap_or(1.0);
        }
        let place = DMat3::from_diagonal(sign * scale);
        Ok(DAffine3::from_mat3_translation(
            place * matrix,
            place * origin,
        ))
    }

    /// The affine of a grid that only says how far apart its samples are.
    fn unplaced(&self, axes: &Axes, notes: &mut Vec<String>) -> Result<DAffine3, Error> {
        let rank = axes.sizes.len();
        let per_axis = |name: &str, field: &str| -> Result<Option<Vec<f64>>, Error> {
            self.get(field)
                .map(|text| numbers::<f64>(name, text, rank))
                .transpose()
        };
        let spacings = per_axis("spacings", "spacings")?;
        let mins = per_axis("axis mins", "axismins")?;
        let maxs = per_axis("axis maxs", "axismaxs")?;
        let centerings: Vec<String> = self
            .get("centerings")
            .or(self.get("centers"))
            .map(|text| {
                text.split_whitespace()
                    .map(str::to_ascii_lowercase)
                    .collect()
            })
            .unwrap_or_default();
        let units = self.get("units").map(quoted_words).unwrap_or_default();

        let mut spacing = DVec3::ONE;
        let mut origin = DVec3::ZERO;
        for (place, &axis) in axes.places.iter().enumerate() {
            let at = |list: &Option<Vec<f64>>| {
                list.as_ref()
                    .map(|list| list[axis])
                    .filter(|value| !value.is_nan())
            };
            let nodes = centerings.get(axis).is_some_and(|c| c == "node");
            let (first, last) = (at(&mins), at(&maxs));
            let step = at(&spacings).or_else(|| {
                let gaps = if nodes {
                    axes.sizes[axis] - 1
                } else {
                    axes.sizes[axis]
                };
                Some((last? - first?) / gaps.max(1) as f64)
            });
            let step = step.unwrap_or(1.0);
            let unit = units
                .get(axis)
                .map_or(1.0, |u| unit_mm(u, notes).unwrap_or(1.0));
            spacing[place] = step * unit;
            if let Some(first) = first {
                origin[place] = (if nodes { first } else { first + 0.5 * step }) * unit;
            }
        }
        notes.push(
            "no `space` is given; the axes are taken as left, back, up (LPS), as ITK does".into(),
        );
        let ras_from_lps = DVec3::new(-1.0, -1.0, 1.0);
        Ok(DAffine3::from_mat3_translation(
            DMat3::from_diagonal(ras_from_lps * spacing),
            ras_from_lps * origin,
        ))
    }

    fn storage(&self, stored: Stored) -> Result<Storage, Error> {
        let text = required(
            "encoding",
            self.get("encoding"),
            "raw, gzip, bzip2, ascii or hex",
        )?;
        let encoding = match text.to_ascii_lowercase().as_str() {
            "raw" => Encoding::Raw,
            "gzip" | "gz" => Encoding::Gzip,
            "bzip2" | "bz2" => Encoding::Bzip2,
            "ascii" | "text" | "txt" => Encoding::Ascii,
            "hex" => Encoding::Hex,
            _ => {
                return Err(Error::field(
                    "encoding",
                    format!("`{text}`"),
                    "raw, gzip, bzip2, ascii or hex",
                ));
            }
        };
        let endian = match self.get("endian").map(str::to_ascii_lowercase).as_deref() {
            Some("little") => Endian::Little,
            Some("big") => Endian::Big,
            Some(other) => {
                return Err(Error::field(
                    "endian",
                    format!("`{other}`"),
                    "little or big",
                ));
            }
            None if stored.bits().size() == 1 || encoding == Encoding::Ascii => Endian::Little,
            None => {
                return Err(ErrorKind::Missing {
                    field: "endian".into(),
                    allowed: format!(
                        "samples of {} bytes need `endian: little` or `endian: big`",
                        stored.bits().size()
                    ),
                }
                .into());
            }
        };
        let number = |name: &str, field: &str| -> Result<i64, Error> {
            let text = self.get(field).unwrap_or("0");
            Ok(numbers::<i64>(name, text, 1)?[0])
        };
        let lines = number("line skip", "lineskip")?;
        let line_skip =
            u64::try_from(lines).map_err(|_| Error::field("line skip", lines, "0 or more"))?;
        let bytes = number("byte skip", "byteskip")?;
        let byte_skip = match u64::try_from(bytes) {
            Ok(bytes) => ByteSkip::Front(bytes),
            Err(_)
                if bytes == -1
                    && matches!(encoding, Encoding::Raw | Encoding::Gzip | Encoding::Bzip2) =>
            {
                ByteSkip::AllButTheEnd
            }
            Err(_) => {
                return Err(Error::field(
                    "byte skip",
                    bytes,
                    "0 or more; −1 (samples at the end) for raw, gzip and bzip2 encoding",
                ));
            }
        };
        Ok(Storage {
            place: self.place()?,
            field: "data file",
            encoding,
            endian,
            line_skip,
            byte_skip,
        })
    }

    fn place(&self) -> Result<Place, Error> {
        let Some(text) = self.get("datafile") else {
            return Ok(Place::After(self.end));
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        if words
            .first()
            .is_some_and(|w| w.eq_ignore_ascii_case("LIST"))
        {
            return Ok(Place::Files(self.listed.clone()));
        }
        if let [pattern, first, last, step] | [pattern, first, last, step, _] = words[..]
            && pattern.contains('%')
        {
            let span = numbers::<i64>("data file", &format!("{first} {last} {step}"), 3)?;
            return Ok(Place::Files(data_files::numbered(
                "data file",
                pattern,
                span[0],
                span[1],
                span[2],
            )?));
        }
        Ok(Place::Files(vec![text.to_owned()]))
    }

    fn metadata(&self, name: &str, axes: &Axes, time_index: usize) -> Metadata {
        let mut entries: Vec<(String, String)> = self.keys.clone();
        if let Some(content) = self.get("content") {
            entries.insert(0, ("content".into(), content.to_owned()));
        }
        let modality = self
            .keys
            .iter()
            .find(|(key, _)| key.eq_ignore_ascii_case("modality"));
        let patient_space = self.get("space").is_some_and(|space| {
            let space = space.to_ascii_lowercase();
            ["right", "left", "ras", "las", "lps"]
                .iter()
                .any(|s| space.starts_with(s))
        });
        Metadata {
            name: name.to_owned(),
            format: "NRRD".into(),
            modality: modality.and_then(|(_, value)| modality_of(value)),
            value_unit: self
                .get("sampleunits")
                .map(|unit| unit.trim_matches('"').to_owned())
                .filter(|unit| !unit.is_empty()),
            has_length_unit: patient_space
                || self.get("spaceunits").is_some()
                || self.get("units").is_some(),
            time_points: axes.frames(),
            time_index,
            entries,
            ..Metadata::default()
        }
    }
}

/// The device that a DICOM code or its name stands for.
pub(crate) fn modality_of(text: &str) -> Option<Modality> {
    match text.trim().to_ascii_uppercase().as_str() {
        "CT" => Some(Modality::Ct),
        "MR" | "MRI" => Some(Modality::Mr),
        "PT" | "PET" | "NM" | "SPECT" => Some(Modality::Nuclear),
        "US" => Some(Modality::Ultrasound),
        _ => None,
    }
}

/// `(1,0,0) none (0, 0, 2)` → vectors of `dimension` numbers. Of four, the last (time) is left
/// out; two lie in the plane z = 0.
fn vectors(field: &str, text: &str, dimension: usize) -> Result<Vec<Option<DVec3>>, Error> {
    let wrong = || {
        Error::field(
            field,
            format!("`{text}`"),
            format!("vectors of {dimension} numbers such as (1,0,0), or `none`"),
        )
    };
    let mut vectors = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix("none") {
            vectors.push(None);
            rest = after.trim_start();
            continue;
        }
        let inside = rest.strip_prefix('(').ok_or_else(wrong)?;
        let (inside, after) = inside.split_once(')').ok_or_else(wrong)?;
        let numbers: Vec<f64> = inside
            .split(',')
            .map(|n| n.trim().parse())
            .collect::<Result<_, _>>()
            .map_err(|_| wrong())?;
        if numbers.len() != dimension {
            return Err(wrong());
        }
        // Not known, or no place (NRRD's own words for it are NaN).
        if numbers.iter().all(|n| n.is_nan()) {
            vectors.push(None);
            rest = after.trim_start();
            continue;
        }
        let z = numbers.get(2).copied().unwrap_or(0.0);
        let vector = DVec3::new(numbers[0], numbers[1], z);
        // An axis that leads through time only is no place.
        let is_time = dimension == 4 && vector == DVec3::ZERO && field == "space directions";
        vectors.push((!is_time).then_some(vector));
        rest = after.trim_start();
    }
    Ok(vectors)
}

/// `"mm" "mm" ""` → the words.
fn quoted_words(text: &str) -> Vec<String> {
    if text.contains('"') {
        text.split('"')
            .skip(1)
            .step_by(2)
            .map(str::to_owned)
            .collect()
    } else {
        text.split_whitespace().map(str::to_owned).collect()
    }
}

/// Length of a unit in mm; unknown ones are noted.
fn unit_mm(unit: &str, notes: &mut Vec<String>) -> Option<f64> {
    match unit.trim() {
        "mm" | "millimeter" | "millimeters" | "millimetre" => Some(1.0),
        "cm" | "centimeter" => Some(10.0),
        "m" | "meter" | "metre" => Some(1000.0),
        "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" | "micrometers" => Some(1e-3),
        "nm" | "nanometer" => Some(1e-6),
        "" | "none" | "???" => None,
        other => {
            let note = format!("the unit `{other}` is not known as a length; it counts as mm");
            if !notes.contains(&note) {
                notes.push(note);
            }
            None
        }
    }
}

/// `\n` and `\\` in keys and values stand for a line break and a backslash.
fn unescaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        match c {
            '\\' => match chars.next() {
                Some('n') => out.push('\n'),
                Some('\\') => out.push('\\'),
                Some(other) => out.extend(['\\', other]),
                None => out.push('\\'),
            },
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picking_along_an_axis_is_indexing() {
        // Sizes 2 × 3 × 4, the axis of length 3.
        let all: Vec<usize> = (0..24).collect();
        for index in 0..3 {
            let mut picked = all.clone();
            pick(&mut picked, 2, 3, index);
            let expected: Vec<usize> = (0..4)
                .flat_map(|z| (0..2).map(move |x| x + 2 * (index + 3 * z)))
                .collect();
            assert_eq!(picked, expected);
        }
    }

    #[test]
    fn vectors_are_read_with_and_without_blanks() {
        let v = vectors("space directions", "(1,0,0) none (0, -2.5e0 ,0)(0,0,3)", 3).unwrap();
        assert_eq!(
            v,
            [
                Some(DVec3::X),
                None,
                Some(-2.5 * DVec3::Y),
                Some(3.0 * DVec3::Z)
            ]
        );
        for wrong in ["(1,0)", "(1,0,0", "1,0,0", "(a,0,0)", "(1,0,0,0)", "nope"] {
            assert!(vectors("space directions", wrong, 3).is_err(), "{wrong}");
        }
    }
}
