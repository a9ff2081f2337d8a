//! Label tables in JSON: niivue's arrays, objects by id, objects by name (see the table in
//! `label_tables.rs`).

use super::table::{Table, hex, id};
use crate::{Error, Label};
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// A value with the entries of objects as they were written: nothing that stands twice is lost.
enum Node {
    Object(Vec<(String, Node)>),
    List(Vec<Node>),
    Text(String),
    Number(f64),
    /// `null`, `true`, `false`.
    Other(&'static str),
}

/// The labels in a text, if it is a label table.
///
/// # Errors
/// Invalid JSON, and whatever is wrong with a table.
pub(super) fn read(text: &str) -> Result<Option<Vec<Label>>, Error> {
    let root: Node = serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        let what = message.split(" at line ").next().unwrap_or_default();
        let field = format!("line {}", error.line());
        Error::field(field, format!("no JSON: {what}"), "valid JSON")
    })?;
    let Node::Object(entries) = root else {
        return Ok(None);
    };
    let get = |key: &str| entries.iter().find(|(name, _)| name == key);
    let labels = match get("labels") {
        Some((_, Node::Object(labels))) => by_key(labels, "labels.")?,
        Some((_, Node::List(_))) => arrays(&entries)?,
        _ if ["R", "G", "B"].iter().all(|key| get(key).is_some()) => arrays(&entries)?,
        _ if is_table(&entries) => by_key(&entries, "")?,
        _ => return Ok(None),
    };
    Ok(Some(labels))
}

/// Whether entries are labels: the first key is an id, or all values are ids.
fn is_table(entries: &[(String, Node)]) -> bool {
    let first_is_id = entries
        .first()
        .is_some_and(|(key, _)| key.parse::<u32>().is_ok());
    let is_whole = |node: &Node| matches!(node, Node::Number(n) if n.fract() == 0.0);
    let all_are_ids = entries.iter().all(|(_, node)| is_whole(node));
    first_is_id || (all_are_ids && !entries.is_empty())
}

/// Labels by id, or by name.
fn by_key(entries: &[(String, Node)], prefix: &str) -> Result<Vec<Label>, Error> {
    let mut table = Table::default();
    let is_by_id = entries
        .first()
        .is_some_and(|(key, _)| key.parse::<u32>().is_ok());
    for (key, node) in entries {
        let path = format!("{prefix}{key}");
        let place = format!("`{path}`");
        if is_by_id {
            let label = label(id(&place, key)?, &path, node)?;
            match node {
                Node::Object(parts) if has_numbers(parts) => table.add_unscaled(&place, label)?,
                _ => table.add(&place, label)?,
            }
        } else {
            let id = whole(node).ok_or_else(|| wrong(&path, node, "one id, a whole number"))?;
            table.add(&place, Label::new(id, key))?;
        }
    }
    Ok(table.finish())
}

fn has_numbers(parts: &[(String, Node)]) -> bool {
    let is_list = |(key, node): &(String, Node)| key == "color" && matches!(node, Node::List(_));
    parts.iter().any(is_list)
}

/// One label of an object by id; a color in numbers is as it is written.
fn label(id: u32, path: &str, node: &Node) -> Result<Label, Error> {
    let mut label = Label::new(id, "");
    let parts = match node {
        Node::Text(name) => return Ok(Label::new(id, name)),
        Node::Object(parts) => parts,
        _ => {
            return Err(wrong(
                path,
                node,
                "a name, or an object with name and color",
            ));
        }
    };
    for (key, node) in parts {
        let path = format!("{path}.{key}");
        let text = || match node {
            Node::Text(text) => Ok(text.clone()),
            _ => Err(wrong(&path, node, "a text")),
        };
        match key.as_str() {
            "name" => label.name = text()?,
            "group" => label.group = Some(text()?),
            "color" => label.color = Some(color(&path, node)?),
            _ => {
                let allowed = "name, color, group";
                return Err(Error::field(format!("`{path}`"), "not known", allowed));
            }
        }
    }
    Ok(label)
}

fn color(path: &str, node: &Node) -> Result<[f32; 3], Error> {
    match node {
        Node::Text(text) => hex(&format!("`{path}`"), text),
        Node::List(list) if list.len() == 3 => {
            let mut color = [0.0; 3];
            for (i, node) in list.iter().enumerate() {
                color[i] = byte(&format!("{path}[{i}]"), node)?;
            }
            Ok(color)
        }
        _ => Err(wrong(path, node, "#rrggbb, or a list of three numbers")),
    }
}

/// Niivue's arrays: `R`, `G`, `B` (0 to 255), `labels`, and `I`, the ids if they are not 0, 1, 2, …
/// An unnamed background is left out.
fn arrays(entries: &[(String, Node)]) -> Result<Vec<Label>, Error> {
    let list = |key: &str| match entries.iter().find(|(name, _)| name == key) {
        None => Ok(None),
        Some((_, Node::List(list))) => Ok(Some((key.to_owned(), list.as_slice()))),
        Some((_, node)) => Err(wrong(key, node, "a list")),
    };
    let names = list("labels")?;
    let [red, green, blue, ids] = [list("R")?, list("G")?, list("B")?, list("I")?];
    let channels = match (&red, &green, &blue) {
        (Some(r), Some(g), Some(b)) => Some([r.1, g.1, b.1]),
        _ => None,
    };
    let lists: Vec<_> = [&names, &red, &green, &blue, &ids]
        .into_iter()
        .flatten()
        .collect();
    let Some((first, count)) = lists.first().map(|(key, list)| (key, list.len())) else {
        return Ok(Vec::new());
    };
    for (key, list) in &lists {
        if list.len() != count {
            let found = format!("{} entries", list.len());
            return Err(Error::field(
                format!("the length of `{key}`"),
                found,
                format!("{count}, as `{first}`"),
            ));
        }
    }
    let mut table = Table::default();
    for i in 0..count {
        let (place, id) = match &ids {
            Some((_, ids)) => {
                let id = whole(&ids[i]);
                let id = id.ok_or_else(|| wrong(&format!("I[{i}]"), &ids[i], "an id"))?;
                (format!("`I[{i}]`"), id)
            }
            None => (format!("entry {i}"), i as u32),
        };
        let name = match names.as_ref().map(|(_, names)| &names[i]) {
            Some(Node::Text(name)) => name.as_str(),
            Some(node) => return Err(wrong(&format!("labels[{i}]"), node, "a name")),
            None => "",
        };
        let mut label = Label::new(id, name);
        if let Some(channels) = channels {
            let mut color = [0.0; 3];
            for (channel, key) in ["R", "G", "B"].into_iter().enumerate() {
                color[channel] = byte(&format!("{key}[{i}]"), &channels[channel][i])? / 255.0;
            }
            label.color = Some(color);
        }
        if id != 0 || !name.is_empty() {
            table.add(&place, label)?;
        }
    }
    Ok(table.finish())
}

fn whole(node: &Node) -> Option<u32> {
    match node {
        Node::Number(n) if n.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(n) => {
            Some(*n as u32)
        }
        _ => None,
    }
}

fn byte(path: &str, node: &Node) -> Result<f32, Error> {
    match node {
        Node::Number(n) if (0.0..=255.0).contains(n) => Ok(*n as f32),
        _ => Err(wrong(path, node, "0 to 255")),
    }
}

fn wrong(path: &str, node: &Node, allowed: &str) -> Error {
    let value = match node {
        Node::Object(_) => "an object".into(),
        Node::List(_) => "a list".into(),
        Node::Text(text) => format!("\"{text}\""),
        Node::Number(n) => n.to_string(),
        Node::Other(word) => (*word).to_owned(),
    };
    Error::field(format!("`{path}`"), value, allowed)
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Node, D::Error> {
        deserializer.deserialize_any(NodeVisitor)
    }
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Node, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = map.next_entry()? {
            entries.push(entry);
        }
        Ok(Node::Object(entries))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Node, A::Error> {
        let mut nodes = Vec::new();
        while let Some(node) = list.next_element()? {
            nodes.push(node);
        }
        Ok(Node::List(nodes))
    }

    fn visit_str<E>(self, text: &str) -> Result<Node, E> {
        Ok(Node::Text(text.to_owned()))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Node, E> {
        Ok(Node::Number(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Node, E> {
        Ok(Node::Number(number as f64))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Node, E> {
        Ok(Node::Number(number as f64))
    }

    fn visit_bool<E>(self, truth: bool) -> Result<Node, E> {
        Ok(Node::Other(if truth { "true" } else { "false" }))
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Other("null"))
    }
}
