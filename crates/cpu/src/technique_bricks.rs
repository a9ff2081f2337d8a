//! In which bricks of a volume each technique shows nothing.

use crate::brick_number::EDGE;
use crate::making::Making;
use std::sync::Arc;
use strahl_scene::plan::{Plan, Segments};
use strahl_scene::visibility::{Contribution, ContributionKey};
use strahl_volume::bricks::Bricks;
use strahl_volume::{Cancelled, ContentId};

/// What the techniques of a Plan with segments show of each brick.
pub struct TechniqueBricks {
    /// All that it depends on, one for each technique.
    pub keys: Vec<ContributionKey>,
    contributions: Vec<Arc<Contribution>>,
}

impl TechniqueBricks {
    /// Of the `bricks` of the volume `source`; nothing is known where places count for runs that show nothing.
    pub fn new(
        making: &Making,
        plan: &Plan,
        (source, bricks): (ContentId, &Bricks),
    ) -> Result<TechniqueBricks, Cancelled> {
        let (mut keys, mut contributions) = (Vec::new(), Vec::new());
        let counts_places = plan.importance.is_some() && plan.weighs_runs();
        if bricks.edge() == EDGE && !counts_places {
            let mut alone = plan.clone();
            for technique in 0..plan.techniques.len() {
                alone.layers[0].segments = Segments::Whole { technique };
                let key = ContributionKey::new(&alone, 0, source, bricks);
                contributions.push(
                    making.find(&key, || Contribution::of(&alone, 0, bricks, making.control))?,
                );
                keys.push(key);
            }
        }
        Ok(TechniqueBricks {
            keys,
            contributions,
        })
    }

    /// Whether the technique with this number, counted from 1, changes nothing by any sample in a brick.
    pub fn is_quiet(&self, technique: u32, brick: usize) -> bool {
        let index = technique.checked_sub(1).map(|index| index as usize);
        match index
            .and_then(|index| self.contributions.get(index))
            .map(|c| &**c)
        {
            Some(Contribution::Visible(visible)) => !visible[brick],
            _ => false,
        }
    }
}
