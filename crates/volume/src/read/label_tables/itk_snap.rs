//! Label descriptions of ITK-SNAP:
//!
//! ```text
//! # IDX   -R-  -G-  -B-  -A--  VIS MSH  LABEL
//!     1   255    0    0     1    1   1  "Label 1"
//! ```
//!
//! Channels are 0 to 255. Alpha and the two switches of the program are ignored.

use super::table::{Table, color_of_bytes, id, meaningful};
use crate::{Error, Label};

/// Whether the first line that is not skipped is seven numbers and a quoted text.
pub(super) fn looks_like(text: &str) -> bool {
    let first = meaningful(text).next();
    first.is_some_and(|(_, line)| parts(line).is_some())
}

/// The seven numbers and the quoted text of a line.
fn parts(line: &str) -> Option<([&str; 7], &str)> {
    let (numbers, name) = line.strip_suffix('"')?.split_once('"')?;
    let numbers: Vec<&str> = numbers.split_whitespace().collect();
    Some((numbers.try_into().ok()?, name))
}

/// # Errors
/// A line without the eight parts; a channel outside 0 to 255; an id that occurs twice.
pub(super) fn read(text: &str) -> Result<Vec<Label>, Error> {
    let mut table = Table::default();
    for (number, line) in meaningful(text) {
        let place = format!("line {number}");
        let Some(([first, r, g, b, ..], name)) = parts(line) else {
            let allowed = "id, red, green, blue, alpha, visible, mesh and \"name\"";
            return Err(Error::field(place, format!("`{line}`"), allowed));
        };
        let label = Label {
            color: Some(color_of_bytes(&place, [r, g, b])?),
            ..Label::new(id(&place, first)?, name)
        };
        table.add(&place, label)?;
    }
    Ok(table.finish())
}
