//! What is made of data once and used again.

use crate::{Cancelled, Control};
use std::any::{Any, TypeId};
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// All that derived data depends on: what it is made of (by [`ContentId`](crate::ContentId)), and its parameters. What
/// it is says the type of the key. Keys that are equal stand for the same value.
pub trait Key: Clone + PartialEq + Send + Sync + 'static {
    /// What is made.
    type Value: Send + Sync + 'static;

    /// What it is called in [`Counts`].
    const NAME: &'static str;

    /// Bytes that `value` and the key take.
    fn bytes(&self, value: &Self::Value) -> usize;
}

/// Derived data under keys, shared by everything that draws from the same data. What was used last stays, within a
/// budget of bytes.
///
/// ```
/// use strahl_volume::{Cancelled, ContentId, Control, Key, Phantom, Store};
///
/// #[derive(Clone, PartialEq)]
/// struct Largest(ContentId);
///
/// impl Key for Largest {
///     type Value = f64;
///     const NAME: &str = "largest value";
///     fn bytes(&self, _: &f64) -> usize {
///         size_of::<(Largest, f64)>()
///     }
/// }
///
/// let (store, volume) = (Store::default(), Phantom::Tree.volume([8, 8, 8])?);
/// let largest = || {
///     let make = || Ok::<_, Cancelled>(volume.statistics().range[1]);
///     store.find(&Largest(volume.id()), &Control::NONE, make)
/// };
/// assert_eq!(largest(), largest());
/// assert_eq!((store.counts().made, store.counts().found), (1, 1));
/// # Ok::<(), strahl_volume::Error>(())
/// ```
pub struct Store {
    budget_bytes: usize,
    state: Mutex<State>,
    /// That something was made, or not.
    changed: Condvar,
}

#[derive(Default)]
struct State {
    slots: HashMap<TypeId, Vec<Slot>>,
    /// Of all that is kept.
    bytes: usize,
    /// How often anything was asked for.
    clock: u64,
    counts: Counts,
}

struct Slot {
    key: Box<dyn Any + Send + Sync>,
    /// `None` while a thread makes it.
    made: Option<Made>,
}

struct Made {
    value: Arc<dyn Any + Send + Sync>,
    bytes: usize,
    last_used: u64,
}

/// What a store has done so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Values made.
    pub made: u64,
    /// Values found, because they had been made before.
    pub found: u64,
    /// Values given up to stay within the budget.
    pub evicted: u64,
    /// Values made, by the name of their kind.
    pub made_by_name: BTreeMap<&'static str, u64>,
}

impl Store {
    /// What [`Store::default`] keeps: 1 GiB.
    pub const USUAL_BUDGET_BYTES: usize = 1 << 30;

    /// A store that keeps up to `budget_bytes`. What is in use stays beyond that, as giving it up would free
    /// nothing.
    pub fn with_budget(budget_bytes: usize) -> Store {
        Store {
            budget_bytes,
            state: Mutex::default(),
            changed: Condvar::new(),
        }
    }

    /// The value of `key`: found if it is known, else made by `make`, outside all locks. A thread that asks for what
    /// another one makes waits for it, so that nothing is made twice at a time. (A thread of a pool does not wait:
    /// it may be the one that the other waits for. It makes the value for itself.)
    ///
    /// # Errors
    /// Those of `make`; `control` was cancelled. Nothing is kept then.
    pub fn find<K: Key, E: From<Cancelled>>(
        &self,
        key: &K,
        control: &Control,
        make: impl FnOnce() -> Result<K::Value, E>,
    ) -> Result<Arc<K::Value>, E> {
        control.check()?;
        let begun = {
            let mut state = self.state();
            loop {
                match state.look_for(key) {
                    Found::Made(value) => return Ok(value),
                    Found::InMaking if is_in_pool() => break None,
                    Found::InMaking => {
                        control.check()?;
                        // Whoever waits may be cancelled meanwhile.
                        let pause = Duration::from_millis(2);
                        let woken = self.changed.wait_timeout(state, pause);
                        state = woken.unwrap_or_else(PoisonError::into_inner).0;
                    }
                    Found::Nothing => {
                        state.begin(key);
                        break Some(Begun { store: self, key });
                    }
                }
            }
        };
        let value = Arc::new(make()?);
        // What is given up is dropped outside the lock.
        let given_up = self.state().keep(key, &value, self.budget_bytes);
        drop(begun);
        drop(given_up);
        Ok(value)
    }

    /// The value of `key`, if it is known. With [`put`](Store::put) for values whose making waits for something else
    /// than this thread.
    pub fn get<K: Key>(&self, key: &K) -> Option<Arc<K::Value>> {
        match self.state().look_for(key) {
            Found::Made(value) => Some(value),
            Found::InMaking | Found::Nothing => None,
        }
    }

    /// Keeps a value that was made for `key`.
    pub fn put<K: Key>(&self, key: &K, value: K::Value) -> Arc<K::Value> {
        let value = Arc::new(value);
        let given_up = self.state().keep(key, &value, self.budget_bytes);
        drop(given_up);
        value
    }

    /// Gives up the value of `key`, whoever holds it.
    pub fn remove<K: Key>(&self, key: &K) {
        let given_up = self.state().take_out(key);
        drop(given_up);
    }

    /// What was made, found and given up so far.
    pub fn counts(&self) -> Counts {
        self.state().counts.clone()
    }

    /// Bytes of all that is kept.
    pub fn bytes(&self) -> usize {
        self.state().bytes
    }

    /// Gives up everything that is not in use.
    pub fn clear(&self) {
        let given_up = self.state().evict(0);
        drop(given_up);
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Default for Store {
    fn default() -> Store {
        Store::with_budget(Store::USUAL_BUDGET_BYTES)
    }
}

impl fmt::Debug for Store {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Store")
            .field("budget_bytes", &self.budget_bytes)
            .field("bytes", &self.bytes())
            .field("counts", &self.counts())
            .finish_non_exhaustive()
    }
}

enum Found<V> {
    Made(Arc<V>),
    InMaking,
    Nothing,
}

impl State {
    fn look_for<K: Key>(&mut self, key: &K) -> Found<K::Value> {
        let slots = self.slots.get_mut(&TypeId::of::<K>());
        let slot = slots.and_then(|slots| slots.iter_mut().find(|slot| slot.is_of(key)));
        match slot {
            None => Found::Nothing,
            Some(Slot { made: None, .. }) => Found::InMaking,
            Some(Slot {
                made: Some(made), ..
            }) => {
                self.clock += 1;
                self.counts.found += 1;
                made.last_used = self.clock;
                match made.value.clone().downcast() {
                    Ok(value) => Found::Made(value),
                    Err(_) => unreachable!("the type of a key says that of its value"),
                }
            }
        }
    }

    fn begin<K: Key>(&mut self, key: &K) {
        let slots = self.slots.entry(TypeId::of::<K>()).or_default();
        slots.push(Slot {
            key: Box::new(key.clone()),
            made: None,
        });
    }

    /// Keeps `value`, and gives up what is beyond the budget then.
    fn keep<K: Key>(&mut self, key: &K, value: &Arc<K::Value>, budget_bytes: usize) -> Vec<Made> {
        self.counts.made += 1;
        *self.counts.made_by_name.entry(K::NAME).or_default() += 1;
        self.clock += 1;
        let bytes = key.bytes(value);
        let made = Made {
            value: value.clone(),
            bytes,
            last_used: self.clock,
        };
        let slots = self.slots.entry(TypeId::of::<K>()).or_default();
        match slots.iter_mut().find(|slot| slot.is_of(key)) {
            // Another thread was faster.
            Some(Slot { made: Some(_), .. }) => return Vec::new(),
            Some(slot) => slot.made = Some(made),
            None => slots.push(Slot {
                key: Box::new(key.clone()),
                made: Some(made),
            }),
        }
        self.bytes += bytes;
        self.evict(budget_bytes)
    }

    fn take_out<K: Key>(&mut self, key: &K) -> Option<Made> {
        let slots = self.slots.get_mut(&TypeId::of::<K>())?;
        let is_of = |slot: &Slot| slot.made.is_some() && slot.is_of(key);
        let index = slots.iter().position(is_of)?;
        let made = slots.swap_remove(index).made?;
        self.bytes -= made.bytes;
        self.counts.evicted += 1;
        Some(made)
    }

    /// Takes out what was used least lately and is not in use, until the rest fits.
    fn evict(&mut self, budget_bytes: usize) -> Vec<Made> {
        let mut given_up = Vec::new();
        while self.bytes > budget_bytes {
            let idle = |slot: &Slot| {
                let made = slot.made.as_ref()?;
                (Arc::strong_count(&made.value) == 1).then_some(made.last_used)
            };
            let places = self.slots.iter().flat_map(|(of, slots)| {
                let of_kind = slots.iter().enumerate();
                of_kind.filter_map(move |(i, slot)| Some((idle(slot)?, *of, i)))
            });
            let Some((_, of, index)) = places.min_by_key(|(last_used, ..)| *last_used) else {
                break;
            };
            let slot = self
                .slots
                .get_mut(&of)
                .map(|slots| slots.swap_remove(index));
            if let Some(made) = slot.and_then(|slot| slot.made) {
                self.bytes -= made.bytes;
                self.counts.evicted += 1;
                given_up.push(made);
            }
        }
        given_up
    }
}

impl Slot {
    fn is_of<K: Key>(&self, key: &K) -> bool {
        self.key.downcast_ref() == Some(key)
    }
}

/// A value that is being made: when this goes and it is still not there, the next one who asks makes it.
struct Begun<'s, K: Key> {
    store: &'s Store,
    key: &'s K,
}

impl<K: Key> Drop for Begun<'_, K> {
    fn drop(&mut self) {
        let mut state = self.store.state();
        if let Some(slots) = state.slots.get_mut(&TypeId::of::<K>()) {
            slots.retain(|slot| slot.made.is_some() || !slot.is_of(self.key));
        }
        drop(state);
        self.store.changed.notify_all();
    }
}

/// Whether this thread belongs to a pool, and so may have been given this work while it waits for other work.
fn is_in_pool() -> bool {
    #[cfg(feature = "threads")]
    {
        rayon::current_thread_index().is_some()
    }
    #[cfg(not(feature = "threads"))]
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A number of bytes, by name and size.
    #[derive(Clone, Debug, PartialEq)]
    struct Block(&'static str, usize);

    impl Key for Block {
        type Value = Vec<u8>;
        const NAME: &str = "block";
        fn bytes(&self, value: &Vec<u8>) -> usize {
            value.len()
        }
    }

    fn find(store: &Store, block: Block) -> Arc<Vec<u8>> {
        let make = || Ok::<_, Cancelled>(vec![0; block.1]);
        store.find(&block, &Control::NONE, make).unwrap()
    }

    #[test]
    fn what_was_used_least_lately_goes_first() {
        let store = Store::with_budget(100);
        for name in ["a", "b"] {
            find(&store, Block(name, 40));
        }
        find(&store, Block("a", 40));
        find(&store, Block("c", 40));
        assert_eq!((store.bytes(), store.counts().evicted), (80, 1));
        // a and c are there, b is not.
        let made = store.counts().made;
        find(&store, Block("a", 40));
        find(&store, Block("c", 40));
        assert_eq!(store.counts().made, made);
        find(&store, Block("b", 40));
        assert_eq!(store.counts().made, made + 1);
    }

    #[test]
    fn what_is_in_use_stays_beyond_the_budget() {
        let store = Store::with_budget(10);
        let held = find(&store, Block("held", 50));
        find(&store, Block("other", 5));
        assert_eq!((store.bytes(), store.counts().evicted), (55, 0));
        drop(held);
        find(&store, Block("third", 5));
        assert_eq!((store.bytes(), store.counts().evicted), (10, 1));
        store.clear();
        assert_eq!(store.bytes(), 0);
    }

    #[test]
    fn threads_that_ask_at_once_make_it_once() {
        const THREADS: usize = 8;
        let (store, barrier) = (Store::default(), Barrier::new(THREADS));
        let makes = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    barrier.wait();
                    let make = || {
                        makes.fetch_add(1, Ordering::Relaxed);
                        std::thread::sleep(Duration::from_millis(30));
                        Ok::<_, Cancelled>(vec![7; 3])
                    };
                    let found = store.find(&Block("x", 3), &Control::NONE, make);
                    assert_eq!(*found.unwrap(), [7; 3]);
                });
            }
        });
        assert_eq!(makes.into_inner(), 1);
        assert_eq!(store.counts().found, THREADS as u64 - 1);
    }

    #[test]
    fn what_could_not_be_made_is_made_by_the_next_who_asks() {
        let store = Store::default();
        let block = Block("x", 3);
        let failed = store.find(&block, &Control::NONE, || Err(Cancelled));
        assert_eq!(failed, Err(Cancelled));
        assert_eq!(store.counts(), Counts::default());
        assert_eq!(*find(&store, block.clone()), [0; 3]);
        // Nobody makes anything for somebody who has given up.
        let control = Control::new();
        control.cancel();
        let make = || -> Result<Vec<u8>, Cancelled> { unreachable!() };
        assert_eq!(store.find(&Block("y", 1), &control, make), Err(Cancelled));
    }

    #[test]
    fn who_waits_can_be_cancelled() {
        let (store, control) = (Store::default(), Control::new());
        let barrier = Barrier::new(2);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let make = || {
                    barrier.wait();
                    while !control.is_cancelled() {
                        std::thread::yield_now();
                    }
                    // The other one ends while this is still in the making.
                    barrier.wait();
                    Ok::<_, Cancelled>(vec![1])
                };
                store.find(&Block("x", 1), &Control::NONE, make)
            });
            barrier.wait();
            let waiting = scope.spawn(|| {
                let make = || -> Result<Vec<u8>, Cancelled> { unreachable!() };
                store.find(&Block("x", 1), &control, make)
            });
            control.cancel();
            assert_eq!(waiting.join().unwrap(), Err(Cancelled));
            barrier.wait();
        });
    }
}
