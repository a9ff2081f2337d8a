//! From a graph to a linked program, once for each shape of a graph.

use crate::check::{self, Checked};
use crate::emit::emit;
use crate::error::{Error, Problem};
use crate::functions::Patterns;
use crate::group::unfolded;
use crate::model::{Graph, Kind, Texture};
use std::collections::HashMap;
use std::fmt::Write;
use std::sync::Arc;
use strahl_program::Functions;
use strahl_shader::{Linker, Program, RayLoop, Selection, graph_loop};

/// A graph ready to be drawn.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// The program, the same as long as only values change.
    pub program: Arc<Program>,
    /// The bytes of its parameters' uniform block.
    pub parameters: Vec<u8>,
    /// The textures that it reads, in the order of their bindings, with their nodes' names and objects.
    pub textures: Vec<(String, Texture, usize)>,
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
}

/// Everything that decides about a [`Shape`].
type Key = (String, RayLoop, Selection);

/// Compiles graphs, and remembers what it has compiled.
#[derive(Debug, Default)]
pub struct Compiler {
    linker: Linker,
    patterns: Patterns,
    shapes: HashMap<Key, Arc<Shape>>,
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
    ) -> Result<Compiled, Error> {
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
        let key = (shape_of(graph), what.clone(), functions.selection.clone());
        let shape = match self.shapes.get(&key) {
            Some(shape) => {
                // The shape is known to be right, its values are not.
                values(graph, shape).map_err(wrong)?;
                shape.clone()
            }
            None => {
                let checked = check::check(graph, &self.patterns, what.objects).map_err(wrong)?;
                let shape = Arc::new(self.link(graph, checked, what, functions).map_err(
                    |e| match e {
                        Wrong::Graph(problems) => wrong(problems),
                        Wrong::Link(error) => Error::Link(error),
                    },
                )?);
                self.shapes.insert(key, shape.clone());
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
        let textures = graph.nodes.iter().filter_map(|n| match &n.kind {
            Kind::Texture(texture) => Some((n.name.clone(), texture.clone(), n.object)),
            _ => None,
        });
        Ok(Compiled {
            program: shape.program.clone(),
            parameters,
            textures: textures.collect(),
            warnings: shape.warnings.clone(),
        })
    }

    fn link(
        &mut self,
        graph: &Graph,
        checked: Checked,
        what: &RayLoop,
        functions: &Functions,
    ) -> Result<Shape, Wrong> {
        let emitted = emit(&checked, what.objects).map_err(Wrong::Graph)?;
        let skeleton = graph_loop(
            what,
            &emitted.march,
            emitted.entry.as_deref(),
            emitted.functions,
        )
        .map_err(Wrong::Link)?;
        let program = self
            .linker
            .link(&skeleton, &functions.selection)
            .map_err(Wrong::Link)?;
        let nodes = emitted.nodes.iter().filter_map(|(name, label)| {
            let node = graph.nodes.iter().position(|n| n.name == *name)?;
            Some((node, label.clone()))
        });
        Ok(Shape {
            nodes: nodes.collect(),
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

/// All of a graph but the values that can be set.
fn shape_of(graph: &Graph) -> String {
    let mut shape = String::new();
    for node in &graph.nodes {
        let _ = write!(shape, "{}|{}|{:?}|", node.name, node.object, node.stage);
        match &node.kind {
            Kind::Uniform { ty, .. } => shape.push_str(ty),
            Kind::Texture(_) => shape.push_str("texture"),
            kind => {
                let _ = write!(shape, "{kind:?}");
            }
        }
        for (name, input) in &node.inputs {
            let _ = write!(shape, "|{name}={input:?}");
        }
        let _ = writeln!(shape, "|{}", node.comment);
    }
    for (name, root) in &graph.roots {
        let _ = writeln!(shape, "{name}={root}");
    }
    shape
}
