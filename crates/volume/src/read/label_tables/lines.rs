//! Lines of an id and a name, as comments of NIfTI files have them:
//!
//! ```text
//! 1 Area 3b (PostCG)
//! 2 Area hOc4la (LOC)
//! ```
//!
//! Empty lines, and those that begin with `#`, mean nothing.

use super::{Table, id};
use crate::{Error, Label};

/// Whether the first line that means something is an id with a name.
pub(crate) fn looks_like(text: &str) -> bool {
    let first = meaningful(text).next();
    let words = first.and_then(|(_, line)| line.split_once(char::is_whitespace));
    words.is_some_and(|(id, name)| id.parse::<u32>().is_ok() && !name.trim().is_empty())
}

/// # Errors
/// A line without an id or without a name; an id that comes twice.
pub(crate) fn read(text: &str) -> Result<Vec<Label>, Error> {
    let mut table = Table::default();
    for (number, line) in meaningful(text) {
        let Some((first, name)) = line.split_once(char::is_whitespace) else {
            let allowed = "an id and a name, with a blank between them";
            return Err(Error::field(
                format!("line {number}"),
                format!("`{line}`"),
                allowed,
            ));
        };
        table.add(number, Label::new(id(number, first)?, name.trim()))?;
    }
    Ok(table.labels)
}

/// The lines that mean something, with their numbers from 1.
fn meaningful(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate();
    let trimmed = lines.map(|(i, line)| (i + 1, line.trim()));
    trimmed.filter(|(_, line)| !(line.is_empty() || line.starts_with('#')))
}
