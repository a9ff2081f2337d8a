//! What programs read as textures beside the volumes.

use crate::frame::Object;
use crate::functions::choose;
use crate::segments::SegmentTable;
use strahl_scene::NoiseTile;
use strahl_scene::plan::Plan;
use strahl_shader::{Error, TABLE_ROW, TECHNIQUE_TEXELS, TechniqueTexels};
use strahl_volume::{Cancelled, Control, Store};

/// A table that a graph reads, linear RGBA, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Table2d {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// width × height texels.
    pub texels: Vec<[f32; 4]>,
}

/// The transfer tables of all techniques, whole rows of [`TABLE_ROW`] entries, each table from the start of a
/// row on; tells `objects` where theirs begins. Before them come the techniques, if there are several, and
/// before these, if segments have them, where segments are found: `segments` says so.
///
/// # Errors
/// None for a Plan that `resolve` made.
pub fn tables(
    plan: &Plan,
    objects: &mut [Object],
    segments: Option<&SegmentTable>,
) -> Result<Vec<[f32; 4]>, Error> {
    let row = TABLE_ROW as usize;
    let mut head = Vec::new();
    if let Some(segments) = segments {
        head.extend_from_slice(&segments.found_by);
        head.resize(TECHNIQUE_TEXELS as usize, [0.0; 4]);
    }
    let number = plan.drawn_techniques().count();
    if !plan.has_one_technique() {
        let texels = head.len() + number * TECHNIQUE_TEXELS as usize;
        head.resize(texels.next_multiple_of(row), [0.0; 4]);
    }
    let (mut entries, mut techniques) = (head, Vec::new());
    for technique in plan.drawn_techniques() {
        let (table, first) = (&technique.table, entries.len() as u32);
        let steps_per_reference = plan.lattice.step_mm / f64::from(table.reference_mm());
        techniques.push(TechniqueTexels::new(
            first,
            table.entries().len() as u32,
            table.domain(),
            steps_per_reference as f32,
        ));
        if let Some(object) = objects.get_mut(techniques.len() - 1) {
            object.table_first = first;
        }
        entries.extend_from_slice(table.entries());
        entries.extend_from_slice(table.rows());
        entries.resize(entries.len().next_multiple_of(row), [0.0; 4]);
    }
    if !plan.has_one_technique() {
        choose(plan, &mut techniques)?;
        let skipped = usize::from(segments.is_some());
        let places = entries.chunks_mut(TECHNIQUE_TEXELS as usize).skip(skipped);
        for (to, technique) in places.zip(&techniques) {
            to.copy_from_slice(technique.texels());
        }
    }
    Ok(entries)
}

/// The numbers that jitter repeats over the picture, row by row, and how many there are in a row.
///
/// # Errors
/// It was cancelled.
pub fn noise_tile(
    plan: &Plan,
    store: &Store,
    control: &Control,
) -> Result<(u32, Vec<f32>), Cancelled> {
    let tile = NoiseTile::find(plan.lattice.jitter, store, control)?;
    Ok(match tile {
        Some(tile) => (tile.edge(), tile.values().to_vec()),
        None => (1, vec![0.5]),
    })
}

/// Blocks behind one another along z, in one block that is wide enough for all: its dimensions, its
/// elements, and where each begins.
pub fn stacked<T: Copy + Default>(blocks: &[([u32; 3], Vec<T>)]) -> ([u32; 3], Vec<T>, Vec<u32>) {
    let most = |axis: usize| blocks.iter().map(|(dims, _)| dims[axis]).max().unwrap_or(1);
    let (width, height) = (most(0), most(1));
    let depth: u32 = blocks.iter().map(|(dims, _)| dims[2]).sum();
    let mut all = vec![T::default(); (width * height) as usize * depth as usize];
    let mut first = Vec::new();
    let mut z0 = 0;
    for (dims, elements) in blocks {
        first.push(z0);
        let [nx, ny, nz] = dims.map(|n| n as usize);
        for z in 0..nz {
            for y in 0..ny {
                let from = nx * (y + ny * z);
                let to = width as usize * (y + height as usize * (z + z0 as usize));
                all[to..to + nx].copy_from_slice(&elements[from..from + nx]);
            }
        }
        z0 += dims[2];
    }
    ([width, height, depth], all, first)
}
