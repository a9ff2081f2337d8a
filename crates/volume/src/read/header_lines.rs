//! The lines of a text header, one by one, each of bounded length, and numbers in them.

use super::Bytes;
use crate::error::{Error, ErrorKind};
use std::str::FromStr;

/// What some editors write before UTF-8.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The lines of a text header. Bytes after it (the samples) are not looked at.
pub(crate) struct HeaderLines<'a> {
    bytes: &'a dyn Bytes,
    buffer: Vec<u8>,
    /// Start of the next line in `buffer`.
    next: usize,
    /// Position of `buffer[0]` in the file.
    base: u64,
}

impl<'a> HeaderLines<'a> {
    /// A list of several thousand files, one number per file, fits in one line of this length.
    const LONGEST_LINE: usize = 1 << 16;
    /// No header of these formats that is not an accident is longer.
    const LONGEST_HEADER: u64 = 1 << 24;

    /// Lines from the start of a file.
    pub(crate) fn new(bytes: &'a dyn Bytes) -> HeaderLines<'a> {
        HeaderLines {
            bytes,
            buffer: Vec::new(),
            next: 0,
            base: 0,
        }
    }

    /// Position in the file of the first byte after the last line that was returned.
    pub(crate) fn position(&self) -> u64 {
        self.base + self.next as u64
    }

    /// The next line without its end (`\n` or `\r\n`); bytes that are not UTF-8 become U+FFFD.
    /// `None` at the end of the file.
    ///
    /// # Errors
    /// A line or a header that is too long, or what the system says.
    pub(crate) fn next_line(&mut self) -> Result<Option<String>, Error> {
        if self.position() > Self::LONGEST_HEADER {
            return Err(Error::field(
                "size of the text header",
                format!("more than {} bytes", Self::LONGEST_HEADER),
                "a header that ends before the samples",
            ));
        }
        let mut searched = 0;
        loop {
            let rest = &self.buffer[self.next..];
            if let Some(n) = rest[searched..].iter().position(|&c| c == b'\n') {
                let line = &rest[..searched + n];
                let line = line.strip_suffix(b"\r").unwrap_or(line);
                let line = String::from_utf8_lossy(line).into_owned();
                self.next += searched + n + 1;
                return Ok(Some(line));
            }
            searched = rest.len();
            if searched > Self::LONGEST_LINE {
                return Err(Error::field(
                    "length of a header line",
                    format!("more than {} bytes", Self::LONGEST_LINE),
                    "text lines, each ended by a line break",
                ));
            }
            if !self.fill()? {
                if searched == 0 {
                    return Ok(None);
                }
                let line = String::from_utf8_lossy(&self.buffer[self.next..]).into_owned();
                self.next = self.buffer.len();
                return Ok(Some(line));
            }
        }
    }

    /// Reads on; `false` at the end of the file.
    fn fill(&mut self) -> Result<bool, Error> {
        self.buffer.drain(..self.next);
        self.base += self.next as u64;
        self.next = 0;
        let end = self.base + self.buffer.len() as u64;
        let more = self.bytes.len().saturating_sub(end).min(4096) as usize;
        let start = self.buffer.len();
        self.buffer.resize(start + more, 0);
        self.bytes.read_at(end, &mut self.buffer[start..])?;
        if end == 0 && self.buffer.starts_with(BYTE_ORDER_MARK) {
            self.next = BYTE_ORDER_MARK.len();
        }
        Ok(more > 0)
    }
}

/// Exactly `count` numbers between white space.
///
/// # Errors
/// Names the field, the value and what is allowed.
pub(crate) fn numbers<T: FromStr>(field: &str, text: &str, count: usize) -> Result<Vec<T>, Error> {
    let wrong = || Error::field(field, format!("`{text}`"), numbers_wanted::<T>(count));
    let numbers: Vec<T> = text
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()
        .map_err(|_| wrong())?;
    if numbers.len() == count {
        Ok(numbers)
    } else {
        Err(wrong())
    }
}

fn numbers_wanted<T>(count: usize) -> String {
    let kind = if std::any::type_name::<T>().starts_with('f') {
        "number"
    } else {
        "whole number"
    };
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {kind}{plural} between spaces")
}

/// A required field.
///
/// # Errors
/// [`ErrorKind::Missing`] if there is none.
pub(crate) fn required<T>(field: &str, value: Option<T>, allowed: &str) -> Result<T, Error> {
    value.ok_or_else(|| {
        ErrorKind::Missing {
            field: field.into(),
            allowed: allowed.into(),
        }
        .into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_either_way_and_the_position_is_behind_them() {
        let file = b"one\r\ntwo\n\nlast".to_vec();
        let mut lines = HeaderLines::new(&file);
        assert_eq!(lines.next_line().unwrap().as_deref(), Some("one"));
        assert_eq!(lines.position(), 5);
        assert_eq!(lines.next_line().unwrap().as_deref(), Some("two"));
        assert_eq!(lines.next_line().unwrap().as_deref(), Some(""));
        assert_eq!(lines.position(), 10);
        assert_eq!(lines.next_line().unwrap().as_deref(), Some("last"));
        assert_eq!(lines.next_line().unwrap(), None);
    }

    #[test]
    fn lines_longer_than_the_buffer_come_whole() {
        let long = "x".repeat(10_000);
        let file = format!("{long}\n{long}\nend\n").into_bytes();
        let mut lines = HeaderLines::new(&file);
        assert_eq!(lines.next_line().unwrap(), Some(long.clone()));
        assert_eq!(lines.next_line().unwrap(), Some(long));
        assert_eq!(lines.position(), 20_002);
        assert_eq!(lines.next_line().unwrap().as_deref(), Some("end"));
    }

    #[test]
    fn an_endless_line_is_refused() {
        let file = vec![b'x'; 1 << 20];
        assert!(HeaderLines::new(&file).next_line().is_err());
    }

    #[test]
    fn numbers_are_counted_and_parsed_strictly() {
        assert_eq!(numbers::<u32>("dims", " 1 2\t3 ", 3).unwrap(), [1, 2, 3]);
        for text in ["1 2", "1 2 3 4", "1 2 -3", "1 2 3.0", "1 2 x", ""] {
            let error = numbers::<u32>("dims", text, 3).unwrap_err().to_string();
            assert!(
                error.contains("dims") && error.contains("3 whole numbers"),
                "{error}"
            );
        }
    }
}
