//! From names to places: every input of a graph is found, typed, and checked before any text is made.
//!
//! What is only there for people ends here: anchors are what they hand on, constant conditions are decided,
//! and what no root needs is left out.

use crate::error::Problem;
use crate::functions::{self, Call, Function, Patterns, Port, nearest};
use crate::literal::Literal;
use crate::model::{Constant, Graph, Input, Kind, Node, Reference, Stage, Texture};
use crate::types::{Meaning, Scalar, Type};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Loops in one graph.
pub const MOST_LOOPS: usize = 64;

/// Nodes in one graph, groups unfolded. (Parsing a program takes naga a time that grows with the square of the
/// expressions in a function: of so many a few seconds.)
pub const MOST_NODES: usize = 20_000;

/// Whoever has a thousand mistakes reads the first.
const MOST_PROBLEMS: usize = 50;

/// Textures in one graph.
pub const MOST_TEXTURES: usize = strahl_shader::bindings::TEXTURES as usize;

/// A graph in which everything is found.
#[derive(Debug)]
pub struct CheckedGraph {
    /// Nodes that compute something, sources before those that read them; loops at their end.
    pub nodes: Vec<CheckedNode>,
    /// What is wanted.
    pub roots: Vec<(String, Operand)>,
    /// Textures that are read: node and content.
    pub textures: Vec<(String, Texture)>,
    /// What is odd, but no error.
    pub warnings: Vec<Problem>,
}

/// A node, found and typed.
#[derive(Debug)]
pub struct CheckedNode {
    /// Its name.
    pub name: String,
    /// What it does.
    pub what: What,
    /// Which node of the text it is.
    pub number: usize,
    /// The loops that it is in: bit i is loop i.
    pub loops: u64,
    /// A word for people.
    pub comment: String,
}

/// What a node does.
#[derive(Debug)]
pub enum What {
    /// Calls a function.
    Call {
        /// The function.
        function: Function,
        /// Its arguments.
        arguments: Vec<Operand>,
        /// Which object it reads; of a scene with segments, of which technique it is.
        object: usize,
        /// Where it is computed.
        stage: Stage,
    },
    /// One of two.
    If {
        /// Which.
        condition: Operand,
        /// Name, type, then, else.
        outputs: Vec<(String, Type, Operand, Operand)>,
    },
    /// A loop.
    Loop {
        /// Its number.
        index: usize,
        /// Name, type, start, next.
        carry: Vec<(String, Type, Operand, Operand)>,
        /// Looked at before each turn.
        while_: Option<Operand>,
        /// Looked at after each turn.
        until: Option<Operand>,
    },
}

/// Where a value comes from.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Operand {
    /// A value that is known.
    Constant(Literal),
    /// Output `output` of a node, then members.
    Output(usize, usize, Vec<String>),
    /// A carried variable inside its loop.
    Carried(usize, usize, Vec<String>),
    /// A carried variable after its loop.
    Last(usize, usize, Vec<String>),
    /// A texture.
    Texture(usize),
}

/// A value: where it comes from, its type and meaning.
#[derive(Clone, Debug)]
struct Value {
    operand: Operand,
    ty: Type,
    meaning: Option<Meaning>,
}

/// Everything wrong with `graph`, or what it means. `objects` is how many objects the scene has,
/// `techniques` how many techniques its segments have; 0 if it has no segments.
pub fn check(
    graph: &Graph,
    patterns: &Patterns,
    objects: usize,
    techniques: usize,
) -> Result<CheckedGraph, Vec<Problem>> {
    let mut checker = Checker::new(graph, patterns, objects);
    checker.techniques = techniques;
    checker.number();
    // Of so many, nobody wants to know what else is wrong.
    checker.stop()?;
    checker.names();
    checker.problems.extend(crate::slicing::problems(graph));
    checker.problems.extend(crate::unread::unread(graph));
    checker.functions();
    checker.segments();
    // Without names and functions nothing can be found.
    checker.stop()?;
    checker.values();
    checker.stop()?;
    let order = checker.order();
    checker.stop()?;
    let loops = checker.loops(&order);
    checker.stop()?;
    Ok(checker.finish(&order, &loops))
}

struct Checker<'g> {
    graph: &'g Graph,
    patterns: &'g Patterns,
    objects: usize,
    techniques: usize,
    problems: Vec<Problem>,
    warnings: Vec<Problem>,
    by_name: HashMap<&'g str, usize>,
    functions: Vec<Option<Function>>,
    textures: Vec<(usize, Texture)>,
    /// The operands of each node, by the place of the key.
    nodes: Vec<Found>,
    roots: Vec<(String, Operand)>,
    loop_nodes: Vec<usize>,
    /// Outputs of anchors and ifs whose value is known: (node, output) → value.
    known: HashMap<(usize, usize), Value>,
}

/// What is found of a node.
#[derive(Clone, Debug, Default)]
struct Found {
    arguments: Vec<Operand>,
    condition: Option<Operand>,
    outputs: Vec<(String, Type, Operand, Operand)>,
    while_: Option<Operand>,
    until: Option<Operand>,
}

impl<'g> Checker<'g> {
    fn new(graph: &'g Graph, patterns: &'g Patterns, objects: usize) -> Checker<'g> {
        Checker {
            graph,
            patterns,
            objects,
            techniques: 0,
            problems: Vec::new(),
            warnings: Vec::new(),
            by_name: HashMap::new(),
            functions: Vec::new(),
            textures: Vec::new(),
            nodes: Vec::new(),
            roots: Vec::new(),
            loop_nodes: Vec::new(),
            known: HashMap::new(),
        }
    }

    fn stop(&mut self) -> Result<(), Vec<Problem>> {
        if self.problems.is_empty() {
            return Ok(());
        }
        Err(std::mem::take(&mut self.problems))
    }

    fn wrong(&mut self, place: impl Into<String>, why: impl Into<String>) {
        if self.problems.len() < MOST_PROBLEMS {
            self.problems.push(Problem::new(place, why));
        }
    }

    fn number(&mut self) {
        if self.graph.nodes.len() > MOST_NODES {
            let n = self.graph.nodes.len();
            self.wrong(
                "nodes",
                format!("{n} nodes; a graph has at most {MOST_NODES}"),
            );
        }
    }

    fn names(&mut self) {
        for (i, node) in self.graph.nodes.iter().enumerate() {
            let place = format!("nodes.{}", node.name);
            if let Err(why) = check_name(&node.name) {
                self.wrong(&place, why);
            } else if self.by_name.insert(&node.name, i).is_some() {
                self.wrong(&place, "there are two nodes of this name; rename one");
            }
        }
        if self.graph.roots.is_empty() {
            self.wrong(
                "roots",
                "nothing is wanted of this graph; a ray caster has the root `color`",
            );
        }
        let mut seen = Vec::new();
        for (name, _) in &self.graph.roots {
            if seen.contains(&name) {
                let place = format!("roots.{name}");
                self.problems
                    .push(Problem::new(place, "there are two roots of this name"));
            }
            seen.push(name);
        }
    }

    fn functions(&mut self) {
        for (i, node) in self.graph.nodes.iter().enumerate() {
            let place = format!("nodes.{}", node.name);
            let function = match &node.kind {
                Kind::Slot(slot) => functions::of_slot(slot).map(Some),
                Kind::Function(path) => functions::of_library(path).map(Some),
                Kind::Pattern(name) => self.patterns.function(name).map(Some),
                Kind::Wgsl(source) => {
                    functions::of_wgsl(&node.name, &format!("{place}.wgsl"), source).map(Some)
                }
                Kind::Uniform { ty, .. } => functions::of_uniform(ty).map(Some),
                Kind::Texture(texture) => {
                    self.textures.push((i, texture.clone()));
                    Ok(None)
                }
                Kind::Loop(_) => {
                    self.loop_nodes.push(i);
                    Ok(None)
                }
                Kind::Anchor | Kind::If => Ok(None),
                Kind::Group(_) => Err("a group is unfolded before a graph is checked".to_owned()),
            };
            match function {
                Ok(function) => {
                    if let Some(function) = &function {
                        self.parameters(node, function, &place);
                    }
                    self.functions.push(function);
                }
                Err(why) => {
                    self.wrong(&place, why);
                    self.functions.push(None);
                }
            }
            if node.object >= self.objects {
                let objects = self.objects;
                self.wrong(
                    format!("{place}.object"),
                    format!(
                        "object {}; the scene has {objects}, counted from 0",
                        node.object
                    ),
                );
            }
        }
        if self.textures.len() > MOST_TEXTURES {
            self.wrong(
                "nodes",
                format!(
                    "{} textures; a graph has at most {MOST_TEXTURES}",
                    self.textures.len()
                ),
            );
        }
        if self.loop_nodes.len() > MOST_LOOPS {
            self.wrong(
                "nodes",
                format!(
                    "{} loops; a graph has at most {MOST_LOOPS}",
                    self.loop_nodes.len()
                ),
            );
        }
    }

    /// That nodes fit a scene with segments, or one without.
    fn segments(&mut self) {
        let techniques = self.techniques;
        if techniques > 0 && self.graph.slicing.is_some() {
            self.wrong(
                "slicing",
                "slices cannot draw the segments of a label volume, whose runs lie along rays; remove `slicing`, or `labels` from the scene",
            );
        }
        for node in &self.graph.nodes {
            let place = format!("nodes.{}", node.name);
            if techniques == 0 && node.technique > 0 {
                self.wrong(
                    format!("{place}.technique"),
                    "the scene has no segments with techniques; remove this key, or give the scene `labels`",
                );
            } else if techniques > 0 && node.technique >= techniques {
                self.wrong(
                    format!("{place}.technique"),
                    format!(
                        "technique {}; the scene has {techniques}, counted from 0",
                        node.technique
                    ),
                );
            }
            let Kind::Pattern(name) = &node.kind else {
                continue;
            };
            if techniques == 0 && functions::OF_SEGMENTS.contains(&name.as_str()) {
                self.wrong(
                    place,
                    format!("the pattern `{name}` is for the segments of a scene; this one has none: give it `labels`"),
                );
            } else if techniques > 0 && functions::NOT_OF_SEGMENTS.contains(&name.as_str()) {
                self.wrong(
                    place,
                    format!("the pattern `{name}` cannot be used with segments; `graph show` prints the nodes that replace it"),
                );
            }
        }
    }

    fn parameters(&mut self, node: &Node, function: &Function, place: &str) {
        if let Kind::Uniform { value, .. } = &node.kind {
            let Call::Module(module) = &function.call else {
                return;
            };
            if let Err(why) = module.parameters()[0].check(value) {
                self.wrong(format!("{place}.uniform.value"), why);
            }
            return;
        }
        for (name, value) in &node.params {
            let place = format!("{place}.params.{name}");
            let Call::Module(module) = &function.call else {
                let settings = matches!(node.kind, Kind::Slot(_));
                self.wrong(
                    place,
                    if settings {
                        "the function of a slot has the parameters of the scene's settings; set it there, or name a function instead of a slot"
                    } else {
                        "this node has no parameters"
                    },
                );
                return;
            };
            let parameters = module.parameters();
            match parameters.iter().find(|p| p.name == *name) {
                Some(parameter) => {
                    if let Err(why) = parameter.check(value) {
                        self.wrong(place, why);
                    }
                }
                None => {
                    let names: Vec<_> = parameters.iter().map(|p| &*p.name).collect();
                    self.wrong(
                        place,
                        match names[..] {
                            [] => "this node has no parameters".to_owned(),
                            _ => format!("no such parameter; there are {}", names.join(", ")),
                        },
                    );
                }
            }
        }
    }

    /// The outputs of a node that has a function, or nothing.
    fn outputs(&self, node: usize) -> &[Port] {
        self.functions[node].as_ref().map_or(&[], |f| &f.outputs)
    }

    /// What `reference`, read at `place`, is.
    fn value(&mut self, reference: &Reference, place: &str) -> Option<Value> {
        match self.find(reference) {
            Ok(value) => Some(value),
            Err(why) => {
                self.wrong(place, why);
                None
            }
        }
    }

    fn node_of(&self, name: &str) -> Result<usize, String> {
        if let Some(found) = self.by_name.get(name) {
            return Ok(*found);
        }
        if self.problems.len() >= MOST_PROBLEMS {
            // Nobody will read it, and looking for what is near takes long in a large graph.
            return Err(String::new());
        }
        Err(match nearest(name, self.by_name.keys().copied()) {
            Some(near) => format!("there is no node `{name}`; did you mean `{near}`?"),
            None => {
                let anchors = self.by_name.keys().filter(|n| n.starts_with("after_"));
                let mut anchors: Vec<_> = anchors.map(|anchor| format!("`{anchor}`")).collect();
                anchors.sort();
                match anchors.is_empty() {
                    true => format!("there is no node `{name}`"),
                    false => format!(
                        "there is no node `{name}`; which nodes there are depends on the settings (method, shading, …); these anchors are there: {}",
                        anchors.join(", ")
                    ),
                }
            }
        })
    }

    /// Follows anchors and decided ifs to what computes the value. Each step is one of a chain, which is
    /// walked without recursion, as a file can make it as long as it likes.
    fn find(&mut self, reference: &Reference) -> Result<Value, String> {
        // What is looked for at the end, and the members taken of it on the way back, innermost last.
        let mut chain: Vec<((usize, usize), Vec<String>)> = Vec::new();
        let mut passed = HashSet::new();
        let mut at = reference.clone();
        let mut value = loop {
            let node = self.node_of(&at.node)?;
            let described = self.graph.nodes[node].name.as_str();
            let (step, members) = match &self.graph.nodes[node].kind {
                Kind::Anchor => {
                    let input = self.graph.nodes[node].reads("in");
                    let Some(input) = input else {
                        return Err(format!("the anchor `{described}` is not connected"));
                    };
                    ((node, 0, input.clone()), at.path.clone())
                }
                Kind::If => {
                    let Some((output, members)) = at.path.split_first() else {
                        return Err(format!(
                            "name an output of `{described}`: `{described}.NAME`"
                        ));
                    };
                    let this = &self.graph.nodes[node];
                    let names: Vec<_> = if_outputs(this);
                    let Some(index) = names.iter().position(|n| n == output) else {
                        return Err(format!(
                            "`{described}` has no output `{output}`; it has {}",
                            names.join(", ")
                        ));
                    };
                    let decided = match this.reads("if") {
                        Some(Input::Constant(Constant::Bool(truth))) => Some(*truth),
                        _ => None,
                    };
                    let branch = if decided == Some(false) {
                        "else"
                    } else {
                        "then"
                    };
                    let Some(input) = this.reads(&format!("{branch}.{output}")) else {
                        return Err(format!("`{described}` has no `{branch}.{output}`"));
                    };
                    // What is not decided has the type of either.
                    let input = match input {
                        Input::Constant(_) if decided.is_none() => {
                            this.reads(&format!("else.{output}")).unwrap_or(input)
                        }
                        _ => input,
                    };
                    ((node, index, input.clone()), members.to_vec())
                }
                Kind::Loop(region) => {
                    let (is_last, rest) = match at.path.split_first() {
                        Some((first, rest)) if first == "last" => (true, rest),
                        _ => (false, &at.path[..]),
                    };
                    let names: Vec<_> = region.carry.iter().map(|c| c.name.as_str()).collect();
                    let Some((variable, members)) = rest.split_first() else {
                        return Err(format!(
                            "name a variable of `{described}`: inside the loop `{described}.NAME`, outside `{described}.last.NAME`, with {}",
                            names.join(", ")
                        ));
                    };
                    let Some(index) = names.iter().position(|n| n == variable) else {
                        return Err(format!(
                            "the loop `{described}` has no variable `{variable}`; it carries {}",
                            names.join(", ")
                        ));
                    };
                    let carried = &region.carry[index];
                    let key = (node, 2 * index + usize::from(is_last));
                    let operand = if is_last {
                        Operand::Last(node, index, Vec::new())
                    } else {
                        Operand::Carried(node, index, Vec::new())
                    };
                    if let Some(ty) = &carried.ty {
                        let value = Value {
                            operand,
                            ty: Type::of(ty),
                            meaning: None,
                        };
                        break self.members(value, members)?;
                    }
                    match &carried.start {
                        Some(Input::From(start)) => {
                            if let Some(known) = self.known.get(&key).cloned() {
                                break self.members(known, members)?;
                            }
                            if !passed.insert(key) {
                                return Err(format!("`{reference}` reads itself"));
                            }
                            chain.push((key, members.to_vec()));
                            at = start.clone();
                            continue;
                        }
                        Some(Input::Constant(_)) => {
                            return Err(format!(
                                "the type of `{described}.{variable}` does not follow from a number; set `type`"
                            ));
                        }
                        None => {
                            return Err(format!(
                                "the loop variable `{described}.{variable}` has no initial value; set `start`"
                            ));
                        }
                    }
                }
                Kind::Texture(_) => {
                    let index = self.textures.iter().position(|(n, _)| *n == node);
                    if !at.path.is_empty() {
                        return Err(format!("`{described}` is a texture, which has no members"));
                    }
                    break Value {
                        operand: Operand::Texture(index.unwrap_or(0)),
                        ty: Type::Texture,
                        meaning: None,
                    };
                }
                _ => {
                    let outputs = self.outputs(node);
                    let named = at.path.first().and_then(|first| {
                        let found = outputs.iter().position(|port| port.name == *first)?;
                        Some((found, &at.path[1..]))
                    });
                    let (index, members) = match (named, outputs) {
                        (Some(found), _) => found,
                        (None, [_]) => (0, &at.path[..]),
                        (None, _) => {
                            let names: Vec<_> = outputs.iter().map(|p| p.name.as_str()).collect();
                            let names = names.join(", ");
                            return Err(match at.path.first() {
                                Some(wrong) => {
                                    format!("`{described}` has no output `{wrong}`; it has {names}")
                                }
                                None => {
                                    format!("name an output of `{described}`: it has {names}")
                                }
                            });
                        }
                    };
                    let port = &outputs[index];
                    let value = Value {
                        operand: Operand::Output(node, index, Vec::new()),
                        ty: port.ty.clone(),
                        meaning: port.meaning,
                    };
                    break self.members(value, members)?;
                }
            };
            let (node, index, input) = step;
            if let Some(known) = self.known.get(&(node, index)).cloned() {
                break self.members(known, &members)?;
            }
            if !passed.insert((node, index)) {
                return Err(format!("`{reference}` reads itself, through `{described}`"));
            }
            chain.push(((node, index), members));
            match input {
                Input::From(next) => at = next,
                Input::Constant(constant) => {
                    break match &constant {
                        Constant::Bool(truth) => Value {
                            operand: Operand::Constant(Literal::truth(*truth)),
                            ty: Type::BOOL,
                            meaning: None,
                        },
                        Constant::Numbers(numbers) => {
                            let ty = Type::Vector(Scalar::F32, numbers.len());
                            Value {
                                operand: Operand::Constant(Literal::of(&constant, &ty)?),
                                ty,
                                meaning: None,
                            }
                        }
                    };
                }
            }
        };
        // Back along the chain.
        for (key, members) in chain.into_iter().rev() {
            let (node, output) = key;
            let is_decided = match &self.graph.nodes[node].kind {
                Kind::Anchor => true,
                Kind::If => matches!(
                    self.graph.nodes[node].reads("if"),
                    Some(Input::Constant(Constant::Bool(_)))
                ),
                _ => false,
            };
            if !is_decided {
                value.operand = match &self.graph.nodes[node].kind {
                    Kind::Loop(_) if output % 2 == 1 => Operand::Last(node, output / 2, Vec::new()),
                    Kind::Loop(_) => Operand::Carried(node, output / 2, Vec::new()),
                    _ => Operand::Output(node, output, Vec::new()),
                };
                if matches!(self.graph.nodes[node].kind, Kind::Loop(_)) {
                    // What a loop starts with need not be what it goes on with.
                    value.meaning = None;
                }
            }
            self.known.insert(key, value.clone());
            value = self.members(value, &members)?;
        }
        Ok(value)
    }

    fn members(&self, mut value: Value, members: &[String]) -> Result<Value, String> {
        for member in members {
            let Some((ty, meaning)) = value.ty.member(member) else {
                let known = value.ty.members();
                return Err(match known[..] {
                    [] => format!("a {} has no member `{member}`", value.ty),
                    _ => format!(
                        "a {} has no member `{member}`; it has {}",
                        value.ty,
                        known.join(", ")
                    ),
                });
            };
            // All components of a color are still that color.
            if !(ty == value.ty || (member == "rgb" && meaning.is_none())) {
                value.meaning = meaning;
            }
            value.ty = ty;
            match &mut value.operand {
                Operand::Output(_, _, path)
                | Operand::Carried(_, _, path)
                | Operand::Last(_, _, path) => {
                    path.push(member.clone());
                }
                Operand::Constant(literal) => *literal = literal.components(member),
                Operand::Texture(_) => {}
            }
        }
        Ok(value)
    }

    /// What `input` is as a value of `port`.
    fn fitting(&mut self, input: &Input, port: &Port, place: &str) -> Option<Operand> {
        match input {
            Input::Constant(constant) => match Literal::of(constant, &port.ty) {
                Ok(literal) => Some(Operand::Constant(literal)),
                Err(why) => {
                    self.wrong(place, why);
                    None
                }
            },
            Input::From(reference) => {
                let value = self.value(reference, place)?;
                // A number whose type nobody has told takes that of the port.
                if let Operand::Constant(literal) = &value.operand
                    && value.ty != port.ty
                    && let Some(number) = literal.as_float()
                    && let constant = Constant::Numbers(vec![f64::from(number)])
                    && let Ok(literal) = Literal::of(&constant, &port.ty)
                {
                    return Some(Operand::Constant(literal));
                }
                if value.ty != port.ty {
                    self.wrong(
                        place,
                        format!(
                            "`{reference}` is {}, but `{}` needs {}",
                            value.ty, port.name, port.ty
                        ),
                    );
                    return None;
                }
                if let (Some(found), Some(wanted)) = (value.meaning, port.meaning)
                    && found != wanted
                {
                    let hint = match wanted.conversion_from(found) {
                        Some(pattern) => format!("; the pattern `{pattern}` makes it so"),
                        None => String::new(),
                    };
                    self.wrong(
                        place,
                        format!(
                            "`{reference}` is {found}, and `{}` takes {wanted}{hint}",
                            port.name
                        ),
                    );
                    return None;
                }
                Some(value.operand)
            }
        }
    }

    fn values(&mut self) {
        for i in 0..self.graph.nodes.len() {
            let node = &self.graph.nodes[i];
            let place = format!("nodes.{}", node.name);
            let mut found = Found::default();
            match &node.kind {
                Kind::Loop(_) => found = self.loop_values(i, &place),
                Kind::If => found = self.if_values(i, &place),
                Kind::Anchor => {
                    if node.reads("in").is_some() {
                        self.value(&Reference::new(&node.name), &format!("{place}.inputs.in"));
                    } else {
                        self.wrong(
                            &place,
                            "an anchor has one input, `in`, which has to be connected",
                        );
                    }
                    self.no_other_inputs(node, &["in"], &place);
                }
                Kind::Texture(_) => self.no_other_inputs(node, &[], &place),
                _ => {
                    if let Some(function) = self.functions[i].clone() {
                        found.arguments = self.arguments(node, &function, &place);
                    }
                }
            }
            self.nodes.push(found);
        }
        for (name, reference) in &self.graph.roots {
            let place = format!("roots.{name}");
            let wanted = match name.as_str() {
                "color" => Some("vec4f"),
                "depth_mm" => Some("f32"),
                _ => None,
            };
            let Some(wanted) = wanted else {
                if self.graph.inputs.is_empty() {
                    self.wrong(place, "no such root; there are `color` (vec4f, premultiplied) and `depth_mm` (f32)");
                }
                continue;
            };
            if let Some(value) = self.value(reference, &place) {
                if value.ty != Type::of(wanted) {
                    self.wrong(
                        place,
                        format!("`{reference}` is {}, but the root needs {wanted}", value.ty),
                    );
                }
                self.roots.push((name.clone(), value.operand));
            }
        }
    }

    fn no_other_inputs(&mut self, node: &Node, known: &[&str], place: &str) {
        for (name, _) in &node.inputs {
            if !known.contains(&name.as_str()) {
                let hint = match nearest(name, known.iter().copied()) {
                    Some(near) => format!("; did you mean `{near}`?"),
                    None if known.is_empty() => "; it has none".to_owned(),
                    None => format!("; it has {}", known.join(", ")),
                };
                self.wrong(
                    format!("{place}.inputs.{name}"),
                    format!("the node has no such input{hint}"),
                );
            }
        }
        let mut seen = Vec::new();
        for (name, _) in &node.inputs {
            if seen.contains(&name) {
                self.wrong(
                    format!("{place}.inputs.{name}"),
                    "connected twice; an input reads one output",
                );
            }
            seen.push(name);
        }
    }

    fn arguments(&mut self, node: &Node, function: &Function, place: &str) -> Vec<Operand> {
        let names: Vec<_> = function.inputs.iter().map(|p| p.name.as_str()).collect();
        self.no_other_inputs(node, &names, place);
        let mut arguments = Vec::new();
        for port in &function.inputs {
            let place = format!("{place}.inputs.{}", port.name);
            let operand = match (node.reads(&port.name), &port.default) {
                (Some(input), _) => self.fitting(input, port, &place),
                (None, Some(default)) => {
                    self.fitting(&Input::Constant(default.clone()), port, &place)
                }
                (None, None) => {
                    self.wrong(
                        place,
                        format!("not connected, and it has no default; it needs {}", port.ty),
                    );
                    None
                }
            };
            arguments.push(operand.unwrap_or(Operand::Constant(Literal(Vec::new()))));
        }
        arguments
    }

    fn if_values(&mut self, i: usize, place: &str) -> Found {
        let node = &self.graph.nodes[i];
        let outputs = if_outputs(node);
        let mut known = vec!["if".to_owned()];
        for output in &outputs {
            known.push(format!("then.{output}"));
            known.push(format!("else.{output}"));
        }
        let known: Vec<_> = known.iter().map(String::as_str).collect();
        self.no_other_inputs(node, &known, place);
        let mut found = Found::default();
        let condition = Port {
            name: "if".into(),
            ty: Type::BOOL,
            meaning: None,
            default: None,
            comment: String::new(),
        };
        match node.reads("if") {
            Some(input) => {
                found.condition = self.fitting(input, &condition, &format!("{place}.inputs.if"));
            }
            None => self.wrong(
                place,
                "an `if` has the input `if`, which has to be connected",
            ),
        }
        if outputs.is_empty() {
            self.wrong(
                place,
                "an `if` has at least one output X: inputs `then.X` and `else.X`",
            );
        }
        for output in outputs {
            let reference = Reference::new(&format!("{}.{output}", node.name));
            let Some(value) = self.value(&reference, &format!("{place}.inputs.then.{output}"))
            else {
                continue;
            };
            let mut operands = Vec::new();
            for branch in ["then", "else"] {
                let key = format!("{branch}.{output}");
                let port = Port {
                    name: key.clone(),
                    ty: value.ty.clone(),
                    meaning: value.meaning,
                    default: None,
                    comment: String::new(),
                };
                let place = format!("{place}.inputs.{key}");
                match node.reads(&key) {
                    Some(input) => operands.extend(self.fitting(input, &port, &place)),
                    None => self.wrong(place, "missing: both branches give every output"),
                }
            }
            if let Ok([then, other]) = <[Operand; 2]>::try_from(operands) {
                found.outputs.push((output, value.ty, then, other));
            }
        }
        found
    }

    fn loop_values(&mut self, i: usize, place: &str) -> Found {
        let node = &self.graph.nodes[i];
        let Kind::Loop(region) = &node.kind else {
            return Found::default();
        };
        self.no_other_inputs(node, &[], place);
        let mut found = Found::default();
        if region.while_.is_none() && region.until.is_none() {
            self.wrong(
                format!("{place}.loop"),
                "the loop never ends; set `while` or `until`",
            );
        }
        let mut seen: Vec<&str> = Vec::new();
        for carried in &region.carry {
            let place = format!("{place}.loop.carry.{}", carried.name);
            if let Err(why) = check_name(&carried.name) {
                self.wrong(&place, why);
                continue;
            }
            if carried.name == "last" || seen.contains(&carried.name.as_str()) {
                self.wrong(&place, "the name is taken; choose another one");
                continue;
            }
            seen.push(&carried.name);
            let inside = Reference::new(&format!("{}.{}", node.name, carried.name));
            let Some(start) = &carried.start else {
                self.wrong(&place, "no initial value; set `start`");
                continue;
            };
            let Some(value) = self.value(&inside, &place) else {
                continue;
            };
            if matches!(value.ty, Type::Other(_) | Type::Texture | Type::Own(_)) {
                self.wrong(format!("{place}.type"), format!("a loop cannot carry a {}; it carries numbers, vectors and Surface, Light, Ray, Sample", value.ty));
                continue;
            }
            let port = |key: &str| Port {
                name: key.to_owned(),
                ty: value.ty.clone(),
                meaning: None,
                default: None,
                comment: String::new(),
            };
            let first = self.fitting(start, &port("start"), &format!("{place}.start"));
            let next = match &carried.next {
                Some(next) => Some(next.clone()),
                None => self.carried_by_name(i, &carried.name, &place),
            };
            let Some(next) = next else { continue };
            let next = self.fitting(&next, &port("next"), &format!("{place}.next"));
            if let (Some(first), Some(next)) = (first, next) {
                found
                    .outputs
                    .push((carried.name.clone(), value.ty, first, next));
            }
        }
        let truth = |key: &str| Port {
            name: key.to_owned(),
            ty: Type::BOOL,
            meaning: None,
            default: None,
            comment: String::new(),
        };
        if let Some(reference) = &region.while_ {
            let input = Input::From(reference.clone());
            found.while_ = self.fitting(&input, &truth("while"), &format!("{place}.loop.while"));
        }
        if let Some(reference) = &region.until {
            let input = Input::From(reference.clone());
            found.until = self.fitting(&input, &truth("until"), &format!("{place}.loop.until"));
        }
        found
    }

    /// The output of this name of the only node that has one.
    fn carried_by_name(&mut self, of: usize, name: &str, place: &str) -> Option<Input> {
        let mut found = Vec::new();
        for (i, node) in self.graph.nodes.iter().enumerate() {
            let has = match &node.kind {
                Kind::If => if_outputs(node).iter().any(|output| output == name),
                _ => self.outputs(i).iter().any(|port| port.name == name),
            };
            if has && i != of {
                found.push(node.name.clone());
            }
        }
        match &found[..] {
            [one] => Some(Input::From(Reference::new(&format!("{one}.{name}")))),
            [] => {
                self.wrong(
                    place,
                    format!("no next value: set `next`, or add a node with the output `{name}`"),
                );
                None
            }
            several => {
                self.wrong(
                    place,
                    format!(
                        "no next value, and several nodes have the output `{name}`: {}; set `next`",
                        several.join(", ")
                    ),
                );
                None
            }
        }
    }

    /// What a node reads: vertices of the dependency graph. Vertex 2·i is node i (of a loop: its end), 2·i + 1
    /// the beginning of loop i.
    fn reads(&self, vertex: usize) -> Vec<usize> {
        let node = vertex / 2;
        let found = &self.nodes[node];
        let mut reads = Vec::new();
        let mut read = |operand: &Operand| match operand {
            Operand::Output(n, ..) | Operand::Last(n, ..) => reads.push(2 * n),
            Operand::Carried(n, ..) => reads.push(2 * n + 1),
            Operand::Constant(_) | Operand::Texture(_) => {}
        };
        match (&self.graph.nodes[node].kind, vertex % 2) {
            (Kind::Loop(_), 1) => found
                .outputs
                .iter()
                .for_each(|(_, _, start, _)| read(start)),
            (Kind::Loop(_), _) => {
                for (_, _, _, next) in &found.outputs {
                    read(next);
                }
                found.while_.iter().chain(&found.until).for_each(&mut read);
                reads.push(vertex + 1);
            }
            (Kind::If, _) => {
                found.condition.iter().for_each(&mut read);
                for (_, _, then, other) in &found.outputs {
                    read(then);
                    read(other);
                }
            }
            _ => found.arguments.iter().for_each(read),
        }
        reads
    }

    /// The vertices that roots need, sources first; ties in the order of the text.
    fn order(&mut self) -> Vec<usize> {
        let mut needed = vec![false; 2 * self.graph.nodes.len()];
        let mut open: Vec<usize> = Vec::new();
        for (_, operand) in &self.roots {
            match operand {
                Operand::Output(n, ..) | Operand::Last(n, ..) => open.push(2 * n),
                Operand::Carried(n, ..) => open.push(2 * n + 1),
                _ => {}
            }
        }
        while let Some(vertex) = open.pop() {
            if std::mem::replace(&mut needed[vertex], true) {
                continue;
            }
            if vertex % 2 == 1 {
                // Inside a loop is its end as well: somebody has to close it.
                open.push(vertex - 1);
            }
            open.extend(self.reads(vertex));
        }
        let mut waiting = vec![0usize; needed.len()];
        let mut readers: Vec<Vec<usize>> = vec![Vec::new(); needed.len()];
        for vertex in (0..needed.len()).filter(|v| needed[*v]) {
            for read in self.reads(vertex) {
                readers[read].push(vertex);
                waiting[vertex] += 1;
            }
        }
        let mut ready: std::collections::BTreeSet<usize> = (0..needed.len())
            .filter(|v| needed[*v] && waiting[*v] == 0)
            .collect();
        let mut order = Vec::new();
        while let Some(vertex) = ready.pop_first() {
            order.push(vertex);
            for reader in &readers[vertex] {
                waiting[*reader] -= 1;
                if waiting[*reader] == 0 {
                    ready.insert(*reader);
                }
            }
        }
        if let Some(stuck) = (0..needed.len()).find(|v| needed[*v] && waiting[*v] > 0) {
            // From anything that waits, sources that wait lead into a circle.
            let mut path = vec![stuck];
            loop {
                let last = path[path.len() - 1];
                let Some(next) = self.reads(last).into_iter().find(|v| waiting[*v] > 0) else {
                    break;
                };
                if let Some(start) = path.iter().position(|v| *v == next) {
                    path.drain(..start);
                    break;
                }
                path.push(next);
            }
            let names: Vec<_> = path
                .iter()
                .rev()
                .map(|v| self.graph.nodes[v / 2].name.as_str())
                .collect();
            let first = names[0].to_owned();
            let shown: Vec<_> = names.iter().take(12).copied().collect();
            let more = if names.len() > 12 { " → …" } else { "" };
            let text = format!(
                "nodes read one another in a circle: {}{more} → {first}; what goes round belongs into a loop's carried variable",
                shown.join(" → ")
            );
            self.wrong(format!("nodes.{first}"), text);
        }
        let known: std::collections::HashSet<_> = self.known.keys().map(|(n, _)| *n).collect();
        for (i, node) in self.graph.nodes.iter().enumerate() {
            let is_silent = matches!(
                node.kind,
                Kind::Anchor | Kind::Uniform { .. } | Kind::Texture(_)
            );
            let is_known = known.contains(&i) && matches!(node.kind, Kind::If);
            if !needed[2 * i] && !is_silent && !is_known {
                self.warnings.push(Problem::new(
                    format!("nodes.{}", node.name),
                    "no root needs it; it is left out",
                ));
            }
        }
        self.senseless(&order);
        order
    }

    /// Warns of nodes that light by a normal which comes from no gradient. What one's own WGSL makes may be
    /// anything.
    fn senseless(&mut self, order: &[usize]) {
        let is_source = |i: usize| {
            let calls = |function: &Function| match &function.call {
                Call::Module(module) => module.needs().contains(&"gradient"),
                Call::Name(name) => *name == "gradient",
            };
            let gives = |function: &Function| {
                let is_gradient = |port: &Port| port.meaning == Some(Meaning::Gradient);
                function.outputs.iter().any(is_gradient)
            };
            let function = self.functions[i].as_ref();
            matches!(
                self.graph.nodes[i].kind,
                Kind::Wgsl(_) | Kind::Uniform { .. }
            ) || function.is_some_and(|f| calls(f) || gives(f))
        };
        // Which vertices know a gradient. What a loop carries it may know from the turn before.
        let mut knows = vec![false; 2 * self.graph.nodes.len()];
        for _ in 0..2 {
            for &vertex in order {
                let is_carried = vertex % 2 == 1 && knows[vertex - 1];
                knows[vertex] = is_carried
                    || is_source(vertex / 2)
                    || self.reads(vertex).into_iter().any(|read| knows[read]);
            }
        }
        let mut found = Vec::new();
        for vertex in order {
            let (i, node) = (vertex / 2, &self.graph.nodes[vertex / 2]);
            let Some(function) = self.functions[i].as_ref() else {
                continue;
            };
            let lights = function
                .inputs
                .iter()
                .position(|port| port.name == "normal" && port.meaning == Some(Meaning::Direction));
            let Some(operand) = lights.and_then(|port| self.nodes[i].arguments.get(port)) else {
                continue;
            };
            let has_gradient = match operand {
                Operand::Output(n, ..) | Operand::Last(n, ..) => knows[2 * n],
                Operand::Carried(n, ..) => knows[2 * n + 1],
                _ => false,
            };
            if !has_gradient {
                found.push(Problem::new(
                    format!("nodes.{}.inputs.normal", node.name),
                    "it lights by a normal that no gradient makes; connect `normal_of_gradient` of the gradient",
                ));
            }
        }
        self.warnings.extend(found);
    }

    /// The loops that each node is in.
    fn loops(&mut self, order: &[usize]) -> Vec<u64> {
        let bit = |node: usize| {
            self.loop_nodes
                .iter()
                .position(|n| *n == node)
                .map_or(0, |b| 1u64 << b)
        };
        // The loops around each loop.
        let mut outer: BTreeMap<usize, u64> = self.loop_nodes.iter().map(|n| (*n, 0)).collect();
        let mut of = vec![0u64; 2 * self.graph.nodes.len()];
        loop {
            let mut is_changed = false;
            for &vertex in order {
                let node = vertex / 2;
                let reads = self.reads(vertex);
                let union = reads.iter().fold(0, |all, read| all | of[*read]);
                let is_loop = matches!(self.graph.nodes[node].kind, Kind::Loop(_));
                if !is_loop {
                    of[vertex] = union;
                    continue;
                }
                let around = outer.entry(node).or_default();
                let found = *around | (union & !bit(node));
                if found != *around {
                    *around = found;
                    is_changed = true;
                }
                of[vertex] = if vertex % 2 == 1 {
                    found | bit(node)
                } else {
                    found
                };
            }
            if !is_changed {
                break;
            }
        }
        // A set of loops is one in which each is around the next.
        let is_nest = |set: u64| {
            set == 0
                || outer.iter().any(|(node, around)| {
                    set & bit(*node) != 0 && around & bit(*node) == 0 && around | bit(*node) == set
                })
        };
        let names = |set: u64| -> Vec<&str> {
            let of_set = self.loop_nodes.iter().filter(|n| set & bit(**n) != 0);
            of_set.map(|n| self.graph.nodes[*n].name.as_str()).collect()
        };
        let mut problems = Vec::new();
        for (node, around) in &outer {
            let (a, name) = (bit(*node), &self.graph.nodes[*node].name);
            for (other, around_other) in &outer {
                let b = bit(*other);
                if other > node && around & b != 0 && around_other & a != 0 {
                    let second = &self.graph.nodes[*other].name;
                    problems.push(Problem::new(
                        format!("nodes.{name}.loop"),
                        format!("the loops `{name}` and `{second}` are each inside the other; outside a loop its variables are read as NAME.last.VARIABLE"),
                    ));
                }
            }
        }
        if problems.is_empty() {
            for &vertex in order {
                if !is_nest(of[vertex]) {
                    problems.push(Problem::new(
                        format!("nodes.{}", self.graph.nodes[vertex / 2].name),
                        format!(
                            "it reads variables of loops of which none is in the other: {}; outside a loop they are read as NAME.last.VARIABLE",
                            names(of[vertex]).join(", ")
                        ),
                    ));
                }
            }
        }
        for (name, operand) in &self.roots {
            let set = match operand {
                Operand::Output(n, ..) | Operand::Last(n, ..) => of[2 * n],
                Operand::Carried(n, ..) => of[2 * n + 1],
                _ => 0,
            };
            if set != 0 {
                let path = self.path_into(operand, &of);
                problems.push(Problem::new(
                    format!("roots.{name}"),
                    format!(
                        "it reads what changes inside the loop {}: {path}; outside a loop its variables are read as NAME.last.VARIABLE",
                        names(set).join(", ")
                    ),
                ));
            }
        }
        self.problems
            .extend(problems.into_iter().take(MOST_PROBLEMS));
        of
    }

    /// How a value depends on a loop: names from the loop to the reader.
    fn path_into(&self, operand: &Operand, of: &[u64]) -> String {
        let mut at = match operand {
            Operand::Output(n, ..) | Operand::Last(n, ..) => 2 * n,
            Operand::Carried(n, ..) => 2 * n + 1,
            _ => return String::new(),
        };
        let mut path = vec![self.graph.nodes[at / 2].name.as_str()];
        while at % 2 == 0 && path.len() < 100 {
            let Some(next) = self.reads(at).into_iter().find(|read| of[*read] != 0) else {
                break;
            };
            path.push(&self.graph.nodes[next / 2].name);
            at = next;
        }
        path.reverse();
        path.join(" → ")
    }

    /// What roots need, in a list of its own.
    fn finish(&mut self, order: &[usize], loops: &[u64]) -> CheckedGraph {
        let mut number: HashMap<usize, usize> = HashMap::new();
        let mut nodes: Vec<CheckedNode> = Vec::new();
        // Loops are named before what is in them is: their place is their end.
        let ends: Vec<usize> = order.iter().copied().filter(|v| v % 2 == 0).collect();
        for vertex in &ends {
            number.insert(vertex / 2, number.len());
        }
        let moved = |operand: &Operand| {
            let to = |n: &usize| number.get(n).copied().unwrap_or(0);
            match operand {
                Operand::Output(n, o, p) => Operand::Output(to(n), *o, p.clone()),
                Operand::Carried(n, v, p) => Operand::Carried(to(n), *v, p.clone()),
                Operand::Last(n, v, p) => Operand::Last(to(n), *v, p.clone()),
                other => other.clone(),
            }
        };
        for vertex in &ends {
            let node = vertex / 2;
            let this = &self.graph.nodes[node];
            let found = &self.nodes[node];
            let four = |list: &[(String, Type, Operand, Operand)]| -> Vec<_> {
                let moved = |(n, t, a, b): &(String, Type, Operand, Operand)| {
                    (n.clone(), t.clone(), moved(a), moved(b))
                };
                list.iter().map(moved).collect()
            };
            let what = match (&this.kind, &self.functions[node]) {
                (Kind::Loop(_), _) => What::Loop {
                    index: self.loop_nodes.iter().position(|n| *n == node).unwrap_or(0),
                    carry: four(&found.outputs),
                    while_: found.while_.as_ref().map(&moved),
                    until: found.until.as_ref().map(&moved),
                },
                (Kind::If, _) => What::If {
                    condition: found
                        .condition
                        .as_ref()
                        .map_or(Operand::Constant(Literal::truth(false)), &moved),
                    outputs: four(&found.outputs),
                },
                (_, Some(function)) => What::Call {
                    function: function.clone(),
                    arguments: found.arguments.iter().map(&moved).collect(),
                    object: if self.techniques > 0 {
                        this.technique
                    } else {
                        this.object
                    },
                    stage: this.stage,
                },
                (_, None) => continue,
            };
            nodes.push(CheckedNode {
                name: this.name.clone(),
                what,
                number: node,
                loops: loops[*vertex],
                comment: this.comment.clone(),
            });
        }
        CheckedGraph {
            nodes,
            roots: self
                .roots
                .iter()
                .map(|(n, o)| (n.clone(), moved(o)))
                .collect(),
            textures: (self.textures.iter())
                .map(|(n, t)| (self.graph.nodes[*n].name.clone(), t.clone()))
                .collect(),
            warnings: std::mem::take(&mut self.warnings),
        }
    }
}

/// The outputs of an `if`, in the order of its inputs.
fn if_outputs(node: &Node) -> Vec<String> {
    let mut outputs: Vec<String> = Vec::new();
    for (name, _) in &node.inputs {
        let output = name
            .strip_prefix("then.")
            .or_else(|| name.strip_prefix("else."));
        if let Some(output) = output
            && !outputs.iter().any(|o| o == output)
        {
            outputs.push(output.to_owned());
        }
    }
    outputs
}

/// Whether a node or variable can be called so.
pub(crate) fn check_name(name: &str) -> Result<(), String> {
    let mut letters = name.chars();
    let begins = letters.next().is_some_and(|c| c.is_ascii_alphabetic());
    if !begins || !letters.all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Err("a name has letters, digits and `_`, and begins with a letter".to_owned());
    }
    if name.len() > 100 {
        return Err("the name has more than 100 letters".to_owned());
    }
    if naga::keywords::wgsl::RESERVED.contains(&name) {
        return Err(format!("`{name}` is a word of WGSL; choose another name"));
    }
    Ok(())
}
