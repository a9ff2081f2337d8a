//! Lines of an id and a name, as in comments of NIfTI files:
//!
//! ```text
//! 1 Area 3b (PostCG)
//! 2 Area hOc4la (LOC)
//! ```
//!
//! Empty lines and lines that begin with `#` are skipped.

use super::table::{Table, id, meaningful};
use crate::{Error, Label};

/// Whether the first line that is not skipped is an id with a name.
pub(crate) fn looks_like(text: &str) -> bool {
    let first = meaningful(text).next();
    let words = first.and_then(|(_, line)| line.split_once(char::is_whitespace));
    words.is_some_and(|(id, name)| id.parse::<u32>().is_ok() && !name.trim().is_empty())
}

/// # Errors
/// A line without an id or without a name; an id that occurs twice.
pub(crate) fn read(text: &str) -> Result<Vec<Label>, Error> {
    let mut table = Table::default();
    for (number, line) in meaningful(text) {
        let place = format!("line {number}");
        let Some((first, name)) = line.split_once(char::is_whitespace) else {
            let allowed = "an id, a space and a name";
            return Err(Error::field(place, format!("`{line}`"), allowed));
        };
        table.add(&place, Label::new(id(&place, first)?, name.trim()))?;
    }
    Ok(table.finish())
}
