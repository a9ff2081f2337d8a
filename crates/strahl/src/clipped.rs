//! Objects of which clips leave nothing.

use crate::Error;
use crate::note::Note;
use crate::session::Session;
use strahl_scene::plan::{ClipPlane, ClipShape, Plan};
use strahl_scene::{Scene, visibility::dropped};
use strahl_volume::bricks::{Bricks, BricksKey};
use strahl_volume::{Control, Datasets, Grid};

/// Cells along the edge of a brick, as linked programs have them.
const EDGE: usize = Bricks::EDGE;

/// A note for every volume of which the clips of the scene certainly leave nothing.
///
/// # Errors
/// `control` was cancelled.
pub(crate) fn of_clips(
    session: &Session,
    scene: &Scene,
    plan: &Plan,
    data: &Datasets,
    control: &Control,
) -> Result<Vec<Note>, Error> {
    let mut notes = Vec::new();
    let names = names(scene);
    for (layer, name) in (0..plan.layers.len()).zip(names) {
        if by_planes(plan, layer) || by_shapes(session, plan, layer, data, control)? {
            notes.push(Note::ClippedAway { object: name });
        }
    }
    Ok(notes)
}

/// Of the volumes of a scene, in the order of the layers.
fn names(scene: &Scene) -> Vec<String> {
    let objects = scene.objects.iter().flatten().enumerate();
    let volumes = objects.filter(|(_, object)| object.volume.is_some() || object.like.is_some());
    let of = |(i, object): (usize, &strahl_scene::SceneObject)| match &object.name {
        Some(name) => format!("the object {name:?}"),
        None => format!("objects[{i}]"),
    };
    let own = std::iter::once("the scene's own volume".to_owned());
    own.chain(volumes.map(of)).collect()
}

/// Whether the whole volume lies behind one plane.
fn by_planes(plan: &Plan, layer: usize) -> bool {
    let corners = corners_mm(&plan.field_of(layer).grid);
    let is_behind = |plane: &ClipPlane| {
        let heights = corners.map(|corner| plane.normal.dot(corner) + plane.offset_mm);
        heights.iter().all(|height| *height < 0.0)
    };
    let mut planes = plan.ray_clips.iter();
    planes.any(|plane| plane.layers >> layer & 1 == 1 && is_behind(plane))
}

fn corners_mm(grid: &Grid) -> [glam::DVec3; 8] {
    let (low, high) = grid.extent_in_voxels();
    std::array::from_fn(|corner| {
        let side = |axis: usize| {
            if corner >> axis & 1 == 1 {
                high[axis]
            } else {
                low[axis]
            }
        };
        let voxel = glam::DVec3::new(side(0), side(1), side(2));
        grid.world_from_voxel().transform_point3(voxel)
    })
}

/// Whether boxes, ellipsoids, cylinders and masks drop every brick.
fn by_shapes(
    session: &Session,
    plan: &Plan,
    layer: usize,
    data: &Datasets,
    control: &Control,
) -> Result<bool, Error> {
    let mut of_masks = Vec::new();
    for clip in plan.sample_clips.iter().filter(|clip| clip.cuts(layer)) {
        if let ClipShape::Mask { mask, .. } = clip.shape {
            let volume = &data.masks[mask];
            let make = || Bricks::under(volume, EDGE, 0, control).map_err(Error::from);
            let key = BricksKey::new(volume, EDGE, 0);
            of_masks.push((mask, session.store().find(&key, control, make)?));
        }
    }
    let mask = |number: usize| {
        let bricks = of_masks.iter().find(|(of, _)| *of == number);
        (&data.masks[number], &*bricks.expect("made above").1)
    };
    let dims = plan.field_of(layer).grid.dims();
    let bricks = dims.map(|n| n.saturating_sub(1).div_ceil(EDGE).max(1));
    let found = dropped(plan, layer, bricks, EDGE, mask, control)?;
    Ok(found.is_some_and(|bricks| bricks.iter().all(|is_dropped| *is_dropped)))
}
