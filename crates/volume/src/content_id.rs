//! Which data this is, wherever it goes.

use std::sync::atomic::{AtomicU64, Ordering};

/// Tells volumes and meshes apart within a process. Clones share it, as they share their content, which never
/// changes: whatever is derived from a volume can be kept under its id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContentId(u64);

impl ContentId {
    /// One that nothing has had before.
    pub(crate) fn unique() -> ContentId {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        ContentId(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}
