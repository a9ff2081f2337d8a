//! Files that are packed as a whole (`.nrrd.gz`, `.raw.gz`, …), read as if they were not.
//!
//! The bytes are unpacked on the way to where they stay: once to learn their number, once to read
//! them. So a small file that unpacks to a huge one costs time but no memory.

use super::block::{self, Encoding};
use super::input::Whole;
use super::sniff::{self, Kind};
use super::{Bytes, Input, LoadedVolume};
use crate::error::Error;
use crate::memory;
use std::io::{self, Read};
use std::sync::Mutex;

/// Reads bytes of a kind, or finds out which kind they are.
type ReadKind<'r> = dyn Fn(Option<Kind>, &Input) -> Result<LoadedVolume, Error> + 'r;

/// Reads what is in a packed file: `read_kind` is told the kind of the unpacked bytes, if they say it.
pub(crate) fn read(
    input: &Input,
    encoding: Encoding,
    read_kind: &ReadKind,
) -> Result<LoadedVolume, Error> {
    let unpacked = Unpacked::new(input.bytes, encoding)?;
    let packed_name = input.name;
    let lower = input.name.to_ascii_lowercase();
    let name = [".gz", ".bz2"]
        .iter()
        .find(|suffix| lower.ends_with(*suffix))
        .map_or(input.name, |suffix| {
            &input.name[..input.name.len() - suffix.len()]
        });
    let input = Input {
        name,
        bytes: &unpacked,
        files: input.files,
    };
    match sniff::kind(&unpacked)? {
        // These jump about in the file, which a packed one does not allow.
        Some(kind @ (Kind::Tiff | Kind::Dicom | Kind::MaybeDicom | Kind::Png)) => {
            let whole = Whole {
                bytes: unpacked.whole()?,
                file: Box::new(unpacked.packed),
            };
            // A file of a series is known by its own name.
            let name = match kind {
                Kind::Dicom | Kind::MaybeDicom => packed_name,
                _ => name,
            };
            let input = Input {
                name,
                bytes: &whole,
                ..input
            };
            read_kind(Some(kind), &input)
        }
        kind => read_kind(kind, &input),
    }
}

/// All bytes of a file that is packed with gzip, if the first unpacked ones are wanted. `None` for all others.
///
/// # Errors
/// Damaged data, more of it than fits, or what the system says.
#[cfg(feature = "dicom")]
pub(crate) fn whole_if(
    bytes: &dyn Bytes,
    is_wanted: impl Fn(&dyn Bytes) -> bool,
) -> Result<Option<Vec<u8>>, Error> {
    let Some(Kind::Packed(encoding @ Encoding::Gzip)) = sniff::kind(bytes)? else {
        return Ok(None);
    };
    let Ok(head) = block::head(bytes, 0, encoding, sniff::HEAD_BYTES) else {
        return Ok(None);
    };
    match is_wanted(&head) {
        true => Ok(Some(Unpacked::new(bytes, encoding)?.whole()?)),
        false => Ok(None),
    }
}

/// The unpacked bytes of a packed file. Reading on is cheap, going back starts from the front.
struct Unpacked<'a> {
    packed: &'a dyn Bytes,
    encoding: Encoding,
    len: u64,
    reading: Mutex<Reading<'a>>,
}

struct Reading<'a> {
    // The trait object is only ever used behind the mutex, by one thread at a time.
    decoder: Box<dyn Read + Send + 'a>,
    position: u64,
}

impl<'a> Unpacked<'a> {
    fn new(packed: &'a dyn Bytes, encoding: Encoding) -> Result<Unpacked<'a>, Error> {
        let len = block::unpacked_length(packed, 0, encoding)?;
        Ok(Unpacked {
            packed,
            encoding,
            len,
            reading: Mutex::new(Reading {
                decoder: block::decoder(packed, 0, encoding),
                position: 0,
            }),
        })
    }
}

/// The most that a file may unpack to where all of it has to be in memory.
const MOST_BYTES: u64 = 1 << 31;

impl Unpacked<'_> {
    /// All bytes. Their number was counted, not read in a header.
    fn whole(&self) -> Result<Vec<u8>, Error> {
        if self.len > MOST_BYTES {
            return Err(Error::field(
                "the unpacked size",
                format!("{} bytes", self.len),
                format!("up to {MOST_BYTES} bytes for this format; unpack the file first"),
            ));
        }
        self.packed.has_room(self.len)?;
        let mut all = memory::zeroed(self.len as usize)?;
        self.read_at(0, &mut all)?;
        Ok(all)
    }
}

impl Bytes for Unpacked<'_> {
    fn len(&self) -> u64 {
        self.len
    }

    fn read_at(&self, offset: u64, into: &mut [u8]) -> io::Result<()> {
        let mut reading = self.reading.lock().map_err(|_| io::ErrorKind::Other)?;
        if offset < reading.position {
            *reading = Reading {
                decoder: block::decoder(self.packed, 0, self.encoding),
                position: 0,
            };
        }
        let skip = offset - reading.position;
        io::copy(&mut (&mut reading.decoder).take(skip), &mut io::sink())?;
        reading.decoder.read_exact(into)?;
        reading.position = offset + into.len() as u64;
        Ok(())
    }

    fn check(&self) -> io::Result<()> {
        self.packed.check()
    }

    fn has_room(&self, bytes: u64) -> Result<(), Error> {
        self.packed.has_room(bytes)
    }

    fn keep(&self, bytes: u64) -> Result<(), Error> {
        self.packed.keep(bytes)
    }
}
