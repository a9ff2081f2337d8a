//! What tells images at one place apart: time, echo, diffusion direction, … and the groups of a nuclear study.

use super::elements::DataSet;
use super::image::{Image, Lookup};
use super::tags::{self, Tag};
use crate::error::Error;

/// What may tell images at the same place apart, and in which order they then come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Key {
    pub(super) name: &'static str,
    /// Whether all places must show the same values; times differ from slice to slice.
    pub(super) is_shared: bool,
    /// Whether its values have an order of their own. Without, images come as they were acquired.
    pub(super) is_ordered: bool,
    /// It says nothing of what the images show, so it is asked last and alone.
    pub(super) is_last_resort: bool,
}

const fn shared(name: &'static str) -> Key {
    Key {
        name,
        is_shared: true,
        is_ordered: true,
        is_last_resort: false,
    }
}

const fn own(name: &'static str) -> Key {
    Key {
        is_shared: false,
        ..shared(name)
    }
}

/// Tried in this order.
pub(super) const KEYS: [Key; 21] = [
    // What the writer of a multi-frame file sorted by.
    shared("dimension index"),
    shared("temporal position"),
    own("trigger time (ms)"),
    shared("frame reference time (ms)"),
    shared("energy window"),
    shared("detector"),
    shared("phase"),
    shared("R-R interval"),
    shared("time slot"),
    shared("time slice"),
    own("acquisition time"),
    shared("acquisition number"),
    shared("echo time (ms)"),
    shared("inversion time (ms)"),
    shared("flip angle (degrees)"),
    shared("diffusion b-value (s/mm²)"),
    Key {
        is_ordered: false,
        ..shared("diffusion gradient direction")
    },
    shared("complex component"),
    shared("image type"),
    Key {
        is_last_resort: true,
        ..own("content time")
    },
    Key {
        is_last_resort: true,
        ..own("instance number")
    },
];

/// Which of [`KEYS`] is the order of acquisition.
pub(super) const INSTANCE_NUMBER: usize = KEYS.len() - 1;

/// The value of a key.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub(super) enum KeyValue {
    Number(f64),
    Text(String),
    Numbers(Vec<f64>),
}

impl std::fmt::Display for KeyValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            KeyValue::Number(number) => number.fmt(f),
            KeyValue::Text(text) => f.write_str(text),
            KeyValue::Numbers(numbers) => {
                for (i, number) in numbers.iter().enumerate() {
                    let before = if i > 0 { " " } else { "" };
                    write!(f, "{before}{}", (number * 1e3).round() / 1e3)?;
                }
                Ok(())
            }
        }
    }
}

/// The values of all keys.
pub(super) type KeyValues = [Option<KeyValue>; KEYS.len()];

/// The vectors of nuclear medicine that number the groups of frames (PS3.3, C.8.4.8), in the order of their keys.
pub(super) const NUCLEAR_VECTORS: [Tag; 6] = [
    tags::ENERGY_WINDOW_VECTOR,
    tags::DETECTOR_VECTOR,
    tags::PHASE_VECTOR,
    tags::RR_INTERVAL_VECTOR,
    tags::TIME_SLOT_VECTOR,
    tags::TIME_SLICE_VECTOR,
];

/// What a frame says for each key. `groups` are its numbers in [`NUCLEAR_VECTORS`].
///
/// # Errors
/// A number that is none.
pub(super) fn of_frame(
    image: &Image,
    lookup: &Lookup,
    frame: usize,
    groups: [Option<u16>; NUCLEAR_VECTORS.len()],
) -> Result<KeyValues, Error> {
    let set = image.set();
    let number = |n: Option<f64>| n.filter(|n| n.is_finite()).map(KeyValue::Number);
    let decimal = |tag: Tag| Ok::<_, Error>(number(set.decimal(tag)?));
    let content = tags::FRAME_CONTENT_SEQUENCE;
    let temporal = match set.decimal(tags::TEMPORAL_POSITION_IDENTIFIER)? {
        Some(n) => Some(n),
        None => lookup
            .find(content, tags::TEMPORAL_POSITION_INDEX)
            .u32(tags::TEMPORAL_POSITION_INDEX)
            .map(f64::from),
    };
    let delay = tags::NOMINAL_CARDIAC_TRIGGER_DELAY_TIME;
    let trigger = match set.decimal(tags::TRIGGER_TIME)? {
        Some(n) => Some(n),
        None => lookup
            .find(tags::CARDIAC_SYNCHRONIZATION_SEQUENCE, delay)
            .f64(delay),
    };
    let acquired = lookup
        .find(content, tags::FRAME_ACQUISITION_DATE_TIME)
        .text(tags::FRAME_ACQUISITION_DATE_TIME)
        .or_else(|| set.text(tags::ACQUISITION_DATE_TIME))
        .or_else(|| set.text(tags::ACQUISITION_TIME));
    let echo = match set.decimal(tags::ECHO_TIME)? {
        Some(n) => Some(n),
        None => lookup
            .find(tags::MR_ECHO_SEQUENCE, tags::EFFECTIVE_ECHO_TIME)
            .f64(tags::EFFECTIVE_ECHO_TIME),
    };
    let diffusion = lookup.find(tags::MR_DIFFUSION_SEQUENCE, tags::DIFFUSION_B_VALUE);
    let b_value = diffusion.f64(tags::DIFFUSION_B_VALUE);
    let orientation = tags::DIFFUSION_GRADIENT_ORIENTATION;
    // In a sequence of its own in multi-frame files, beside the b-value in others.
    let direction = lookup
        .of_frame(tags::MR_DIFFUSION_SEQUENCE)
        .flat_map(|item| item.items(tags::DIFFUSION_GRADIENT_DIRECTION_SEQUENCE))
        .find_map(|item| item.f64s(orientation))
        .or_else(|| set.f64s(orientation));
    let frame_type = [
        tags::MR_IMAGE_FRAME_TYPE_SEQUENCE,
        tags::CT_IMAGE_FRAME_TYPE_SEQUENCE,
    ]
    .into_iter()
    .find_map(|sequence| {
        let item = lookup.find(sequence, tags::FRAME_TYPE);
        item.text(tags::FRAME_TYPE)
    })
    .or_else(|| set.text(tags::IMAGE_TYPE));
    let component = tags::COMPLEX_IMAGE_COMPONENT;
    let component = lookup
        .find(tags::MR_IMAGE_FRAME_TYPE_SEQUENCE, component)
        .text(component);
    let [window, detector, phase, interval, slot, time_slice] =
        groups.map(|group| group.map(|n| KeyValue::Number(n.into())));
    // Frames of one file follow one another.
    let instance = set.decimal(tags::INSTANCE_NUMBER)?;
    let instance = match image.frames()? {
        1 => instance.map(|n| vec![n]),
        _ => Some(vec![instance.unwrap_or(0.0), frame as f64 + 1.0]),
    };
    Ok([
        dimension_index(set, lookup).map(KeyValue::Numbers),
        number(temporal),
        number(trigger),
        decimal(tags::FRAME_REFERENCE_TIME)?,
        window,
        detector,
        phase,
        interval,
        slot,
        time_slice,
        // Dates and times sort as text: the largest units come first.
        acquired.map(KeyValue::Text),
        decimal(tags::ACQUISITION_NUMBER)?,
        number(echo),
        decimal(tags::INVERSION_TIME)?,
        decimal(tags::FLIP_ANGLE)?,
        number(b_value),
        direction.map(KeyValue::Numbers),
        component.map(KeyValue::Text),
        frame_type.map(KeyValue::Text),
        set.text(tags::CONTENT_TIME).map(KeyValue::Text),
        instance.map(KeyValue::Numbers),
    ])
}

/// The frame's DimensionIndexValues without those that number places.
fn dimension_index(set: &DataSet, lookup: &Lookup) -> Option<Vec<f64>> {
    let places = [
        tags::STACK_ID,
        tags::IN_STACK_POSITION_NUMBER,
        tags::IMAGE_POSITION_PATIENT,
    ];
    let is_place = |item: &DataSet| {
        let pointer = item.u16s(tags::DIMENSION_INDEX_POINTER).unwrap_or_default();
        matches!(pointer[..], [group, element] if places.contains(&Tag(group, element)))
    };
    let dimensions = set.items(tags::DIMENSION_INDEX_SEQUENCE);
    let values = lookup
        .of_frame(tags::FRAME_CONTENT_SEQUENCE)
        .find_map(|item| item.u32s(tags::DIMENSION_INDEX_VALUES))?;
    let kept: Vec<f64> = dimensions
        .iter()
        .zip(&values)
        .filter(|(dimension, _)| !is_place(dimension))
        .map(|(_, value)| f64::from(*value))
        .collect();
    (dimensions.len() == values.len() && !kept.is_empty()).then_some(kept)
}
