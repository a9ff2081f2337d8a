//! From a graph to a linked program, once for each shape of a graph.

use crate::check::{self, CheckedGraph};
use crate::emit::emit;
use crate::error::{Error, Problem};
use crate::fold::folded;
use crate::functions::Patterns;
use crate::group::unfolded;
use crate::model::{Graph, Kind, Node, Texture};
use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use strahl_program::{Functions, Slicing, SlicingError};
use strahl_shader::{Linker, Program, RayLoop, Selection, graph_loop};

/// A graph ready to be drawn.
#[derive(Clone, Debug)]
pub struct CompiledGraph {
    /// The program, the same as long as only values change.
    pub program: Arc<Program>,
    /// The bytes of its parameters' uniform block.
    pub parameters: Vec<u8>,
    /// The textures that it reads, in the order of their bindings, with their nodes' names and objects; of a scene with
    /// segments, with their techniques.
    pub textures: Vec<(String, Texture, usize)>,
    /// If it is drawn by slices: how these are blended. Its program then is that of a slice.
    pub slicing: Option<Slicing>,
    /// What is odd, but no error.
    pub warnings: Vec<Problem>,
}

/// What is the same for all values of a graph.
#[derive(Debug)]
struct Shape {
    program: Arc<Program>,
    warnings: Vec<Problem>,
    /// Nodes that have parameters, and what they are called in the program.
    nodes: Vec<(usize, String)>,
    /// Nodes that are the textures which it reads.
    textures: Vec<usize>,
}

/// Everything that decides about a [`Shape`]: a graph, whose values do not count, and what is drawn.
#[derive(Debug)]
struct Key {
    graph: Graph,
    what: RayLoop,
    selection: Selection,
    techniques: usize,
}

/// Shapes that a compiler remembers.
const MOST_SHAPES: usize = 64;

/// Compiles graphs, and remembers what it has compiled last.
#[derive(Debug, Default)]
pub struct Compiler {
    patterns: Patterns,
    /// What was used last comes first. Keys are compared, not hashed: most differ at the first look, and the
    /// one that is wanted is nearly always the first.
    shapes: VecDeque<(Key, Arc<Shape>)>,
}

impl Compiler {
    /// A compiler for graphs that use these patterns.
    pub fn new(patterns: Patterns) -> Compiler {
        Compiler {
            patterns,
            ..Compiler::default()
        }
    }

    /// The patterns.
    pub fn patterns(&self) -> &Patterns {
        &self.patterns
    }

    /// The program that draws `graph` over the objects of `what`, where slots hold `functions`. A graph of the
    /// same shape, with other values of parameters and uniforms, compiles nothing.
    ///
    /// # Errors
    /// Everything that is wrong with the graph; `file` is its name in messages.
    pub fn compile(
        &mut self,
        file: &str,
        graph: &Graph,
        what: &RayLoop,
        functions: &Functions,
    ) -> Result<CompiledGraph, Error> {
        let wrong = |problems| Error::Graph {
            file: file.to_owned(),
            problems,
        };
        let has_groups = (graph.nodes.iter()).any(|n| matches!(n.kind, Kind::Group(_)));
        let whole;
        let graph = if has_groups {
            whole = unfolded(graph).map_err(wrong)?;
            &whole
        } else {
            graph
        };
        if graph.slicing.is_some() && what.is_before_geometry {
            let why = SlicingError::Meshes.to_string();
            return Err(wrong(vec![Problem::new("slicing", why)]));
        }
        let selection = &functions.selection;
        let techniques = functions.techniques_of_segments;
        let seen = (self.shapes.iter()).position(|(key, _)| {
            key.what == *what
                && key.selection == *selection
                && key.techniques == techniques
                && is_same_shape(&key.graph, graph)
        });
        let shape = match seen.and_then(|i| self.shapes.remove(i)) {
            Some((key, shape)) => {
                self.shapes.push_front((key, shape.clone()));
                // The shape is known to be right, its values are not.
                values(graph, &shape).map_err(wrong)?;
                let mut problems = crate::slicing::problems(graph);
                problems.extend(crate::unread::unread(graph));
                if !problems.is_empty() {
                    return Err(wrong(problems));
                }
                shape
            }
            None => {
                let checked =
                    check::check(graph, &self.patterns, what.objects, techniques).map_err(wrong)?;
                let shape = Arc::new(self.link(graph, checked, what, functions).map_err(
                    |e| match e {
                        Wrong::Graph(problems) => wrong(problems),
                        Wrong::Link(error) => Error::Link(error),
                    },
                )?);
                let key = Key {
                    graph: graph.clone(),
                    what: what.clone(),
                    selection: selection.clone(),
                    techniques,
                };
                self.shapes.push_front((key, shape.clone()));
                self.shapes.truncate(MOST_SHAPES);
                shape
            }
        };
        let mut parameters = functions.parameters(&shape.program)?;
        for (node, label) in &shape.nodes {
            let node = &graph.nodes[*node];
            if let Kind::Uniform { value, .. } = &node.kind {
                shape.program.set(&mut parameters, label, "value", value)?;
            }
            for (name, value) in &node.params {
                shape.program.set(&mut parameters, label, name, value)?;
            }
        }
        let textures = shape.textures.iter().filter_map(|n| {
            let node = &graph.nodes[*n];
            match &node.kind {
                Kind::Texture(texture) => {
                    let of = if techniques > 0 {
                        node.technique
                    } else {
                        node.object
                    };
                    Some((node.name.clone(), texture.clone(), of))
                }
                _ => None,
            }
        });
        Ok(CompiledGraph {
            program: shape.program.clone(),
            parameters,
            textures: textures.collect(),
            slicing: graph.slicing,
            warnings: shape.warnings.clone(),
        })
    }

    fn link(
        &self,
        graph: &Graph,
        checked: CheckedGraph,
        what: &RayLoop,
        functions: &Functions,
    ) -> Result<Shape, Wrong> {
        let checked = folded(checked, what, &functions.selection);
        let emitted = emit(&checked, what, graph.slicing.map(|s| s.order)).map_err(Wrong::Graph)?;
        let skeleton = graph_loop(
            what,
            &emitted.march,
            emitted.entry.as_deref(),
            emitted.functions,
        )
        .map_err(Wrong::Link)?;
        // What is linked is remembered here, by its graph.
        let program = Linker::new()
            .link(&skeleton, &functions.selection)
            .map_err(Wrong::Link)?;
        let place: HashMap<_, _> = (graph.nodes.iter().enumerate())
            .map(|(i, node)| (node.name.as_str(), i))
            .collect();
        let nodes = emitted.nodes.iter().filter_map(|(name, label)| {
            let node = place.get(name.as_str())?;
            Some((*node, label.clone()))
        });
        let textures = checked.textures.iter();
        Ok(Shape {
            nodes: nodes.collect(),
            textures: textures
                .filter_map(|(name, _)| place.get(name.as_str()).copied())
                .collect(),
            program,
            warnings: checked.warnings,
        })
    }
}

enum Wrong {
    Graph(Vec<Problem>),
    Link(strahl_shader::Error),
}

/// Whether all values of `graph` can be set.
fn values(graph: &Graph, shape: &Shape) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    for (node, label) in &shape.nodes {
        let node = &graph.nodes[*node];
        let blocks = shape.program.blocks();
        let Some(block) = blocks.iter().find(|b| b.label == *label) else {
            continue;
        };
        let mut check = |name: &str, value: &[f64], place: String| {
            let parameters = block.module.parameters();
            match parameters.iter().find(|p| p.name == name) {
                Some(parameter) => {
                    if let Err(why) = parameter.check(value) {
                        problems.push(Problem::new(place, why));
                    }
                }
                None => problems.push(Problem::new(place, "no such parameter")),
            }
        };
        if let Kind::Uniform { value, .. } = &node.kind {
            check("value", value, format!("nodes.{}.uniform.value", node.name));
        }
        for (name, value) in &node.params {
            check(name, value, format!("nodes.{}.params.{name}", node.name));
        }
    }
    if problems.is_empty() {
        Ok(())
    } else {
        Err(problems)
    }
}

/// Whether all of two graphs is equal but the values that can be set.
fn is_same_shape(a: &Graph, b: &Graph) -> bool {
    let is_same_kind = |a: &Kind, b: &Kind| match (a, b) {
        (Kind::Uniform { ty: a, .. }, Kind::Uniform { ty: b, .. }) => a == b,
        (Kind::Texture(_), Kind::Texture(_)) => true,
        (a, b) => a == b,
    };
    let is_same_node = |(a, b): (&Node, &Node)| {
        a.name == b.name
            && is_same_kind(&a.kind, &b.kind)
            && a.inputs == b.inputs
            && a.object == b.object
            && a.technique == b.technique
            && a.stage == b.stage
            && a.comment == b.comment
    };
    // How slices are blended is no part of the program.
    let order = |graph: &Graph| graph.slicing.map(|slicing| slicing.order);
    // Edits are mostly at the end.
    a.nodes.len() == b.nodes.len()
        && a.roots == b.roots
        && a.inputs == b.inputs
        && order(a) == order(b)
        && a.nodes
            .iter()
            .rev()
            .zip(b.nodes.iter().rev())
            .all(is_same_node)
}
