//! Nuclear medicine (PS3.3, C.8.4): which slice and which group each frame of a file is.
//!
//! The frames of a file are numbered by vectors, one entry a frame: SliceVector says which slice it is, the others
//! which energy window, phase, time slot and so on. Projections and planar pictures are no slices.

use super::elements::DataSet;
use super::keys::NUCLEAR_VECTORS;
use super::tags::{self, Tag, field_name};
use crate::error::{Error, ErrorKind};

/// Where the frames of a file belong.
pub(super) struct Nuclear {
    /// For each frame its slice, from 0.
    pub(super) slices: Vec<usize>,
    /// For each frame its numbers in the vectors.
    pub(super) groups: Vec<[Option<u16>; NUCLEAR_VECTORS.len()]>,
}

const NUCLEAR_MEDICINE_IMAGE_STORAGE: &str = "1.2.840.10008.5.1.4.1.1.20";

impl Nuclear {
    /// `None` for other images.
    ///
    /// # Errors
    /// Projections and planar pictures; a vector that has not one entry a frame.
    pub(super) fn of(set: &DataSet, frames: usize) -> Result<Option<Nuclear>, Error> {
        let is_nuclear = set.text(tags::MODALITY).as_deref() == Some("NM")
            || set.text(tags::SOP_CLASS_UID).as_deref() == Some(NUCLEAR_MEDICINE_IMAGE_STORAGE);
        if !is_nuclear {
            return Ok(None);
        }
        let vector = |tag: Tag| match set.u16s(tag) {
            Some(numbers) if numbers.len() == frames => Ok(Some(numbers)),
            // Some writers fill it for other kinds of frames.
            Some(numbers) if numbers.is_empty() || frames == 1 => Ok(None),
            Some(numbers) => Err(Error::field(
                field_name(tag),
                format!("a list of {}", numbers.len()),
                format!("{frames} numbers, one a frame"),
            )),
            None => Ok(None),
        };
        let slices = vector(tags::SLICE_VECTOR)?;
        refuse_projections(set, frames, slices.is_some())?;
        if frames == 1 {
            return Ok(None);
        }
        let vectors: Vec<Option<Vec<u16>>> = NUCLEAR_VECTORS
            .into_iter()
            .map(vector)
            .collect::<Result<_, _>>()?;
        let groups: Vec<[Option<u16>; NUCLEAR_VECTORS.len()]> = (0..frames)
            .map(|frame| std::array::from_fn(|v| Some(vectors[v].as_ref()?[frame])))
            .collect();
        let slices = match slices {
            Some(numbers) => {
                let first = numbers.iter().min().copied().unwrap_or(0).min(1);
                numbers.iter().map(|n| usize::from(n - first)).collect()
            }
            // Slices follow one another in each group.
            None => {
                let mut counts = std::collections::BTreeMap::new();
                let next = |group| {
                    let count = counts.entry(group).or_insert(0usize);
                    *count += 1;
                    *count - 1
                };
                groups.iter().map(next).collect()
            }
        };
        Ok(Some(Nuclear { slices, groups }))
    }
}

/// The third value of ImageType says what the frames are.
fn refuse_projections(set: &DataSet, frames: usize, has_slices: bool) -> Result<(), Error> {
    let image_type = set.text(tags::IMAGE_TYPE).unwrap_or_default();
    let kind = image_type.split('\\').nth(2).unwrap_or_default().trim();
    let is_reconstructed = kind.contains("RECON");
    let views = set.u16s(tags::ANGULAR_VIEW_VECTOR).unwrap_or_default();
    let has_views = views.windows(2).any(|pair| pair[0] != pair[1]);
    let instead = match kind {
        "TOMO" | "GATED TOMO" => "reconstruct them first: projections are no slices",
        _ if has_views && !is_reconstructed && !has_slices => {
            "reconstruct them first: projections are no slices"
        }
        "STATIC" | "WHOLE BODY" | "DYNAMIC" | "GATED" if frames > 1 && !has_slices => {
            "planar pictures are no slices; save them as PNG or TIFF"
        }
        _ => return Ok(()),
    };
    Err(ErrorKind::Unsupported {
        feature: format!(
            "a nuclear study of {frames} frames whose kind is {kind:?} (the third value of {})",
            field_name(tags::IMAGE_TYPE)
        ),
        instead: instead.into(),
    }
    .into())
}
