//! Color tables of FreeSurfer (`FreeSurferColorLUT.txt`) and 3D Slicer (`.ctbl`):
//!
//! ```text
//! #No. Label Name:                R   G   B   A
//! 2    Left-Cerebral-White-Matter 245 245 245 0
//! ```
//!
//! Channels are 0 to 255. The alpha is ignored: it is a transparency in one and an opacity in the
//! other program.

use super::table::{Table, color_of_bytes, id, meaningful};
use crate::{Error, Label};

/// Whether a line is an id, a name and four numbers.
pub(super) fn looks_like(text: &str) -> bool {
    meaningful(text).any(|(_, line)| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let is_number = |word: &&str| word.parse::<u32>().is_ok();
        words.len() >= 6 && is_number(&words[0]) && words[words.len() - 4..].iter().all(is_number)
    })
}

/// # Errors
/// A line without name or color; a channel outside 0 to 255; an id that occurs twice.
pub(super) fn read(text: &str) -> Result<Vec<Label>, Error> {
    let mut table = Table::default();
    for (number, line) in meaningful(text) {
        let place = format!("line {number}");
        let words: Vec<&str> = line.split_whitespace().collect();
        let [first, name @ .., r, g, b, _] = &words[..] else {
            return Err(incomplete(&place, line));
        };
        if name.is_empty() {
            return Err(incomplete(&place, line));
        }
        let label = Label {
            color: Some(color_of_bytes(&place, [r, g, b])?),
            ..Label::new(id(&place, first)?, name.join(" "))
        };
        table.add(&place, label)?;
    }
    Ok(table.finish())
}

fn incomplete(place: &str, line: &str) -> Error {
    let allowed = "id, name, red, green, blue and alpha";
    Error::field(place, format!("`{line}`"), allowed)
}
