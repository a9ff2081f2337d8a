//! Which bricks can show anything under a Plan.

use strahl_scene::plan::Plan;
use strahl_scene::visibility::Contribution;
use strahl_volume::bricks::Bricks;

/// One byte per brick, x fastest: 0 where nothing can be seen of object number `object`.
pub fn occupancy(bricks: &Bricks, plan: &Plan, object: usize) -> Vec<u8> {
    match Contribution::of(plan, object, bricks) {
        Contribution::Visible(visible) => visible.into_iter().map(u8::from).collect(),
        // What a ray has seen so far is not asked here.
        Contribution::Every | Contribution::Largest(_) | Contribution::Smallest(_) => {
            vec![1; bricks.ranges().len()]
        }
    }
}
