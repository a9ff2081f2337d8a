//! Work on parts of a slice, on all cores where there are threads.

use crate::control::Parts;
use crate::{Cancelled, Error};

/// Has `of_row` work on each `length` numbers in a row of `numbers`, told which row it is, on all cores (feature
/// `threads`), until `parts` are cancelled.
pub(crate) fn for_each_row<T: Send>(
    numbers: &mut [T],
    length: usize,
    parts: &Parts,
    of_row: impl Fn(usize, &mut [T]) + Sync,
) -> Result<(), Cancelled> {
    let step = |(row, numbers): (usize, &mut [T])| {
        of_row(row, numbers);
        parts.done(1)
    };
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        numbers
            .par_chunks_mut(length)
            .enumerate()
            .try_for_each(step)
    }
    #[cfg(not(feature = "threads"))]
    numbers.chunks_mut(length).enumerate().try_for_each(step)
}

/// What was made under [`Control::NONE`](crate::Control::NONE), which nobody cancels.
///
/// # Panics
/// If there is no memory for it.
pub(crate) fn made<T>(made: Result<T, Error>) -> T {
    made.expect("memory for it, as nobody cancels")
}
