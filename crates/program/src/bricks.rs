//! Which bricks can show anything under a Plan.

use crate::frame::Object;
use crate::tables::stacked;
use strahl_scene::plan::Plan;
use strahl_scene::visibility::{Contribution, ContributionKey};
use strahl_volume::bricks::Bricks;
use strahl_volume::{Cancelled, ContentId, Control, Store};

/// One byte per brick, x fastest: 0 where nothing can be seen of object number `object`. The `bricks` are those of
/// `source`, which the object is reconstructed from; what they can give is kept in `store`.
///
/// # Errors
/// `control` was cancelled.
pub fn occupancy(
    plan: &Plan,
    object: usize,
    (source, bricks): (ContentId, &Bricks),
    store: &Store,
    control: &Control,
) -> Result<Vec<u8>, Cancelled> {
    let key = ContributionKey::new(plan, object, source, bricks);
    let make = || Contribution::of(plan, object, bricks, control);
    Ok(match &*store.find(&key, control, make)? {
        Contribution::Visible(visible) => visible.iter().map(|&is| u8::from(is)).collect(),
        // What a ray has seen so far is not asked here.
        Contribution::Every | Contribution::Largest(_) | Contribution::Smallest(_) => {
            vec![1; bricks.number()]
        }
    })
}

/// Which bricks of all objects can be seen, the objects behind one another along z: dimensions and a byte
/// per brick. Tells `objects` where theirs begin. `of_object` gives what an object is reconstructed from, and its
/// bricks; else as [`occupancy`].
///
/// # Errors
/// `control` was cancelled.
pub fn visible_bricks<'b>(
    plan: &Plan,
    objects: &mut [Object],
    of_object: impl Fn(usize) -> (ContentId, &'b Bricks),
    store: &Store,
    control: &Control,
) -> Result<([u32; 3], Vec<u8>), Cancelled> {
    let mut blocks = Vec::new();
    for i in 0..objects.len() {
        let of = of_object(i);
        let dims = of.1.dims().map(|n| n as u32);
        blocks.push((dims, occupancy(plan, i, of, store, control)?));
    }
    let (dims, bytes, first) = stacked(&blocks);
    for (object, first) in objects.iter_mut().zip(first) {
        object.bricks_first = [0, 0, first];
    }
    Ok((dims, bytes))
}
