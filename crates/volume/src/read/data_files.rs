//! Samples in the files that a text header names: one, a list, or a numbered sequence.

use super::block::{self, Block, ByteReader, Encoding, Endian, Trailing};
use super::stored::Stored;
use super::{Bytes, Input};
use crate::Samples;
use crate::error::{Error, ErrorKind};
use std::io::{BufRead, BufReader};
use std::ops::Range;

/// Where the samples of a header lie, and how.
pub(crate) struct Storage {
    pub(crate) place: Place,
    /// What the format calls the entry that names the files.
    pub(crate) field: &'static str,
    pub(crate) encoding: Encoding,
    pub(crate) endian: Endian,
    /// Text lines before the (encoded) samples of each file …
    pub(crate) line_skip: u64,
    /// … and then decoded bytes.
    pub(crate) byte_skip: ByteSkip,
}

/// Which file the samples are in.
pub(crate) enum Place {
    /// In the header's own file from a position on.
    After(u64),
    /// In files beside it, each with the same number of samples.
    Files(Vec<String>),
}

/// Bytes to leave out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByteSkip {
    Front(u64),
    /// Whatever is left when the samples lie at the end of the (unpacked) file.
    AllButTheEnd,
}

impl Storage {
    /// The samples of `range`, of `total` that all files hold together.
    ///
    /// # Errors
    /// A file that is not there; what [`Block::read`] finds; a total that the files cannot share
    /// evenly.
    pub(crate) fn read(
        &self,
        input: &Input,
        stored: Stored,
        total: usize,
        range: Range<usize>,
        notes: &mut Vec<String>,
    ) -> Result<Samples, Error> {
        let is_text = self.encoding == Encoding::Ascii;
        let mut samples = Samples::new(match is_text {
            true => stored.of_text(),
            false => stored.bits(),
        });
        match &self.place {
            &Place::After(offset) => {
                self.append(input.bytes, offset, &mut samples, total, range)?;
            }
            Place::Files(names) => {
                if names.is_empty() || !total.is_multiple_of(names.len()) {
                    return Err(Error::field(
                        self.field,
                        format!("{} files", names.len()),
                        format!("a number of files that divides {total} samples"),
                    ));
                }
                let each = total / names.len();
                for (i, path) in names.iter().enumerate() {
                    let here = (i * each).max(range.start)..((i + 1) * each).min(range.end);
                    if here.is_empty() {
                        continue;
                    }
                    let (name, bytes) = open(input, self.field, path, notes)?;
                    let here = here.start - i * each..here.end - i * each;
                    self.append(&*bytes, 0, &mut samples, each, here)
                        .map_err(|error| error.in_file(&name))?;
                }
            }
        }
        match is_text {
            true => stored.kept_of_text(samples, notes),
            false => stored.kept_of_bits(samples, input.bytes, notes),
        }
    }

    fn append(
        &self,
        bytes: &dyn Bytes,
        offset: u64,
        samples: &mut Samples,
        total: usize,
        range: Range<usize>,
    ) -> Result<(), Error> {
        let size = samples.sample_type().size() as u64;
        let all_bytes = (total as u64)
            .checked_mul(size)
            .ok_or_else(|| Error::field("number of samples", total, "fewer"))?;
        let mut offset = skip_lines(bytes, offset, self.line_skip)?;
        let mut encoding = self.encoding;
        if encoding == Encoding::Zlib && begins_like_gzip(bytes, offset)? {
            encoding = Encoding::Gzip;
        }
        let skip = match self.byte_skip {
            ByteSkip::Front(skip) => skip,
            ByteSkip::AllButTheEnd => {
                let stored = match encoding {
                    Encoding::Raw => bytes.len(),
                    // Counted without being kept.
                    _ => block::unpacked_length(bytes, offset, encoding)?,
                };
                let before = stored.checked_sub(all_bytes).ok_or(ErrorKind::Truncated {
                    what: "the sample data".into(),
                    expected: all_bytes,
                    found: stored,
                })?;
                match encoding {
                    Encoding::Raw => {
                        offset = before;
                        0
                    }
                    _ => before,
                }
            }
        };
        // Numbers in text are counted one by one, everything else in bytes.
        let before = range.start as u64 * if encoding == Encoding::Ascii { 1 } else { size };
        let block = Block {
            bytes,
            offset,
            encoding,
            skip: skip
                .checked_add(before)
                .ok_or_else(|| Error::field("bytes to skip", skip, "fewer"))?,
            endian: self.endian,
            trailing: if encoding == Encoding::Raw || range.end < total {
                Trailing::Ignored
            } else {
                Trailing::Refused
            },
        };
        block.append(samples, range.len())
    }
}

/// Opens the file that `field` names: beside the header, or in a folder below. A header must not reach into places
/// that the user did not name, so of a path from the root only the file's name counts, with a note.
///
/// # Errors
/// Says which field names which file if it is not there, or lies elsewhere.
pub(crate) fn open<'a>(
    input: &Input<'a>,
    field: &str,
    path: &str,
    notes: &mut Vec<String>,
) -> Result<(String, Box<dyn Bytes + 'a>), Error> {
    let name = match place_of(path) {
        Named::Inside(name) => name,
        Named::FromTheRoot(name) => {
            notes.push(format!(
                "{field} names `{path}`; {name} beside {} was read",
                input.name
            ));
            name
        }
        Named::Outside => {
            return Err(Error::field(
                field,
                format!("`{path}`"),
                format!(
                    "a file beside {}, or in a folder below; put it there",
                    input.name
                ),
            ));
        }
    };
    let (name, opened) = match input.files.open(&name) {
        // Headers that were written on Windows often have another case.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let names = input.files.names();
            match names.into_iter().find(|n| n.eq_ignore_ascii_case(&name)) {
                Some(other) => {
                    let opened = input.files.open(&other);
                    (other, opened)
                }
                None => (name, Err(error)),
            }
        }
        opened => (name, opened),
    };
    match opened {
        Ok(bytes) => Ok((name, bytes)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Err(Error::field(
            field,
            format!("`{path}`"),
            format!(
                "the name of a file beside {}, or in a folder below; there is no {name}",
                input.name
            ),
        )),
        Err(error) => Err(Error::from(error).in_file(&name)),
    }
}

/// Where a name in a header leads.
#[derive(Debug, PartialEq)]
enum Named {
    /// A file here or below, with `/` between folders.
    Inside(String),
    /// A place that depends on the machine: the last part of its name.
    FromTheRoot(String),
    /// Above the folder of the header.
    Outside,
}

fn place_of(path: &str) -> Named {
    let path = path.trim();
    let is_drive = matches!(path.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic());
    let mut parts = Vec::new();
    for part in path.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => {
                if parts.pop().is_none() {
                    return Named::Outside;
                }
            }
            part => parts.push(part),
        }
    }
    if parts.is_empty() {
        return Named::Outside;
    }
    if path.starts_with(['/', '\\']) || is_drive {
        return Named::FromTheRoot(parts.last().copied().unwrap_or_default().to_owned());
    }
    Named::Inside(parts.join("/"))
}

/// The names that a pattern such as `slice%03d.raw` with first, last and step makes. The step may
/// be negative.
///
/// # Errors
/// A pattern without exactly one `%d`, a step of 0 or of the wrong sign, or too many names.
pub(crate) fn numbered(
    field: &str,
    pattern: &str,
    first: i64,
    last: i64,
    step: i64,
) -> Result<Vec<String>, Error> {
    const MOST: i64 = 1 << 20;
    let steps = last
        .checked_sub(first)
        .and_then(|span| span.checked_div(step))
        .filter(|steps| (0..MOST).contains(steps));
    let Some(steps) = steps else {
        return Err(Error::field(
            field,
            format!("first {first}, last {last}, step {step}"),
            format!(
                "a step that leads from the first to the last number in less than {MOST} steps"
            ),
        ));
    };
    let wrong = || {
        Error::field(
            field,
            format!("`{pattern}`"),
            "a name with exactly one `%d`, `%03d` or the like",
        )
    };
    let (before, rest) = pattern.split_once('%').ok_or_else(wrong)?;
    let end = rest.find(['d', 'i', 'u']).ok_or_else(wrong)?;
    let (width, after) = (&rest[..end], &rest[end + 1..]);
    let zeros = width.starts_with('0') || width.starts_with('.');
    let digits = width.trim_start_matches(['0', '.']);
    let width: usize = match digits {
        "" => 0,
        digits => digits.parse().ok().filter(|&w| w <= 32).ok_or_else(wrong)?,
    };
    if after.contains('%') {
        return Err(wrong());
    }
    Ok((0..=steps)
        .map(|i| first + i * step)
        .map(|n| {
            if zeros {
                format!("{before}{n:0width$}{after}")
            } else {
                format!("{before}{n:width$}{after}")
            }
        })
        .collect())
}

fn skip_lines(bytes: &dyn Bytes, offset: u64, lines: u64) -> Result<u64, Error> {
    if lines == 0 {
        return Ok(offset);
    }
    let mut source = BufReader::new(ByteReader::new(bytes, offset));
    let mut position = offset;
    let mut left = lines;
    while left > 0 {
        let buffer = source.fill_buf()?;
        if buffer.is_empty() {
            return Err(Error::field(
                "lines to skip",
                lines,
                format!("at most the {} that are there", lines - left),
            ));
        }
        let used = match buffer.iter().position(|&c| c == b'\n') {
            Some(n) => {
                left -= 1;
                n + 1
            }
            None => buffer.len(),
        };
        source.consume(used);
        position += used as u64;
    }
    Ok(position)
}

fn begins_like_gzip(bytes: &dyn Bytes, offset: u64) -> Result<bool, Error> {
    let mut magic = [0; 2];
    if bytes.len().saturating_sub(offset) < 2 {
        return Ok(false);
    }
    bytes.read_at(offset, &mut magic)?;
    Ok(magic == [0x1f, 0x8b])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder_of_the_header() {
        let inside = |name: &str| Named::Inside(name.into());
        for (path, place) in [
            ("v.raw", inside("v.raw")),
            (" ./v.raw ", inside("v.raw")),
            ("data/v.raw", inside("data/v.raw")),
            ("data\\deep\\v 1.raw", inside("data/deep/v 1.raw")),
            ("data/../v.raw", inside("v.raw")),
            ("../v.raw", Named::Outside),
            ("data/../../v.raw", Named::Outside),
            ("/scans/v.raw", Named::FromTheRoot("v.raw".into())),
            ("C:\\scans\\v.raw", Named::FromTheRoot("v.raw".into())),
        ] {
            assert_eq!(place_of(path), place, "{path}");
        }
    }

    #[test]
    fn numbered_names_follow_printf() {
        let names = |pattern, first, last, step| numbered("data file", pattern, first, last, step);
        assert_eq!(
            names("s%03d.raw", 8, 12, 2).unwrap(),
            ["s008.raw", "s010.raw", "s012.raw"]
        );
        assert_eq!(names("%d", 2, 1, -1).unwrap(), ["2", "1"]);
        assert_eq!(names("a%2i", 9, 10, 1).unwrap(), ["a 9", "a10"]);
        for (pattern, first, last, step) in [
            ("none", 0, 1, 1),
            ("%d%d", 0, 1, 1),
            ("%s", 0, 1, 1),
            ("%999999999999d", 0, 1, 1),
            ("%d", 0, 1, 0),
            ("%d", 0, 1, -1),
            ("%d", 0, i64::MAX, 1),
            ("%d", i64::MIN, i64::MAX, 1),
            ("%d", i64::MIN, 0, -1),
        ] {
            assert!(
                names(pattern, first, last, step).is_err(),
                "{pattern} {first} {last} {step}"
            );
        }
    }
}
