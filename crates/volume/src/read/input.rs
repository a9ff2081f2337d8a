//! What a reader may see: the bytes of files, by name.

use crate::Error;
use std::collections::BTreeMap;
use std::io;

/// The bytes of one file, read by position, so that samples go straight to where they stay.
pub trait Bytes: Send + Sync {
    /// Number of bytes.
    fn len(&self) -> u64;

    /// Whether there is no byte.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fills `into` from `offset` on.
    ///
    /// # Errors
    /// `UnexpectedEof` if the file ends before, or what the system says.
    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()>;

    /// Whether reading goes on; readers ask where they work for long on bytes that they have.
    ///
    /// # Errors
    /// Somebody ended it.
    fn check(&self) -> io::Result<()> {
        Ok(())
    }

    /// Whether there is memory for as many bytes; readers ask before they take much of it.
    ///
    /// # Errors
    /// It is more than whoever reads allows.
    fn has_room(&self, bytes: u64) -> Result<(), Error> {
        let _ = bytes;
        Ok(())
    }

    /// The same of memory that stays when the file has been read.
    ///
    /// # Errors
    /// As [`has_room`](Bytes::has_room).
    fn keep(&self, bytes: u64) -> Result<(), Error> {
        self.has_room(bytes)
    }
}

impl Bytes for [u8] {
    fn len(&self) -> u64 {
        self.len() as u64
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        let source = usize::try_from(offset)
            .ok()
            .and_then(|start| self.get(start..start.checked_add(into.len())?))
            .ok_or(io::ErrorKind::UnexpectedEof)?;
        into.copy_from_slice(source);
        Ok(())
    }
}

impl<B: Bytes + ?Sized> Bytes for &B {
    fn len(&self) -> u64 {
        (**self).len()
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        (**self).read_at(offset, into)
    }

    fn check(&self) -> io::Result<()> {
        (**self).check()
    }

    fn has_room(&self, bytes: u64) -> Result<(), Error> {
        (**self).has_room(bytes)
    }

    fn keep(&self, bytes: u64) -> Result<(), Error> {
        (**self).keep(bytes)
    }
}

/// What a file unpacks to, in memory. What holds for reading the file holds for it.
pub(crate) struct Whole<'a> {
    pub(crate) bytes: Vec<u8>,
    pub(crate) file: Box<dyn Bytes + 'a>,
}

impl Bytes for Whole<'_> {
    fn len(&self) -> u64 {
        self.bytes.len() as u64
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        self.bytes.read_at(offset, into)
    }

    fn check(&self) -> io::Result<()> {
        self.file.check()
    }

    fn has_room(&self, bytes: u64) -> Result<(), Error> {
        self.file.has_room(bytes)
    }

    fn keep(&self, bytes: u64) -> Result<(), Error> {
        self.file.keep(bytes)
    }
}

impl Bytes for Vec<u8> {
    fn len(&self) -> u64 {
        self.as_slice().len() as u64
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        self.as_slice().read_at(offset, into)
    }
}

/// A folder, or a list of files, as a reader sees it: names without folders, and their bytes.
pub trait Files: Sync {
    /// The names, sorted.
    fn names(&self) -> Vec<String>;

    /// The names of the files here and in folders below (`folder/name`), sorted. Without folders, those of
    /// [`names`](Files::names).
    ///
    /// # Errors
    /// More folders than one wants to walk through, or what the system says.
    fn names_below(&self) -> io::Result<Vec<String>> {
        Ok(self.names())
    }

    /// Opens a file by name; one in a folder below as `folder/name`.
    ///
    /// # Errors
    /// `NotFound` for an unknown name, or what the system says.
    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>>;
}

/// Files that are already in memory, those in folders as `folder/name`.
pub type MemoryFiles = BTreeMap<String, Vec<u8>>;

impl Files for MemoryFiles {
    fn names(&self) -> Vec<String> {
        let here = self.keys().filter(|name| !name.contains('/'));
        here.cloned().collect()
    }

    fn names_below(&self) -> io::Result<Vec<String>> {
        Ok(self.keys().cloned().collect())
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Bytes + '_>> {
        match self.get(name) {
            Some(bytes) => Ok(Box::new(bytes.as_slice())),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }
}

/// What every reader gets: the file, and its siblings for headers that name other files.
pub(crate) struct Input<'a> {
    /// The file's name, without folders.
    pub(crate) name: &'a str,
    /// Its bytes (unpacked, if the whole file was packed).
    pub(crate) bytes: &'a dyn Bytes,
    /// The files beside it.
    pub(crate) files: &'a dyn Files,
}
