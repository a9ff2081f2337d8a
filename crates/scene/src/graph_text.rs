//! The key `graph`: the text of a graph and its edits, which the graph compiler reads.

#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};
use serde_json::value::RawValue;
#[cfg(feature = "schema")]
use std::borrow::Cow;

/// The text of a graph and its edits as they stand in a scene: JSON, an object of keys. A scene only keeps it;
/// `docs/graph.md` says what it means.
#[derive(Clone, Debug)]
pub struct GraphText(String);

impl GraphText {
    /// From the text of a `.graph.json`.
    ///
    /// # Errors
    /// The text is not JSON, or no object.
    pub fn new(text: impl Into<String>) -> Result<GraphText, String> {
        let text = text.into();
        let raw: &RawValue = serde_json::from_str(&text).map_err(|error| error.to_string())?;
        if !raw.get().starts_with('{') {
            return Err("a graph is an object of keys, { … }".to_owned());
        }
        Ok(GraphText(text))
    }

    /// The text. Read from a scene, its lines have the numbers that they have there.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Puts as many empty lines before the text as stand before it in `scene`.
    pub(crate) fn with_lines_of(&mut self, scene: &str) {
        if let Some(at) = scene.find(&self.0) {
            let lines = scene[..at].matches('\n').count();
            self.0.insert_str(0, &"\n".repeat(lines));
        }
    }
}

impl PartialEq for GraphText {
    fn eq(&self, other: &GraphText) -> bool {
        self.0.trim() == other.0.trim()
    }
}

impl Serialize for GraphText {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let raw: &RawValue = serde_json::from_str(&self.0).map_err(ser::Error::custom)?;
        raw.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for GraphText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<GraphText, D::Error> {
        let raw = Box::<RawValue>::deserialize(deserializer)?;
        GraphText::new(raw.get()).map_err(de::Error::custom)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for GraphText {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "GraphText".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object" })
    }
}
