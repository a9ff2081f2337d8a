//! Text ↔ graph: JSON with comments, in which nodes and everything else that has a name is a key.

use crate::edit::{Edit, EditList, Replacement};
use crate::error::{Error, Problem};
use crate::model::{
    CarriedVariable, Constant, Graph, GroupInput, Input, Interpolation, Kind, Loop, Node,
    Reference, Stage, Texture,
};
use crate::slicing::SlicingText;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{self, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// The version of the text form that this crate writes, and the newest that it reads.
pub const VERSION: i64 = 1;

/// No graph is longer; a text that is was not meant as one.
pub const MOST_GRAPH_BYTES: usize = 64 << 20;

/// Files in one another.
const DEEPEST: usize = 16;

/// Files that a text and those that it names may name, each counted as often as it is named: ten small files that name
/// one another several times would be millions.
const MOST_FILES: usize = 1000;

/// What a text asks for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GraphUse {
    /// The graph that stands in place of the standard one, if the text has nodes.
    pub graph: Option<Graph>,
    /// What is changed, in this order.
    pub edits: Vec<EditList>,
    /// Folders with patterns of the project's own.
    pub patterns: Vec<String>,
}

/// Reads a file that a text names, as its path from the folder of the outermost text.
pub type ReadFile<'r> = dyn FnMut(&str) -> Result<String, String> + 'r;

impl GraphUse {
    /// What `text` asks for: that of a `.graph.json`, or of a scene's key `graph`. `file` is its name in
    /// messages, `read` opens other files that it names.
    ///
    /// ```
    /// use strahl_graph::GraphUse;
    /// let text = r#"{
    ///     "strahl_graph": 1,
    ///     "edits": [{ "name": "reddish", "commands": [
    ///         { "add": { "red": { "pattern": "multiply", "inputs": { "b": [1, 0.5, 0.5] } } } },
    ///         { "insert": { "node": "red", "into": "after_shade_color" } },  // the shaded color
    ///     ] }],
    /// }"#;
    /// let asked = GraphUse::read("reddish.graph.json", text, &mut |_| Err("no files here".to_owned()))?;
    /// assert_eq!(asked.edits[0].name, "reddish");
    /// # Ok::<(), strahl_graph::Error>(())
    /// ```
    ///
    /// # Errors
    /// The text is not JSON, has a key twice or one that is not known, was written by a newer Strahl, or a file
    /// that it names cannot be read.
    pub fn read(file: &str, text: &str, read: &mut ReadFile) -> Result<GraphUse, Error> {
        let (mut files, mut bytes) = (0, text.len());
        let mut within = |path: &str| {
            if files == MOST_FILES {
                return Err(format!(
                    "more than {MOST_FILES} files are named, each as often as it is"
                ));
            }
            files += 1;
            let text = read(path)?;
            bytes += text.len();
            match bytes > MOST_GRAPH_BYTES {
                true => Err(format!(
                    "with it the files have more than {MOST_GRAPH_BYTES} bytes together"
                )),
                false => Ok(text),
            }
        };
        read_at(file, text, &mut within, 0)
    }

    /// All of it as one text that names no other graph or WGSL file; [`GraphUse::read`] reads the same from it.
    pub fn to_text(&self) -> String {
        let graph = self.graph.as_ref().map(graph_text).unwrap_or_default();
        GraphText {
            strahl_graph: Some(VERSION),
            patterns: self.patterns.clone(),
            edits: self.edits.iter().map(edit_list_text).collect(),
            ..graph
        }
        .print()
    }

    /// Every path that stays in the text: pictures of textures, folders of patterns.
    pub fn for_each_path_mut(&mut self, mut f: impl FnMut(&mut String)) {
        self.patterns.iter_mut().for_each(&mut f);
        let mut graphs: Vec<&mut [Node]> = Vec::new();
        graphs.extend(self.graph.as_mut().map(|graph| &mut graph.nodes[..]));
        for command in self.edits.iter_mut().flat_map(|list| &mut list.commands) {
            match command {
                Edit::Add(nodes) => graphs.push(nodes),
                Edit::Everything(graph) => graphs.push(&mut graph.nodes),
                _ => {}
            }
        }
        while let Some(nodes) = graphs.pop() {
            for node in nodes {
                match &mut node.kind {
                    Kind::Texture(Texture::File(path)) => f(path),
                    Kind::Group(graph) => graphs.push(&mut graph.nodes),
                    _ => {}
                }
            }
        }
    }
}

fn read_at(file: &str, text: &str, read: &mut ReadFile, depth: usize) -> Result<GraphUse, Error> {
    let text: GraphText = parse(file, text)?;
    let mut reader = Reader {
        file,
        read,
        depth,
        problems: Vec::new(),
    };
    let asked = reader.asked(text)?;
    if reader.problems.is_empty() {
        return Ok(asked);
    }
    Err(Error::Graph {
        file: file.to_owned(),
        problems: reader.problems,
    })
}

impl Graph {
    /// The graph as text: a line for each node where it fits, in the order of the nodes. [`GraphUse::read`]
    /// reads the same graph from it.
    pub fn to_text(&self) -> String {
        let text = GraphText {
            strahl_graph: Some(VERSION),
            ..graph_text(self)
        };
        text.print()
    }
}

impl GraphText {
    fn print(&self) -> String {
        // Nothing of it is anything that JSON cannot say.
        let compact = serde_json::to_string(self).unwrap_or_default();
        let tree: Tree = serde_json::from_str(&compact).unwrap_or(Tree::Null);
        let mut out = String::new();
        tree.write(&mut out, 0, 0);
        out.push('\n');
        out
    }
}

/// The JSON schema of graphs, as checked in at `docs/graph.schema.json`.
pub fn schema() -> String {
    let schema = schemars::schema_for!(GraphText);
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}

/// Text to the struct of the same keys.
fn parse(file: &str, text: &str) -> Result<GraphText, Error> {
    let wrong = |line: usize, column: usize, why: String| Error::Syntax {
        file: file.to_owned(),
        line,
        column,
        why,
    };
    if text.len() > MOST_GRAPH_BYTES {
        let n = text.len();
        return Err(wrong(
            1,
            1,
            format!("{n} bytes; a graph has at most {MOST_GRAPH_BYTES}"),
        ));
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut plain = text.to_owned();
    json_strip_comments::strip(&mut plain)
        .map_err(|error| wrong(text.lines().count().max(1), 1, error.to_string()))?;
    // Block comments lose their line ends when they are stripped.
    let mut bytes = plain.into_bytes();
    for (byte, original) in bytes.iter_mut().zip(text.bytes()) {
        if *byte == b' ' && original == b'\n' {
            *byte = b'\n';
        }
    }
    let plain = String::from_utf8(bytes).unwrap_or_default();
    strahl_scene::check_json_size(&plain).map_err(|why| wrong(1, 1, why))?;
    let located = |path: &str, error: serde_json::Error| {
        let (line, column) = (error.line(), error.column().max(1));
        let text = error.to_string();
        let suffix = format!(" at line {line} column {}", error.column());
        let why = text.strip_suffix(&suffix).unwrap_or(&text);
        let why = match path {
            "" | "." => why.to_owned(),
            path => format!("{path}: {why}"),
        };
        wrong(line, column, why)
    };
    // Keys that stand twice, and the version before anything that only a newer one knows.
    let tree: Tree = serde_json::from_str(&plain).map_err(|error| located("", error))?;
    if let Tree::Map(keys) = &tree
        && let Some((_, version)) = keys.iter().find(|(key, _)| key == "strahl_graph")
    {
        match version {
            Tree::Number(number) if number.as_f64().is_some_and(|n| n > VERSION as f64) => {
                return Err(Error::Version {
                    file: file.to_owned(),
                    found: number.as_f64().map_or(i64::MAX, |n| n as i64),
                    known: VERSION,
                });
            }
            Tree::Number(number) if number.as_i64() == Some(VERSION) => {}
            _ => {
                return Err(wrong(
                    1,
                    1,
                    format!("strahl_graph is the version of the format, {VERSION}"),
                ));
            }
        }
    }
    let mut json = serde_json::Deserializer::from_str(&plain);
    serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let path = error.path().to_string();
        located(&path, error.into_inner())
    })
}

/// JSON with its keys in their order, each once.
enum Tree {
    Null,
    Bool(bool),
    Number(serde_json::Number),
    Text(String),
    List(Vec<Tree>),
    Map(Vec<(String, Tree)>),
}

impl Tree {
    /// On one line, or over several if that is too long.
    fn write(&self, out: &mut String, indent: usize, before: usize) {
        const WIDTH: usize = 110;
        let mut line = String::new();
        if self.write_line(&mut line, WIDTH.saturating_sub(indent + before)) && indent > 0 {
            out.push_str(&line);
            return;
        }
        let deeper = indent + 2;
        match self {
            Tree::List(list) => {
                out.push('[');
                for (i, inner) in list.iter().enumerate() {
                    out.push_str(if i > 0 { ",\n" } else { "\n" });
                    out.extend(std::iter::repeat_n(' ', deeper));
                    inner.write(out, deeper, 0);
                }
                out.push('\n');
                out.extend(std::iter::repeat_n(' ', indent));
                out.push(']');
            }
            Tree::Map(map) => {
                out.push('{');
                for (i, (key, inner)) in map.iter().enumerate() {
                    out.push_str(if i > 0 { ",\n" } else { "\n" });
                    out.extend(std::iter::repeat_n(' ', deeper));
                    let key = serde_json::Value::from(key.as_str()).to_string();
                    out.push_str(&key);
                    out.push_str(": ");
                    inner.write(out, deeper, key.len() + 2);
                }
                out.push('\n');
                out.extend(std::iter::repeat_n(' ', indent));
                out.push('}');
            }
            _ => {
                self.write_line(out, usize::MAX);
            }
        }
    }

    /// Whether it fits into `width` letters.
    fn write_line(&self, out: &mut String, width: usize) -> bool {
        match self {
            Tree::Null => out.push_str("null"),
            Tree::Bool(truth) => out.push_str(if *truth { "true" } else { "false" }),
            Tree::Number(number) => {
                let text = number.to_string();
                out.push_str(text.strip_suffix(".0").unwrap_or(&text));
            }
            Tree::Text(text) => out.push_str(&serde_json::Value::from(text.as_str()).to_string()),
            Tree::List(list) => {
                out.push('[');
                for (i, inner) in list.iter().enumerate() {
                    out.push_str(if i > 0 { ", " } else { "" });
                    if !inner.write_line(out, width) {
                        return false;
                    }
                }
                out.push(']');
            }
            Tree::Map(map) => {
                out.push_str("{ ");
                for (i, (key, inner)) in map.iter().enumerate() {
                    out.push_str(if i > 0 { ", " } else { "" });
                    out.push_str(&serde_json::Value::from(key.as_str()).to_string());
                    out.push_str(": ");
                    if !inner.write_line(out, width) {
                        return false;
                    }
                }
                out.push_str(if map.is_empty() { "}" } else { " }" });
            }
        }
        out.len() <= width
    }
}

impl<'de> Deserialize<'de> for Tree {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Tree, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Tree;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("JSON")
            }
            fn visit_unit<E>(self) -> Result<Tree, E> {
                Ok(Tree::Null)
            }
            fn visit_bool<E>(self, truth: bool) -> Result<Tree, E> {
                Ok(Tree::Bool(truth))
            }
            fn visit_i64<E>(self, number: i64) -> Result<Tree, E> {
                Ok(Tree::Number(number.into()))
            }
            fn visit_u64<E>(self, number: u64) -> Result<Tree, E> {
                Ok(Tree::Number(number.into()))
            }
            fn visit_f64<E>(self, number: f64) -> Result<Tree, E> {
                Ok(serde_json::Number::from_f64(number).map_or(Tree::Null, Tree::Number))
            }
            fn visit_str<E>(self, text: &str) -> Result<Tree, E> {
                Ok(Tree::Text(text.to_owned()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Tree, A::Error> {
                let mut list = Vec::new();
                while let Some(inner) = seq.next_element()? {
                    list.push(inner);
                }
                Ok(Tree::List(list))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Tree, A::Error> {
                Ok(Tree::Map(keys_once(map)?))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// The keys of an object in their order.
fn keys_once<'de, T: Deserialize<'de>, A: MapAccess<'de>>(
    mut map: A,
) -> Result<Vec<(String, T)>, A::Error> {
    let mut keys: Vec<(String, T)> = Vec::new();
    let mut seen = std::collections::HashSet::new();
    while let Some(key) = map.next_key::<String>()? {
        if !seen.insert(key.clone()) {
            return Err(de::Error::custom(format!(
                "the key `{key}` stands there twice; of two nodes of one name rename one"
            )));
        }
        keys.push((key, map.next_value()?));
    }
    Ok(keys)
}

/// An object whose keys are names, in their order.
#[derive(Clone, Debug, PartialEq)]
struct Map<T>(Vec<(String, T)>);

impl<T> Default for Map<T> {
    fn default() -> Map<T> {
        Map(Vec::new())
    }
}

impl<T> Map<T> {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T: Serialize> Serialize for Map<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (key, value) in &self.0 {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Map<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Map<T>, D::Error> {
        struct Keys<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Keys<T> {
            type Value = Map<T>;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object of names")
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Map<T>, A::Error> {
                Ok(Map(keys_once(map)?))
            }
        }
        deserializer.deserialize_map(Keys(PhantomData))
    }
}

impl<T: JsonSchema> JsonSchema for Map<T> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        format!("MapOf{}", T::schema_name()).into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        std::collections::BTreeMap::<String, T>::json_schema(generator)
    }
}

/// What an input reads: `"node.output"`, a number, a list of numbers, true or false.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
enum InputText {
    /// An output of a node, such as `"ray.direction"`.
    From(String),
    /// A truth.
    Bool(bool),
    /// A number; it fills a vector.
    Number(f64),
    /// A vector.
    Numbers(Vec<f64>),
}

impl<'de> Deserialize<'de> for InputText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<InputText, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = InputText;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("\"node.output\", a number, a list of numbers, true or false")
            }
            fn visit_bool<E>(self, truth: bool) -> Result<InputText, E> {
                Ok(InputText::Bool(truth))
            }
            fn visit_i64<E>(self, number: i64) -> Result<InputText, E> {
                Ok(InputText::Number(number as f64))
            }
            fn visit_u64<E>(self, number: u64) -> Result<InputText, E> {
                Ok(InputText::Number(number as f64))
            }
            fn visit_f64<E>(self, number: f64) -> Result<InputText, E> {
                Ok(InputText::Number(number))
            }
            fn visit_str<E>(self, text: &str) -> Result<InputText, E> {
                Ok(InputText::From(text.to_owned()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<InputText, A::Error> {
                let mut numbers = Vec::new();
                while let Some(number) = seq.next_element::<f64>()? {
                    numbers.push(number);
                    if numbers.len() > 16 {
                        return Err(de::Error::custom("a vector has at most 4 numbers"));
                    }
                }
                Ok(InputText::Numbers(numbers))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

impl InputText {
    fn input(self) -> Input {
        match self {
            InputText::From(text) => Input::From(Reference::new(&text)),
            InputText::Bool(truth) => Input::Constant(Constant::Bool(truth)),
            InputText::Number(number) => Input::Constant(Constant::Numbers(vec![number])),
            InputText::Numbers(numbers) => Input::Constant(Constant::Numbers(numbers)),
        }
    }

    fn of(input: &Input) -> InputText {
        match input {
            Input::From(reference) => InputText::From(reference.to_string()),
            Input::Constant(constant) => InputText::constant(constant),
        }
    }

    fn constant(constant: &Constant) -> InputText {
        match constant {
            Constant::Bool(truth) => InputText::Bool(*truth),
            Constant::Numbers(numbers) => InputText::numbers(numbers),
        }
    }

    fn numbers(numbers: &[f64]) -> InputText {
        match numbers {
            [one] => InputText::Number(*one),
            _ => InputText::Numbers(numbers.to_vec()),
        }
    }
}

/// Numbers of a parameter, or what else stands where only numbers belong.
fn numbers_of(text: InputText) -> Result<Vec<f64>, &'static str> {
    match text {
        InputText::Number(number) => Ok(vec![number]),
        InputText::Numbers(numbers) => Ok(numbers),
        _ => {
            Err("a parameter is a number or a list of numbers; what comes from a node is an input")
        }
    }
}

fn is_false(truth: &bool) -> bool {
    !*truth
}

/// A graph, and edits of graphs: what `.graph.json` and a scene's key `graph` hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "Strahl graph", rename = "Graph")]
struct GraphText {
    /// Version of the format: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("const" = 1))]
    strahl_graph: Option<i64>,
    /// What it is called, for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// Another text that comes first, relative to the folder of this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    /// Folders with patterns of one's own, `NAME.wgsl` each, relative to the folder of this text.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    patterns: Vec<String>,
    /// The graph is drawn by slices across the view instead of along rays.
    #[serde(skip_serializing_if = "Option::is_none")]
    slicing: Option<SlicingText>,
    /// Inputs of a graph that stands as a node in others; inside they are read as `inputs.NAME`.
    #[serde(skip_serializing_if = "Map::is_empty")]
    inputs: Map<GroupInputText>,
    /// The nodes by their names. With nodes, the graph stands in place of the standard one.
    #[serde(skip_serializing_if = "Map::is_empty")]
    nodes: Map<NodeText>,
    /// What is computed: `color` (vec4f, linear, premultiplied), and `depth_mm` (f32) if you like.
    #[serde(skip_serializing_if = "Map::is_empty")]
    roots: Map<String>,
    /// Named lists of commands, carried out in this order whenever the settings change.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    edits: Vec<EditListText>,
}

/// An input of a graph that stands as a node in others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "GroupInput")]
struct GroupInputText {
    /// What it is if nothing is connected; without, something has to be.
    #[serde(skip_serializing_if = "Option::is_none")]
    default: Option<InputText>,
}

/// A node: exactly one of `slot`, `function`, `pattern`, `wgsl`, `wgsl_file`, `anchor`, `uniform`, `texture`,
/// `loop`, `if`, `graph`, `graph_file` says what it does.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "Node")]
struct NodeText {
    /// The function that the scene's settings put into this slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    slot: Option<String>,
    /// A function of the library, `slot/name`, with parameters of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    function: Option<String>,
    /// A node of the pattern library; `strahl graph patterns` lists them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pattern: Option<String>,
    /// WGSL with the function that it is: a text, or a list of lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    wgsl: Option<Lines>,
    /// The same in a file, relative to the folder of this text.
    #[serde(skip_serializing_if = "Option::is_none")]
    wgsl_file: Option<String>,
    /// Hands on what it gets: a place for edits.
    #[serde(skip_serializing_if = "Option::is_none")]
    anchor: Option<InputText>,
    /// The type of a number or vector that is set from outside: `f32`, `vec3f` …; its value is `value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    uniform: Option<String>,
    /// Of a uniform.
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<InputText>,
    /// A table in two dimensions.
    #[serde(skip_serializing_if = "Option::is_none")]
    texture: Option<TextureText>,
    /// What a loop carries, and when it ends. Its variables are read inside as `LOOP.NAME`, and outside as
    /// `LOOP.last.NAME`.
    #[serde(rename = "loop", skip_serializing_if = "Option::is_none")]
    loop_: Option<LoopText>,
    /// Which of `then` and `else` counts; each computes only what it needs.
    #[serde(rename = "if", skip_serializing_if = "Option::is_none")]
    if_: Option<InputText>,
    /// The outputs if so.
    #[serde(skip_serializing_if = "Map::is_empty")]
    then: Map<InputText>,
    /// The outputs if not.
    #[serde(rename = "else", skip_serializing_if = "Map::is_empty")]
    else_: Map<InputText>,
    /// A graph as one node: its roots are the outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    graph: Option<Box<GraphText>>,
    /// The same in a file, relative to the folder of this text.
    #[serde(skip_serializing_if = "Option::is_none")]
    graph_file: Option<String>,
    /// What its inputs read; those that are left out have their default.
    #[serde(skip_serializing_if = "Map::is_empty")]
    inputs: Map<InputText>,
    /// Values of its function's parameters; changing them never compiles anything.
    #[serde(skip_serializing_if = "Map::is_empty")]
    params: Map<InputText>,
    /// Which object of the scene its function reads, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<usize>,
    /// Of a scene with segments, which of its techniques its function is of, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    technique: Option<usize>,
    /// Where it is computed; `pixel`, the default, is wherever it is needed.
    #[serde(skip_serializing_if = "Option::is_none")]
    stage: Option<StageText>,
    /// How outputs of the vertex stage get to the pixels; default `perspective`.
    #[serde(skip_serializing_if = "Option::is_none")]
    interpolation: Option<InterpolationText>,
    /// A word for people, printed into the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    comment: Option<String>,
}

/// A text, or a list of its lines.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
enum Lines {
    /// All of it.
    Text(String),
    /// Line by line.
    Lines(Vec<String>),
}

impl<'de> Deserialize<'de> for Lines {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Lines, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Lines;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("WGSL, as a text or as a list of lines")
            }
            fn visit_str<E>(self, text: &str) -> Result<Lines, E> {
                Ok(Lines::Text(text.to_owned()))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Lines, A::Error> {
                let mut lines = Vec::new();
                while let Some(line) = seq.next_element()? {
                    lines.push(line);
                }
                Ok(Lines::Lines(lines))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "Stage")]
enum StageText {
    /// Once per ray, or per turn of a loop.
    Pixel,
    /// At the corners of the picture, interpolated in between.
    Vertex,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "Interpolation")]
enum InterpolationText {
    /// Straight in space.
    Perspective,
    /// Straight in the picture.
    Linear,
    /// Not at all: the first corner's.
    Flat,
}

/// A table: a `file`, `texels`, or `pre_integrated`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "Texture")]
struct TextureText {
    /// A PNG, relative to the folder of this text; sRGB becomes linear.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    /// Columns and rows of `texels`.
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<[u32; 2]>,
    /// Row by row from the top, linear red, green, blue, opacity.
    #[serde(skip_serializing_if = "Option::is_none")]
    texels: Option<Vec<[f32; 4]>>,
    /// The pre-integrated transfer function of an object in so many columns and rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pre_integrated: Option<u32>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "Loop")]
struct LoopText {
    /// Variables that go from turn to turn.
    carry: Map<CarryText>,
    /// Looked at before each turn: the loop goes on while it is true.
    #[serde(rename = "while", skip_serializing_if = "Option::is_none")]
    while_: Option<String>,
    /// Looked at after each turn: the loop ends when it is true.
    #[serde(skip_serializing_if = "Option::is_none")]
    until: Option<String>,
}

/// A variable that a loop hands from turn to turn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "Carried")]
struct CarryText {
    /// Its type; that of `start` if not said.
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    ty: Option<String>,
    /// Its value in the first turn; required.
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<InputText>,
    /// Its value in the next turn; if not said, the output of this name of the only node in the loop that has
    /// one.
    #[serde(skip_serializing_if = "Option::is_none")]
    next: Option<InputText>,
}

/// A list of commands with a name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "EditList")]
struct EditListText {
    /// For messages.
    name: String,
    /// Left out as long as this is true.
    #[serde(skip_serializing_if = "is_false")]
    off: bool,
    /// What is done, one after the other.
    commands: Vec<EditText>,
}

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(rename = "Edit")]
enum EditText {
    /// More nodes, connected to nothing but what they read.
    Add(Map<NodeText>),
    /// `NODE.INPUT` reads this, in place of what it read; of an `if` also `NODE.if`, `NODE.then.X`,
    /// `NODE.else.X`, and of a loop `NODE.VARIABLE.next`, `NODE.VARIABLE.start`, `NODE.while`, `NODE.until`.
    Connect(Map<InputText>),
    /// A node between an input and what that read.
    Insert(InsertText),
    /// Whoever reads a node reads another one; or: a stage of the standard graph is another one.
    Replace(ReplaceText),
    /// More variables that a loop carries, `LOOP.VARIABLE`.
    Carry(Map<CarryText>),
    /// Values of parameters and uniforms, `NODE.PARAMETER` and `NODE.value`.
    Set(Map<InputText>),
    /// Roots, in place of those of the same name.
    Root(Map<String>),
    /// Roots that are wanted no more.
    RemoveRoot(Vec<String>),
    /// Nodes that are there no more.
    Remove(Vec<String>),
    /// Another graph in place of everything.
    Everything(Box<GraphText>),
}

/// A node between an input and what that read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Insert")]
struct InsertText {
    /// The node, which is there already.
    node: String,
    /// `NODE.INPUT`, or an anchor's name.
    into: String,
    /// The input of the node that reads what `into` read; its first unconnected one if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    input: Option<String>,
    /// The output that `into` reads now; its only one if not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    output: Option<String>,
}

/// `node` or `stage`, and `by` what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Replace")]
struct ReplaceText {
    /// A node: its outputs are those of `by`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    node: Option<String>,
    /// A stage: clip_ray, jitter, sample, clip_sample, classify, shade, composite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stage: Option<String>,
    /// What comes in its place; for shade and composite its parts `color` and `opacity`.
    by: ReplacementText,
}

#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "By")]
enum ReplacementText {
    /// One output.
    One(String),
    /// Part by part.
    Parts(Map<InputText>),
}

impl<'de> Deserialize<'de> for ReplacementText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<ReplacementText, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = ReplacementText;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str(
                    "\"node.output\", or an object of parts such as { \"color\": \"node.output\" }",
                )
            }
            fn visit_str<E>(self, text: &str) -> Result<ReplacementText, E> {
                Ok(ReplacementText::One(text.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ReplacementText, A::Error> {
                Ok(ReplacementText::Parts(Map(keys_once(map)?)))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// From texts to what they mean.
struct Reader<'r, 'f> {
    file: &'r str,
    read: &'r mut ReadFile<'f>,
    depth: usize,
    problems: Vec<Problem>,
}

impl Reader<'_, '_> {
    fn wrong(&mut self, place: impl Into<String>, why: impl Into<String>) {
        if self.problems.len() < 50 {
            self.problems.push(Problem::new(place, why));
        }
    }

    /// A path that stands in this text, from the folder of the outermost one.
    fn path(&self, path: &str) -> String {
        match self.file.rsplit_once('/') {
            Some((folder, _)) if self.depth > 0 && !path.starts_with('/') => {
                format!("{folder}/{path}")
            }
            _ => path.to_owned(),
        }
    }

    fn open(&mut self, place: &str, path: &str) -> Option<(String, String)> {
        if self.depth >= DEEPEST {
            self.wrong(
                place,
                format!("files name one another more than {DEEPEST} deep, or in a circle"),
            );
            return None;
        }
        let path = self.path(path);
        match (self.read)(&path) {
            Ok(text) => Some((path, text)),
            Err(why) => {
                self.wrong(place, format!("{path}: {why}"));
                None
            }
        }
    }

    fn asked(&mut self, text: GraphText) -> Result<GraphUse, Error> {
        let mut asked = GraphUse::default();
        if let Some(path) = &text.file
            && let Some((path, inner)) = self.open("file", path)
        {
            asked = read_at(&path, &inner, self.read, self.depth + 1)?;
        }
        for folder in &text.patterns {
            let folder = self.path(folder);
            asked.patterns.push(folder);
        }
        let edits = text.edits.clone();
        let has_graph = !text.nodes.is_empty() || !text.roots.is_empty() || !text.inputs.is_empty();
        if has_graph || text.slicing.is_some() {
            if asked.graph.is_some() {
                self.wrong(
                    "nodes",
                    "the text that `file` names has a graph already; change it by `edits`, of which `everything` takes its place",
                );
            }
            asked.graph = Some(self.graph(text, "")?);
        }
        for (i, list) in edits.into_iter().enumerate() {
            if list.off {
                continue;
            }
            let place = match &list.name[..] {
                "" => format!("edits[{i}]"),
                name => format!("edits.{name}"),
            };
            if list.name.is_empty() {
                self.wrong(
                    format!("{place}.name"),
                    "a list of edits has a name, for messages",
                );
            } else if asked.edits.iter().any(|l| l.name == list.name) {
                self.wrong(
                    format!("{place}.name"),
                    format!("there is a list `{}` already", list.name),
                );
            }
            let mut commands = Vec::new();
            for (j, command) in list.commands.into_iter().enumerate() {
                let place = format!("{place}.commands[{j}]");
                commands.extend(self.edit(command, &place)?);
            }
            asked.edits.push(EditList {
                name: list.name,
                commands,
            });
        }
        Ok(asked)
    }

    fn edit(&mut self, command: EditText, place: &str) -> Result<Option<Edit>, Error> {
        let reference = |text: &str| Reference::new(text);
        Ok(Some(match command {
            EditText::Add(nodes) => {
                let place = format!("{place}.add");
                Edit::Add(self.nodes(nodes, &place)?)
            }
            EditText::Connect(inputs) => Edit::Connect(
                inputs
                    .0
                    .into_iter()
                    .map(|(to, from)| (to, from.input()))
                    .collect(),
            ),
            EditText::Insert(insert) => Edit::Insert {
                node: insert.node,
                into: insert.into,
                input: insert.input,
                output: insert.output,
            },
            EditText::Replace(replace) => {
                let by = match replace.by {
                    ReplacementText::One(text) => Replacement::One(reference(&text)),
                    ReplacementText::Parts(parts) => Replacement::Parts(
                        parts
                            .0
                            .into_iter()
                            .map(|(p, from)| (p, from.input()))
                            .collect(),
                    ),
                };
                match (replace.node, replace.stage) {
                    (Some(node), None) => Edit::ReplaceNode { node, by },
                    (None, Some(stage)) => Edit::ReplaceStage { stage, by },
                    _ => {
                        self.wrong(format!("{place}.replace"), "set either `node` or `stage`");
                        return Ok(None);
                    }
                }
            }
            EditText::Carry(variables) => Edit::Carry(
                (variables.0.into_iter())
                    .map(|(to, text)| (to, carried(String::new(), text)))
                    .collect(),
            ),
            EditText::Set(values) => {
                let mut set = Vec::new();
                for (to, value) in values.0 {
                    match numbers_of(value) {
                        Ok(numbers) => set.push((to, numbers)),
                        Err(why) => self.wrong(format!("{place}.set.{to}"), why),
                    }
                }
                Edit::Set(set)
            }
            EditText::Root(roots) => Edit::Root(
                roots
                    .0
                    .iter()
                    .map(|(name, from)| (name.clone(), reference(from)))
                    .collect(),
            ),
            EditText::RemoveRoot(names) => Edit::RemoveRoot(names),
            EditText::Remove(names) => Edit::Remove(names),
            EditText::Everything(graph) => {
                let place = format!("{place}.everything");
                Edit::Everything(self.graph(*graph, &place)?)
            }
        }))
    }

    fn graph(&mut self, text: GraphText, place: &str) -> Result<Graph, Error> {
        let under = |key: &str| match place {
            "" => key.to_owned(),
            place => format!("{place}.{key}"),
        };
        if !place.is_empty() {
            for (key, is_there) in [
                ("edits", !text.edits.is_empty()),
                ("file", text.file.is_some()),
                ("patterns", !text.patterns.is_empty()),
            ] {
                if is_there {
                    self.wrong(
                        under(key),
                        "only the outermost text has this; a graph in a graph has nodes and roots",
                    );
                }
            }
        }
        let inputs = text.inputs.0.into_iter().map(|(name, input)| {
            let default = input.default.map(InputText::input);
            (name, default)
        });
        let mut group_inputs = Vec::new();
        for (name, default) in inputs {
            let default = match default {
                None => None,
                Some(Input::Constant(constant)) => Some(constant),
                Some(Input::From(_)) => {
                    self.wrong(
                        under(&format!("inputs.{name}.default")),
                        "a default is a number, a list of numbers, true or false",
                    );
                    None
                }
            };
            group_inputs.push(GroupInput { name, default });
        }
        let slicing = text.slicing.map(|slicing| slicing.slicing());
        if slicing.is_some_and(|s| s.start.iter().any(|number| !number.is_finite())) {
            self.wrong(
                under("slicing.start"),
                "a number is beyond what an f32 can hold",
            );
        }
        Ok(Graph {
            name: text.name.unwrap_or_default(),
            nodes: self.nodes(text.nodes, &under("nodes"))?,
            roots: (text.roots.0.iter())
                .map(|(name, from)| (name.clone(), Reference::new(from)))
                .collect(),
            inputs: group_inputs,
            slicing,
        })
    }

    fn nodes(&mut self, nodes: Map<NodeText>, place: &str) -> Result<Vec<Node>, Error> {
        let mut made = Vec::new();
        for (name, text) in nodes.0 {
            let place = format!("{place}.{name}");
            made.extend(self.node(name, text, &place)?);
        }
        Ok(made)
    }

    fn node(&mut self, name: String, text: NodeText, place: &str) -> Result<Option<Node>, Error> {
        let is_if = text.if_.is_some();
        let is_uniform = text.uniform.is_some();
        let mut kinds: Vec<(&str, Kind)> = Vec::new();
        let mut inputs: Vec<(String, Input)> = Vec::new();
        if let Some(slot) = text.slot {
            kinds.push(("slot", Kind::Slot(slot)));
        }
        if let Some(function) = text.function {
            kinds.push(("function", Kind::Function(function)));
        }
        if let Some(pattern) = text.pattern {
            kinds.push(("pattern", Kind::Pattern(pattern)));
        }
        if let Some(wgsl) = text.wgsl {
            let source = match wgsl {
                Lines::Text(text) => text,
                Lines::Lines(lines) => lines.join("\n"),
            };
            kinds.push(("wgsl", Kind::Wgsl(source)));
        }
        if let Some(path) = text.wgsl_file {
            let opened = self.open(&format!("{place}.wgsl_file"), &path);
            kinds.push((
                "wgsl_file",
                Kind::Wgsl(opened.map_or(String::new(), |(_, text)| text)),
            ));
        }
        if let Some(from) = text.anchor {
            inputs.push(("in".to_owned(), from.input()));
            kinds.push(("anchor", Kind::Anchor));
        }
        if let Some(ty) = text.uniform {
            let value = match text.value.clone().map(numbers_of) {
                Some(Ok(value)) => value,
                Some(Err(why)) => {
                    self.wrong(format!("{place}.value"), why);
                    Vec::new()
                }
                None => {
                    self.wrong(place, "a uniform has a `value`");
                    Vec::new()
                }
            };
            kinds.push(("uniform", Kind::Uniform { ty, value }));
        }
        if let Some(texture) = text.texture {
            let of = (texture.file, texture.texels, texture.pre_integrated);
            let texture = match (of, texture.size) {
                ((Some(path), None, None), None) => Some(Texture::File(self.path(&path))),
                ((None, Some(texels), None), Some(_))
                    if texels.iter().flatten().any(|number| !number.is_finite()) =>
                {
                    self.wrong(
                        format!("{place}.texture.texels"),
                        "a number is beyond what an f32 can hold",
                    );
                    return Ok(None);
                }
                ((None, Some(texels), None), Some([width, height])) => Some(Texture::Texels {
                    width,
                    height,
                    texels,
                }),
                ((None, None, Some(edge)), None) => Some(Texture::PreIntegrated { edge }),
                _ => None,
            };
            match texture {
                Some(texture) => kinds.push(("texture", Kind::Texture(texture))),
                None => {
                    self.wrong(
                        format!("{place}.texture"),
                        "set one of `file`, `texels` with `size`, `pre_integrated`",
                    );
                    return Ok(None);
                }
            }
        }
        if let Some(region) = text.loop_ {
            let region = Loop {
                carry: (region.carry.0.into_iter())
                    .map(|(name, text)| carried(name, text))
                    .collect(),
                while_: region.while_.map(|text| Reference::new(&text)),
                until: region.until.map(|text| Reference::new(&text)),
            };
            kinds.push(("loop", Kind::Loop(region)));
        }
        if let Some(condition) = text.if_ {
            inputs.push(("if".to_owned(), condition.input()));
            kinds.push(("if", Kind::If));
        }
        for (branch, outputs) in [("then", text.then), ("else", text.else_)] {
            if !is_if && !outputs.is_empty() {
                self.wrong(
                    format!("{place}.{branch}"),
                    "only a node with `if` has this",
                );
            }
            let outputs = outputs.0.into_iter();
            inputs
                .extend(outputs.map(|(output, from)| (format!("{branch}.{output}"), from.input())));
        }
        if let Some(graph) = text.graph {
            if graph.slicing.is_some() {
                self.wrong(
                    format!("{place}.graph.slicing"),
                    "only the outermost graph sets how slices are blended; a nested graph has nodes and roots",
                );
            }
            let graph = self.graph(*graph, &format!("{place}.graph"))?;
            kinds.push(("graph", Kind::Group(Box::new(graph))));
        }
        if let Some(path) = text.graph_file {
            let place = format!("{place}.graph_file");
            let mut graph = Graph::default();
            if let Some((path, inner)) = self.open(&place, &path) {
                let inner = read_at(&path, &inner, self.read, self.depth + 1)?;
                let slices = inner.graph.as_ref().is_some_and(|g| g.slicing.is_some());
                if slices || !inner.edits.is_empty() || !inner.patterns.is_empty() {
                    self.wrong(
                        &place,
                        format!(
                            "{path} has edits, patterns or slicing; a graph in a graph has nodes and roots"
                        ),
                    );
                }
                graph = inner.graph.unwrap_or_default();
            }
            kinds.push(("graph_file", Kind::Group(Box::new(graph))));
        }
        if !is_uniform && text.value.is_some() {
            self.wrong(
                format!("{place}.value"),
                "only a uniform has a value; parameters stand in `params`",
            );
        }
        let (what, kind) = match kinds.len() {
            1 => kinds.remove(0),
            0 => {
                self.wrong(place, "set one of slot, function, pattern, wgsl, wgsl_file, anchor, uniform, texture, loop, if, graph or graph_file");
                return Ok(None);
            }
            _ => {
                let names: Vec<_> = kinds.iter().map(|(name, _)| *name).collect();
                self.wrong(
                    place,
                    format!(
                        "does more than one thing: {}; make it several nodes",
                        names.join(", ")
                    ),
                );
                return Ok(None);
            }
        };
        if matches!(
            kind,
            Kind::Anchor | Kind::If | Kind::Loop(_) | Kind::Texture(_) | Kind::Uniform { .. }
        ) && !text.inputs.is_empty()
        {
            self.wrong(
                format!("{place}.inputs"),
                format!("a node with `{what}` has no `inputs`"),
            );
        }
        inputs.extend(
            text.inputs
                .0
                .into_iter()
                .map(|(name, from)| (name, from.input())),
        );
        let mut params = Vec::new();
        for (name, value) in text.params.0 {
            match numbers_of(value) {
                Ok(numbers) => params.push((name, numbers)),
                Err(why) => self.wrong(format!("{place}.params.{name}"), why),
            }
        }
        let stage = match (text.stage, text.interpolation) {
            (Some(StageText::Vertex), how) => Stage::Vertex(match how {
                None | Some(InterpolationText::Perspective) => Interpolation::Perspective,
                Some(InterpolationText::Linear) => Interpolation::Linear,
                Some(InterpolationText::Flat) => Interpolation::Flat,
            }),
            (_, Some(_)) => {
                self.wrong(
                    format!("{place}.interpolation"),
                    "only a node of the stage `vertex` is interpolated",
                );
                Stage::Pixel
            }
            _ => Stage::Pixel,
        };
        Ok(Some(Node {
            name,
            kind,
            inputs,
            params,
            object: text.object.unwrap_or(0),
            technique: text.technique.unwrap_or(0),
            stage,
            comment: text.comment.unwrap_or_default(),
        }))
    }
}

fn carried(name: String, text: CarryText) -> CarriedVariable {
    CarriedVariable {
        name,
        ty: text.ty,
        start: text.start.map(InputText::input),
        next: text.next.map(InputText::input),
    }
}

fn graph_text(graph: &Graph) -> GraphText {
    let named = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    GraphText {
        name: named(&graph.name),
        inputs: Map((graph.inputs.iter())
            .map(|input| {
                let default = input.default.as_ref().map(InputText::constant);
                (input.name.clone(), GroupInputText { default })
            })
            .collect()),
        nodes: Map(graph
            .nodes
            .iter()
            .map(|node| (node.name.clone(), node_text(node)))
            .collect()),
        roots: Map((graph.roots.iter())
            .map(|(name, from)| (name.clone(), from.to_string()))
            .collect()),
        slicing: graph.slicing.as_ref().map(SlicingText::of),
        ..GraphText::default()
    }
}

fn node_text(node: &Node) -> NodeText {
    let mut text = NodeText::default();
    let mut inputs = Vec::new();
    for (name, input) in &node.inputs {
        let from = InputText::of(input);
        match (&node.kind, name.split_once('.')) {
            (Kind::If, Some(("then", output))) => text.then.0.push((output.to_owned(), from)),
            (Kind::If, Some(("else", output))) => text.else_.0.push((output.to_owned(), from)),
            (Kind::If, _) if name == "if" => text.if_ = Some(from),
            (Kind::Anchor, _) if name == "in" => text.anchor = Some(from),
            _ => inputs.push((name.clone(), from)),
        }
    }
    text.inputs = Map(inputs);
    text.params = Map((node.params.iter())
        .map(|(name, value)| (name.clone(), InputText::numbers(value)))
        .collect());
    match &node.kind {
        Kind::Slot(slot) => text.slot = Some(slot.clone()),
        Kind::Function(function) => text.function = Some(function.clone()),
        Kind::Pattern(pattern) => text.pattern = Some(pattern.clone()),
        Kind::Wgsl(source) => {
            let lines: Vec<_> = source.split('\n').map(str::to_owned).collect();
            text.wgsl = Some(match &lines[..] {
                [one] => Lines::Text(one.clone()),
                _ => Lines::Lines(lines),
            });
        }
        Kind::Anchor | Kind::If => {}
        Kind::Uniform { ty, value } => {
            text.uniform = Some(ty.clone());
            text.value = Some(InputText::numbers(value));
        }
        Kind::Texture(texture) => {
            let mut of = TextureText::default();
            match texture {
                Texture::File(path) => of.file = Some(path.clone()),
                Texture::Texels {
                    width,
                    height,
                    texels,
                } => {
                    of.size = Some([*width, *height]);
                    of.texels = Some(texels.clone());
                }
                Texture::PreIntegrated { edge } => of.pre_integrated = Some(*edge),
            }
            text.texture = Some(of);
        }
        Kind::Loop(region) => {
            let carry =
                (region.carry.iter()).map(|carried| (carried.name.clone(), carry_text(carried)));
            text.loop_ = Some(LoopText {
                carry: Map(carry.collect()),
                while_: region.while_.as_ref().map(Reference::to_string),
                until: region.until.as_ref().map(Reference::to_string),
            });
        }
        Kind::Group(graph) => text.graph = Some(Box::new(graph_text(graph))),
    }
    text.object = (node.object > 0).then_some(node.object);
    text.technique = (node.technique > 0).then_some(node.technique);
    if let Stage::Vertex(how) = node.stage {
        text.stage = Some(StageText::Vertex);
        text.interpolation = match how {
            Interpolation::Perspective => None,
            Interpolation::Linear => Some(InterpolationText::Linear),
            Interpolation::Flat => Some(InterpolationText::Flat),
        };
    }
    text.comment = (!node.comment.is_empty()).then(|| node.comment.clone());
    text
}

fn edit_list_text(list: &EditList) -> EditListText {
    EditListText {
        name: list.name.clone(),
        off: false,
        commands: list.commands.iter().map(edit_text).collect(),
    }
}

fn edit_text(edit: &Edit) -> EditText {
    let nodes = |nodes: &[Node]| {
        Map(nodes
            .iter()
            .map(|node| (node.name.clone(), node_text(node)))
            .collect())
    };
    let inputs = |inputs: &[(String, Input)]| {
        Map(inputs
            .iter()
            .map(|(to, from)| (to.clone(), InputText::of(from)))
            .collect())
    };
    let by = |by: &Replacement| match by {
        Replacement::One(reference) => ReplacementText::One(reference.to_string()),
        Replacement::Parts(parts) => ReplacementText::Parts(inputs(parts)),
    };
    match edit {
        Edit::Add(added) => EditText::Add(nodes(added)),
        Edit::Connect(ends) => EditText::Connect(inputs(ends)),
        Edit::Insert {
            node,
            into,
            input,
            output,
        } => EditText::Insert(InsertText {
            node: node.clone(),
            into: into.clone(),
            input: input.clone(),
            output: output.clone(),
        }),
        Edit::ReplaceNode { node, by: with } => EditText::Replace(ReplaceText {
            node: Some(node.clone()),
            stage: None,
            by: by(with),
        }),
        Edit::ReplaceStage { stage, by: with } => EditText::Replace(ReplaceText {
            node: None,
            stage: Some(stage.clone()),
            by: by(with),
        }),
        Edit::Carry(variables) => EditText::Carry(Map((variables.iter())
            .map(|(to, carried)| (to.clone(), carry_text(carried)))
            .collect())),
        Edit::Set(values) => EditText::Set(Map((values.iter())
            .map(|(to, value)| (to.clone(), InputText::numbers(value)))
            .collect())),
        Edit::Root(roots) => EditText::Root(Map((roots.iter())
            .map(|(name, from)| (name.clone(), from.to_string()))
            .collect())),
        Edit::RemoveRoot(names) => EditText::RemoveRoot(names.clone()),
        Edit::Remove(names) => EditText::Remove(names.clone()),
        Edit::Everything(graph) => EditText::Everything(Box::new(graph_text(graph))),
    }
}

fn carry_text(carried: &CarriedVariable) -> CarryText {
    CarryText {
        ty: carried.ty.clone(),
        start: carried.start.as_ref().map(InputText::of),
        next: carried.next.as_ref().map(InputText::of),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_is_current() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/graph.schema.json");
        if std::env::var_os("STRAHL_UPDATE").is_some() {
            std::fs::write(path, schema()).unwrap();
        }
        assert_eq!(
            std::fs::read_to_string(path).unwrap_or_default(),
            schema(),
            "docs/graph.schema.json is not current; run STRAHL_UPDATE=1 cargo test -p strahl-graph schema"
        );
    }
}
