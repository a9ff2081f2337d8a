//! DICOM: the slices of a series, or the frames of a multi-frame file, put together to a volume.
//!
//! The elements of all files are read first (`elements`), without the pixels; then files are
//! grouped to series (`series`), their images placed (`frames`) and sorted along the normal
//! (`stack`); last the pixels are decoded, each slice straight to where it stays (`pixels`).
//! Neither file names nor instance numbers order anything.

mod character_set;
mod color;
mod contours;
mod elements;
mod frames;
mod image;
mod jpeg_lossless;
mod jpeg_ls;
mod keys;
mod mosaic;
mod nuclear;
mod palette_segments;
mod pixels;
mod ras;
mod rle;
mod segmentation;
mod series;
mod stack;
mod structure_set;
mod syntax;
mod tags;

use super::block;
use super::components::{self, Choice, Meaning};
use super::input::Whole;
use super::{Bytes, Files, Input, LoadedVolume, ReadOptions};
use crate::cores;
use crate::error::{Error, ErrorKind};
use crate::samples::with_type;
use crate::{Grid, Metadata, Modality, Rescale, Sample, SampleType, Samples, Volume, memory};
use frames::Frame;
use image::Image;
use pixels::Source;
pub use series::SeriesSummary;
use stack::Stack;
use std::collections::BTreeMap;
use std::io;

/// The series among `files`, by series number.
///
/// # Errors
/// What the system says when a file is read. Files that are no DICOM images are passed over.
pub fn list_series(files: &dyn Files) -> Result<Vec<SeriesSummary>, Error> {
    let scan = scan_here_or_below(files)?;
    Ok(scan
        .series
        .into_iter()
        .map(|(summary, _)| summary)
        .collect())
}

/// The series of a folder; if no file in it is an image, those of the folders below.
fn scan_here_or_below(files: &dyn Files) -> Result<series::Scan, Error> {
    let scan = series::scan(files, files.names())?;
    if !scan.series.is_empty() {
        return Ok(scan);
    }
    let names = files.names_below()?;
    if names.iter().all(|name| !name.contains('/')) {
        return Ok(scan);
    }
    let mut below = series::scan(files, names)?;
    let first = below.series.first().and_then(|(_, images)| images.first());
    if let Some(image) = first {
        below.notes.insert(
            0,
            format!("the images lie in folders below, such as {}", image.name),
        );
    }
    Ok(below)
}

/// The images that a DICOMDIR names (PS3.3, annex F).
fn read_directory(
    input: &Input,
    elements: &elements::Elements,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    // Names on a CD are in capitals; what copied it may have changed that, or written a version behind.
    let plain = |name: &str| {
        let name = name.to_ascii_lowercase();
        name.strip_suffix(";1").unwrap_or(&name).to_owned()
    };
    let there: BTreeMap<String, String> = input
        .files
        .names_below()?
        .into_iter()
        .map(|name| (plain(&name), name))
        .collect();
    let named: Vec<String> = elements
        .set
        .items(tags::DIRECTORY_RECORD_SEQUENCE)
        .iter()
        .filter_map(|record| record.text(tags::REFERENCED_FILE_ID))
        .map(|path| {
            let parts: Vec<&str> = path.split('\\').map(str::trim).collect();
            parts.join("/")
        })
        .collect();
    let found: Vec<String> = named
        .iter()
        .filter_map(|name| there.get(&plain(name)).cloned())
        .collect();
    if found.is_empty() {
        return Err(Error::field(
            tags::field_name(tags::REFERENCED_FILE_ID),
            match named.first() {
                Some(name) => format!("`{name}` and {} more", named.len() - 1),
                None => "missing".into(),
            },
            format!("files beside {} or in folders below", input.name),
        ));
    }
    let mut scan = series::scan(input.files, found.clone())?;
    if found.len() < named.len() {
        scan.notes.push(format!(
            "{} of the {} files that {} names are not there",
            named.len() - found.len(),
            named.len(),
            input.name
        ));
    }
    read_scan(input.name, scan, input.files, options)
}

/// A multi-frame file alone; a file with one image stands for its whole series in the folder.
pub(crate) fn read_file(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let (elements, result) = elements::read(input.bytes);
    result?;
    if elements.set.has(tags::DIRECTORY_RECORD_SEQUENCE) {
        return read_directory(input, &elements, options);
    }
    if structure_set::is_structure_set(&elements.set) {
        return read_structure_set(input, &elements, options);
    }
    let image = series::image(input.name, input.bytes, elements);
    let image = image.ok_or_else(|| {
        Error::from(ErrorKind::Missing {
            field: tags::field_name(tags::PIXEL_DATA),
            allowed: "this DICOM file holds no image".into(),
        })
    })?;
    if options.series.is_some() {
        return read_folder(input.name, input.files, options);
    }
    let uid = image.series();
    let alone = SingleFile {
        name: input.name,
        bytes: input.bytes,
    };
    if uid.is_empty() || image.frames()? > 1 {
        return assemble(vec![image], None, &alone, options, Vec::new());
    }
    let scan = series::scan(input.files, input.files.names())?;
    let found = scan
        .series
        .iter()
        .position(|(_, images)| images.iter().any(|other| other.name == input.name));
    // Not found there: the file was packed, its bytes are known to us alone.
    let Some(index) = found else {
        return assemble(vec![image], None, &alone, options, Vec::new());
    };
    let mut notes = Vec::new();
    let damaged = damaged(scan.damaged, &uid, &mut notes);
    let mut all = scan.series;
    let (_, images) = all.swap_remove(index);
    damaged?;
    if images.len() > 1 {
        notes.insert(
            0,
            format!(
                "{} is one of {} files of its series, which make one volume",
                input.name,
                images.len()
            ),
        );
    }
    assemble(images, Some(input.name), input.files, options, notes)
}

/// Contours, on the grid of the images on which they were drawn if those are there.
fn read_structure_set(
    input: &Input,
    elements: &elements::Elements,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    let wanted = structure_set::referenced_series(&elements.set);
    let is_wanted = |uid: &str| wanted.iter().any(|wanted| wanted == uid);
    let mut notes = Vec::new();
    let mut scan = series::scan(input.files, input.files.names())?;
    if !scan
        .series
        .iter()
        .any(|(summary, _)| is_wanted(&summary.uid))
    {
        scan = series::scan(input.files, input.files.names_below()?)?;
    }
    let found = scan
        .series
        .into_iter()
        .find(|(summary, _)| is_wanted(&summary.uid));
    let grid = match found {
        Some((summary, mut images)) => {
            drop_copies(&mut images, None, &mut notes);
            let arranged = arranged(&images, options, &mut notes)?;
            notes.push(format!(
                "the grid is that of the {} slices of the series {} in the folder",
                arranged.stack.slices.len(),
                summary.uid
            ));
            Some(arranged.grid)
        }
        None => None,
    };
    structure_set::read(input, elements, grid, options, notes)
}

/// The series of a folder that `options.series` picks, or the only one.
pub(crate) fn read_folder(
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    read_scan(name, scan_here_or_below(files)?, files, options)
}

fn read_scan(
    name: &str,
    scan: series::Scan,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<LoadedVolume, Error> {
    let (summary, images, rest) = scan.pick(options.series.as_deref())?;
    let mut notes = rest.notes;
    damaged(rest.damaged, &summary.uid, &mut notes)?;
    let mut loaded = assemble(images, None, files, options, notes)?;
    if summary.description.is_empty() {
        let (grid, samples, rescale, mut metadata) = loaded.volume.into_parts();
        metadata.name = name.to_owned();
        loaded.volume = Volume::new(grid, samples, rescale, metadata)?;
    }
    Ok(loaded)
}

/// A damaged file of the series is an error, one of an unknown series is told.
fn damaged(
    files: Vec<(String, Option<String>, Error)>,
    uid: &str,
    notes: &mut Vec<String>,
) -> Result<(), Error> {
    for (_, series, error) in files {
        match series {
            Some(series) if series == uid => return Err(error),
            Some(_) => {}
            None => notes.push(format!("left out: {error}")),
        }
    }
    Ok(())
}

/// A file whose bytes are at hand, as if it were alone in its folder.
struct SingleFile<'a> {
    name: &'a str,
    bytes: &'a dyn Bytes,
}

impl Files for SingleFile<'_> {
    fn names(&self) -> Vec<String> {
        vec![self.name.to_owned()]
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>> {
        match name == self.name {
            true => Ok(Box::new(self.bytes)),
            false => Err(io::ErrorKind::NotFound.into()),
        }
    }
}

/// The volume that the images of one series make, of which somebody has `asked` for one.
fn assemble(
    mut images: Vec<Image>,
    asked: Option<&str>,
    files: &dyn Files,
    options: &ReadOptions,
    mut notes: Vec<String>,
) -> Result<LoadedVolume, Error> {
    drop_copies(&mut images, asked, &mut notes);
    if let [image] = &images[..]
        && segmentation::is_segmentation(image.set())
    {
        components::choice(1, Meaning::Vector, options, &mut notes)?;
        let bytes = series::open(files, &image.name)?;
        let mut loaded = segmentation::read(image, &*bytes).map_err(|e| e.in_file(&image.name))?;
        loaded.notes.splice(0..0, notes);
        return Ok(loaded);
    }
    note_mislabeled(&images, &mut notes);
    let Arranged {
        frames,
        stack,
        grid,
    } = arranged(&images, options, &mut notes)?;
    let slices: Vec<&Frame> = stack.slices.iter().map(|slice| &frames[*slice]).collect();
    let layout = slices[0].layout;
    let components = layout.components();
    let choice = components::choice(components.count, Meaning::Color, options, &mut notes)?;

    let rescale = slices[0].rescale;
    let is_uniform = slices.iter().all(|slice| slice.rescale == rescale);
    let reader = Reader {
        files,
        images: &images,
        slices: &slices,
        choice,
    };
    let (mut samples, rescale) = if is_uniform {
        (reader.stored(layout.sample_type)?, rescale)
    } else {
        notes.push(
            "the rescale differs from slice to slice; the values were put on one scale as f32"
                .into(),
        );
        (reader.values(layout.sample_type)?, Rescale::IDENTITY)
    };
    if !stack.resampled.is_empty() {
        reader.keep(grid.voxel_count(), samples.sample_type())?;
        samples = crate::with_samples!(&samples, s => resample(s, layout.frame_samples(), &stack.resampled)?);
    }
    notes.extend(stack.notes.iter().cloned());
    let labels = segmentation::labels_of_map(images[slices[0].image].set());
    let metadata = metadata(&images, &slices, &stack, options, &mut notes);
    Ok(LoadedVolume {
        volume: Volume::new(grid, samples, rescale, metadata)?,
        labels,
        notes,
    })
}

/// Frames in order, and their grid.
struct Arranged {
    frames: Vec<Frame>,
    stack: Stack,
    grid: Grid,
}

/// Where the images of one series lie.
fn arranged(
    images: &[Image],
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Arranged, Error> {
    let frames = place(images, options, notes)?;
    let set = images[frames[0].image].set();
    let thickness = match set.decimal(tags::SPACING_BETWEEN_SLICES)? {
        Some(mm) if mm > 0.0 => Some(mm),
        _ => set.decimal(tags::SLICE_THICKNESS)?,
    };
    let name_of = |frame: &Frame| match images[frame.image].frames() {
        Ok(1) => images[frame.image].name.clone(),
        _ => format!("{}, frame {}", images[frame.image].name, frame.frame + 1),
    };
    let stack = stack::arrange(&frames, &name_of, thickness, options)?;
    let layout = frames[stack.slices[0]].layout;
    let count = match stack.resampled.len() {
        0 => stack.slices.len(),
        n => n,
    };
    let grid = Grid::new([layout.columns, layout.rows, count], stack.world_from_voxel)?;
    Ok(Arranged {
        frames,
        stack,
        grid,
    })
}

fn note_mislabeled(images: &[Image], notes: &mut Vec<String>) {
    let mut odd = images.iter().filter(|image| image.elements.is_mislabeled);
    if let Some(first) = odd.next() {
        let written = match first.elements.syntax.is_explicit {
            true => "explicit",
            false => "implicit",
        };
        notes.push(format!(
            "the elements of {} files have {written} value representations, in contradiction to the transfer syntax (first in {})",
            1 + odd.count(),
            first.name
        ));
    }
}

/// The same image in two files, as exports with several folders have it, counts once: that in the file `asked`, or the
/// first.
fn drop_copies(images: &mut Vec<Image>, asked: Option<&str>, notes: &mut Vec<String>) {
    let uid_of = |image: &Image| image.set().text(tags::SOP_INSTANCE_UID);
    let of_asked = images
        .iter()
        .find(|image| Some(&*image.name) == asked)
        .and_then(uid_of);
    let mut seen = BTreeMap::new();
    let mut left_out: Vec<(String, String)> = Vec::new();
    images.retain(|image| {
        let Some(uid) = uid_of(image) else {
            return true;
        };
        if Some(&uid) == of_asked.as_ref() && Some(&*image.name) != asked {
            left_out.push((image.name.clone(), asked.unwrap_or_default().to_owned()));
            return false;
        }
        match seen.get(&uid) {
            Some(first) => {
                left_out.push((image.name.clone(), String::clone(first)));
                false
            }
            None => {
                seen.insert(uid, image.name.clone());
                true
            }
        }
    });
    match left_out.as_slice() {
        [] => {}
        [(name, read)] => notes.push(format!(
            "{name} has the SOPInstanceUID of {read} and was left out"
        )),
        [(name, read), ..] => notes.push(format!(
            "{} files have the SOPInstanceUID of others and were left out, such as {name} for {read}",
            left_out.len()
        )),
    }
}

/// The frames of the largest group of one size, type and orientation.
fn place(
    images: &[Image],
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<Frame>, Error> {
    let mut groups: Vec<Vec<Frame>> = Vec::new();
    let mut unplaced: Option<(&str, tags::Tag)> = None;
    let mut unsupported: Option<Error> = None;
    let (mut unplaced_count, mut unsupported_count) = (0, 0);
    for (number, image) in images.iter().enumerate() {
        let frames = match frames::of_image(number, image, options, notes) {
            Ok(Ok(frames)) => frames,
            Ok(Err(missing)) => {
                unplaced_count += 1;
                unplaced.get_or_insert((&image.name, missing));
                continue;
            }
            Err(error) if matches!(error.kind(), ErrorKind::Unsupported { .. }) => {
                unsupported_count += 1;
                unsupported.get_or_insert(error.in_file(&image.name));
                continue;
            }
            Err(error) => return Err(error.in_file(&image.name)),
        };
        for frame in frames {
            match groups.iter_mut().find(|group| belongs(&group[0], &frame)) {
                Some(group) => group.push(frame),
                None => groups.push(vec![frame]),
            }
        }
    }
    let largest = groups
        .iter()
        .enumerate()
        // The first of several equal ones: the order of the files is that of their names.
        .max_by_key(|(i, group)| (group.len(), std::cmp::Reverse(*i)))
        .map(|(i, _)| i);
    let Some(largest) = largest else {
        return Err(match (unsupported, unplaced) {
            (Some(error), _) => error,
            (None, unplaced) => {
                let (name, missing) = unplaced.unwrap_or(("", tags::IMAGE_POSITION_PATIENT));
                Error::from(ErrorKind::Missing {
                    field: tags::field_name(missing),
                    allowed: "slices without a place in the patient make no volume; save them as PNG or TIFF and give the spacing when you read those".into(),
                })
                .in_file(name)
            }
        });
    };
    let chosen = groups.swap_remove(largest);
    for group in &groups {
        let (kept, frame) = (&chosen[0], &group[0]);
        let reason = if (frame.layout.columns, frame.layout.rows)
            != (kept.layout.columns, kept.layout.rows)
        {
            format!("other size, {}×{}", frame.layout.columns, frame.layout.rows)
        } else if frame.layout.sample_type != kept.layout.sample_type {
            format!("other sample type, {}", frame.layout.sample_type)
        } else if frame.layout.components() != kept.layout.components() {
            "gray and color".to_owned()
        } else if !is_parallel(frame, kept) {
            "other orientation".to_owned()
        } else {
            "other pixel spacing".to_owned()
        };
        notes.push(format!(
            "{} images were left out ({reason}; first in {})",
            group.len(),
            images[frame.image].name
        ));
    }
    if let Some((name, missing)) = unplaced {
        notes.push(format!(
            "{unplaced_count} images without a place in the patient were left out ({} is missing, first in {name})",
            tags::field_name(missing)
        ));
    }
    if let Some(error) = unsupported {
        notes.push(format!(
            "{unsupported_count} images were left out ({error})"
        ));
    }
    Ok(chosen)
}

/// Whether two frames can be slices of one volume.
fn belongs(a: &Frame, b: &Frame) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a;
    (a.layout.columns, a.layout.rows, a.layout.sample_type)
        == (b.layout.columns, b.layout.rows, b.layout.sample_type)
        && a.layout.components() == b.layout.components()
        && is_parallel(a, b)
        && near(a.spacing[0], b.spacing[0])
        && near(a.spacing[1], b.spacing[1])
}

/// Within rounding: a thousandth moves the far corner of a 512-sample slice by half a sample.
fn is_parallel(a: &Frame, b: &Frame) -> bool {
    a.row.distance(b.row) <= 1e-3 && a.column.distance(b.column) <= 1e-3
}

/// Decodes slices.
struct Reader<'a> {
    files: &'a dyn Files,
    images: &'a [Image],
    slices: &'a [&'a Frame],
    /// Which number of a pixel is read.
    choice: Choice,
}

impl Reader<'_> {
    /// The samples as they are stored.
    fn stored(&self, sample_type: SampleType) -> Result<Samples, Error> {
        with_type!(sample_type, T => {
            self.fill::<T>(|source, frame, samples| source.read(frame.frame, samples))
        })
    }

    /// The rescaled values.
    fn values(&self, sample_type: SampleType) -> Result<Samples, Error> {
        with_type!(sample_type, T => {
            self.fill::<f32>(|source, frame, values| {
                let mut stored = memory::zeroed::<T>(values.len())?;
                source.read(frame.frame, &mut stored)?;
                for (value, stored) in values.iter_mut().zip(stored) {
                    *value = frame.rescale.value(stored.to_f64()) as f32;
                }
                Ok(())
            })
        })
    }

    /// Asks for memory for samples that stay.
    fn keep(&self, count: usize, sample_type: SampleType) -> Result<(), Error> {
        let bytes = self.files.open(&self.images[self.slices[0].image].name)?;
        bytes.keep(block::bytes_of(count, sample_type))
    }

    fn fill<T: Sample>(
        &self,
        read: impl Fn(&Source, &Frame, &mut [T]) -> Result<(), Error> + Sync,
    ) -> Result<Samples, Error> {
        let frame_samples = self.slices[0].layout.frame_samples();
        let count = frame_samples.saturating_mul(self.slices.len());
        self.keep(count, T::TYPE)?;
        let mut samples = memory::zeroed::<T>(count)?;
        let mut by_image: BTreeMap<usize, Vec<(&Frame, &mut [T])>> = BTreeMap::new();
        for (frame, into) in self
            .slices
            .iter()
            .zip(samples.chunks_exact_mut(frame_samples))
        {
            by_image.entry(frame.image).or_default().push((frame, into));
        }
        cores::try_for_each(
            by_image,
            || (),
            |(), (image, parts)| {
                let image = &self.images[image];
                self.read_image(image, parts, &read)
                    .map_err(|error| error.in_file(&image.name))
            },
        )?;
        Ok(T::wrap(samples))
    }

    fn read_image<T: Sample>(
        &self,
        image: &Image,
        parts: Vec<(&Frame, &mut [T])>,
        read: &(impl Fn(&Source, &Frame, &mut [T]) -> Result<(), Error> + Sync),
    ) -> Result<(), Error> {
        let bytes = series::open(self.files, &image.name)?;
        let frame = parts[0].0;
        let layout = frame.tile.map_or(frame.layout, |tile| tile.picture);
        let frames = image.frames()?;
        let bytes: Box<dyn Bytes + '_> = if image.elements.syntax.is_deflated {
            let end = image.pixels.offset + layout.frame_bytes() * frames as u64;
            let inflated = elements::inflate(&*bytes, image.elements.set_offset, end)?;
            if (inflated.len() as u64) < end {
                return Err(ErrorKind::Truncated {
                    what: "the deflated pixel data".into(),
                    expected: end,
                    found: inflated.len() as u64,
                }
                .into());
            }
            Box::new(Whole {
                bytes: inflated,
                file: bytes,
            })
        } else {
            bytes
        };
        let source = Source::new(
            &image.elements,
            image.pixels,
            &layout,
            frames,
            &*bytes,
            self.choice,
        )?;
        if frame.tile.is_some() {
            let mut picture = memory::zeroed::<T>(layout.frame_samples())?;
            read(&source, frame, &mut picture)?;
            for (frame, samples) in parts {
                copy_tile(frame, &picture, samples);
            }
            return Ok(());
        }
        cores::try_for_each(
            parts,
            || (),
            |(), (frame, samples)| read(&source, frame, samples),
        )
    }
}

/// The samples of a slice that is a part of a picture.
fn copy_tile<T: Sample>(frame: &Frame, picture: &[T], into: &mut [T]) {
    let Some(mosaic::Tile {
        picture: layout,
        corner: [left, top],
    }) = frame.tile
    else {
        return;
    };
    let width = frame.layout.columns;
    for (y, row) in into.chunks_exact_mut(width).enumerate() {
        let start = (top + y) * layout.columns + left;
        row.copy_from_slice(&picture[start..start + width]);
    }
}

/// Slices on an even grid, between those that are there.
fn resample<T: Sample>(
    samples: &[T],
    frame_samples: usize,
    places: &[(usize, f64)],
) -> Result<Samples, Error> {
    let mut even = memory::zeroed::<T>(frame_samples.saturating_mul(places.len()))?;
    let slice = |i: usize| &samples[i * frame_samples..(i + 1) * frame_samples];
    for (into, (below, part)) in even.chunks_exact_mut(frame_samples).zip(places) {
        for ((into, low), high) in into.iter_mut().zip(slice(*below)).zip(slice(below + 1)) {
            let (low, high) = (low.to_f64(), high.to_f64());
            *into = T::from_f64(low + (high - low) * part);
        }
    }
    Ok(T::wrap(even))
}

fn metadata(
    images: &[Image],
    slices: &[&Frame],
    stack: &Stack,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Metadata {
    let image = &images[slices[0].image];
    let set = image.set();
    let code = set.text(tags::MODALITY).unwrap_or_default();
    let modality = match code.as_str() {
        "CT" => Some(Modality::Ct),
        "MR" => Some(Modality::Mr),
        "PT" | "NM" => Some(Modality::Nuclear),
        "US" => Some(Modality::Ultrasound),
        "SM" | "GM" => Some(Modality::Microscopy),
        _ => None,
    };
    let transformation = set
        .items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE)
        .first()
        .into_iter()
        .chain(set.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE))
        .flat_map(|groups| groups.items(tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE))
        .next()
        .unwrap_or(set);
    // US is the standard's "unspecified".
    let rescale_type = transformation
        .text(tags::RESCALE_TYPE)
        .or_else(|| set.text(tags::UNITS))
        .or_else(|| set.text(tags::DOSE_UNITS))
        .filter(|unit| unit != "US");
    let value_unit = match (modality, rescale_type) {
        (_, Some(unit)) => Some(unit),
        (Some(Modality::Ct), None) => Some("HU".to_owned()),
        _ => None,
    };

    let mut entries = Vec::new();
    let mut entry = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            entries.push((name.to_owned(), value));
        }
    };
    entry("modality", set.text(tags::MODALITY));
    entry(
        "series description",
        set.description(tags::SERIES_DESCRIPTION),
    );
    entry("series number", set.text(tags::SERIES_NUMBER));
    entry("series UID", set.text(tags::SERIES_INSTANCE_UID));
    entry(
        "study description",
        set.description(tags::STUDY_DESCRIPTION),
    );
    entry("study date", set.text(tags::STUDY_DATE));
    entry("protocol", set.description(tags::PROTOCOL_NAME));
    entry("body part", set.description(tags::BODY_PART_EXAMINED));
    entry("patient position", set.text(tags::PATIENT_POSITION));
    entry("slice thickness (mm)", set.text(tags::SLICE_THICKNESS));
    entry(
        "convolution kernel",
        set.description(tags::CONVOLUTION_KERNEL),
    );
    entry("tube voltage (kV)", set.text(tags::KVP));
    entry("echo time (ms)", set.text(tags::ECHO_TIME));
    entry("manufacturer", set.description(tags::MANUFACTURER));
    entry("model", set.description(tags::MANUFACTURER_MODEL_NAME));
    let window = set
        .items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE)
        .first()
        .into_iter()
        .chain(set.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE))
        .flat_map(|groups| groups.items(tags::FRAME_VOILUT_SEQUENCE))
        .next()
        .unwrap_or(set);
    // Several windows may be there; the first is the one that a viewer opens with.
    let first = |tag| {
        let text = window.text(tag)?;
        text.split('\\').next().map(|part| part.trim().to_owned())
    };
    entry("window center", first(tags::WINDOW_CENTER));
    entry("window width", first(tags::WINDOW_WIDTH));
    if let Some(padding) = set.u16(tags::PIXEL_PADDING_VALUE) {
        let value = match set.u16(tags::PIXEL_REPRESENTATION) {
            Some(1) => i32::from(padding as i16),
            _ => i32::from(padding),
        };
        entry("pixel padding value (stored)", Some(value.to_string()));
    }
    if set.text(tags::PHOTOMETRIC_INTERPRETATION).as_deref() == Some("MONOCHROME1") {
        entry("photometric interpretation", Some("MONOCHROME1".to_owned()));
        notes.push(
            "the images are meant to be shown inverted (MONOCHROME1: low numbers white); the numbers were kept"
                .into(),
        );
    }
    Metadata {
        name: set
            .description(tags::SERIES_DESCRIPTION)
            .or_else(|| set.description(tags::PROTOCOL_NAME))
            .unwrap_or_else(|| image.name.clone()),
        format: "DICOM".into(),
        modality,
        value_unit,
        has_length_unit: true,
        time_points: stack.time_points,
        time_index: options.time_index,
        components: slices[0].layout.components(),
        entries,
    }
}
