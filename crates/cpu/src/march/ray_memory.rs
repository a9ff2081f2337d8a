//! What only some Plans remember of the rays of a packet.

use super::ray_history::RayHistory;
use super::runs::Runs;
use crate::levels::Level;
use crate::scenery::Scenery;
use strahl_scene::plan::Sampling;

/// Lent to one packet after the other, so that Plans that need none of it do not write it for every packet.
pub struct RayMemory<S: Level> {
    /// Where sampling looks back.
    pub(super) look_back: RayHistory<S>,
    /// Where the Plan has segments.
    pub(super) runs: Runs<S>,
}

impl<S: Level> RayMemory<S> {
    /// Of rays that have not begun.
    pub fn none() -> RayMemory<S> {
        RayMemory {
            look_back: RayHistory::none(),
            runs: Runs::none(),
        }
    }

    /// Forgets other rays, as far as rays through `scenery` would remember them.
    #[inline(always)]
    pub(super) fn clear(&mut self, scenery: &Scenery<S>) {
        let sampling = scenery.plan.sampling;
        if !matches!(sampling, Sampling::Regular | Sampling::ByOpacity { .. }) {
            self.look_back = RayHistory::none();
        }
        if scenery.segments.is_some() {
            self.runs = Runs::none();
        }
    }
}
