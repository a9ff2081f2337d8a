//! Siemens mosaics: all slices of a volume as tiles of one picture, row by row from the top left.
//!
//! How many there are and which way they follow each other stands in the private CSA header (0029,xx10):
//!
//! | offset | bytes | what                                                                                    |
//! |--------|-------|-----------------------------------------------------------------------------------------|
//! | 0      | 8     | `SV10` 04 03 02 01 (version 2; version 1 goes without)                                  |
//! | 8 or 0 | 4, 4  | number n of tags, 77                                                                    |
//! | …      | n × … | name (64), number of values (4), VR (4), syngo's type (4), number of items (4), 77 or 205 (4), items |
//! | item   | 16    | four numbers; the second is the length (version 1: the first, less the items of the first tag) |
//! | …      | …     | text, filled up to 4 bytes                                                              |
//!
//! ImagePositionPatient is the corner of a picture as large as the mosaic about the middle of a slice, so it is moved
//! by half of the difference; so do nibabel (`MosaicWrapper.image_position`) and dcm2niix.

use super::elements::{DataSet, plain_text};
use super::pixels::{Layout, missing_spacing};
use super::tags::{self, Tag, field_name};
use crate::error::{Error, ErrorKind};
use crate::read::ReadOptions;
use glam::DVec3;

/// A picture of tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mosaic {
    /// How many tiles hold a slice.
    pub(super) slices: usize,
    /// Tiles along an edge.
    across: usize,
    /// Which way the slices follow each other, if the CSA header says.
    normal: Option<DVec3>,
}

/// Which part of a picture is a slice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// How the whole picture is stored.
    pub(super) picture: Layout,
    /// Column and row of its first sample.
    pub(super) corner: [usize; 2],
}

/// Where the CSA header may lie: the block of private elements is free.
pub(super) const CSA_HEADERS: [Tag; 3] = [
    tags::CSA_IMAGE_HEADER,
    tags::CSA_IMAGE_HEADER_IN_BLOCK_11,
    tags::CSA_IMAGE_HEADER_IN_BLOCK_12,
];

impl Mosaic {
    /// The tiles of a picture of one frame that says it is a mosaic, and says how many slices it has. `notes` hears of
    /// one that does not.
    ///
    /// # Errors
    /// It is larger than what was acquired and does not say its number of slices.
    pub(super) fn of(set: &DataSet, notes: &mut Vec<String>) -> Result<Option<Mosaic>, Error> {
        let image_type = set.text(tags::IMAGE_TYPE).unwrap_or_default();
        let says_so = image_type.split('\\').any(|part| part.trim() == "MOSAIC");
        // Newer scanners write slices as frames and still say MOSAIC.
        if !says_so || set.has(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE) {
            return Ok(None);
        }
        let csa = CSA_HEADERS
            .into_iter()
            .filter_map(|tag| Csa::parse(set.bytes(tag)?))
            .find(|csa| csa.slices.is_some())
            .unwrap_or_default();
        let private = set.u16(tags::NUMBER_OF_IMAGES_IN_MOSAIC).map(usize::from);
        let Some(slices) = csa
            .slices
            .or(private)
            .filter(|n| (1..=MOST_SLICES).contains(n))
        else {
            return Mosaic::of_unknown_number(set, notes);
        };
        let across = (1..).find(|edge| edge * edge >= slices).unwrap_or(1);
        Ok(Some(Mosaic {
            slices,
            across,
            normal: csa.normal,
        }))
    }

    fn of_unknown_number(set: &DataSet, notes: &mut Vec<String>) -> Result<Option<Mosaic>, Error> {
        let acquired = set.u16s(tags::ACQUISITION_MATRIX).unwrap_or_default();
        let acquired = acquired.into_iter().max().unwrap_or(0);
        let rows = set.u16(tags::ROWS).unwrap_or(0);
        if acquired > 0 && rows / 2 >= acquired {
            return Err(ErrorKind::Unsupported {
                feature: format!(
                    "a Siemens mosaic without {} and without its CSA header {}",
                    field_name(tags::NUMBER_OF_IMAGES_IN_MOSAIC),
                    field_name(tags::CSA_IMAGE_HEADER)
                ),
                instead: "no element states the number of slices; use files whose private elements were not removed".into(),
            }
            .into());
        }
        notes.push(
            "the images are marked MOSAIC but do not state their number of slices; each is read as one slice".into(),
        );
        Ok(None)
    }

    /// The layout of a slice.
    ///
    /// # Errors
    /// A picture that the tiles do not fill.
    pub(super) fn slice_layout(&self, picture: &Layout) -> Result<Layout, Error> {
        let Mosaic { slices, across, .. } = self;
        if !picture.columns.is_multiple_of(*across) || !picture.rows.is_multiple_of(*across) {
            return Err(Error::field(
                "the size of the mosaic",
                format!("{}×{}", picture.columns, picture.rows),
                format!(
                    "a multiple of {across}, for {across}×{across} tiles that hold {slices} slices"
                ),
            ));
        }
        Ok(picture.with_size(picture.columns / across, picture.rows / across))
    }

    /// The place of slice `k` in the picture.
    pub(super) fn tile(&self, k: usize, picture: &Layout) -> Tile {
        let (columns, rows) = (picture.columns / self.across, picture.rows / self.across);
        Tile {
            picture: *picture,
            corner: [k % self.across * columns, k / self.across * rows],
        }
    }

    /// The position of the first sample of the first slice, and the way to the next slice.
    ///
    /// # Errors
    /// Nothing says how far apart the slices are.
    pub(super) fn place(
        &self,
        set: &DataSet,
        picture: &Layout,
        position: DVec3,
        [row, column]: [DVec3; 2],
        spacing: [f64; 2],
        options: &ReadOptions,
    ) -> Result<(DVec3, DVec3), Error> {
        let beyond = |edge: usize| (edge - edge / self.across) as f64 / 2.0;
        let first = position
            + row * spacing[0] * beyond(picture.columns)
            + column * spacing[1] * beyond(picture.rows);
        let distance = [tags::SPACING_BETWEEN_SLICES, tags::SLICE_THICKNESS]
            .into_iter()
            .map(|tag| set.decimal(tag))
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .flatten()
            .find(|mm| *mm > 0.0)
            .or(options.spacing_mm.map(|[_, _, z]| z));
        let Some(distance) = distance else {
            return Err(missing_spacing(self.slices));
        };
        // The images' own axes are the most exact; the header says the sign (as in nibabel).
        let normal = row.cross(column).normalize();
        let is_reversed = self.normal.is_some_and(|said| said.dot(normal) < 0.0);
        Ok((
            first,
            if is_reversed {
                -distance * normal
            } else {
                distance * normal
            },
        ))
    }
}

/// Real mosaics have up to a few hundred.
const MOST_SLICES: usize = 4096;

/// What is of use in a CSA header.
#[derive(Default)]
struct Csa {
    slices: Option<usize>,
    normal: Option<DVec3>,
}

impl Csa {
    fn parse(bytes: &[u8]) -> Option<Csa> {
        let is_version_2 = bytes.starts_with(b"SV10");
        let mut at = if is_version_2 { 8 } else { 0 };
        let number = |at: usize| -> Option<usize> {
            let bytes = bytes.get(at..)?.first_chunk()?;
            usize::try_from(i32::from_le_bytes(*bytes)).ok()
        };
        let tags = number(at)?;
        if !(1..=1024).contains(&tags) {
            return None;
        }
        at += 8;
        let mut csa = Csa::default();
        let mut first_items = None;
        for _ in 0..tags {
            let name = bytes.get(at..at + 64)?;
            let name = &name[..name.iter().position(|c| *c == 0).unwrap_or(64)];
            let (values, items) = (number(at + 64)?, number(at + 76)?);
            let first_items = *first_items.get_or_insert(items);
            at += 84;
            let mut texts = Vec::new();
            for item in 0..items {
                let length = match is_version_2 {
                    true => number(at + 4)?,
                    false => number(at)?.checked_sub(first_items)?,
                };
                let text = bytes.get(at + 16..(at + 16).checked_add(length)?)?;
                // Without a number of values, those that say something count.
                let counts = values == 0 || item < values;
                texts.extend(Some(plain_text(text)).filter(|text| counts && !text.is_empty()));
                at += 16 + length.next_multiple_of(4);
            }
            let mut numbers = texts.iter().map_while(|text| {
                text.trim_end_matches('\0')
                    .parse::<f64>()
                    .ok()
                    .filter(|n| n.is_finite())
            });
            match name {
                b"NumberOfImagesInMosaic" => {
                    let number = numbers.next().map(|n| n as usize);
                    csa.slices = number.filter(|n| (1..=MOST_SLICES).contains(n));
                }
                b"SliceNormalVector" => {
                    csa.normal = numbers
                        .collect::<Vec<f64>>()
                        .get(..3)
                        .map(DVec3::from_slice);
                }
                _ => {}
            }
        }
        Some(csa)
    }
}
