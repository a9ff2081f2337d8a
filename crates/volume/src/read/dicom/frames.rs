//! Frames: every image of a series, whether it fills a file or is one of many in it, with its place.

use super::elements::DataSet;
use super::image::{Image, Lookup};
use super::keys::{self, KeyValues};
use super::mosaic::{Mosaic, Tile};
use super::nuclear::Nuclear;
use super::pixels::{Layout, missing_spacing};
use super::segmentation;
use super::tags::{self, Tag, field_name, missing};
use crate::error::{Error, ErrorKind, Remedy};
use crate::{Rescale, read::ReadOptions};
use glam::DVec3;

/// One image of a series. Lengths in mm, in the patient's LPS system.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Which file of the series.
    pub(super) image: usize,
    /// Which frame of the file, from 0.
    pub(super) frame: usize,
    pub(super) layout: Layout,
    /// Center of the first sample.
    pub(super) position: DVec3,
    /// Direction in which the column index grows.
    pub(super) row: DVec3,
    /// Direction in which the row index grows.
    pub(super) column: DVec3,
    /// Distance between columns, and between rows.
    pub(super) spacing: [f64; 2],
    pub(super) rescale: Rescale,
    /// For a slice that is a part of its picture, which part.
    pub(super) tile: Option<Tile>,
    pub(super) keys: KeyValues,
}

impl Frame {
    /// Unit normal of the image: row × column.
    pub(super) fn normal(&self) -> DVec3 {
        self.row.cross(self.column).normalize()
    }
}

/// The frames of a file, or the element that would say where they lie and is missing. `notes` hears what had to be
/// assumed.
///
/// # Errors
/// A missing or impossible value.
pub(super) fn of_image(
    number: usize,
    image: &Image,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Result<Vec<Frame>, Tag>, Error> {
    let set = image.set();
    let keeps_indices = options.as_labels
        || options.label_table.is_some()
        || segmentation::labels_of_map(set).is_some();
    let layout = Layout::of(set, &image.pixels, keeps_indices)?;
    if set.has(tags::MODALITY_LUT_SEQUENCE) && !set.items(tags::MODALITY_LUT_SEQUENCE).is_empty() {
        return Err(ErrorKind::Unsupported {
            feature: field_name(tags::MODALITY_LUT_SEQUENCE),
            instead: "only a linear rescale is; convert the files first".into(),
        }
        .into());
    }
    let count = image.frames()?;
    super::pixels::check_size(
        &image.elements,
        &image.pixels,
        &layout,
        count,
        image.file_bytes,
    )?;
    let nuclear = Nuclear::of(set, count)?;
    let is_described = !set
        .items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE)
        .is_empty();
    let stack = match count {
        1 => None,
        _ if is_described => None,
        _ => Some(Stacked::of(set, count, nuclear.as_ref(), options)?),
    };
    let mosaic = match count {
        1 => Mosaic::of(set, notes)?,
        _ => None,
    };
    let mut frames = Vec::new();
    for index in 0..count {
        let lookup = Lookup::of(set, index);
        let placed = match &stack {
            Some(stack) => Ok((stack.position(index).to_array(), stack.orientation)),
            None => lookup.place()?,
        };
        let (position, orientation) = match placed {
            Ok(place) => place,
            Err(missing) => return Ok(Err(missing)),
        };
        let [row, column] = directions(orientation)?;
        let transformation = lookup.find(
            tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE,
            tags::RESCALE_SLOPE,
        );
        let slope = match transformation.decimal(tags::RESCALE_SLOPE)? {
            Some(slope) => slope,
            None => set.decimal(tags::DOSE_GRID_SCALING)?.unwrap_or(1.0),
        };
        let intercept = transformation
            .decimal(tags::RESCALE_INTERCEPT)?
            .unwrap_or(0.0);
        let groups = nuclear.as_ref().map(|nuclear| nuclear.groups[index]);
        frames.push(Frame {
            image: number,
            frame: index,
            layout,
            position: DVec3::from_array(position),
            row,
            column,
            spacing: spacing(&lookup, options)?,
            rescale: Rescale::new(slope, intercept),
            tile: None,
            keys: keys::of_frame(image, &lookup, index, groups.unwrap_or_default())?,
        });
    }
    if let Some(mosaic) = mosaic {
        frames = tiles(&frames[0], &mosaic, set, options)?;
    }
    if let Some(stack) = stack {
        notes.extend(stack.notes);
    }
    Ok(Ok(frames))
}

/// The slices that the tiles of a picture are.
fn tiles(
    picture: &Frame,
    mosaic: &Mosaic,
    set: &DataSet,
    options: &ReadOptions,
) -> Result<Vec<Frame>, Error> {
    let layout = mosaic.slice_layout(&picture.layout)?;
    let directions = [picture.row, picture.column];
    let (first, step) = mosaic.place(
        set,
        &picture.layout,
        picture.position,
        directions,
        picture.spacing,
        options,
    )?;
    let slice = |k: usize| Frame {
        layout,
        position: first + k as f64 * step,
        tile: Some(mosaic.tile(k, &picture.layout)),
        ..picture.clone()
    };
    Ok((0..mosaic.slices).map(slice).collect())
}

/// Distance between columns, and between rows, in mm.
fn spacing(lookup: &Lookup, options: &ReadOptions) -> Result<[f64; 2], Error> {
    let tag = tags::PIXEL_SPACING;
    let found = lookup
        .find(tags::PIXEL_MEASURES_SEQUENCE, tag)
        .decimal_array::<2>(tag)?;
    // The file gives the distance between rows (along y) first.
    let spacing = match (found, options.spacing_mm) {
        (Some([rows, columns]), _) => [columns, rows],
        (None, Some([x, y, _])) => [x, y],
        (None, None) => {
            return Err(missing(tag, "two lengths in mm").with_remedy(Remedy::Spacing));
        }
    };
    if spacing.iter().any(|mm| *mm <= 0.0) {
        return Err(Error::field(
            field_name(tag),
            format!("{}\\{}", spacing[1], spacing[0]),
            "two lengths above 0 in mm",
        ));
    }
    Ok(spacing)
}

/// Unit vectors along a row and along a column.
fn directions(orientation: [f64; 6]) -> Result<[DVec3; 2], Error> {
    let [a, b, c, d, e, f] = orientation;
    let (row, column) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
    // Written with few digits by some scanners; 1 % is beyond any rounding.
    let is_unit = |v: DVec3| (v.length() - 1.0).abs() < 0.01;
    if !is_unit(row) || !is_unit(column) || row.dot(column).abs() > 0.01 {
        return Err(Error::field(
            field_name(tags::IMAGE_ORIENTATION_PATIENT),
            orientation.map(|v| v.to_string()).join("\\"),
            "two unit vectors at right angles",
        ));
    }
    Ok([row, column])
}

/// Frames of a file without per-frame places, one behind the other along the normal.
struct Stacked {
    origin: DVec3,
    orientation: [f64; 6],
    /// Distance of each frame from the origin.
    offsets_mm: Vec<f64>,
    notes: Vec<String>,
}

impl Stacked {
    fn of(
        set: &DataSet,
        count: usize,
        nuclear: Option<&Nuclear>,
        options: &ReadOptions,
    ) -> Result<Stacked, Error> {
        // Nuclear medicine keeps the place with the detector.
        let find = |tag: Tag| {
            set.items(tags::DETECTOR_INFORMATION_SEQUENCE)
                .iter()
                .find(|item| item.bytes(tag).is_some() && set.bytes(tag).is_none())
                .unwrap_or(set)
        };
        let (position, orientation) = (
            tags::IMAGE_POSITION_PATIENT,
            tags::IMAGE_ORIENTATION_PATIENT,
        );
        let position = find(position).decimal_array::<3>(position)?;
        let orientation = find(orientation).decimal_array::<6>(orientation)?;
        let is_placed = position.is_some() && orientation.is_some();
        let mut notes = Vec::new();
        let offsets_mm = match set.decimals(tags::GRID_FRAME_OFFSET_VECTOR)? {
            Some(offsets) if offsets.len() == count => {
                offsets.iter().map(|offset| offset - offsets[0]).collect()
            }
            Some(offsets) => {
                return Err(Error::field(
                    field_name(tags::GRID_FRAME_OFFSET_VECTOR),
                    format!("a list of {}", offsets.len()),
                    format!("{count} numbers, one a frame"),
                ));
            }
            None => {
                let step = frame_distance(set, count, is_placed, options, &mut notes)?;
                let slice = |frame: usize| nuclear.map_or(frame, |nuclear| nuclear.slices[frame]);
                (0..count).map(|frame| slice(frame) as f64 * step).collect()
            }
        };
        if !is_placed {
            notes.push(
                "the file does not state the patient's orientation; its slices are read as axial, from the feet up"
                    .to_owned(),
            );
        }
        Ok(Stacked {
            origin: DVec3::from_array(position.unwrap_or_default()),
            orientation: orientation.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
            offsets_mm,
            notes,
        })
    }

    fn position(&self, frame: usize) -> DVec3 {
        let [a, b, c, d, e, f] = self.orientation;
        let normal = DVec3::new(a, b, c).cross(DVec3::new(d, e, f));
        self.origin + self.offsets_mm[frame] * normal
    }
}

/// How far apart the slices of a file are that does not place each of its frames.
fn frame_distance(
    set: &DataSet,
    count: usize,
    is_placed: bool,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<f64, Error> {
    if let Some(step) = set.decimal(tags::SPACING_BETWEEN_SLICES)?
        && step != 0.0
    {
        return Ok(step);
    }
    if let Some([_, _, step]) = options.spacing_mm {
        return Ok(step);
    }
    // Frames of a tomograph that lie somewhere are slices, unless the file says that they follow in time.
    let pointer = set.u16s(tags::FRAME_INCREMENT_POINTER).unwrap_or_default();
    let is_film = [tags::FRAME_TIME, tags::FRAME_TIME_VECTOR]
        .iter()
        .any(|time| pointer.starts_with(&[time.0, time.1]));
    let modality = set.text(tags::MODALITY).unwrap_or_default();
    let is_tomograph = matches!(modality.as_str(), "CT" | "MR" | "PT" | "NM");
    match set.decimal(tags::SLICE_THICKNESS)? {
        Some(thickness) if thickness > 0.0 && is_tomograph && is_placed && !is_film => {
            notes.push(format!(
                "the file of {count} frames does not state their distance; the slice thickness, {thickness} mm, is used"
            ));
            Ok(thickness)
        }
        _ => Err(missing_spacing(count)),
    }
}
