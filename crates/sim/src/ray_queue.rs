//! The ray manager: a queue that sorts (document §7.4).
//!
//! [`StageCascade`] is the circuit, stage by stage; [`SortedQueue`] does the same faster and is what runs. A property test
//! holds both against a priority queue.

use crate::messages::Slot;

/// A ray that waits: number and key. Older tiles come first, then smaller keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WaitingRay {
    /// Its number.
    pub slot: Slot,
    /// Tile (which only orders; the circuit needs one bit of it) and key.
    pub rank: Rank,
}

/// What the comparators compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rank(u64);

impl Rank {
    /// Of a ray of the `tile`th tile with this key.
    pub fn new(tile: u32, key: u32) -> Rank {
        Rank(u64::from(tile) << 32 | u64::from(key))
    }
}

/// The queue as the run uses it: entries in order in a ring.
#[derive(Clone, Debug)]
pub struct SortedQueue {
    ring: Box<[WaitingRay]>,
    mask: usize,
    head: usize,
    len: usize,
}

impl SortedQueue {
    /// For at most `stages` rays.
    pub fn new(stages: usize) -> SortedQueue {
        let size = stages.max(1).next_power_of_two();
        let nobody = WaitingRay {
            slot: Slot(0),
            rank: Rank(0),
        };
        SortedQueue {
            ring: vec![nobody; size].into(),
            mask: size - 1,
            head: 0,
            len: 0,
        }
    }

    /// Rays that wait.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether nobody waits.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The ray at a place, 0 is next.
    #[inline(always)]
    pub fn get(&self, place: usize) -> Option<WaitingRay> {
        (place < self.len).then(|| self.ring[(self.head + place) & self.mask])
    }

    /// Takes the next ray.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<WaitingRay> {
        let first = self.get(0)?;
        self.head = (self.head + 1) & self.mask;
        self.len -= 1;
        Some(first)
    }

    /// Takes the ray at a place.
    pub fn remove(&mut self, place: usize) -> Option<WaitingRay> {
        let taken = self.get(place)?;
        for i in (1..=place).rev() {
            self.ring[(self.head + i) & self.mask] = self.ring[(self.head + i - 1) & self.mask];
        }
        self.head = (self.head + 1) & self.mask;
        self.len -= 1;
        Some(taken)
    }

    /// Puts a ray behind all that are not greater.
    ///
    /// # Panics
    /// If all stages are taken, which the run prevents.
    #[inline(always)]
    pub fn insert(&mut self, new: WaitingRay) {
        assert!(self.len <= self.mask, "more rays than stages");
        let mut place = self.head + self.len;
        for _ in 0..self.len {
            let before = self.ring[(place - 1) & self.mask];
            if before.rank <= new.rank {
                break;
            }
            self.ring[place & self.mask] = before;
            place = place.wrapping_sub(1);
        }
        self.ring[place & self.mask] = new;
        self.len += 1;
    }
}

/// The queue as a circuit: identical stages, each with a register, a comparator with the broadcast sort bus, and a
/// multiplexer. Stage 0 is at the output.
#[derive(Clone, Debug)]
pub struct StageCascade {
    stages: Vec<Option<WaitingRay>>,
}

impl StageCascade {
    /// A cascade of empty stages.
    pub fn new(stages: usize) -> StageCascade {
        StageCascade {
            stages: vec![None; stages],
        }
    }

    /// One clock: `shift_in` at the far end (only without `sort`), a ray on the sort bus, and what leaves.
    ///
    /// A stage whose ray is greater than the sort bus, or that is empty, holds; the others shift, and the last of them
    /// takes the ray from the bus. If all hold, the ray passes by them to the output: the case that the document leaves
    /// out.
    pub fn clock(
        &mut self,
        shift_in: Option<WaitingRay>,
        sort: Option<WaitingRay>,
    ) -> Option<WaitingRay> {
        let Some(new) = sort else {
            let out = self.stages[0];
            self.stages.rotate_left(1);
            if let Some(last) = self.stages.last_mut() {
                *last = shift_in;
            }
            return out;
        };
        let shifts: Vec<bool> = self
            .stages
            .iter()
            .map(|stage| stage.is_some_and(|waiting| waiting.rank <= new.rank))
            .collect();
        if !shifts[0] {
            return Some(new);
        }
        let out = self.stages[0];
        for i in 0..self.stages.len() {
            if !shifts[i] {
                break;
            }
            let shift_in_is_active = shifts.get(i + 1).copied().unwrap_or(false);
            self.stages[i] = if shift_in_is_active {
                self.stages[i + 1]
            } else {
                Some(new)
            };
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;

    fn waiting(slot: u16, key: u32) -> WaitingRay {
        WaitingRay {
            slot: Slot(slot),
            rank: Rank::new(0, key),
        }
    }

    proptest! {
        /// Any sequence of clocks: circuit, run and a priority queue with first-in-first-out among equals let the same
        /// rays out.
        #[test]
        fn circuit_and_run_are_priority_queues(
            first in prop::collection::vec(0u32..20, 0..64),
            clocks in prop::collection::vec(prop::option::weighted(0.7, 0u32..40), 0..300),
        ) {
            let mut cascade = StageCascade::new(64);
            let mut queue = SortedQueue::new(64);
            let mut heap = BinaryHeap::new();
            let mut sequence = 0u32;
            let mut sorted = first;
            sorted.sort_unstable();
            // The tile's rays come in sorted, from the far end, until the first is at the output.
            let bubbles = 64 - sorted.len();
            for key in &sorted {
                let new = waiting(sequence as u16, *key);
                prop_assert_eq!(cascade.clock(Some(new), None), None);
                queue.insert(new);
                heap.push(Reverse((*key, sequence)));
                sequence += 1;
            }
            for _ in 0..bubbles {
                prop_assert_eq!(cascade.clock(None, None), None);
            }
            for sort in clocks {
                // A ray can only come back if there is a stage for it.
                let new = sort.filter(|_| heap.len() < 64).map(|key| {
                    let new = waiting(sequence as u16, key);
                    heap.push(Reverse((key, sequence)));
                    sequence += 1;
                    new
                });
                if let Some(new) = new {
                    queue.insert(new);
                }
                let out = cascade.clock(None, new);
                prop_assert_eq!(queue.pop(), out);
                let expected = heap.pop().map(|Reverse((_, s))| s as u16);
                prop_assert_eq!(out.map(|w| w.slot.0), expected);
            }
        }

        #[test]
        fn a_ray_from_the_middle_leaves_the_others_in_order(keys in prop::collection::vec(0u32..9, 1..40), place in 0usize..40) {
            let mut queue = SortedQueue::new(40);
            for (i, key) in keys.iter().enumerate() {
                queue.insert(waiting(i as u16, *key));
            }
            let mut all: Vec<_> = (0..queue.len()).filter_map(|i| queue.get(i)).collect();
            let taken = queue.remove(place);
            prop_assert_eq!(taken, (place < all.len()).then(|| all.remove(place)));
            let rest: Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
            prop_assert_eq!(rest, all);
        }
    }

    #[test]
    fn a_ray_before_all_others_passes_them() {
        let mut cascade = StageCascade::new(2);
        cascade.clock(Some(waiting(0, 5)), None);
        cascade.clock(Some(waiting(1, 6)), None);
        assert_eq!(
            cascade.clock(None, Some(waiting(2, 4))),
            Some(waiting(2, 4))
        );
        assert_eq!(cascade.clock(None, None), Some(waiting(0, 5)));
    }

    #[test]
    fn equal_keys_keep_their_order() {
        let mut cascade = StageCascade::new(3);
        for i in 0..2 {
            cascade.clock(Some(waiting(i, 7)), None);
        }
        cascade.clock(None, None);
        assert_eq!(
            cascade.clock(None, Some(waiting(2, 7))),
            Some(waiting(0, 7))
        );
        assert_eq!(cascade.clock(None, None), Some(waiting(1, 7)));
        assert_eq!(cascade.clock(None, None), Some(waiting(2, 7)));
    }
}
