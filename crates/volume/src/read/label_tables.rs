//! Tables of the names and colors of labels: those inside of images.

pub(crate) mod caret;
pub(crate) mod lines;

use crate::{Error, Label};
use std::collections::BTreeMap;

/// The labels of a table while it is read.
#[derive(Default)]
struct Table {
    labels: Vec<Label>,
    /// The line that named an id.
    line_of_id: BTreeMap<u32, usize>,
}

impl Table {
    /// Adds the label in a line, counted from 1. Several ids may have one name: left and right
    /// parts often do.
    ///
    /// # Errors
    /// An earlier line has named the id.
    fn add(&mut self, line: usize, label: Label) -> Result<(), Error> {
        if let Some(first) = self.line_of_id.insert(label.id, line) {
            return Err(Error::field(
                format!("line {line}: the id"),
                format!("{}, which line {first} has named", label.id),
                "each id once",
            ));
        }
        self.labels.push(label);
        Ok(())
    }
}

/// The id that `text` in a line is.
fn id(line: usize, text: &str) -> Result<u32, Error> {
    text.trim().parse().map_err(|_| {
        let allowed = "a whole number from 0 to 4294967295";
        Error::field(format!("line {line}: the id"), format!("`{text}`"), allowed)
    })
}

/// The share of a color, 0 to 1, that `text` in a line is.
fn share(line: usize, what: &str, text: &str) -> Result<f32, Error> {
    let share = text.trim().parse().ok();
    share
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| {
            Error::field(
                format!("line {line}: {what}"),
                format!("`{text}`"),
                "0 to 1",
            )
        })
}
