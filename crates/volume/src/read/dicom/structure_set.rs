//! Structure sets of radiotherapy (PS3.3, A.19 and C.8.8.5 to C.8.8.8): contours in planes, drawn around structures, as a
//! volume of labels.
//!
//! Contours have no grid of their own. It is that of the images on which they were drawn, if those lie beside the file
//! or in folders below; otherwise the user gives a spacing, and the grid goes along the axes of the patient.

use super::contours::Planes;
use super::elements::{DataSet, Elements};
use super::ras::ras;
use super::segmentation::narrowed;
use super::tags::{self, field_name};
use crate::error::{Error, ErrorKind, Remedy};
use crate::read::components::{self, Meaning};
use crate::read::{Bytes, Input, LoadedVolume, ReadOptions};
use crate::{Grid, Label, Metadata, Rescale, Volume, memory};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::collections::BTreeMap;

const RT_STRUCTURE_SET_STORAGE: &str = "1.2.840.10008.5.1.4.1.1.481.3";

/// How often voxels may lie in structures, on average. Real sets stay below ten.
const MOST_FOLD: u64 = 64;

/// Voxels of a grid that no image has.
const MOST_OWN_VOXELS: f64 = 268_435_456.0;

/// Whether a file holds contours of structures.
pub(super) fn is_structure_set(set: &DataSet) -> bool {
    set.text(tags::SOP_CLASS_UID).as_deref() == Some(RT_STRUCTURE_SET_STORAGE)
}

/// The series on which the contours were drawn.
pub(super) fn referenced_series(set: &DataSet) -> Vec<String> {
    let frames = set.items(tags::REFERENCED_FRAME_OF_REFERENCE_SEQUENCE);
    let studies = frames
        .iter()
        .flat_map(|frame| frame.items(tags::RT_REFERENCED_STUDY_SEQUENCE));
    let series = studies.flat_map(|study| study.items(tags::RT_REFERENCED_SERIES_SEQUENCE));
    series
        .filter_map(|series| series.text(tags::SERIES_INSTANCE_UID))
        .collect()
}

/// One structure.
struct Structure {
    number: i64,
    label: Label,
    /// Corners in mm, in LPS as they are stored, and how thick the slab around it is.
    contours: Vec<(Vec<DVec3>, Option<f64>)>,
}

/// The labels that the contours of a file make. `images` is the grid of the images on which they were drawn.
///
/// # Errors
/// No contours; such that lie in no plane of the grid; no grid.
pub(super) fn read(
    input: &Input,
    elements: &Elements,
    images: Option<Grid>,
    options: &ReadOptions,
    mut notes: Vec<String>,
) -> Result<LoadedVolume, Error> {
    let set = &elements.set;
    components::choice(1, Meaning::Vector, options, &mut notes)?;
    let mut structures = structures(set, &mut notes)?;
    number(&mut structures);
    let grid = match images {
        Some(grid) => grid,
        None => own_grid(set, &structures, options)?,
    };
    let planes: Vec<Planes> = structures
        .iter()
        .map(|structure| planes(structure, &grid))
        .collect::<Result<_, Error>>()?;
    let dims = grid.dims();
    let counts = counts(&planes, &grid, input.bytes)?;
    for (structure, count) in structures.iter().zip(&counts) {
        if *count == 0 && !structure.contours.is_empty() {
            notes.push(format!("{} has no voxel of the grid", structure.label.name));
        }
    }
    // The outline of the body holds all others: the smaller of two structures is kept.
    let mut order: Vec<usize> = (0..planes.len()).collect();
    order.sort_by_key(|i| std::cmp::Reverse(counts[*i]));
    input.bytes.keep(2 * grid.voxel_count() as u64)?;
    let mut voxels: Vec<u16> = memory::zeroed(grid.voxel_count())?;
    let mut overlaps = 0usize;
    for i in order {
        let id = structures[i].label.id as u16;
        planes[i].runs(dims, &mut |z, y, columns| {
            let row = dims[0] * (y + dims[1] * z);
            for voxel in &mut voxels[row + columns.start..row + columns.end] {
                overlaps += usize::from(*voxel != 0);
                *voxel = id;
            }
            Ok(input.bytes.check()?)
        })?;
    }
    if overlaps > 0 {
        notes.push(format!(
            "{overlaps} times, a voxel is in two structures; the one with fewer voxels is kept"
        ));
    }
    let metadata = Metadata {
        name: set
            .description(tags::STRUCTURE_SET_LABEL)
            .unwrap_or_else(|| input.name.to_owned()),
        format: "DICOM RTSTRUCT".into(),
        has_length_unit: true,
        time_points: 1,
        ..Metadata::default()
    };
    Ok(LoadedVolume {
        volume: Volume::new(grid, narrowed(voxels)?, Rescale::IDENTITY, metadata)?,
        labels: Some(structures.into_iter().map(|s| s.label).collect()),
        notes,
    })
}

/// The structures with their closed contours, in the order of the file.
fn structures(set: &DataSet, notes: &mut Vec<String>) -> Result<Vec<Structure>, Error> {
    let types: BTreeMap<String, String> = set
        .items(tags::RT_ROI_OBSERVATIONS_SEQUENCE)
        .iter()
        .filter_map(|item| {
            let number = item.text(tags::REFERENCED_ROI_NUMBER)?;
            Some((number, item.description(tags::RT_ROI_INTERPRETED_TYPE)?))
        })
        .collect();
    let drawn: BTreeMap<String, &DataSet> = set
        .items(tags::ROI_CONTOUR_SEQUENCE)
        .iter()
        .filter_map(|item| Some((item.text(tags::REFERENCED_ROI_NUMBER)?, item)))
        .collect();
    let items = set.items(tags::STRUCTURE_SET_ROI_SEQUENCE);
    if items.len() > usize::from(u16::MAX) {
        return Err(Error::field(
            field_name(tags::STRUCTURE_SET_ROI_SEQUENCE),
            format!("of {} structures", items.len()),
            format!("up to {}", u16::MAX),
        ));
    }
    let mut left_out = 0;
    let mut structures = Vec::new();
    for item in items {
        let number = item.text(tags::ROI_NUMBER).unwrap_or_default();
        let name = item
            .description_within(tags::ROI_NAME, set)
            .unwrap_or_default();
        let drawing = drawn.get(&number);
        let color = match drawing {
            Some(drawing) => drawing.decimal_array::<3>(tags::ROI_DISPLAY_COLOR)?,
            None => None,
        };
        let mut contours = Vec::new();
        for contour in drawing.map_or(&[][..], |d| d.items(tags::CONTOUR_SEQUENCE)) {
            let kind = contour.text(tags::CONTOUR_GEOMETRIC_TYPE);
            if !matches!(kind.as_deref(), Some("CLOSED_PLANAR" | "CLOSEDPLANAR_XOR")) {
                left_out += 1;
                continue;
            }
            contours.push((
                corners(contour, &name)?,
                contour.decimal(tags::CONTOUR_SLAB_THICKNESS)?,
            ));
        }
        structures.push(Structure {
            label: Label {
                id: 0,
                name,
                color: color.map(|rgb| rgb.map(|c| (c / 255.0).clamp(0.0, 1.0) as f32)),
                group: types.get(&number).cloned(),
            },
            number: number.parse().unwrap_or(0),
            contours,
        });
    }
    if left_out > 0 {
        notes.push(format!(
            "{left_out} contours that are no closed planes (points, lines) were left out"
        ));
    }
    if structures
        .iter()
        .all(|structure| structure.contours.is_empty())
    {
        return Err(tags::missing(
            tags::CONTOUR_DATA,
            "closed contours (CLOSED_PLANAR) of one structure or more",
        ));
    }
    Ok(structures)
}

fn corners(contour: &DataSet, structure: &str) -> Result<Vec<DVec3>, Error> {
    let numbers = contour.decimals(tags::CONTOUR_DATA)?.unwrap_or_default();
    let (corners, rest) = numbers.as_chunks::<3>();
    if !rest.is_empty() || corners.is_empty() {
        return Err(Error::field(
            format!("{} of {structure}", field_name(tags::CONTOUR_DATA)),
            format!("of {} numbers", numbers.len()),
            "three for each point",
        ));
    }
    Ok(corners
        .iter()
        .map(|corner| DVec3::from_array(*corner))
        .collect())
}

/// Gives ids: the numbers of the structures, or 1, 2, … if those are no ids.
fn number(structures: &mut [Structure]) {
    let numbers: std::collections::BTreeSet<i64> = structures.iter().map(|s| s.number).collect();
    let are_ids = numbers.len() == structures.len()
        && numbers
            .iter()
            .all(|n| (1..=i64::from(u16::MAX)).contains(n));
    for (i, structure) in structures.iter_mut().enumerate() {
        structure.label.id = match are_ids {
            true => structure.number as u32,
            false => i as u32 + 1,
        };
    }
}

/// The contours of a structure in voxels.
fn planes(structure: &Structure, grid: &Grid) -> Result<Planes, Error> {
    /// How far, in slices, the corners of a contour may lie from its plane.
    const FLAT: f64 = 0.25;
    let voxel_from_world = grid.world_from_voxel().inverse();
    let mut contours = Vec::new();
    let mut slab = None;
    for (corners, thickness_mm) in &structure.contours {
        let mut flat = Vec::new();
        let (mut low, mut high, mut sum) = (f64::MAX, f64::MIN, 0.0);
        for corner in corners {
            let voxel = voxel_from_world.transform_point3(ras(*corner));
            flat.push(DVec2::new(voxel.x, voxel.y));
            (low, high, sum) = (low.min(voxel.z), high.max(voxel.z), sum + voxel.z);
        }
        if high - low > FLAT {
            return Err(ErrorKind::Slices(format!(
                "a contour of {} lies across {:.1} slices; contours are read that are parallel to the slices of the images",
                structure.label.name,
                high - low
            ))
            .into());
        }
        slab = slab.or(thickness_mm.map(|mm| mm / grid.spacing_mm().z));
        contours.push((sum / corners.len() as f64, flat));
    }
    let slab = slab.filter(|slices| *slices > 0.0).unwrap_or(1.0);
    Ok(Planes::new(contours, slab))
}

/// Voxels in each structure.
///
/// # Errors
/// Voxels that lie in more than [`MOST_FOLD`] structures on average; no memory.
fn counts(planes: &[Planes], grid: &Grid, bytes: &dyn Bytes) -> Result<Vec<u64>, Error> {
    let most = (grid.voxel_count() as u64).saturating_mul(MOST_FOLD);
    let mut total = 0;
    let count = |planes: &Planes| {
        let mut count = 0;
        planes.runs(grid.dims(), &mut |_, _, columns| {
            count += columns.len() as u64;
            Ok(bytes.check()?)
        })?;
        total += count;
        match total > most {
            false => Ok(count),
            true => Err(Error::field(
                "the number of voxels in all structures",
                format!("{total} or more"),
                format!("up to {most}, {MOST_FOLD} times those of the grid"),
            )),
        }
    };
    planes.iter().map(count).collect()
}

/// A grid along the axes of the patient around all contours, where there are no images.
fn own_grid(set: &DataSet, structures: &[Structure], options: &ReadOptions) -> Result<Grid, Error> {
    let Some(spacing) = options.spacing_mm else {
        let series = referenced_series(set);
        return Err(Error::from(ErrorKind::Unsupported {
            feature: "a structure set without the images on which it was drawn".into(),
            instead: format!(
                "put the series {} beside it or in a folder below, or give the spacing of a grid",
                series.first().map_or("that it names", String::as_str)
            ),
        })
        .with_remedy(Remedy::Spacing));
    };
    let spacing = DVec3::from(spacing);
    let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
    for (corners, _) in structures.iter().flat_map(|s| &s.contours) {
        for corner in corners {
            (low, high) = (low.min(*corner), high.max(*corner));
        }
    }
    // Voxels lie on the lowest plane.
    let dims = ((high - low) / spacing).ceil() + DVec3::ONE;
    if dims.element_product() > MOST_OWN_VOXELS {
        return Err(Error::field(
            "the spacing of the grid",
            spacing,
            format!(
                "a larger one: the contours cover {} mm, and a grid of their own has up to {MOST_OWN_VOXELS} voxels",
                high - low
            ),
        ));
    }
    let dims = dims.to_array().map(|n| n as usize);
    let matrix = DMat3::from_diagonal(DVec3::new(-spacing.x, -spacing.y, spacing.z));
    Grid::new(dims, DAffine3::from_mat3_translation(matrix, ras(low)))
}
