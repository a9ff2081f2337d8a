//! What all formats of tables are made of: labels whose ids are unique, ids, and colors.

use crate::{Error, Label};
use std::collections::BTreeMap;

/// The labels of a table while it is read.
#[derive(Default)]
pub(super) struct Table {
    labels: Vec<Label>,
    /// Where each id was named.
    place_of_id: BTreeMap<u32, String>,
    /// Labels whose color is in numbers of an unknown range.
    unscaled: Vec<usize>,
}

impl Table {
    /// Adds the label at a place such as `line 3`. Several ids may have one name: left and right
    /// parts often do.
    ///
    /// # Errors
    /// The id was named before.
    pub(super) fn add(&mut self, place: &str, label: Label) -> Result<(), Error> {
        if let Some(first) = self.place_of_id.get(&label.id) {
            return Err(Error::field(
                format!("{place}: the id"),
                format!("{}, as in {first}", label.id),
                "each id once",
            ));
        }
        self.place_of_id.insert(label.id, place.to_owned());
        self.labels.push(label);
        Ok(())
    }

    /// Adds a label whose color is 0 to 255, or 0 to 1 if that holds for all such labels.
    ///
    /// # Errors
    /// The id was named before.
    pub(super) fn add_unscaled(&mut self, place: &str, label: Label) -> Result<(), Error> {
        self.unscaled.push(self.labels.len());
        self.add(place, label)
    }

    pub(super) fn finish(mut self) -> Vec<Label> {
        let colors = self.unscaled.iter().filter_map(|i| self.labels[*i].color);
        if colors.flatten().any(|channel| channel > 1.0) {
            for i in self.unscaled {
                let color = &mut self.labels[i].color;
                *color = color.map(|color| color.map(|channel| channel / 255.0));
            }
        }
        self.labels
    }
}

/// The lines that mean something, with their numbers from 1.
pub(super) fn meaningful(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate();
    let trimmed = lines.map(|(i, line)| (i + 1, line.trim()));
    trimmed.filter(|(_, line)| !(line.is_empty() || line.starts_with('#')))
}

/// The id that `text` at a place is.
pub(super) fn id(place: &str, text: &str) -> Result<u32, Error> {
    text.trim().parse().map_err(|_| {
        let allowed = "a whole number from 0 to 4294967295";
        Error::field(format!("{place}: the id"), format!("`{text}`"), allowed)
    })
}

/// The number from 0 to `most` that `text` at a place is.
pub(super) fn channel(place: &str, what: &str, text: &str, most: f32) -> Result<f32, Error> {
    let number = text.trim().parse().ok();
    let number = number.filter(|number| (0.0..=most).contains(number));
    number.ok_or_else(|| {
        let allowed = format!("a number from 0 to {most}");
        Error::field(format!("{place}: {what}"), format!("`{text}`"), allowed)
    })
}

/// Red, green and blue from 0 to 255, as shares.
pub(super) fn color_of_bytes(place: &str, texts: [&str; 3]) -> Result<[f32; 3], Error> {
    let [r, g, b] = texts;
    let share = |what, text| channel(place, what, text, 255.0).map(|number| number / 255.0);
    Ok([share("red", r)?, share("green", g)?, share("blue", b)?])
}

/// The color `#rrggbb`.
pub(super) fn hex(place: &str, text: &str) -> Result<[f32; 3], Error> {
    let digits = text.trim().strip_prefix('#');
    let digits = digits.filter(|d| d.len() == 6 && d.bytes().all(|c| c.is_ascii_hexdigit()));
    let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
    let number = number.ok_or_else(|| {
        Error::field(
            format!("{place}: color"),
            format!("`{text}`"),
            "such as #dd8265",
        )
    })?;
    Ok([16, 8, 0].map(|shift| f32::from((number >> shift) as u8) / 255.0))
}
