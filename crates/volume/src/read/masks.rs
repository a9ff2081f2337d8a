//! A folder of masks: one volume per structure, called after it, as TotalSegmentator writes them.
//!
//! Masks hold zeros and one other number. In alphabetical order of the files they are the labels 1,
//! 2, …; a voxel in several masks belongs to the last one. One mask is in memory at a time.

use super::label_tables::stem_of;
use super::sniff::Kind;
use super::{LoadedVolume, block};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Label, Metadata, Rescale, Sample, Samples, Volume, with_samples};

/// Those of the volume files of a folder that can be masks, by their kinds.
pub(super) fn among(volumes: &[(String, Kind)]) -> Vec<String> {
    let can_be_mask = |kind| matches!(kind, Kind::Nifti | Kind::Nrrd | Kind::MetaImage | Kind::Mgh);
    let names = volumes.iter().filter(|(_, kind)| can_be_mask(*kind));
    names.map(|(name, _)| name.clone()).collect()
}

/// The labels that the masks `names` make, each read by `read_volume`. `others` are all files that
/// could have been masks. `instead` is the message if one is none.
///
/// # Errors
/// A file that cannot be read, is no mask, or is on another grid than the first.
pub(super) fn read(
    folder: &str,
    others: &[String],
    names: &[String],
    read_volume: &dyn Fn(&str) -> Result<LoadedVolume, Error>,
    instead: &str,
) -> Result<LoadedVolume, Error> {
    const MOST: usize = u16::MAX as usize;
    if names.len() > MOST {
        let allowed = format!("up to {MOST}");
        return Err(Error::field("the number of masks", names.len(), allowed));
    }
    let mut notes = Vec::new();
    let mut labels = Vec::new();
    let mut all: Option<(Grid, Metadata, Vec<u16>)> = None;
    let mut overlaps = 0;
    for (i, name) in names.iter().enumerate() {
        let id = i as u16 + 1;
        let mask = read_volume(name)?;
        notes.extend(mask.notes.iter().map(|note| format!("{name}: {note}")));
        let (grid, samples, rescale, metadata) = mask.volume.into_parts();
        let (first, _, ids) = match &mut all {
            Some(all) => all,
            None => {
                let mut ids = Vec::new();
                block::reserve(&mut ids, grid.voxel_count())?;
                ids.resize(grid.voxel_count(), 0);
                all.insert((grid, metadata, ids))
            }
        };
        if !first.matches(&grid, 0.1 * first.min_spacing_mm()) {
            return Err(other_grid(name, &names[0], &grid, first));
        }
        let added = with_samples!(&samples, samples => add(samples, rescale, id, ids));
        overlaps += added.map_err(|[one, two]| no_mask(name, instead, one, two))?;
        labels.push(Label::new(id.into(), stem_of(name)));
    }
    let Some((grid, metadata, ids)) = all else {
        return Err(Error::field("the number of masks", 0, "1 or more"));
    };
    if overlaps > 0 {
        let what = format!("{overlaps} voxels are in several masks");
        notes.push(format!(
            "{what}; the last mask in alphabetical order is kept"
        ));
    }
    let left_out: Vec<&str> = others
        .iter()
        .filter(|o| !names.contains(o))
        .map(|o| &**o)
        .collect();
    if !left_out.is_empty() {
        notes.push(format!("left out what is no mask: {}", left_out.join(", ")));
    }
    let metadata = Metadata {
        name: folder.to_owned(),
        format: format!("{} masks ({})", names.len(), metadata.format),
        has_length_unit: metadata.has_length_unit,
        time_points: 1,
        ..Metadata::default()
    };
    let samples = match names.len() <= usize::from(u8::MAX) {
        true => Samples::U8(ids.into_iter().map(|id| id as u8).collect()),
        false => Samples::U16(ids),
    };
    Ok(LoadedVolume {
        volume: Volume::new(grid, samples, Rescale::IDENTITY, metadata)?,
        labels: Some(labels),
        notes,
    })
}

/// Sets the id of the voxels in a mask. Returns how many had another one, or two different values
/// that are not 0.
fn add<T: Sample>(
    samples: &[T],
    rescale: Rescale,
    id: u16,
    ids: &mut [u16],
) -> Result<u64, [f64; 2]> {
    let mut inside = None;
    let mut overlaps = 0;
    let mut at = 0;
    for run in samples.chunk_by(|a, b| a == b) {
        let ids = &mut ids[at..at + run.len()];
        at += run.len();
        let value = rescale.value(run[0].to_f64());
        if value == 0.0 {
            continue;
        }
        let inside = *inside.get_or_insert(value);
        // NaN is not equal to itself.
        if value != inside || value.is_nan() {
            return Err([inside, value]);
        }
        overlaps += ids.iter().filter(|id| **id != 0).count() as u64;
        ids.fill(id);
    }
    Ok(overlaps)
}

fn no_mask(name: &str, instead: &str, one: f64, two: f64) -> Error {
    let why = match two.is_nan() {
        true => "has values that are no numbers".to_owned(),
        false => format!("has the values {one} and {two}; masks have 0 and one other value"),
    };
    let why = format!("{instead}; {name} is no mask: it {why}");
    ErrorKind::Unknown { why }.into()
}

fn other_grid(name: &str, first: &str, grid: &Grid, other: &Grid) -> Error {
    let describe = |grid: &Grid| {
        let [x, y, z] = grid.dims();
        let affine = crate::grid::rows(&grid.world_from_voxel());
        format!("{x}×{y}×{z} voxels, world_from_voxel {affine}")
    };
    Error::field(
        format!("the grid of {name}"),
        describe(grid),
        format!("the grid of {first}: {}", describe(other)),
    )
}
