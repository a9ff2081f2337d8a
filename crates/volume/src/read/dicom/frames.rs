//! Frames: every image of a series, whether it fills a file or is one of many in it, with its place.

use super::elements::{DataSet, Elements, PixelData};
use super::pixels::{Layout, missing};
use super::tags::{self, Tag, field_name};
use crate::error::{Error, ErrorKind, Remedy};
use crate::{Rescale, read::ReadOptions};
use glam::DVec3;

/// A DICOM file that holds pixels.
#[derive(Clone, Debug)]
pub(super) struct Image {
    pub(super) name: String,
    pub(super) file_bytes: u64,
    pub(super) elements: Elements,
    pub(super) pixels: PixelData,
}

impl Image {
    /// The elements outside of functional groups.
    pub(super) fn set(&self) -> &DataSet {
        &self.elements.set
    }

    /// The series it belongs to.
    pub(super) fn series(&self) -> String {
        self.set()
            .text(tags::SERIES_INSTANCE_UID)
            .unwrap_or_default()
    }

    /// Number of frames.
    ///
    /// # Errors
    /// A number that is not a whole one above 0, or not that of the frames described.
    pub(super) fn frames(&self) -> Result<usize, Error> {
        let count = match self.set().decimal(tags::NUMBER_OF_FRAMES)? {
            None => 1,
            Some(n) if n >= 1.0 && n.fract() == 0.0 && n <= f64::from(u32::MAX) => n as usize,
            Some(n) => {
                return Err(Error::field(
                    field_name(tags::NUMBER_OF_FRAMES),
                    n,
                    "a whole number from 1",
                ));
            }
        };
        let described = self
            .set()
            .items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE)
            .len();
        if described != 0 && described != count {
            return Err(Error::field(
                field_name(tags::NUMBER_OF_FRAMES),
                count,
                format!("{described}, as many as the per-frame functional groups"),
            ));
        }
        Ok(count)
    }
}

/// What may tell images at the same place apart, and in which order they then come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Key {
    pub(super) name: &'static str,
    /// Whether all places must show the same values; times differ from slice to slice.
    pub(super) is_shared: bool,
}

/// Tried in this order.
pub(super) const KEYS: [Key; 7] = [
    Key {
        name: "temporal position",
        is_shared: true,
    },
    Key {
        name: "trigger time (ms)",
        is_shared: false,
    },
    Key {
        name: "acquisition time",
        is_shared: false,
    },
    Key {
        name: "acquisition number",
        is_shared: true,
    },
    Key {
        name: "echo time (ms)",
        is_shared: true,
    },
    Key {
        name: "diffusion b-value (s/mm²)",
        is_shared: true,
    },
    Key {
        name: "image type",
        is_shared: true,
    },
];

/// The value of a key.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub(super) enum KeyValue {
    Number(f64),
    Text(String),
}

impl std::fmt::Display for KeyValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            KeyValue::Number(number) => number.fmt(f),
            KeyValue::Text(text) => f.write_str(text),
        }
    }
}

/// One image of a series. Lengths in mm, in the patient's LPS system.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Which file of the series.
    pub(super) image: usize,
    /// Which frame of the file, from 0.
    pub(super) frame: usize,
    pub(super) layout: Layout,
    /// Centre of the first sample.
    pub(super) position: DVec3,
    /// Direction in which the column index grows.
    pub(super) row: DVec3,
    /// Direction in which the row index grows.
    pub(super) column: DVec3,
    /// Distance between columns, and between rows.
    pub(super) spacing: [f64; 2],
    pub(super) rescale: Rescale,
    pub(super) keys: [Option<KeyValue>; KEYS.len()],
}

impl Frame {
    /// Unit normal of the image: row × column.
    pub(super) fn normal(&self) -> DVec3 {
        self.row.cross(self.column).normalize()
    }
}

/// Where values of a frame are looked up: its own functional groups, the shared ones, the data set.
struct Lookup<'a> {
    set: &'a DataSet,
    shared: &'a [DataSet],
    frame: Option<&'a DataSet>,
}

impl<'a> Lookup<'a> {
    fn of(set: &'a DataSet, frame: usize) -> Lookup<'a> {
        Lookup {
            set,
            shared: set.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE),
            frame: set
                .items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE)
                .get(frame),
        }
    }

    /// The innermost set that has the element.
    fn find(&self, sequence: Tag, tag: Tag) -> &'a DataSet {
        self.frame
            .into_iter()
            .chain(self.shared)
            .flat_map(|groups| groups.items(sequence))
            .find(|item| item.bytes(tag).is_some())
            .unwrap_or(self.set)
    }

    fn keys(&self) -> Result<[Option<KeyValue>; KEYS.len()], Error> {
        let number = |n: Option<f64>| n.map(KeyValue::Number);
        let content = tags::FRAME_CONTENT_SEQUENCE;
        let temporal = match self.set.decimal(tags::TEMPORAL_POSITION_IDENTIFIER)? {
            Some(n) => Some(n),
            None => self
                .find(content, tags::TEMPORAL_POSITION_INDEX)
                .u32(tags::TEMPORAL_POSITION_INDEX)
                .map(f64::from),
        };
        let delay = tags::NOMINAL_CARDIAC_TRIGGER_DELAY_TIME;
        let trigger = match self.set.decimal(tags::TRIGGER_TIME)? {
            Some(n) => Some(n),
            None => self
                .find(tags::CARDIAC_SYNCHRONIZATION_SEQUENCE, delay)
                .f64(delay),
        };
        let acquired = self
            .find(content, tags::FRAME_ACQUISITION_DATE_TIME)
            .text(tags::FRAME_ACQUISITION_DATE_TIME)
            .or_else(|| self.set.text(tags::ACQUISITION_DATE_TIME))
            .or_else(|| self.set.text(tags::ACQUISITION_TIME));
        let echo = match self.set.decimal(tags::ECHO_TIME)? {
            Some(n) => Some(n),
            None => self
                .find(tags::MR_ECHO_SEQUENCE, tags::EFFECTIVE_ECHO_TIME)
                .f64(tags::EFFECTIVE_ECHO_TIME),
        };
        let b_value = self
            .find(tags::MR_DIFFUSION_SEQUENCE, tags::DIFFUSION_B_VALUE)
            .f64(tags::DIFFUSION_B_VALUE);
        let image_type = [
            tags::MR_IMAGE_FRAME_TYPE_SEQUENCE,
            tags::CT_IMAGE_FRAME_TYPE_SEQUENCE,
        ]
        .into_iter()
        .find_map(|sequence| self.find(sequence, tags::FRAME_TYPE).text(tags::FRAME_TYPE))
        .or_else(|| self.set.text(tags::IMAGE_TYPE));
        Ok([
            number(temporal),
            number(trigger),
            // Dates and times sort as text: the largest units come first.
            acquired.map(KeyValue::Text),
            number(self.set.decimal(tags::ACQUISITION_NUMBER)?),
            number(echo),
            number(b_value.filter(|b| b.is_finite())),
            image_type.map(KeyValue::Text),
        ])
    }
}

/// The frames of a file, or `None` if nothing says where they lie. `notes` hears what had to be
/// assumed.
///
/// # Errors
/// A missing or impossible value.
pub(super) fn of_image(
    number: usize,
    image: &Image,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Option<Vec<Frame>>, Error> {
    let set = image.set();
    let layout = Layout::of(set, &image.pixels)?;
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
    let stack = match count {
        1 => None,
        _ if !set
            .items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE)
            .is_empty() =>
        {
            None
        }
        _ => Some(Stacked::of(set, count, options)?),
    };
    let mut frames = Vec::new();
    for index in 0..count {
        let lookup = Lookup::of(set, index);
        let (position, orientation) = match &stack {
            Some(stack) => (
                Some(stack.position(index).to_array()),
                Some(stack.orientation),
            ),
            None => {
                let (position, orientation) = (
                    tags::IMAGE_POSITION_PATIENT,
                    tags::IMAGE_ORIENTATION_PATIENT,
                );
                (
                    lookup
                        .find(tags::PLANE_POSITION_SEQUENCE, position)
                        .decimal_array(position)?,
                    lookup
                        .find(tags::PLANE_ORIENTATION_SEQUENCE, orientation)
                        .decimal_array(orientation)?,
                )
            }
        };
        let (Some(position), Some(orientation)) = (position, orientation) else {
            return Ok(None);
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
        frames.push(Frame {
            image: number,
            frame: index,
            layout,
            position: DVec3::from_array(position),
            row,
            column,
            spacing: spacing(&lookup, options)?,
            rescale: Rescale::new(slope, intercept),
            keys: lookup.keys()?,
        });
    }
    if let Some(stack) = stack {
        notes.extend(stack.note.clone());
    }
    Ok(Some(frames))
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
    note: Option<String>,
}

impl Stacked {
    fn of(set: &DataSet, count: usize, options: &ReadOptions) -> Result<Stacked, Error> {
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
        let mut note = None;
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
                let step = match (
                    set.decimal(tags::SPACING_BETWEEN_SLICES)?,
                    options.spacing_mm,
                ) {
                    (Some(step), _) if step != 0.0 => step,
                    (_, Some([_, _, step])) => step,
                    _ => {
                        return Err(Error::from(ErrorKind::Unsupported {
                            feature: format!(
                                "a file of {count} frames that says neither where each lies (functional groups) nor {}",
                                field_name(tags::SPACING_BETWEEN_SLICES)
                            ),
                            instead: "its frames may be moments of a film; if they are slices, their spacing has to be said".into(),
                        })
                        .with_remedy(Remedy::Spacing));
                    }
                };
                (0..count).map(|frame| frame as f64 * step).collect()
            }
        };
        if position.is_none() || orientation.is_none() {
            note = Some(
                "the file does not say how the patient lay; its slices count as axial, from the feet up"
                    .to_owned(),
            );
        }
        Ok(Stacked {
            origin: DVec3::from_array(position.unwrap_or_default()),
            orientation: orientation.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
            offsets_mm,
            note,
        })
    }

    fn position(&self, frame: usize) -> DVec3 {
        let [a, b, c, d, e, f] = self.orientation;
        let normal = DVec3::new(a, b, c).cross(DVec3::new(d, e, f));
        self.origin + self.offsets_mm[frame] * normal
    }
}
