//! Tables with a header and a delimiter (comma, semicolon or tab):
//!
//! ```text
//! id,name,color
//! 5,liver,#dd8265
//! 6,"stomach, full",
//! ```
//!
//! The columns are found by their names; others are ignored. An empty color is no color.

use super::table::{Table, channel, hex, id};
use crate::{Error, Label};

const IDS: &[&str] = &["id", "index", "labelvalue", "value", "key"];
const NAMES: &[&str] = &["name", "label", "labelname", "structure"];
const COLORS: &[&str] = &["color", "colour", "hex"];
const GROUPS: &[&str] = &["group", "category"];
const CHANNELS: [(&str, &[&str]); 3] = [
    ("red", &["r", "red", "color_r"]),
    ("green", &["g", "green", "color_g"]),
    ("blue", &["b", "blue", "color_b"]),
];

/// The columns that are used.
struct Columns {
    delimiter: char,
    count: usize,
    id: usize,
    name: Option<usize>,
    color: Option<usize>,
    channels: Option<[usize; 3]>,
    group: Option<usize>,
}

impl Columns {
    /// Those of a header, if it has ids and something that they mean.
    fn of(header: &str) -> Option<Columns> {
        let delimiter = ['\t', ';', ','].into_iter().find(|d| header.contains(*d))?;
        let cells = cells(header, delimiter)?;
        let names: Vec<String> = cells
            .iter()
            .map(|c| c.trim().to_ascii_lowercase())
            .collect();
        let place = |known: &[&str]| {
            let mut known = known.iter();
            known.find_map(|known| names.iter().position(|name| name == known))
        };
        let channels = CHANNELS.map(|(_, known)| place(known));
        let columns = Columns {
            delimiter,
            count: names.len(),
            id: place(IDS)?,
            name: place(NAMES),
            color: place(COLORS),
            channels: match channels {
                [Some(r), Some(g), Some(b)] => Some([r, g, b]),
                _ => None,
            },
            group: place(GROUPS),
        };
        let says = columns.name.or(columns.color).is_some() || columns.channels.is_some();
        says.then_some(columns)
    }
}

/// The lines that are not empty, with their numbers from 1.
fn rows(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let rows = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    rows.filter(|(_, line)| !line.trim().is_empty())
}

pub(super) fn looks_like(text: &str) -> bool {
    let header = rows(text).next();
    header.is_some_and(|(_, header)| Columns::of(header).is_some())
}

/// # Errors
/// A row of another length than the header; a cell that is no id, color or number; an id that
/// occurs twice.
pub(super) fn read(text: &str) -> Result<Vec<Label>, Error> {
    let mut rows = rows(text);
    let mut table = Table::default();
    let columns = rows.next().and_then(|(_, header)| Columns::of(header));
    let Some(columns) = columns else {
        return Ok(table.finish());
    };
    for (number, row) in rows {
        let place = format!("line {number}");
        let cells = cells(row, columns.delimiter).ok_or_else(|| {
            let allowed = "a quote at its end, and two for a quote inside";
            Error::field(format!("{place}: a quoted text"), "not closed", allowed)
        })?;
        if cells.len() != columns.count {
            return Err(Error::field(
                format!("{place}: the number of columns"),
                cells.len(),
                format!("{}, as in the header", columns.count),
            ));
        }
        let cell = |column: Option<usize>| column.map_or("", |column| cells[column].trim());
        let mut label = Label::new(id(&place, &cells[columns.id])?, cell(columns.name));
        let group = cell(columns.group);
        label.group = (!group.is_empty()).then(|| group.to_owned());
        if !cell(columns.color).is_empty() {
            label.color = Some(hex(&place, cell(columns.color))?);
            table.add(&place, label)?;
        } else {
            label.color = numbers(&place, &columns, &cells)?;
            table.add_unscaled(&place, label)?;
        }
    }
    Ok(table.finish())
}

/// The color in three columns, as it is written.
fn numbers(place: &str, columns: &Columns, cells: &[String]) -> Result<Option<[f32; 3]>, Error> {
    let Some(channels) = columns.channels else {
        return Ok(None);
    };
    if channels
        .iter()
        .all(|column| cells[*column].trim().is_empty())
    {
        return Ok(None);
    }
    let mut color = [0.0; 3];
    for (i, column) in channels.into_iter().enumerate() {
        color[i] = channel(place, CHANNELS[i].0, &cells[column], 255.0)?;
    }
    Ok(Some(color))
}

/// The cells of a line (RFC 4180, without line breaks inside of quotes). `None` if a quote stays
/// open.
fn cells(line: &str, delimiter: char) -> Option<Vec<String>> {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    let mut chars = line.chars().peekable();
    while let Some(c) = chars.next() {
        let cell = cells.last_mut()?;
        match c {
            '"' if is_quoted && chars.peek() == Some(&'"') => {
                chars.next();
                cell.push('"');
            }
            '"' if is_quoted || cell.trim().is_empty() => is_quoted = !is_quoted,
            c if c == delimiter && !is_quoted => cells.push(String::new()),
            c => cell.push(c),
        }
    }
    (!is_quoted).then_some(cells)
}
