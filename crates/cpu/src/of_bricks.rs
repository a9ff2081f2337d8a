//! What a rule of sampling knows of each brick of a volume.

use crate::brick_number::{EDGE, brick_number};
use crate::clipped::Clipped;
use crate::kept::Kept;
use crate::lanes::{I32s, words};
use crate::levels::Level;
use std::sync::Arc;
use strahl_scene::plan::{Plan, Reconstruct, Sampling};
use strahl_scene::transfer::TransferTable;
use strahl_volume::Rescale;
use strahl_volume::bricks::Bricks;

/// A byte per brick.
pub struct OfBricks {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    /// Three more, so that a word can be read anywhere.
    bytes: Arc<Vec<u8>>,
}

/// What was found for the Plan drawn last: most have only another camera.
pub type RecentOfBricks = Kept<Asked, Vec<u8>>;

/// All that the bytes depend on.
#[derive(PartialEq)]
pub struct Asked {
    volume: usize,
    sampling: Sampling,
    step_mm: f64,
    reconstruct: Reconstruct,
    rescale: Rescale,
    table: TransferTable,
    clipped: Option<Clipped>,
}

impl OfBricks {
    /// What `find` says of object number `object`, or said of it last, and 0 where bricks are `clipped`; `None` if it
    /// says nothing.
    pub fn new(
        recent: &RecentOfBricks,
        bricks: &Bricks,
        plan: &Plan,
        layer: usize,
        clipped: Option<&Clipped>,
        find: impl FnOnce(&Plan, usize, &Bricks) -> Option<Vec<u8>>,
    ) -> Option<OfBricks> {
        assert_eq!(bricks.edge(), EDGE);
        // Words are gathered at 32-bit offsets.
        if bricks.number() > i32::MAX as usize / 8 {
            return None;
        }
        let (field, technique) = (plan.field_of(layer), plan.technique_of(layer));
        let asked = Asked {
            volume: field.volume,
            sampling: plan.sampling,
            step_mm: plan.lattice.step_mm,
            reconstruct: field.reconstruct,
            rescale: field.rescale,
            table: technique.table.clone(),
            clipped: clipped.cloned(),
        };
        let bytes = recent.find(asked, 2 * plan.layers.len(), |_| {
            let mut bytes = find(plan, layer, bricks)?;
            for (byte, clipped) in bytes
                .iter_mut()
                .zip(clipped.map_or(&[][..], Clipped::bricks))
            {
                *byte *= u8::from(!clipped);
            }
            bytes.extend([0; 3]);
            Some(bytes)
        })?;
        Some(OfBricks {
            dims: bricks.dims().map(|n| n as i32),
            bytes,
        })
    }

    /// That of the brick around each cell.
    #[inline(always)]
    pub fn at<S: Level>(&self, cell: [I32s<S>; 3]) -> I32s<S> {
        let index = brick_number(self.dims, cell);
        // SAFETY: the cell lies in one of the bricks, and there are three bytes behind the last.
        unsafe { words(&self.bytes, index) }.and(0xFF)
    }
}
