//! Which bricks can show anything under a Plan.

use crate::frame::Object;
use crate::tables::stacked;
use strahl_scene::plan::Plan;
use strahl_scene::visibility::Contribution;
use strahl_volume::bricks::Bricks;

/// One byte per brick, x fastest: 0 where nothing can be seen of object number `object`.
pub fn occupancy(bricks: &Bricks, plan: &Plan, object: usize) -> Vec<u8> {
    match Contribution::of(plan, object, bricks) {
        Contribution::Visible(visible) => visible.into_iter().map(u8::from).collect(),
        // What a ray has seen so far is not asked here.
        Contribution::Every | Contribution::Largest(_) | Contribution::Smallest(_) => {
            vec![1; bricks.number()]
        }
    }
}

/// Which bricks of all objects can be seen, the objects behind one another along z: dimensions and a byte
/// per brick. Tells `objects` where theirs begin. `bricks` gives those of an object.
pub fn visible_bricks<'b>(
    plan: &Plan,
    objects: &mut [Object],
    bricks: impl Fn(usize) -> &'b Bricks,
) -> ([u32; 3], Vec<u8>) {
    let of_object: Vec<_> = (0..objects.len())
        .map(|i| {
            let bricks = bricks(i);
            let dims = bricks.dims().map(|n| n as u32);
            (dims, occupancy(bricks, plan, i))
        })
        .collect();
    let (dims, bytes, first) = stacked(&of_object);
    for (object, first) in objects.iter_mut().zip(first) {
        object.bricks_first = [0, 0, first];
    }
    (dims, bytes)
}
