//! A folder of masks: one volume per structure, called after it, as TotalSegmentator writes them.
//!
//! Masks hold zeros and one other number. In alphabetical order of the files they are the labels 1,
//! 2, …; a voxel in several masks belongs to the last one. One mask is in memory at a time.

use super::LoadedVolume;
use super::label_tables::stem_of;
use super::sniff::Kind;
use crate::error::{Error, ErrorKind};
use crate::made_labels::MergedMasks;
use crate::{Label, Metadata};

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
    let mut notes = Vec::new();
    let mut labels = Vec::new();
    let mut all: Option<(Metadata, MergedMasks)> = None;
    for (i, name) in names.iter().enumerate() {
        let mask = read_volume(name)?;
        notes.extend(mask.notes.iter().map(|note| format!("{name}: {note}")));
        let mask = mask.volume;
        let (_, merged) = match &mut all {
            Some(all) => all,
            None => all.insert((mask.metadata().clone(), MergedMasks::new(mask.grid())?)),
        };
        let added = merged.add_or_values(&mask, name, &names[0])?;
        added.map_err(|[one, two]| no_mask(name, instead, one, two))?;
        labels.push(Label::new(i as u32 + 1, stem_of(name)));
    }
    let Some((metadata, merged)) = all else {
        return Err(Error::field("the number of masks", 0, "1 or more"));
    };
    let overlaps = merged.overlaps();
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
    Ok(LoadedVolume {
        volume: merged.into_volume(metadata)?,
        labels: Some(labels),
        notes,
    })
}

fn no_mask(name: &str, instead: &str, one: f64, two: f64) -> Error {
    let why = match two.is_nan() {
        true => "has values that are no numbers".to_owned(),
        false => format!("has the values {one} and {two}; masks have 0 and one other value"),
    };
    let why = format!("{instead}; {name} is no mask: it {why}");
    ErrorKind::Unknown { why }.into()
}
