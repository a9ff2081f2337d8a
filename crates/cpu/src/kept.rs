//! What was found for the Plans drawn last: most have only another camera.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What was found, and what it depends on; the newest first.
pub struct Kept<K, V>(Mutex<Vec<(K, Arc<V>)>>);

impl<K, V> Default for Kept<K, V> {
    fn default() -> Kept<K, V> {
        Kept(Mutex::default())
    }
}

impl<K: PartialEq, V> Kept<K, V> {
    /// What depends on `asked`, made if it is not known; `None` if there is none to make. The newest `most` are kept.
    pub fn find(
        &self,
        asked: K,
        most: usize,
        make: impl FnOnce(&K) -> Option<V>,
    ) -> Option<Arc<V>> {
        {
            let mut all = self.all();
            if let Some(index) = all.iter().position(|(of, _)| *of == asked) {
                all[..=index].rotate_right(1);
                return Some(all[0].1.clone());
            }
        }
        // Not under the lock: the threads that help here may draw other pictures meanwhile.
        let made = Arc::new(make(&asked)?);
        let mut all = self.all();
        all.insert(0, (asked, made.clone()));
        all.truncate(most);
        Some(made)
    }

    fn all(&self) -> MutexGuard<'_, Vec<(K, Arc<V>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
