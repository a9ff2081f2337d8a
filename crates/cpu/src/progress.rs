//! How far a picture is, and whether to go on.

use std::ops::ControlFlow;

/// Called after every tile, from any thread, with the number of tiles drawn and of all tiles;
/// `Break` ends the picture with [`Error::Cancelled`](crate::Error::Cancelled).
pub type Progress<'p> = &'p (dyn Fn(usize, usize) -> ControlFlow<()> + Sync);

/// A [`Progress`] that does nothing.
pub fn no_progress(_drawn: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
