//! Pools of threads, kept from picture to picture.

use crate::error::Error;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A pool for each number of threads that was asked for. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct Pools(Arc<Mutex<BTreeMap<usize, Arc<ThreadPool>>>>);

impl Pools {
    /// The pool of this many threads, started when it is first asked for; `None` stands for the surrounding pool, by
    /// default that of all cores, if the number is 0.
    ///
    /// # Errors
    /// The operating system gives no threads.
    pub fn of(&self, threads: usize) -> Result<Option<Arc<ThreadPool>>, Error> {
        if threads == 0 {
            return Ok(None);
        }
        let mut pools = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pool) = pools.get(&threads) {
            return Ok(Some(pool.clone()));
        }
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = Arc::new(pool.map_err(|why| Error::Threads {
            threads,
            why: why.to_string(),
        })?);
        pools.insert(threads, pool.clone());
        Ok(Some(pool))
    }
}
