//! Pools of threads, kept from picture to picture.

use crate::error::Error;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Threads that work together.
#[cfg(feature = "threads")]
#[derive(Debug)]
pub struct Pool(rayon::ThreadPool);

/// Threads that work together: there are none in builds without the feature `threads`.
#[cfg(not(feature = "threads"))]
#[derive(Debug)]
pub enum Pool {}

#[cfg(feature = "threads")]
impl Pool {
    fn new(threads: usize) -> Result<Pool, String> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map(Pool).map_err(|why| why.to_string())
    }

    /// Has `work` done on these threads.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.0.install(work)
    }
}

#[cfg(not(feature = "threads"))]
impl Pool {
    fn new(_threads: usize) -> Result<Pool, String> {
        Err("this build draws on one thread; build with the feature `threads`".to_owned())
    }

    /// Has `work` done on these threads.
    pub fn install<R: Send>(&self, _work: impl FnOnce() -> R + Send) -> R {
        match *self {}
    }
}

/// More threads than this would only wait for one another.
pub const MOST_THREADS: usize = 1024;

/// A pool for each number of threads that was asked for. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct Pools(Arc<Mutex<BTreeMap<usize, Arc<Pool>>>>);

impl Pools {
    /// The pool of this many threads, started when it is first asked for; `None` stands for the surrounding pool, by
    /// default that of all cores, if the number is 0, and in builds without threads for the caller's own.
    ///
    /// # Errors
    /// They are more than [`MOST_THREADS`]; the operating system gives no threads; the build has none, and more than one are asked for.
    pub fn of(&self, threads: usize) -> Result<Option<Arc<Pool>>, Error> {
        if threads == 0 || (threads == 1 && cfg!(not(feature = "threads"))) {
            return Ok(None);
        }
        if threads > MOST_THREADS {
            let why = format!("at most {MOST_THREADS} draw together; 0 takes one per core");
            return Err(Error::Threads { threads, why });
        }
        let mut pools = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pool) = pools.get(&threads) {
            return Ok(Some(pool.clone()));
        }
        let pool = Pool::new(threads).map_err(|why| Error::Threads { threads, why })?;
        let pool = Arc::new(pool);
        pools.insert(threads, pool.clone());
        Ok(Some(pool))
    }
}
