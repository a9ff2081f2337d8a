//! Bytes and numbers of a TIFF, in its byte order.

use crate::error::{Error, ErrorKind};
use crate::read::Bytes;
use crate::read::block::Endian;

/// A file with its byte order and size of positions.
pub(super) struct Source<'a> {
    pub(super) bytes: &'a dyn Bytes,
    pub(super) endian: Endian,
    pub(super) big: bool,
}

impl<'a> Source<'a> {
    pub(super) fn open(bytes: &'a dyn Bytes) -> Result<Source<'a>, Error> {
        let mut source = Source {
            bytes,
            endian: Endian::Little,
            big: false,
        };
        let magic = source.fetch(0, 4, "the TIFF header")?;
        source.endian = match &magic[..2] {
            b"II" => Endian::Little,
            b"MM" => Endian::Big,
            other => {
                return Err(Error::field("byte order", other.escape_ascii(), "II or MM"));
            }
        };
        source.big = match integer(&magic[2..], source.endian) {
            42 => false,
            43 => true,
            other => return Err(Error::field("TIFF version", other, "42 or 43 (BigTIFF)")),
        };
        if source.big {
            let sizes = source.fetch(4, 4, "the BigTIFF header")?;
            let offset_bytes = integer(&sizes[..2], source.endian);
            if offset_bytes != 8 {
                return Err(Error::field("bytes of a position", offset_bytes, "8"));
            }
        }
        Ok(source)
    }

    pub(super) fn first_directory(&self) -> Result<u64, Error> {
        let (at, size) = if self.big { (8, 8) } else { (4, 4) };
        let position = self.fetch(at, size, "the TIFF header")?;
        Ok(integer(&position, self.endian))
    }

    pub(super) fn fetch(&self, offset: u64, size: u64, what: &str) -> Result<Vec<u8>, Error> {
        let end = offset.saturating_add(size);
        if end > self.bytes.len() {
            return Err(ErrorKind::Truncated {
                what: what.into(),
                expected: end,
                found: self.bytes.len(),
            }
            .into());
        }
        let mut into = vec![0; size as usize];
        self.bytes.read_at(offset, &mut into)?;
        Ok(into)
    }
}

/// An unsigned number of 1 to 8 bytes.
pub(super) fn integer(bytes: &[u8], endian: Endian) -> u64 {
    let join = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
    match endian {
        Endian::Big => bytes.iter().fold(0, join),
        Endian::Little => bytes.iter().rev().fold(0, join),
    }
}
