//! A file with pixels, and where values of its frames are looked up.

use super::elements::{DataSet, Elements, PixelData};
use super::mosaic::Mosaic;
use super::tags::{self, Tag, field_name};
use crate::error::Error;

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

    /// Number of slices, as far as the elements say.
    pub(super) fn slices(&self) -> usize {
        match Mosaic::of(self.set(), &mut Vec::new()) {
            Ok(Some(mosaic)) => mosaic.slices,
            _ => self.frames().unwrap_or(1),
        }
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

/// ImagePositionPatient and ImageOrientationPatient.
pub(super) type Place = ([f64; 3], [f64; 6]);

/// Where values of a frame are looked up: its own functional groups, the shared ones, the data set.
pub(super) struct Lookup<'a> {
    set: &'a DataSet,
    shared: &'a [DataSet],
    frame: Option<&'a DataSet>,
}

impl<'a> Lookup<'a> {
    pub(super) fn of(set: &'a DataSet, frame: usize) -> Lookup<'a> {
        Lookup {
            set,
            shared: set.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE),
            frame: set
                .items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE)
                .get(frame),
        }
    }

    /// Position and orientation, or the element that is missing.
    pub(super) fn place(&self) -> Result<Result<Place, Tag>, Error> {
        let (position, orientation) = (
            tags::IMAGE_POSITION_PATIENT,
            tags::IMAGE_ORIENTATION_PATIENT,
        );
        let place = self.find(tags::PLANE_POSITION_SEQUENCE, position);
        let axes = self.find(tags::PLANE_ORIENTATION_SEQUENCE, orientation);
        Ok(
            match (
                place.decimal_array(position)?,
                axes.decimal_array(orientation)?,
            ) {
                (Some(place), Some(axes)) => Ok((place, axes)),
                (None, _) => Err(position),
                (_, None) => Err(orientation),
            },
        )
    }

    /// The items of a sequence of functional groups, the frame's own before the shared ones.
    pub(super) fn of_frame(&self, sequence: Tag) -> impl Iterator<Item = &'a DataSet> {
        let groups = self.frame.into_iter().chain(self.shared);
        groups.flat_map(move |groups| groups.items(sequence))
    }

    /// The innermost set that has the element.
    pub(super) fn find(&self, sequence: Tag, tag: Tag) -> &'a DataSet {
        self.of_frame(sequence)
            .find(|item| item.bytes(tag).is_some())
            .unwrap_or(self.set)
    }
}
