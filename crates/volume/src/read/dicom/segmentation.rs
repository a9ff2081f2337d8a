//! DICOM segmentations (PS3.3, C.8.20 and A.51): frames of one segment each, put together to a volume of labels.
//!
//! Binary frames have one bit a sample, the lowest bit of a byte first, and follow each other without a gap, also within
//! a byte. Slices in which a segment is empty are usually left out, so places are taken from the frames and the
//! distance of slices from the pixel measures.

use super::elements::{self, DataSet};
use super::image::{Image, Lookup};
use super::ras::ras;
use super::tags::{self, Tag, field_name, missing};
use crate::error::{Error, ErrorKind};
use crate::read::{Bytes, LoadedVolume};
use crate::{Grid, Label, Metadata, Rescale, Samples, Volume, memory};
use glam::{DAffine3, DMat3, DVec3};

const SEGMENTATION_STORAGE: &str = "1.2.840.10008.5.1.4.1.1.66.4";
const LABEL_MAP_SEGMENTATION_STORAGE: &str = "1.2.840.10008.5.1.4.1.1.66.7";

/// Whether a file holds frames of segments.
pub(super) fn is_segmentation(set: &DataSet) -> bool {
    set.text(tags::SOP_CLASS_UID).as_deref() == Some(SEGMENTATION_STORAGE)
}

/// Ids in the narrowest type.
///
/// # Errors
/// No memory.
pub(super) fn narrowed(ids: Vec<u16>) -> Result<Samples, Error> {
    if ids.iter().any(|id| *id > u16::from(u8::MAX)) {
        return Ok(Samples::U16(ids));
    }
    let mut narrow = memory::reserved(ids.len())?;
    narrow.extend(ids.iter().map(|id| *id as u8));
    Ok(Samples::U8(narrow))
}

/// Names and colors of the segments, of files whose samples are their numbers.
pub(super) fn labels_of_map(set: &DataSet) -> Option<Vec<Label>> {
    let class = set.text(tags::SOP_CLASS_UID);
    (class.as_deref() == Some(LABEL_MAP_SEGMENTATION_STORAGE)).then(|| labels(set))
}

fn labels(set: &DataSet) -> Vec<Label> {
    let label = |segment: &DataSet| {
        let lab = segment.u16s(tags::RECOMMENDED_DISPLAY_CIELAB_VALUE);
        let category = segment
            .items(tags::SEGMENTED_PROPERTY_CATEGORY_CODE_SEQUENCE)
            .first();
        Some(Label {
            id: segment.u16(tags::SEGMENT_NUMBER)?.into(),
            name: segment
                .description_within(tags::SEGMENT_LABEL, set)
                .unwrap_or_default(),
            color: lab.and_then(|lab| Some(srgb_of_lab(*lab.first_chunk()?))),
            group: category.and_then(|code| code.description_within(tags::CODE_MEANING, set)),
        })
    };
    let segments = set.items(tags::SEGMENT_SEQUENCE);
    segments.iter().filter_map(label).collect()
}

/// PCS-values (PS3.3, C.10.7.1.1): L* from 0 to 100, a* and b* from −128 to 127, for a white of D50.
fn srgb_of_lab([l, a, b]: [u16; 3]) -> [f32; 3] {
    let part = |value: u16| f64::from(value) / 65535.0;
    let (l, a, b) = (
        100.0 * part(l),
        255.0 * part(a) - 128.0,
        255.0 * part(b) - 128.0,
    );
    let y = (l + 16.0) / 116.0;
    let linear = |f: f64| match f > 6.0 / 29.0 {
        true => f * f * f,
        false => 3.0 * (6.0f64 / 29.0).powi(2) * (f - 4.0 / 29.0),
    };
    let xyz = DVec3::new(
        0.9642 * linear(y + a / 500.0),
        linear(y),
        0.8249 * linear(y - b / 200.0),
    );
    // Bradford's adaptation to D65 and the primaries of sRGB in one (Lindbloom).
    let rgb = DMat3::from_cols(
        DVec3::new(3.1338561, -0.9787684, 0.0719453),
        DVec3::new(-1.6168667, 1.9161415, -0.2289914),
        DVec3::new(-0.4906146, 0.0334540, 1.4052427),
    ) * xyz;
    let encoded = |c: f64| match c <= 0.003_130_8 {
        true => 12.92 * c,
        false => 1.055 * c.powf(1.0 / 2.4) - 0.055,
    };
    rgb.to_array().map(|c| encoded(c).clamp(0.0, 1.0) as f32)
}

/// One frame: which segment, and where.
struct Part {
    segment: u16,
    frame: usize,
    /// Along the normal, in mm.
    height: f64,
    position: DVec3,
}

/// How the frames lie.
struct Shape {
    columns: usize,
    rows: usize,
    row: DVec3,
    column: DVec3,
    spacing: [f64; 2],
    /// From slice to slice.
    distance: f64,
}

/// The labels of one file.
///
/// # Errors
/// Frames without place or segment, slices that do not lie evenly, packed frames, or too little data.
pub(super) fn read(image: &Image, bytes: &dyn Bytes) -> Result<LoadedVolume, Error> {
    let set = image.set();
    let mut notes = Vec::new();
    let count = image.frames()?;
    let edge = |tag: Tag| match set.u16(tag) {
        Some(n) if n > 0 => Ok(usize::from(n)),
        _ => Err(missing(tag, "1 to 65535")),
    };
    let (rows, columns) = (edge(tags::ROWS)?, edge(tags::COLUMNS)?);
    let threshold = threshold(set, &mut notes)?;
    let frames = Frames::open(image, bytes, columns * rows, count, threshold)?;
    let (shape, parts) = parts(set, count, [columns, rows])?;

    let (low, high) = parts
        .iter()
        .fold((f64::MAX, f64::MIN), |(low, high), part| {
            (low.min(part.height), high.max(part.height))
        });
    let slices = ((high - low) / shape.distance).round() as usize + 1;
    // Empty slices are left out, but not nearly all: more would be memory that no file backs.
    if slices > 64 * count {
        return Err(ErrorKind::Slices(format!(
            "{count} frames lie along {} mm with slices {} mm apart; at most {} slices are made of them",
            high - low,
            shape.distance,
            64 * count
        ))
        .into());
    }
    let slice_samples = columns * rows;
    let total = slice_samples
        .checked_mul(slices)
        .ok_or_else(|| Error::field("number of slices", slices, "fewer"))?;
    bytes.keep(2 * total as u64)?;
    let mut voxels: Vec<u16> = memory::zeroed(total)?;
    let mut overlaps = 0usize;
    for part in &parts {
        let place = (part.height - low) / shape.distance;
        if (place - place.round()).abs() > 0.1 {
            return Err(ErrorKind::Slices(format!(
                "frame {} lies {:.3} slices above the first; the slices of a segmentation lie evenly",
                part.frame + 1,
                place
            ))
            .into());
        }
        let start = place.round() as usize * slice_samples;
        overlaps += frames.add(part, &mut voxels[start..start + slice_samples])?;
    }
    if overlaps > 0 {
        notes.push(format!(
            "{overlaps} voxels belong to several segments; that of the later frame is kept"
        ));
    }
    let first = parts.iter().min_by(|a, b| a.height.total_cmp(&b.height));
    let origin = first.map_or(DVec3::ZERO, |part| part.position);
    let normal = shape.row.cross(shape.column).normalize();
    let world_from_voxel = DAffine3::from_mat3_translation(
        DMat3::from_cols(
            ras(shape.row * shape.spacing[0]),
            ras(shape.column * shape.spacing[1]),
            ras(normal * shape.distance),
        ),
        ras(origin),
    );
    let samples = narrowed(voxels)?;
    let volume = Volume::new(
        Grid::new([columns, rows, slices], world_from_voxel)?,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: set
                .description(tags::SERIES_DESCRIPTION)
                .unwrap_or_else(|| image.name.clone()),
            format: "DICOM SEG".into(),
            has_length_unit: true,
            time_points: 1,
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: Some(labels(set)),
        notes,
    })
}

/// The least stored value that counts as inside; `None` for frames of bits.
fn threshold(set: &DataSet, notes: &mut Vec<String>) -> Result<Option<u8>, Error> {
    match set.u16(tags::BITS_ALLOCATED) {
        Some(1) => Ok(None),
        Some(8) if set.text(tags::SEGMENTATION_TYPE).as_deref() == Some("FRACTIONAL") => {
            let most = set.u16(tags::MAXIMUM_FRACTIONAL_VALUE).unwrap_or(255);
            notes.push("the segments are fractional; voxels of at least a half are inside".into());
            Ok(Some(most.div_ceil(2).clamp(1, 255) as u8))
        }
        Some(8) => Ok(Some(1)),
        other => Err(Error::field(
            field_name(tags::BITS_ALLOCATED),
            other.map_or("missing".into(), |n| n.to_string()),
            "1 or 8 for a segmentation",
        )),
    }
}

/// Segment and place of every frame.
fn parts(
    set: &DataSet,
    count: usize,
    [columns, rows]: [usize; 2],
) -> Result<(Shape, Vec<Part>), Error> {
    let mut shape: Option<Shape> = None;
    let mut parts = Vec::new();
    for frame in 0..count {
        let lookup = Lookup::of(set, frame);
        let number = tags::REFERENCED_SEGMENT_NUMBER;
        let segment = lookup
            .find(tags::SEGMENT_IDENTIFICATION_SEQUENCE, number)
            .u16(number)
            .ok_or_else(|| missing(number, "the segment of each frame"))?;
        let (position, orientation) = lookup
            .place()?
            .map_err(|tag| missing(tag, "a place for each frame"))?;
        let [a, b, c, d, e, f] = orientation;
        let (row, column) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
        let position = DVec3::from_array(position);
        let shape = match &shape {
            Some(shape) if shape.row.distance(row) + shape.column.distance(column) > 2e-3 => {
                return Err(ErrorKind::Slices(format!(
                    "frame {} has another orientation than the first",
                    frame + 1
                ))
                .into());
            }
            Some(shape) => shape,
            None => {
                let measures = |tag: Tag| lookup.find(tags::PIXEL_MEASURES_SEQUENCE, tag);
                let spacing = measures(tags::PIXEL_SPACING)
                    .decimal_array::<2>(tags::PIXEL_SPACING)?
                    .filter(|mm| mm.iter().all(|mm| *mm > 0.0))
                    .ok_or_else(|| missing(tags::PIXEL_SPACING, "two lengths above 0 in mm"))?;
                let mut distance = None;
                for tag in [tags::SPACING_BETWEEN_SLICES, tags::SLICE_THICKNESS] {
                    let found = measures(tag).decimal(tag)?;
                    distance = distance.or(found.filter(|mm| *mm > 0.0));
                }
                shape.insert(Shape {
                    columns,
                    rows,
                    row,
                    column,
                    spacing: [spacing[1], spacing[0]],
                    distance: distance.unwrap_or(0.0),
                })
            }
        };
        let normal = shape.row.cross(shape.column);
        parts.push(Part {
            segment,
            frame,
            height: position.dot(normal),
            position,
        });
    }
    let mut shape = shape.ok_or_else(|| missing(tags::PIXEL_DATA, "one frame or more"))?;
    debug_assert_eq!((shape.columns, shape.rows), (columns, rows));
    if shape.distance == 0.0 {
        shape.distance = least_distance(&parts)
            .ok_or_else(|| missing(tags::SPACING_BETWEEN_SLICES, "a length above 0 in mm"))?;
    }
    Ok((shape, parts))
}

/// The least distance between two places.
fn least_distance(parts: &[Part]) -> Option<f64> {
    let mut heights: Vec<f64> = parts.iter().map(|part| part.height).collect();
    heights.sort_by(f64::total_cmp);
    let distances = heights.windows(2).map(|pair| pair[1] - pair[0]);
    distances.filter(|mm| *mm > 1e-3).min_by(f64::total_cmp)
}

/// The stored samples of all frames.
struct Frames<'a> {
    bytes: Stored<'a>,
    offset: u64,
    frame_samples: usize,
    threshold: Option<u8>,
}

enum Stored<'a> {
    File(&'a dyn Bytes),
    Inflated(Vec<u8>),
}

impl<'a> Frames<'a> {
    fn open(
        image: &Image,
        bytes: &'a dyn Bytes,
        frame_samples: usize,
        count: usize,
        threshold: Option<u8>,
    ) -> Result<Frames<'a>, Error> {
        let syntax = &image.elements.syntax;
        if syntax.is_encapsulated {
            return Err(ErrorKind::Unsupported {
                feature: "a segmentation whose frames are packed".into(),
                instead: super::syntax::CONVERT.into(),
            }
            .into());
        }
        let samples = (frame_samples as u64).checked_mul(count as u64);
        let expected = samples
            .map(|samples| match threshold {
                None => samples.div_ceil(8),
                Some(_) => samples,
            })
            .ok_or_else(|| Error::field(field_name(tags::NUMBER_OF_FRAMES), count, "fewer"))?;
        let end = image.pixels.offset.saturating_add(expected);
        let bytes = match syntax.is_deflated {
            true => Stored::Inflated(elements::inflate(bytes, image.elements.set_offset, end)?),
            false => Stored::File(bytes),
        };
        let frames = Frames {
            bytes,
            offset: image.pixels.offset,
            frame_samples,
            threshold,
        };
        let found = frames.stored().len();
        match found < end {
            true => Err(ErrorKind::Truncated {
                what: "the pixel data of the segmentation".into(),
                expected: end,
                found,
            }
            .into()),
            false => Ok(frames),
        }
    }

    fn stored(&self) -> &dyn Bytes {
        match &self.bytes {
            Stored::File(bytes) => *bytes,
            Stored::Inflated(bytes) => bytes,
        }
    }

    /// Writes the segment of a frame into a slice; returns how many voxels had another one.
    fn add(&self, part: &Part, slice: &mut [u16]) -> Result<usize, Error> {
        let first = part.frame as u64 * self.frame_samples as u64;
        let mut overlaps = 0;
        let mut mark = |label: &mut u16| {
            overlaps += usize::from(*label != 0 && *label != part.segment);
            *label = part.segment;
        };
        match self.threshold {
            Some(least) => {
                let mut stored = memory::zeroed(self.frame_samples)?;
                self.stored().read_at(self.offset + first, &mut stored)?;
                let inside = slice
                    .iter_mut()
                    .zip(stored)
                    .filter(|(_, value)| *value >= least);
                inside.for_each(|(label, _)| mark(label));
            }
            None => {
                let (start, shift) = (first / 8, (first % 8) as usize);
                let mut stored = memory::zeroed((shift + self.frame_samples).div_ceil(8))?;
                self.stored().read_at(self.offset + start, &mut stored)?;
                for (i, label) in slice.iter_mut().enumerate() {
                    let bit = shift + i;
                    if stored[bit / 8] >> (bit % 8) & 1 == 1 {
                        mark(label);
                    }
                }
            }
        }
        Ok(overlaps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_of_segments_are_those_of_the_standard() {
        // sRGB red, green and white as CIELab of D50 (Lindbloom's calculator), in the integers of DICOM.
        let stored = |l: f64, a: f64, b: f64| {
            [l / 100.0, (a + 128.0) / 255.0, (b + 128.0) / 255.0]
                .map(|part| (part * 65535.0).round() as u16)
        };
        for (lab, rgb) in [
            (stored(54.29, 80.81, 69.89), [1.0, 0.0, 0.0]),
            (stored(87.82, -79.29, 80.99), [0.0, 1.0, 0.0]),
            (stored(100.0, 0.0, 0.0), [1.0, 1.0, 1.0]),
        ] {
            let found = srgb_of_lab(lab);
            for (found, expected) in found.iter().zip(rgb) {
                assert!((found - expected).abs() < 0.01, "{found} is not {expected}");
            }
        }
    }
}
