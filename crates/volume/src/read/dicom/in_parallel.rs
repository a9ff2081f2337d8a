//! Work on many files at once.

use crate::Error;

/// Runs over all items, on all cores where threads are built in.
///
/// # Errors
/// One of those that the items gave.
pub(super) fn in_parallel<I: Send>(
    items: Vec<I>,
    work: impl Fn(I) -> Result<(), Error> + Sync + Send,
) -> Result<(), Error> {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        items.into_par_iter().try_for_each(work)
    }
    #[cfg(not(feature = "threads"))]
    items.into_iter().try_for_each(work)
}
