//! Files that are packed as a whole (`.nrrd.gz`, `.raw.gz`, …), read as if they were not.
//!
//! The bytes are unpacked on the way to where they stay: once to learn their number, once to read
//! them. So a small file that unpacks to a huge one costs time but no memory.

use super::block::{self, Encoding};
use super::sniff::{self, Kind};
use super::{Bytes, Input, Loaded};
use crate::error::{Error, ErrorKind};
use std::io::{self, Read};
use std::sync::Mutex;

/// Reads bytes of a kind, or finds out which kind they are.
type ReadKind<'r> = dyn Fn(Option<Kind>, &Input) -> Result<Loaded, Error> + 'r;

/// Reads what is in a packed file: `read_kind` is told the kind of the unpacked bytes, if they say it.
pub(crate) fn read(
    input: &Input,
    encoding: Encoding,
    read_kind: &ReadKind,
) -> Result<Loaded, Error> {
    let unpacked = Unpacked::new(input.bytes, encoding)?;
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
            Err(ErrorKind::Unsupported {
                feature: format!("{kind:?} inside {encoding:?}"),
                instead: "unpack the file first".into(),
            }
            .into())
        }
        kind => read_kind(kind, &input),
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
        let mut decoder = block::decoder(packed, 0, encoding);
        let len =
            io::copy(&mut decoder, &mut io::sink()).map_err(|error| ErrorKind::Compression {
                codec: encoding.name(),
                why: error.to_string(),
            })?;
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
}
