//! Extensions between the header of a NIfTI file and its samples. Label tables in them are read.
//!
//! | offset      | bytes | what                                                              |
//! |-------------|-------|-------------------------------------------------------------------|
//! | header size | 4     | the first is not 0: extensions follow                             |
//! | +4          | 4     | bytes of an extension, these 8 included; a multiple of 16         |
//! | +8          | 4     | what it holds: 6 a comment, 30 Caret's XML; writers say 0, too    |
//! | +12         |       | its content, padded with zeros                                    |
//!
//! Some writers put plain text there although the first byte is 0.

use crate::read::block::{self, Encoding, Endian};
use crate::read::label_tables::{caret, lines};
use crate::{Error, Label, read::Bytes};

/// Where the extensions of a file lie.
pub(super) struct Place {
    /// Bytes before the four that say whether there are any.
    pub start: u64,
    /// Bytes before the samples, or `u64::MAX` if those lie in another file.
    pub end: u64,
    pub endian: Endian,
}

/// No text in a header that is not an accident is longer.
const MOST_BYTES: u64 = 1 << 24;

/// The labels that the extensions at `place` name. `None` if they name none and the numbers are not
/// said to be ids of objects.
///
/// # Errors
/// What the system says, or damaged packed data. What is wrong with a table is a note.
pub(super) fn labels(
    place: Option<&Place>,
    is_ids: bool,
    bytes: &dyn Bytes,
    encoding: Encoding,
    time_index: usize,
    notes: &mut Vec<String>,
) -> Result<Option<Vec<Label>>, Error> {
    let texts = match place {
        Some(place) => texts(place, bytes, encoding)?,
        None => Vec::new(),
    };
    for text in texts {
        let read = match () {
            () if caret::looks_like(&text) => caret::read(&text, time_index),
            // Any other comment may begin with a number.
            () if is_ids && lines::looks_like(&text) => lines::read(&text),
            () => continue,
        };
        let labels = read.unwrap_or_else(|error| {
            let note = format!("the names of labels in the header are not used: {error}");
            notes.push(note);
            Vec::new()
        });
        return Ok(Some(labels));
    }
    Ok(is_ids.then(Vec::new))
}

fn texts(place: &Place, bytes: &dyn Bytes, encoding: Encoding) -> Result<Vec<String>, Error> {
    let start = place.start;
    let end = place.end.min(start + MOST_BYTES);
    if end <= start + 4 {
        return Ok(Vec::new());
    }
    let head = block::head(bytes, 0, encoding, end as usize)?;
    let Some((extender, rest)) = head
        .get(start as usize..)
        .and_then(|h| h.split_at_checked(4))
    else {
        return Ok(Vec::new());
    };
    Ok(match extender[0] {
        0 => vec![text_of(rest)],
        _ => contents(rest, place.endian).map(text_of).collect(),
    })
}

/// The contents of the extensions, as far as their sizes make sense.
fn contents(mut rest: &[u8], endian: Endian) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let size = *rest.first_chunk::<4>()?;
        let size = match endian {
            Endian::Little => u32::from_le_bytes(size),
            Endian::Big => u32::from_be_bytes(size),
        };
        let extension = rest.get(..size as usize)?;
        rest = &rest[extension.len()..];
        extension.get(8..)
    })
}

fn text_of(content: &[u8]) -> String {
    let text = String::from_utf8_lossy(content);
    text.trim_matches(|c: char| c == '\0' || c.is_whitespace())
        .to_owned()
}
