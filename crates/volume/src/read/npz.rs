//! NumPy archives (`.npz`): a ZIP file of `.npy` arrays, stored or deflated.
//!
//! | part                 | bytes                                                                            |
//! |----------------------|----------------------------------------------------------------------------------|
//! | local file, for each | `PK` 03 04, 22 bytes, length of the name, of more; name, more, data               |
//! | directory            | for each: `PK` 01 02, …, method at 10, sizes at 20 (packed) and 24, lengths of name, more and comment at 28, 30, 32, position at 42, name at 46 |
//! | end                  | `PK` 05 06, …, number of files at 10, size of the directory at 12, its position at 16 |
//!
//! The one array is read, or the one with three or four axes. (Archives beyond 4 GiB are refused.)

use super::input::Whole;
use super::{Bytes, Input, LoadedVolume, ReadOptions, npy};
use crate::error::{Error, ErrorKind};
use std::io::Read;

/// The most that a deflated array may unpack to: all of it has to be in memory.
const MOST_BYTES: u64 = 1 << 31;
/// Behind the end there may be a comment of this length.
const LONGEST_COMMENT: u64 = 1 << 16;

/// An array of the archive.
struct Entry {
    name: String,
    method: u16,
    packed: u64,
    size: u64,
    position: u64,
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u16_at(bytes, at)) | u64::from(u16_at(bytes, at + 2)) << 16
}

/// The arrays of a ZIP file.
fn entries(bytes: &dyn Bytes) -> Result<Vec<Entry>, Error> {
    let damaged = |why: &str| {
        Error::from(ErrorKind::Compression {
            codec: "ZIP",
            why: why.to_owned(),
        })
    };
    let tail = bytes.len().min(22 + LONGEST_COMMENT);
    let mut end = vec![0; tail as usize];
    bytes.read_at(bytes.len() - tail, &mut end)?;
    let at = end
        .windows(4)
        .rposition(|window| window == b"PK\x05\x06")
        .filter(|at| at + 22 <= end.len())
        .ok_or_else(|| damaged("it has no directory; the file is cut off"))?;
    let (size, position) = (u32_at(&end, at + 12), u32_at(&end, at + 16));
    if position + size > bytes.len() {
        return Err(damaged("its directory lies behind its end"));
    }
    let mut directory = vec![0; size as usize];
    bytes.read_at(position, &mut directory)?;
    let mut entries = Vec::new();
    let mut rest = &directory[..];
    while rest.starts_with(b"PK\x01\x02") && rest.len() >= 46 {
        let lengths = [28, 30, 32].map(|at| usize::from(u16_at(rest, at)));
        let name = rest
            .get(46..46 + lengths[0])
            .ok_or_else(|| damaged("its directory is cut off"))?;
        entries.push(Entry {
            name: String::from_utf8_lossy(name).into_owned(),
            method: u16_at(rest, 10),
            packed: u32_at(rest, 20),
            size: u32_at(rest, 24),
            position: u32_at(rest, 42),
        });
        rest = rest
            .get(46 + lengths.iter().sum::<usize>()..)
            .unwrap_or_default();
    }
    entries.retain(|entry| entry.name.ends_with(".npy"));
    Ok(entries)
}

/// Whether a ZIP file holds arrays.
pub(crate) fn is_npz(bytes: &dyn Bytes) -> bool {
    entries(bytes).is_ok_and(|entries| !entries.is_empty())
}

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let entries = entries(input.bytes)?;
    let mut arrays = Vec::new();
    for entry in &entries {
        let start = unpacked(input.bytes, entry, 1 << 16)?;
        let axes = npy::axes(&start);
        if entries.len() == 1 || axes.is_some_and(|axes| (3..=4).contains(&axes)) {
            arrays.push(entry);
        }
    }
    let [entry] = arrays[..] else {
        let names: Vec<&str> = entries
            .iter()
            .take(8)
            .map(|entry| entry.name.as_str())
            .collect();
        return Err(ErrorKind::Ambiguous(format!(
            "the archive holds {} arrays ({}), {} of them with three or four axes; save the one that is meant by numpy.save",
            entries.len(),
            names.join(", "),
            arrays.len()
        ))
        .into());
    };
    if entry.size > MOST_BYTES {
        return Err(Error::field(
            "the size of the array",
            format!("{} bytes", entry.size),
            format!("up to {MOST_BYTES}; save it by numpy.save"),
        ));
    }
    input.bytes.has_room(entry.size)?;
    let array = Whole {
        bytes: unpacked(input.bytes, entry, entry.size)?,
        file: Box::new(input.bytes),
    };
    let inside = Input {
        name: input.name,
        bytes: &array,
        files: input.files,
    };
    let mut loaded = npy::read(&inside, options)?;
    if entries.len() > 1 {
        loaded
            .notes
            .push(format!("{} is one of {} arrays", entry.name, entries.len()));
    }
    Ok(loaded)
}

/// The first bytes of an array, at most `limit`; memory grows with what comes out.
fn unpacked(bytes: &dyn Bytes, entry: &Entry, limit: u64) -> Result<Vec<u8>, Error> {
    let damaged = |why: String| Error::from(ErrorKind::Compression { codec: "ZIP", why });
    let mut local = [0; 30];
    if entry.position + 30 > bytes.len() {
        return Err(damaged(format!("{} lies behind the end", entry.name)));
    }
    bytes.read_at(entry.position, &mut local)?;
    if !local.starts_with(b"PK\x03\x04") {
        return Err(damaged(format!(
            "{} is not where the directory says",
            entry.name
        )));
    }
    let more = [26, 28].map(|at| u64::from(u16_at(&local, at)));
    let start = entry.position + 30 + more[0] + more[1];
    let source = super::block::ByteReader::new(bytes, start).take(entry.packed);
    let mut all = Vec::new();
    let limit = limit.min(entry.size);
    let result = match entry.method {
        0 => source.take(limit).read_to_end(&mut all),
        8 => flate2::read::DeflateDecoder::new(source)
            .take(limit)
            .read_to_end(&mut all),
        method => {
            return Err(damaged(format!(
                "{} is packed with method {method}; 0 and 8 are read",
                entry.name
            )));
        }
    };
    result.map_err(|error| damaged(error.to_string()))?;
    Ok(all)
}
