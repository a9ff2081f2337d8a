//! The label table in the XML of Caret and Connectome Workbench, an extension of NIfTI files that
//! other programs (TotalSegmentator) write too:
//!
//! ```text
//! <CaretExtension><VolumeInformation Index="0"><LabelTable>
//! <Label Key="5" Red="0" Green="1" Blue="0.5" Alpha="1"><![CDATA[liver]]></Label>
//! </LabelTable></VolumeInformation></CaretExtension>
//! ```
//!
//! Each volume of a file has a table of its own. Colors are 0 to 1. The alpha is ignored.

use super::table::{Table, channel, id};
use crate::error::{Error, ErrorKind};
use crate::{Label, read::xml};

const TABLE: &str = "<LabelTable";

/// Whether there is a table with labels in it.
pub(crate) fn looks_like(text: &str) -> bool {
    text.contains(TABLE) && text.contains("<Label ")
}

/// The table of the volume `index`, or the first where there are fewer.
///
/// # Errors
/// A table or a label without an end; a key that is no id or occurs twice; a color outside 0 to 1.
pub(crate) fn read(text: &str, index: usize) -> Result<Vec<Label>, Error> {
    let mut starts = text.match_indices(TABLE).map(|(at, _)| at + TABLE.len());
    let first = starts.next();
    let Some(start) = index.checked_sub(1).and_then(|i| starts.nth(i)).or(first) else {
        return Ok(Vec::new());
    };
    let end = text[start..].find("</LabelTable");
    let end = start + end.ok_or_else(|| missing("</LabelTable>"))?;
    let mut rest = &text[start..end];
    let (mut line, mut counted) = (1, 0);
    let mut table = Table::default();
    while let Some(at) = rest.find("<Label") {
        let begin = end - rest.len() + at;
        line += text[counted..begin].bytes().filter(|c| *c == b'\n').count();
        counted = begin;
        rest = &rest[at + "<Label".len()..];
        let close = rest
            .find('>')
            .ok_or_else(|| missing("the `>` of a Label"))?;
        let attributes = &rest[..close];
        rest = &rest[close + 1..];
        let name = match attributes.ends_with('/') {
            true => String::new(),
            false => name(&mut rest)?,
        };
        let place = format!("line {line}");
        table.add(&place, label(&place, attributes, name)?)?;
    }
    Ok(table.finish())
}

fn label(place: &str, attributes: &str, name: String) -> Result<Label, Error> {
    let key = xml::attribute(attributes, "Key").unwrap_or_default();
    let mut color = Some([0.0; 3]);
    for (i, what) in ["Red", "Green", "Blue"].into_iter().enumerate() {
        match (xml::attribute(attributes, what), &mut color) {
            (Some(text), Some(color)) => color[i] = channel(place, what, text, 1.0)?,
            _ => color = None,
        }
    }
    Ok(Label {
        color,
        ..Label::new(id(place, key)?, name)
    })
}

/// The text up to the end of a label; `rest` continues after it. CDATA is taken literally.
fn name(rest: &mut &str) -> Result<String, Error> {
    let mut name = String::new();
    loop {
        let end = rest.find("</Label>").ok_or_else(|| missing("</Label>"))?;
        let marked = rest[..end].find("<![CDATA[");
        name += &xml::unescaped(&rest[..marked.unwrap_or(end)]);
        let Some(at) = marked else {
            *rest = &rest[end + "</Label>".len()..];
            return Ok(name.trim().to_owned());
        };
        let inside = &rest[at + "<![CDATA[".len()..];
        let (inside, after) = inside.split_once("]]>").ok_or_else(|| missing("]]>"))?;
        name += inside;
        *rest = after;
    }
}

fn missing(what: &str) -> Error {
    let field = what.to_owned();
    let allowed = "the label table is cut off".to_owned();
    ErrorKind::Missing { field, allowed }.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "<CaretExtension><LabelTable>\n\
        <Label Key=\"0\" Red=\"1\" Green=\"1\" Blue=\"1\" Alpha=\"0\"><![CDATA[???]]></Label>\n\
        <Label Key='7' Red='0.25' Green='0' Blue='1'>a &amp; <![CDATA[</Label> <b>]]> c</Label>\n\
        <Label Key=\"9\"/></LabelTable>\
        <LabelTable><Label Key=\"1\">two</Label></LabelTable></CaretExtension>";

    #[test]
    fn names_are_text_and_marked_characters() {
        let labels = read(TEXT, 0).unwrap();
        let color = |color| Some(color);
        let expected = [
            (0, "???", color([1.0, 1.0, 1.0])),
            (7, "a & </Label> <b> c", color([0.25, 0.0, 1.0])),
            (9, "", None),
        ];
        let expected = expected.map(|(id, name, color)| Label {
            color,
            ..Label::new(id, name)
        });
        assert_eq!(labels, expected);
        assert_eq!(read(TEXT, 1).unwrap(), [Label::new(1, "two")]);
        assert_eq!(read(TEXT, 2).unwrap(), labels);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (from, to, expected) in [
            (
                "Key='7'",
                "Key='x'",
                "line 3: the id is `x`; allowed: a whole number",
            ),
            ("Key='7'", "", "line 3: the id is ``"),
            ("Key='7'", "Key='-1'", "line 3: the id is `-1`"),
            (
                "Key='7'",
                "Key='0'",
                "line 3: the id is 0, as in line 2; allowed: each id once",
            ),
            (
                "'0.25'",
                "'25'",
                "line 3: Red is `25`; allowed: a number from 0 to 1",
            ),
            ("'0.25'", "'NaN'", "line 3: Red is `NaN`"),
        ] {
            let message = read(&TEXT.replace(from, to), 0).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
        let start = TEXT.find(TABLE).unwrap() + TABLE.len();
        let end = TEXT.find("</LabelTable").unwrap() + "</LabelTable".len();
        for cut in 0..TEXT.len() {
            let is_refused = read(&TEXT[..cut], 0).is_err();
            assert_eq!(is_refused, (start..end).contains(&cut), "{cut}");
        }
    }
}
