//! A graph: named nodes whose inputs read outputs of others, and roots, which are what is computed.

use std::fmt;
use strahl_program::Slicing;

/// Nodes, and what is wanted of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    /// What it is called, for people.
    pub name: String,
    /// Its nodes, in the order in which they were written; names are unique.
    pub nodes: Vec<Node>,
    /// What is computed: each a name and where it comes from. A ray caster has `color`, and `depth_mm` if it
    /// likes.
    pub roots: Vec<(String, Reference)>,
    /// Inputs of a graph that stands as a node in others; such a graph cannot be drawn alone.
    pub inputs: Vec<GroupInput>,
    /// If it is drawn by slices instead of along rays: how these are blended.
    pub slicing: Option<Slicing>,
}

/// An input of a graph that stands as a node in others.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupInput {
    /// Its name; inside it is read as `inputs.NAME`.
    pub name: String,
    /// What it is if nothing is connected.
    pub default: Option<Constant>,
}

/// A node: a function with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Unique in its graph: letters, digits and `_`, no word of WGSL.
    pub name: String,
    /// What it does.
    pub kind: Kind,
    /// What its inputs read. Those that are not here have their default.
    pub inputs: Vec<(String, Input)>,
    /// Values of its function's parameters; changing them never compiles anything.
    pub params: Vec<(String, Vec<f64>)>,
    /// Which object of the scene its function reads, from 0.
    pub object: usize,
    /// Of a scene with segments, which of its techniques its function is of, from 0.
    pub technique: usize,
    /// Where it is computed, and how its outputs get from the vertices to the pixels.
    pub stage: Stage,
    /// A word for people, printed into the program.
    pub comment: String,
}

impl Node {
    /// A node without inputs.
    pub fn new(name: impl Into<String>, kind: Kind) -> Node {
        Node {
            name: name.into(),
            kind,
            inputs: Vec::new(),
            params: Vec::new(),
            object: 0,
            technique: 0,
            stage: Stage::Pixel,
            comment: String::new(),
        }
    }

    /// With an input that reads `from`.
    #[must_use]
    pub fn input(mut self, name: impl Into<String>, from: impl Into<Input>) -> Node {
        self.inputs.push((name.into(), from.into()));
        self
    }

    /// With a value of a parameter.
    #[must_use]
    pub fn param(mut self, name: impl Into<String>, value: Vec<f64>) -> Node {
        self.params.push((name.into(), value));
        self
    }

    /// What this input reads, if it is connected.
    pub fn reads(&self, input: &str) -> Option<&Input> {
        self.inputs.iter().find(|(n, _)| n == input).map(|(_, i)| i)
    }
}

/// Where a node is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Where it is needed: once per ray, or per turn of a loop.
    #[default]
    Pixel,
    /// At the three corners of the triangle that covers the picture, interpolated in between.
    Vertex(Interpolation),
}

/// How outputs of the vertex stage get to the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// Straight in space.
    #[default]
    Perspective,
    /// Straight in the picture.
    Linear,
    /// The first corner's, for whole numbers and what is the same everywhere.
    Flat,
}

/// What a node does.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// The function that the scene's settings put into this slot.
    Slot(String),
    /// A function of the library, `slot/name`, with parameters of its own.
    Function(String),
    /// A node of the pattern library, or of a folder of the project's own.
    Pattern(String),
    /// WGSL that stands in the graph.
    Wgsl(String),
    /// Hands on what it gets: a place that edits can rely on, whatever the settings are. Its type is that of
    /// its input.
    Anchor,
    /// A number or vector that is set from outside.
    Uniform {
        /// f32, i32, u32 or a vector of them.
        ty: String,
        /// Its value.
        value: Vec<f64>,
    },
    /// A table of colors or numbers in two dimensions.
    Texture(Texture),
    /// A loop: its outputs are the carried variables inside; outside they are read as `NAME.last.VARIABLE`.
    Loop(Loop),
    /// One of two: what only one of them needs is computed only there. Inputs: `if`, and for each output X
    /// `then.X` and `else.X`.
    If,
    /// A graph as one node: its roots are the outputs.
    Group(Box<Graph>),
}

/// A table in two dimensions.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// A PNG, as it is (sRGB becomes linear); the renderer's folder is where it is looked for.
    File(String),
    /// Texels in the graph itself: width, height, rows from the top, linear RGBA.
    Texels {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// width × height texels.
        texels: Vec<[f32; 4]>,
    },
    /// The pre-integrated transfer function of an object: front value across, back value down; color
    /// premultiplied, opacity of one step.
    PreIntegrated {
        /// Columns and rows.
        edge: u32,
    },
}

/// What a loop carries and when it ends.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loop {
    /// The carried variables.
    pub carry: Vec<CarriedVariable>,
    /// Looked at before each turn; the loop goes on while it is true.
    pub while_: Option<Reference>,
    /// Looked at after each turn; the loop ends when it is true.
    pub until: Option<Reference>,
}

/// A variable that a loop hands from turn to turn.
#[derive(Clone, Debug, PartialEq)]
pub struct CarriedVariable {
    /// Its name.
    pub name: String,
    /// Its type; that of `start` if not said.
    pub ty: Option<String>,
    /// Its value in the first turn; has to be there.
    pub start: Option<Input>,
    /// Its value in the next turn; if not said, the output of this name of the only node in the loop that
    /// has one.
    pub next: Option<Input>,
}

/// What an input gets.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// An output of another node.
    From(Reference),
    /// A number, vector or truth.
    Constant(Constant),
}

impl From<&str> for Input {
    fn from(text: &str) -> Input {
        Input::From(Reference::new(text))
    }
}

impl From<f64> for Input {
    fn from(number: f64) -> Input {
        Input::Constant(Constant::Numbers(vec![number]))
    }
}

impl From<bool> for Input {
    fn from(truth: bool) -> Input {
        Input::Constant(Constant::Bool(truth))
    }
}

/// What is known when the graph is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Constant {
    /// One number, or as many as a vector has; one number fills a vector.
    Numbers(Vec<f64>),
    /// True or false.
    Bool(bool),
}

impl fmt::Display for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Constant::Bool(truth) => write!(f, "{truth}"),
            Constant::Numbers(numbers) => match numbers[..] {
                [one] => write!(f, "{one}"),
                _ => write!(f, "{numbers:?}"),
            },
        }
    }
}

/// Where a value comes from: `node`, `node.output`, or `node.output.member`, `node.member`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Reference {
    /// The node.
    pub node: String,
    /// Output and members, outermost first.
    pub path: Vec<String>,
}

impl Reference {
    /// What `text` means.
    pub fn new(text: &str) -> Reference {
        let mut parts = text.split('.').map(str::to_owned);
        Reference {
            node: parts.next().unwrap_or_default(),
            path: parts.collect(),
        }
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.node)?;
        for part in &self.path {
            write!(f, ".{part}")?;
        }
        Ok(())
    }
}

impl Graph {
    /// The node of this name.
    pub fn node(&self, name: &str) -> Option<&Node> {
        self.nodes.iter().find(|node| node.name == name)
    }

    /// The node of this name, to be changed.
    pub fn node_mut(&mut self, name: &str) -> Option<&mut Node> {
        self.nodes.iter_mut().find(|node| node.name == name)
    }

    /// Every place that reads an output: for messages, the path of the key in the text.
    pub fn for_each_reference_mut(&mut self, mut f: impl FnMut(&str, &mut Reference)) {
        for node in &mut self.nodes {
            let place = format!("nodes.{}", node.name);
            for (name, input) in &mut node.inputs {
                if let Input::From(reference) = input {
                    f(&format!("{place}.inputs.{name}"), reference);
                }
            }
            if let Kind::Loop(region) = &mut node.kind {
                for carried in &mut region.carry {
                    for (key, input) in [("start", &mut carried.start), ("next", &mut carried.next)]
                    {
                        if let Some(Input::From(reference)) = input {
                            f(
                                &format!("{place}.loop.carry.{}.{key}", carried.name),
                                reference,
                            );
                        }
                    }
                }
                for (key, reference) in
                    [("while", &mut region.while_), ("until", &mut region.until)]
                {
                    if let Some(reference) = reference {
                        f(&format!("{place}.loop.{key}"), reference);
                    }
                }
            }
        }
        for (name, reference) in &mut self.roots {
            f(&format!("roots.{name}"), reference);
        }
    }
}
