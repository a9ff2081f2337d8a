//! What a rule of sampling knows of each brick of a volume.

use crate::brick_number::{EDGE, brick_number};
use crate::clipped::{ClippedBricks, ClippedBricksKey};
use crate::lanes::{I32s, words_inside};
use crate::levels::Level;
use crate::making::Making;
use std::sync::Arc;
use strahl_scene::plan::{Illustrate, Plan, Sampling, Shade};
use strahl_scene::visibility::ContributionKey;
use strahl_volume::bricks::Bricks;
use strahl_volume::{Cancelled, Control, Key};

/// A byte per brick.
pub struct BrickBytes {
    /// Number of bricks along each axis.
    dims: [i32; 3],
    /// Three more, so that a word can be read anywhere.
    bytes: Arc<Vec<u8>>,
}

/// All that the bytes depend on.
#[derive(Clone, PartialEq)]
pub struct BrickBytesKey {
    contribution: ContributionKey,
    sampling: Sampling,
    step_mm: f64,
    shade: Shade,
    is_illustrated: bool,
    clipped: Option<ClippedBricksKey>,
}

impl Key for BrickBytesKey {
    /// Empty if nothing is known.
    type Value = Vec<u8>;

    const NAME: &str = "sampling of bricks";

    fn bytes(&self, value: &Vec<u8>) -> usize {
        self.contribution.table_bytes() + value.len()
    }
}

/// What gives a byte per brick of an object, if anything is known of them.
pub type Find = fn(&Plan, usize, &Bricks, &Control) -> Result<Option<Vec<u8>>, Cancelled>;

impl BrickBytes {
    /// What `find` says of object number `object`, and 0 where bricks are `clipped`; `None` if it says nothing.
    pub fn new(
        making: &Making,
        contribution: &ContributionKey,
        bricks: &Bricks,
        (plan, object): (&Plan, usize),
        clipped: Option<&ClippedBricks>,
        find: Find,
    ) -> Result<Option<BrickBytes>, Cancelled> {
        assert_eq!(bricks.edge(), EDGE);
        // Words are gathered at 32-bit offsets.
        if bricks.number() > i32::MAX as usize / 8 {
            return Ok(None);
        }
        let key = BrickBytesKey {
            contribution: contribution.clone(),
            sampling: plan.sampling,
            step_mm: plan.lattice.step_mm,
            shade: plan.technique_of(object).shade,
            is_illustrated: plan.technique_of(object).illustrate != Illustrate::Plain,
            clipped: clipped.map(|clipped| clipped.of.clone()),
        };
        let bytes = making.find(&key, || {
            let Some(mut bytes) = find(plan, object, bricks, making.control)? else {
                return Ok::<_, Cancelled>(Vec::new());
            };
            let clipped = clipped.map_or(&[][..], ClippedBricks::bricks);
            for (byte, clipped) in bytes.iter_mut().zip(clipped) {
                *byte *= u8::from(!clipped);
            }
            bytes.extend([0; 3]);
            Ok(bytes)
        })?;
        Ok((!bytes.is_empty()).then(|| BrickBytes {
            dims: bricks.dims().map(|n| n as i32),
            bytes,
        }))
    }

    /// That of the brick around each cell.
    #[inline(always)]
    pub fn at<S: Level>(&self, cell: [I32s<S>; 3]) -> I32s<S> {
        let index = brick_number(self.dims, cell);
        words_inside(&self.bytes, index).and(0xFF)
    }
}
