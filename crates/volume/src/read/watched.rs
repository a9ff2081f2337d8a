//! Files whose reading can be followed and cancelled.

use super::input::{Bytes, Files};
use crate::{Cancelled, Control, Error, Work};
use std::collections::BTreeSet;
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Counts the bytes that a reader takes, and gives it none once the control is cancelled. What the reader then
/// says is not looked at.
pub(super) struct Watched<'a> {
    files: &'a dyn Files,
    control: &'a Control,
    read: AtomicU64,
    total: AtomicU64,
    /// Files whose length is in `total`; a reader may open one several times.
    known: Mutex<BTreeSet<String>>,
}

impl<'a> Watched<'a> {
    pub(super) fn new(files: &'a dyn Files, control: &'a Control) -> Watched<'a> {
        Watched {
            files,
            control,
            read: 0.into(),
            total: 0.into(),
            known: Mutex::default(),
        }
    }

    fn check(&self) -> io::Result<()> {
        self.control.check().map_err(io::Error::other)
    }
}

impl Files for Watched<'_> {
    fn names(&self) -> Vec<String> {
        self.files.names()
    }

    fn names_below(&self) -> io::Result<Vec<String>> {
        self.check()?;
        self.files.names_below()
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>> {
        self.check()?;
        let bytes = self.files.open(name)?;
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.insert(name.to_owned()) {
            self.total.fetch_add(bytes.len(), Ordering::Relaxed);
        }
        Ok(Box::new(WatchedBytes {
            bytes,
            watched: self,
        }))
    }
}

struct WatchedBytes<'a> {
    bytes: Box<dyn Bytes + 'a>,
    watched: &'a Watched<'a>,
}

/// Large enough to cost nothing, small enough to be read within a few milliseconds.
const PIECE_BYTES: usize = 1 << 20;

impl Bytes for WatchedBytes<'_> {
    fn len(&self) -> u64 {
        self.bytes.len()
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        let watched = self.watched;
        watched.check()?;
        let mut offset = offset;
        for piece in into.chunks_mut(PIECE_BYTES) {
            self.bytes.read_at(offset, piece)?;
            let length = piece.len() as u64;
            offset += length;
            let read = watched.read.fetch_add(length, Ordering::Relaxed) + length;
            let total = watched.total.load(Ordering::Relaxed).max(1);
            let told = watched
                .control
                .report(Work::Reading, read as f64 / total as f64);
            told.map_err(io::Error::other)?;
        }
        Ok(())
    }

    fn check(&self) -> io::Result<()> {
        self.watched.check()
    }

    fn has_room(&self, bytes: u64) -> Result<(), Error> {
        Ok(self.watched.control.has_room(bytes)?)
    }

    fn keep(&self, bytes: u64) -> Result<(), Error> {
        Ok(self.watched.control.keep(bytes)?)
    }
}

/// What was read under `control`: whatever a reader says once it is cancelled is said of missing bytes.
pub(super) fn uncancelled<T>(read: Result<T, Error>, control: &Control) -> Result<T, Error> {
    match read {
        Err(_) if control.is_cancelled() => Err(Cancelled.into()),
        read => read,
    }
}
