//! Finding what a picture needs, and making what is not there yet.

use crate::pools::Pool;
use std::sync::Arc;
use strahl_volume::{Cancelled, Control, Key, Store};

/// Where derived data is kept, who may end its making, and the threads that make it.
pub struct Making<'m> {
    pub store: &'m Store,
    pub control: &'m Control,
    /// The surrounding pool without.
    pub pool: Option<&'m Pool>,
}

impl Making<'_> {
    /// The value of `key`, by `make` if it is not known. (To be called where the picture was asked for, not on a
    /// thread of the pool: see [`Store::find`].)
    pub fn find<K: Key, E: From<Cancelled> + Send>(
        &self,
        key: &K,
        make: impl FnOnce() -> Result<K::Value, E> + Send,
    ) -> Result<Arc<K::Value>, E> {
        self.store.find(key, self.control, || match self.pool {
            Some(pool) => pool.install(make),
            None => make(),
        })
    }
}
