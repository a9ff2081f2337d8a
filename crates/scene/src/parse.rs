//! Text ↔ Scene: JSON with comments and trailing commas.

use crate::json_size::check_json_size;
use crate::nearest::nearest;
use crate::{Method, Scene};
use serde::de::{Deserialize, Deserializer, IgnoredAny, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::error::Category;
use std::collections::BTreeSet;

/// The longest scene that is accepted.
pub const MOST_SCENE_BYTES: usize = 16 << 20;

/// Why a text is not a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is longer than any scene.
    #[error("{file}: {bytes} bytes; a scene has at most {MOST_SCENE_BYTES}")]
    TooLong {
        /// Name of the text.
        file: String,
        /// Its length.
        bytes: usize,
    },
    /// The text has more objects, lists or elements than a scene can use.
    #[error("{file}: {why}")]
    TooMany {
        /// Name of the text.
        file: String,
        /// How many there are.
        why: String,
    },
    /// The text is not JSON, even with comments.
    #[error("{file}:{line}:{column}: not JSON: {why}")]
    Syntax {
        /// Name of the text.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in bytes, from 1.
        column: usize,
        /// What the parser met.
        why: String,
    },
    /// A list where an object of keys belongs.
    #[error("{file}: {path}: a list; write an object of keys, {{ … }}")]
    List {
        /// Name of the text.
        file: String,
        /// Path of the key; `scene` is the whole text.
        path: String,
    },
    /// More than one mistake.
    #[error("{}", lines(.mistakes))]
    Several {
        /// Keys that a scene does not have, and the first other mistake if there is one; in the order in which they are
        /// found.
        mistakes: Vec<Error>,
    },
    /// A key or value that a scene does not have.
    #[error("{file}:{line}:{column}: {path}: {why}")]
    Key {
        /// Name of the text.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in bytes, from 1.
        column: usize,
        /// Path of the key, such as `camera.view_angle_deg`; `scene` is the whole text.
        path: String,
        /// What is wrong and what would be right.
        why: String,
    },
}

impl Scene {
    /// The scene that `text` describes: JSON in which `//`, `/* */` and `#` comments and trailing
    /// commas are allowed. `name` is what the text is called in messages.
    ///
    /// ```
    /// use strahl_scene::Scene;
    /// let scene = Scene::parse("head.json", r#"{
    ///     "volume": { "path": "head.nii.gz" },  // beside this file
    ///     "preset": "ct-bone",
    /// }"#)?;
    /// assert_eq!(scene.preset.as_deref(), Some("ct-bone"));
    /// # Ok::<(), strahl_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// All keys that a scene does not have and the first other mistake, with their lines, columns and paths.
    pub fn parse(name: &str, text: &str) -> Result<Scene, Error> {
        let file = name.to_owned();
        if text.len() > MOST_SCENE_BYTES {
            return Err(Error::TooLong {
                file,
                bytes: text.len(),
            });
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut plain = text.to_owned();
        if let Err(error) = json_strip_comments::strip(&mut plain) {
            let lines = plain.lines().count();
            return Err(Error::Syntax {
                file,
                line: lines.max(1),
                column: 1,
                why: error.to_string(),
            });
        }
        let plain = with_lines_of(text, plain);
        if let Err(why) = check_json_size(&plain) {
            return Err(Error::TooMany { file, why });
        }
        let mut scene = read(&file, &plain).map_err(|first| all_mistakes(&file, &plain, first))?;
        // serde also takes an object's values as a list; nobody could read such a scene.
        let as_written: serde_json::Value = serde_json::from_str(&plain)
            .map_err(|error| located(&file, &plain, ".".to_owned(), error))?;
        let as_understood = serde_json::to_value(&scene).unwrap_or_default();
        match list_for_object(&as_written, &as_understood, "scene") {
            Some(path) => Err(Error::List { file, path }),
            None => {
                if let Some(graph) = &mut scene.graph {
                    graph.with_lines_of(&plain);
                }
                Ok(scene)
            }
        }
    }

    /// The scene as JSON, two spaces per level; [`Scene::parse`] reads the same scene from it if its
    /// numbers are finite.
    pub fn to_json(&self) -> String {
        // A scene holds nothing that JSON cannot say: no maps with keys that are not texts.
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }
}

/// A mistake, and the key if no scene has it.
struct Mistake {
    error: Error,
    unknown_key: Option<UnknownKey>,
}

/// A key that no scene has, and where it ends.
struct UnknownKey {
    name: String,
    line: usize,
    column: usize,
}

/// The scene in `plain`, or its first mistake.
#[expect(
    clippy::result_large_err,
    reason = "a mistake is rare, and made once per scene"
)]
fn read(file: &str, plain: &str) -> Result<Scene, Mistake> {
    let mut json = serde_json::Deserializer::from_str(plain);
    let mistake = |path: String, error: serde_json::Error| {
        let text = error.to_string();
        let name = text.strip_prefix("unknown field `");
        let name = name.and_then(|rest| rest.split('`').next());
        Mistake {
            unknown_key: name.map(|name| UnknownKey {
                name: name.to_owned(),
                line: error.line(),
                column: error.column(),
            }),
            error: located(file, plain, path, error),
        }
    };
    let scene = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let path = error.path().to_string();
        mistake(path, error.into_inner())
    })?;
    json.end().map_err(|error| mistake(".".to_owned(), error))?;
    Ok(scene)
}

/// The `first` mistake and those that are found where the keys before them are left out.
fn all_mistakes(file: &str, plain: &str, first: Mistake) -> Error {
    /// Whoever has more reads the first.
    const MOST: usize = 20;
    let mut text = plain.to_owned();
    let mut mistakes = Vec::new();
    let mut paths = BTreeSet::new();
    let mut next = Some(first);
    while let Some(Mistake {
        mut error,
        unknown_key,
    }) = next
    {
        if let Error::Key { path, why, .. } = &mut error
            && unknown_key.is_some()
            && !paths.insert(path.clone())
            && let Some(at) = why.find("known are")
        {
            // The keys of this object have been listed.
            why.truncate(at);
            why.truncate(why.trim_end_matches([' ', ';']).len());
        }
        mistakes.push(error);
        let rest = unknown_key.and_then(|key| without_entry(&text, &key));
        next = match rest {
            Some(rest) if mistakes.len() < MOST => {
                text = rest;
                read(file, &text).err()
            }
            _ => None,
        };
    }
    match mistakes.len() {
        1 => mistakes.remove(0),
        _ => Error::Several { mistakes },
    }
}

/// `text` with blanks in place of `key` and its value, so that everything else stays where it is. `None` if that is
/// not possible.
fn without_entry(text: &str, key: &UnknownKey) -> Option<String> {
    let lines = text.split_inclusive('\n').take(key.line.checked_sub(1)?);
    let end = lines.map(str::len).sum::<usize>() + key.column;
    let quoted = format!("{:?}", key.name);
    let mut begin = end.checked_sub(quoted.len())?;
    if text.get(begin..end)? != quoted {
        return None;
    }
    let value = text.get(end..)?.trim_start().strip_prefix(':')?;
    let mut values = serde_json::Deserializer::from_str(value).into_iter::<IgnoredAny>();
    values.next()?.ok()?;
    let behind = value.get(values.byte_offset()..)?.trim_start();
    let mut stop = text.len() - behind.len();
    if behind.starts_with(',') {
        stop += 1;
    } else if let Some(before) = text[..begin].trim_end().strip_suffix(',') {
        begin = before.len();
    }
    let blank = text[begin..stop].bytes();
    let blank = blank.map(|byte| if byte == b'\n' { '\n' } else { ' ' });
    let blank: String = blank.collect();
    Some([&text[..begin], &blank, &text[stop..]].concat())
}

fn lines(mistakes: &[Error]) -> String {
    let texts: Vec<String> = mistakes.iter().map(Error::to_string).collect();
    texts.join("\n")
}

/// The keys of a scene, in its order.
pub(crate) fn keys() -> &'static [&'static str] {
    /// Records the fields of a struct, and deserializes nothing.
    struct Fields<'k>(&'k mut &'static [&'static str]);
    impl<'de> Deserializer<'de> for Fields<'_> {
        type Error = serde::de::value::Error;

        fn deserialize_struct<V: Visitor<'de>>(
            self,
            _: &'static str,
            fields: &'static [&'static str],
            visitor: V,
        ) -> Result<V::Value, Self::Error> {
            *self.0 = fields;
            self.deserialize_any(visitor)
        }

        fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
            Err(serde::de::Error::custom("only the keys are asked for"))
        }

        forward_to_deserialize_any! {
            bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
            unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
        }
    }
    let mut keys: &[&str] = &[];
    // It cannot succeed.
    let _ = Scene::deserialize(Fields(&mut keys));
    keys
}

/// The JSON schema of scenes, as checked in at `docs/scene.schema.json`.
#[cfg(feature = "schema")]
pub fn schema() -> String {
    let schema = schemars::schema_for!(Scene);
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}

/// `plain` with the line ends of `text`, byte by byte as long: block comments lose theirs when they
/// are stripped, and messages would name wrong lines.
fn with_lines_of(text: &str, plain: String) -> String {
    debug_assert_eq!(text.len(), plain.len());
    let mut bytes = plain.into_bytes();
    for (byte, original) in bytes.iter_mut().zip(text.bytes()) {
        if *byte == b' ' && original == b'\n' {
            *byte = b'\n';
        }
    }
    // Spaces became line ends: it is UTF-8 as before.
    String::from_utf8(bytes).unwrap_or_default()
}

/// Path of the first list in `text` where `scene` has an object. Points of transfer functions may be
/// lists.
fn list_for_object(
    text: &serde_json::Value,
    scene: &serde_json::Value,
    path: &str,
) -> Option<String> {
    use serde_json::Value;
    match (text, scene) {
        (Value::Array(_), Value::Object(_)) => Some(path.to_owned()),
        (Value::Array(text), Value::Array(scene))
            if !path.ends_with("transfer_function.points") =>
        {
            text.iter()
                .zip(scene)
                .enumerate()
                .find_map(|(i, (text, scene))| {
                    list_for_object(text, scene, &format!("{path}[{i}]"))
                })
        }
        (Value::Object(text), Value::Object(scene)) => text.iter().find_map(|(key, text)| {
            let inner = match path {
                "scene" => key.clone(),
                _ => format!("{path}.{key}"),
            };
            list_for_object(text, scene.get(key)?, &inner)
        }),
        _ => None,
    }
}

/// `error` as one of ours. `plain` is the text in which it was found.
fn located(file: &str, plain: &str, path: String, error: serde_json::Error) -> Error {
    let file = file.to_owned();
    let (line, column) = (error.line(), error.column());
    let suffix = format!(" at line {line} column {column}");
    let text = error.to_string();
    let column = column.max(1);
    let why = text.strip_suffix(&suffix).unwrap_or(&text).to_owned();
    let not_finite = not_finite_at(plain, line, column);
    if error.classify() != Category::Data && not_finite.is_none() {
        return Error::Syntax {
            file,
            line,
            column,
            why,
        };
    }
    let why = match not_finite {
        Some(word) => format!("{word} is not allowed; write a finite number"),
        None => why,
    };
    let unknown = why.starts_with("unknown field") || why.starts_with("unknown variant");
    let (path, why) = if unknown {
        let (path, why) = unknown_name(&path, &why);
        (path, why)
    } else {
        (path, plain_types(&why))
    };
    Error::Key {
        file,
        line,
        column,
        path: if path == "." {
            "scene".to_owned()
        } else {
            path
        },
        why,
    }
}

/// The word at a place, if it is one that other programs write for a number that is not finite. JSON
/// has none. `line` and `column` (in bytes) count from 1.
fn not_finite_at(plain: &str, line: usize, column: usize) -> Option<&'static str> {
    let line = plain.lines().nth(line.checked_sub(1)?)?;
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-.".contains(byte);
    let place = column.saturating_sub(1).min(line.len());
    let (before, after) = line.as_bytes().split_at(place);
    let start = place - before.iter().rev().take_while(|byte| is_word(byte)).count();
    let end = place + after.iter().take_while(|byte| is_word(byte)).count();
    let word = line.get(start..end)?.trim_start_matches(['+', '-']);
    let known = ["NaN", "Infinity", "inf"];
    known
        .into_iter()
        .find(|known| known.eq_ignore_ascii_case(word))
}

/// "unknown field `x`, expected one of `a`, `b`" in our words, with the nearest known name.
fn unknown_name(path: &str, why: &str) -> (String, String) {
    let mut names = why.split('`').skip(1).step_by(2);
    let found = names.next().unwrap_or_default();
    let known: Vec<&str> = names.collect();
    let is_key = why.starts_with("unknown field");
    // The path of an unknown key names the key itself; it belongs into the sentence.
    let path = match path.strip_suffix(found) {
        Some(parent) if is_key => match parent.strip_suffix('.') {
            Some(parent) if !parent.is_empty() => parent.to_owned(),
            _ => ".".to_owned(),
        },
        _ => path.to_owned(),
    };
    let what = if is_key { "key" } else { "value" };
    let mut sentence = format!("unknown {what} {found:?}");
    if let Some(near) = nearest(found, known.iter().copied()) {
        sentence.push_str(&format!("; did you mean {near:?}?"));
    }
    if !known.is_empty() {
        let separator = if sentence.ends_with('?') { " " } else { "; " };
        sentence.push_str(&format!("{separator}known are {}", known.join(", ")));
    }
    let of_samples = Method::ALL.iter().any(|method| method.name() == found);
    if !is_key && path.ends_with("composite") && of_samples {
        sentence.push_str(&format!(
            ". {found:?} is a rule for samples: set `method` to it, of the scene or of a technique"
        ));
    }
    (path, sentence)
}

/// Replaces serde's names of Rust types by words that authors of scenes know.
fn plain_types(why: &str) -> String {
    let mut text = why.to_owned();
    for (rust, plain) in [
        ("expected f64", "expected a number"),
        (
            "expected u32",
            "expected a whole number from 0 to 4294967295",
        ),
        ("expected u64", "expected a whole number from 0"),
        ("expected usize", "expected a whole number from 0"),
        ("expected struct Scene", "expected an object of keys"),
        (
            "expected struct FunctionUse",
            "expected an object such as { \"module\": \"halo\" }",
        ),
        (
            "expected struct VolumeSource",
            "expected an object such as { \"path\": \"head.nii.gz\" }",
        ),
        ("expected a map", "expected an object"),
        ("expected a sequence", "expected a list"),
        ("expected an array of length", "expected a list of length"),
        ("invalid type: map", "invalid type: an object"),
        ("invalid type: sequence", "invalid type: a list"),
        ("floating point `", "number `"),
        ("integer `", "number `"),
        ("missing field", "missing key"),
    ] {
        text = text.replace(rust, plain);
    }
    // Names of other types say nothing to an author.
    if let Some(at) = text.find("expected struct ") {
        let name = &text[at + "expected struct ".len()..];
        let end = name
            .find(|c: char| !c.is_alphanumeric())
            .unwrap_or(name.len());
        let rest = name[end..].to_owned();
        text.truncate(at);
        text.push_str("expected an object of keys");
        text.push_str(&rest);
    }
    text
}
