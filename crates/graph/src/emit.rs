//! From a checked graph to WGSL.
//!
//! Each node goes where it is computed least: into the innermost place that all its readers share, but out of
//! every loop on which it does not depend (C. Click, Global Code Motion / Global Value Numbering, 1995; here
//! nodes have no side effects, and a place is always found from the readers down). What only one branch of an
//! `if` reads is computed in that branch. In one place nodes come by their longest path to a root, the longest
//! first, so that nodes of one stage stand together; ties in the order of the text.

use crate::check::{CheckedGraph, Operand, What};
use crate::error::Problem;
use crate::functions::{Call, RAY};
use crate::model::{Interpolation, Stage};
use crate::types::{Scalar, Type};
use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::sync::Arc;
use strahl_program::Order;
use strahl_shader::{MOST_TURNS, Module, RayLoop, Techniques, bindings, surrounding_words};

/// `if` and loops in one another. Compilers read programs by recursion.
const DEEPEST: usize = 48;

/// Outputs of the vertex stage.
const MOST_VARYINGS: usize = 12;

/// A graph as WGSL.
#[derive(Debug)]
pub struct EmittedProgram {
    /// `fn march`, with what it declares.
    pub march: String,
    /// The functions that it calls, by their names.
    pub functions: Vec<(String, Arc<Module>)>,
    /// Entry points, if nodes are computed in the vertex stage or it is drawn by slices.
    pub entry: Option<String>,
    /// Nodes whose functions have parameters, and what those are called.
    pub nodes: Vec<(String, String)>,
}

/// A function and what it is called.
type Labeled = (String, Arc<Module>);

/// A place in the program.
struct Place {
    parent: Option<usize>,
    depth: usize,
    /// The loop whose body it is.
    body_of: Option<usize>,
    /// The node that it belongs to.
    owner: usize,
}

struct Emitter<'c> {
    graph: &'c CheckedGraph,
    what: &'c RayLoop,
    places: Vec<Place>,
    /// Where each node is computed.
    place: Vec<usize>,
    /// The nodes of each place, in their order.
    nodes_of: Vec<Vec<usize>>,
    /// Places inside a node: then and else, or the body.
    inner: HashMap<usize, [usize; 2]>,
    depth: Vec<usize>,
    names: HashSet<String>,
    /// Names of a node's variables: one for a call, one per output else.
    locals: Vec<Vec<String>>,
    labels: Vec<String>,
    textures: Vec<String>,
    text: String,
    current: Option<usize>,
    turns: Option<String>,
}

/// Writes `graph` for what is drawn: along rays, or a slice of so many that come in this order.
pub fn emit(
    graph: &CheckedGraph,
    what: &RayLoop,
    slices: Option<Order>,
) -> Result<EmittedProgram, Vec<Problem>> {
    let mut emitter = Emitter {
        graph,
        what,
        places: vec![Place {
            parent: None,
            depth: 0,
            body_of: None,
            owner: usize::MAX,
        }],
        place: vec![0; graph.nodes.len()],
        nodes_of: Vec::new(),
        inner: HashMap::new(),
        depth: vec![0; graph.nodes.len()],
        names: surrounding_words()
            .iter()
            .map(|w| (*w).to_owned())
            .collect(),
        locals: Vec::new(),
        labels: Vec::new(),
        textures: Vec::new(),
        text: String::new(),
        current: None,
        turns: None,
    };
    emitter.find_places()?;
    let vertex = emitter.vertex_nodes()?;
    let (functions, nodes) = emitter.name();
    for (i, name) in emitter.textures.clone().iter().enumerate() {
        let binding = bindings::FIRST_TEXTURE + i as u32;
        emitter.line(
            0,
            &format!("@group(0) @binding({binding}) var {name}: texture_2d<f32>;"),
        );
    }
    let has_entry = !vertex.is_empty() || slices.is_some();
    let entry = has_entry.then(|| emitter.entry(&vertex, slices));
    let needs_turns = (graph.nodes.iter().enumerate())
        .any(|(i, node)| matches!(node.what, What::Loop { .. }) && !emitter.ends_by_itself(i));
    if needs_turns {
        let name = emitter.unique("turns_of_graph");
        emitter.line(0, &format!("// Loops that need not end by themselves end together after {MOST_TURNS} turns per ray.\nvar<private> {name}: u32 = 0u;\n"));
        emitter.turns = Some(name);
    }
    emitter.line(0, "fn march(pixel: vec2u) -> vec4f {");
    emitter.block(0, 1);
    let root = |name: &str| graph.roots.iter().find(|(n, _)| n == name);
    if let Some((_, depth)) = root("depth_mm") {
        let text = emitter.operand(depth);
        emitter.line(1, &format!("hit_mm = {text};"));
    }
    let color = root("color").map_or("vec4f(0.0)".to_owned(), |(_, color)| emitter.operand(color));
    if let Some(turns) = &emitter.turns {
        // What a stopped loop gives is not what the graph says. It must not look like a picture.
        let stopped = format!(
            "if {turns} > {MOST_TURNS}u {{\n    // Not a number.\n    return vec4f(bitcast<f32>({turns} | 0x7fc00000u));\n}}"
        );
        emitter.line(1, &stopped);
    }
    emitter.line(1, &format!("return {color};"));
    emitter.line(0, "}");
    Ok(EmittedProgram {
        march: emitter.text,
        functions,
        entry,
        nodes,
    })
}

fn is_vertex(what: &What) -> bool {
    matches!(
        what,
        What::Call {
            stage: Stage::Vertex(_),
            ..
        }
    )
}

impl Emitter<'_> {
    fn common(&self, mut a: usize, mut b: usize) -> usize {
        while a != b {
            if self.places[a].depth < self.places[b].depth {
                b = self.places[b].parent.unwrap_or(0);
            } else {
                a = self.places[a].parent.unwrap_or(0);
            }
        }
        a
    }

    fn find_places(&mut self) -> Result<(), Vec<Problem>> {
        let mut used: Vec<Option<usize>> = vec![None; self.graph.nodes.len()];
        for (_, operand) in &self.graph.roots {
            if let Operand::Output(n, ..) | Operand::Last(n, ..) = operand {
                used[*n] = Some(0);
            }
        }
        for i in (0..self.graph.nodes.len()).rev() {
            let node = &self.graph.nodes[i];
            let mut place = used[i].unwrap_or(0);
            let mut at = Some(place);
            while let Some(p) = at {
                at = self.places[p].parent;
                // Out of a loop on which it does not depend.
                if let Some(index) = self.places[p].body_of
                    && node.loops >> index & 1 == 0
                {
                    place = at.unwrap_or(0);
                }
            }
            self.place[i] = place;
            let new = |body_of: Option<usize>, places: &mut Vec<Place>| {
                let depth = places[place].depth + 1;
                places.push(Place {
                    parent: Some(place),
                    depth,
                    body_of,
                    owner: i,
                });
                places.len() - 1
            };
            let mut reads: Vec<(Operand, usize)> = Vec::new();
            match &node.what {
                What::Call { arguments, .. } => {
                    reads.extend(arguments.iter().map(|a| (a.clone(), place)));
                }
                What::If { condition, outputs } => {
                    let then = new(None, &mut self.places);
                    let other = new(None, &mut self.places);
                    self.inner.insert(i, [then, other]);
                    reads.push((condition.clone(), place));
                    for (_, _, a, b) in outputs {
                        reads.push((a.clone(), then));
                        reads.push((b.clone(), other));
                    }
                }
                What::Loop {
                    index,
                    carry,
                    while_,
                    until,
                } => {
                    let body = new(Some(*index), &mut self.places);
                    self.inner.insert(i, [body, body]);
                    for (_, _, start, next) in carry {
                        reads.push((start.clone(), place));
                        reads.push((next.clone(), body));
                    }
                    reads.extend(while_.iter().chain(until).map(|o| (o.clone(), body)));
                }
            }
            for (operand, at) in reads {
                if let Operand::Output(n, ..) | Operand::Last(n, ..) = operand {
                    used[n] = Some(used[n].map_or(at, |before| self.common(before, at)));
                    self.depth[n] = self.depth[n].max(self.depth[i] + 1);
                }
            }
        }
        self.nodes_of = vec![Vec::new(); self.places.len()];
        for i in 0..self.graph.nodes.len() {
            if !is_vertex(&self.graph.nodes[i].what) {
                self.nodes_of[self.place[i]].push(i);
            }
        }
        for nodes in &mut self.nodes_of {
            nodes.sort_by_key(|i| (Reverse(self.depth[*i]), self.graph.nodes[*i].number));
        }
        let deepest = self.places.iter().max_by_key(|p| p.depth);
        if let Some(place) = deepest
            && place.depth > DEEPEST
        {
            let name = &self.graph.nodes[place.owner].name;
            return Err(vec![Problem::new(
                format!("nodes.{name}"),
                format!(
                    "loops and ifs stand {} deep in one another; at most {DEEPEST} are allowed",
                    place.depth
                ),
            )]);
        }
        Ok(())
    }

    /// The nodes of the vertex stage, sources first, with their interpolation.
    fn vertex_nodes(&mut self) -> Result<Vec<usize>, Vec<Problem>> {
        let mut problems = Vec::new();
        let mut vertex = Vec::new();
        for (i, node) in self.graph.nodes.iter().enumerate() {
            let What::Call {
                stage: Stage::Vertex(how),
                arguments,
                function,
                ..
            } = &node.what
            else {
                continue;
            };
            let place = format!("nodes.{}", node.name);
            for argument in arguments {
                let fits = match argument {
                    Operand::Constant(_) => true,
                    Operand::Output(n, ..) => {
                        is_vertex(&self.graph.nodes[*n].what)
                            || is_uniform(&self.graph.nodes[*n].what)
                    }
                    _ => false,
                };
                if !fits {
                    problems.push(Problem::new(&place, "a node of the vertex stage reads constants, uniforms and nodes of that stage only; what it reads is computed per pixel or is a texture"));
                    break;
                }
            }
            for port in &function.outputs {
                let fits = match &port.ty {
                    Type::Vector(Scalar::F32, _) => true,
                    Type::Vector(Scalar::I32 | Scalar::U32, _) => *how == Interpolation::Flat,
                    _ => false,
                };
                if !fits {
                    problems.push(Problem::new(&place, format!("its output `{}`, a {}, cannot be interpolated; numbers and vectors can, whole ones with \"flat\"", port.name, port.ty)));
                }
            }
            vertex.push(i);
        }
        let varyings: usize = vertex
            .iter()
            .map(|i| match &self.graph.nodes[*i].what {
                What::Call { function, .. } => function.outputs.len(),
                _ => 0,
            })
            .sum();
        if varyings > MOST_VARYINGS {
            problems.push(Problem::new(
                "nodes",
                format!(
                    "{varyings} outputs of the vertex stage; a graph has at most {MOST_VARYINGS}"
                ),
            ));
        }
        if problems.is_empty() {
            Ok(vertex)
        } else {
            Err(problems)
        }
    }

    fn unique(&mut self, wish: &str) -> String {
        let mut name = wish.to_owned();
        while !self.names.insert(name.clone()) {
            name.push('_');
        }
        name
    }

    /// Gives everything a name that nothing else has.
    fn name(&mut self) -> (Vec<Labeled>, Vec<(String, String)>) {
        let (mut functions, mut nodes) = (Vec::<(String, Arc<Module>)>::new(), Vec::new());
        let mut shared: HashMap<Arc<Module>, String> = HashMap::new();
        for (name, _) in &self.graph.textures {
            let name = self.unique(&format!("texture_{name}"));
            self.textures.push(name);
        }
        for node in &self.graph.nodes {
            // Own words of functions must not be taken for locals.
            if let What::Call { function, .. } = &node.what
                && let Call::Module(module) = &function.call
            {
                self.names.extend(module.words().map(str::to_owned));
            }
        }
        for node in &self.graph.nodes {
            let mut label = String::new();
            let locals = match &node.what {
                What::Call { function, .. } => {
                    match &function.call {
                        Call::Name(name) => label = (*name).to_owned(),
                        Call::Module(module) if module.parameter_bytes() == 0 => {
                            label = match shared.get(module) {
                                Some(label) => label.clone(),
                                None => {
                                    let label = self.unique(&format!("node_{}", module.main()));
                                    functions.push((label.clone(), module.clone()));
                                    shared.insert(module.clone(), label.clone());
                                    label
                                }
                            };
                        }
                        Call::Module(module) => {
                            label = self.unique(&format!("node_{}", node.name));
                            functions.push((label.clone(), module.clone()));
                            nodes.push((node.name.clone(), label.clone()));
                        }
                    }
                    vec![self.unique(&node.name)]
                }
                What::If { outputs, .. } => outputs
                    .iter()
                    .map(|(output, ..)| self.unique(&format!("{}_{output}", node.name)))
                    .collect(),
                What::Loop { carry, .. } => carry
                    .iter()
                    .map(|(variable, ..)| self.unique(&format!("{}_{variable}", node.name)))
                    .collect(),
            };
            self.labels.push(label);
            self.locals.push(locals);
        }
        (functions, nodes)
    }

    fn line(&mut self, indent: usize, text: &str) {
        for line in text.lines() {
            self.text.extend(std::iter::repeat_n("    ", indent));
            self.text.push_str(line);
            self.text.push('\n');
        }
    }

    fn operand(&self, operand: &Operand) -> String {
        let with = |name: &str, path: &[String]| {
            let mut text = name.to_owned();
            for part in path {
                text.push('.');
                text.push_str(part);
            }
            text
        };
        match operand {
            Operand::Constant(literal) => literal.to_string(),
            Operand::Texture(i) => self.textures[*i].clone(),
            Operand::Carried(n, v, path) | Operand::Last(n, v, path) => {
                with(&self.locals[*n][*v], path)
            }
            Operand::Output(n, output, path) => match &self.graph.nodes[*n].what {
                What::Call { function, .. } if function.is_struct => {
                    let name = format!("{}.{}", self.locals[*n][0], function.outputs[*output].name);
                    with(&name, path)
                }
                What::Call { .. } => with(&self.locals[*n][0], path),
                _ => with(&self.locals[*n][*output], path),
            },
        }
    }

    fn call(&self, i: usize) -> String {
        let What::Call {
            arguments,
            function,
            ..
        } = &self.graph.nodes[i].what
        else {
            return String::new();
        };
        // What the driver gives them is no output of a node.
        match function.call {
            Call::Name(name @ ("ray_of_pixel" | "slice_of_pixel")) => {
                debug_assert_eq!(RAY, "ray");
                return format!("{name}(pixel)");
            }
            Call::Name(name @ "corner_of_picture") => return format!("{name}(index)"),
            _ => {}
        }
        let arguments: Vec<_> = arguments.iter().map(|a| self.operand(a)).collect();
        format!("{}({})", self.labels[i], arguments.join(", "))
    }

    /// Says of which object, or of which technique, the functions are that are called next.
    fn choice(&self, number: usize) -> Option<String> {
        if self.what.techniques == Techniques::OfSegments {
            return Some(format!("technique_of_run = {}u;", number + 1));
        }
        (self.what.objects > 1).then(|| format!("current = {number}u;"))
    }

    fn block(&mut self, place: usize, indent: usize) {
        for i in std::mem::take(&mut self.nodes_of[place]) {
            self.statement(i, indent);
        }
    }

    fn statement(&mut self, i: usize, indent: usize) {
        let node = &self.graph.nodes[i];
        if !node.comment.is_empty() {
            let comment = node.comment.replace(['\n', '\r'], " ");
            self.line(indent, &format!("// {comment}"));
        }
        match &node.what {
            What::Call { object, .. } => {
                if self.current != Some(*object)
                    && let Some(text) = self.choice(*object)
                {
                    self.line(indent, &text);
                    self.current = Some(*object);
                }
                let text = format!("let {} = {};", self.locals[i][0], self.call(i));
                self.line(indent, &text);
            }
            What::If { condition, outputs } => {
                let [then, other] = self.inner[&i];
                for (output, (_, ty, ..)) in outputs.iter().enumerate() {
                    let text = format!("var {}: {ty};", self.locals[i][output]);
                    self.line(indent, &text);
                }
                let text = format!("if {} {{", self.operand(condition));
                self.line(indent, &text);
                let before = self.current;
                let mut ends = Vec::new();
                for (place, branch) in [(then, 0), (other, 1)] {
                    self.current = before;
                    self.block(place, indent + 1);
                    for (output, (_, _, a, b)) in outputs.iter().enumerate() {
                        let value = self.operand(if branch == 0 { a } else { b });
                        let text = format!("{} = {value};", self.locals[i][output]);
                        self.line(indent + 1, &text);
                    }
                    self.line(indent, if branch == 0 { "} else {" } else { "}" });
                    ends.push(self.current);
                }
                self.current = before.filter(|_| ends.iter().all(|end| *end == before));
            }
            What::Loop {
                carry,
                while_,
                until,
                ..
            } => {
                let body = self.inner[&i][0];
                for (v, (_, ty, start, _)) in carry.iter().enumerate() {
                    let text =
                        format!("var {}: {ty} = {};", self.locals[i][v], self.operand(start));
                    self.line(indent, &text);
                }
                self.line(indent, "loop {");
                self.current = None;
                if !self.ends_by_itself(i)
                    && let Some(turns) = self.turns.clone()
                {
                    self.line(
                        indent + 1,
                        &format!("{turns} += 1u;\nif {turns} > {MOST_TURNS}u {{\n    break;\n}}"),
                    );
                }
                let nodes = std::mem::take(&mut self.nodes_of[body]);
                let first = while_.as_ref().map(|w| self.behind(w)).unwrap_or_default();
                for n in nodes.iter().filter(|n| first.contains(n)) {
                    self.statement(*n, indent + 1);
                }
                if let Some(condition) = while_ {
                    // One instruction less than a negation.
                    let text = format!(
                        "if {} {{\n}} else {{\n    break;\n}}",
                        self.operand(condition)
                    );
                    self.line(indent + 1, &text);
                }
                for n in nodes.iter().filter(|n| !first.contains(n)) {
                    self.statement(*n, indent + 1);
                }
                self.next_turn(i, carry, until.as_ref(), indent + 1);
                self.line(indent, "}");
                self.current = None;
            }
        }
    }

    /// Assigns all variables of a loop at once: whoever reads a variable that is assigned before reads a copy.
    fn next_turn(
        &mut self,
        i: usize,
        carry: &[(String, Type, Operand, Operand)],
        until: Option<&Operand>,
        indent: usize,
    ) {
        let is_own = |operand: &Operand| matches!(operand, Operand::Carried(n, ..) if *n == i);
        let mut values = Vec::new();
        for (v, (_, _, _, next)) in carry.iter().enumerate() {
            let stays = matches!(next, Operand::Carried(n, w, path) if *n == i && *w == v && path.is_empty());
            let text = self.operand(next);
            if stays {
                continue;
            }
            if is_own(next) {
                let copy = self.unique(&format!("{}_next", self.locals[i][v]));
                self.line(indent, &format!("let {copy} = {text};"));
                values.push((v, copy));
            } else {
                values.push((v, text));
            }
        }
        let until = until.map(|operand| {
            let text = self.operand(operand);
            if !is_own(operand) {
                return text;
            }
            let copy = self.unique("ends");
            self.line(indent, &format!("let {copy} = {text};"));
            copy
        });
        for (v, value) in values {
            let text = format!("{} = {value};", self.locals[i][v]);
            self.line(indent, &text);
        }
        if let Some(until) = until {
            self.line(indent, &format!("if {until} {{\n    break;\n}}"));
        }
    }

    /// All nodes behind a value.
    fn behind(&self, operand: &Operand) -> HashSet<usize> {
        let mut open = vec![operand.clone()];
        let mut found = HashSet::new();
        while let Some(operand) = open.pop() {
            let (Operand::Output(n, ..) | Operand::Last(n, ..)) = operand else {
                continue;
            };
            if !found.insert(n) {
                continue;
            }
            match &self.graph.nodes[n].what {
                What::Call { arguments, .. } => open.extend(arguments.iter().cloned()),
                What::If { condition, outputs } => {
                    open.push(condition.clone());
                    open.extend(
                        outputs
                            .iter()
                            .flat_map(|(_, _, a, b)| [a.clone(), b.clone()]),
                    );
                }
                What::Loop {
                    carry,
                    while_,
                    until,
                    ..
                } => {
                    open.extend(carry.iter().flat_map(|(_, _, a, b)| [a.clone(), b.clone()]));
                    open.extend(while_.iter().chain(until).cloned());
                }
            }
        }
        found
    }

    /// Whether a loop is the walk along the lattice: while `before_end(k, count)` of one lattice, k going on by
    /// `advance`, which is one point at least.
    fn ends_by_itself(&self, i: usize) -> bool {
        let main = |n: usize| match &self.graph.nodes[n].what {
            What::Call {
                function,
                arguments,
                ..
            } => {
                let name = match &function.call {
                    Call::Name(name) => *name,
                    Call::Module(module) if module.is_built_in() => module.main(),
                    Call::Module(_) => "",
                };
                Some((name, arguments))
            }
            _ => None,
        };
        let What::Loop {
            carry,
            while_: Some(Operand::Output(condition, ..)),
            ..
        } = &self.graph.nodes[i].what
        else {
            return false;
        };
        let Some(("before_end", compared)) = main(*condition) else {
            return false;
        };
        let [Operand::Carried(of, k, _), Operand::Output(count, 2, _)] = &compared[..] else {
            return false;
        };
        let is_of_lattice = matches!(
            main(*count),
            Some(("lattice_of_ray" | "lattice_of_line", _))
        );
        let Some((_, _, _, Operand::Output(next, ..))) = carry.get(*k) else {
            return false;
        };
        let advances =
            matches!(main(*next), Some(("advance", from)) if from.first() == Some(&compared[0]));
        *of == i && is_of_lattice && advances
    }

    /// Entry points of a program with a vertex stage of its own.
    fn entry(&mut self, vertex: &[usize], slices: Option<Order>) -> String {
        let mut members = String::new();
        let mut assign = String::new();
        let mut body = String::new();
        let mut receive = String::new();
        let mut location = 0;
        // Nodes of the vertex stage read one another there; only then is known what they are called elsewhere.
        let mut received = Vec::new();
        let mut arguments = "@builtin(vertex_index) index: u32".to_owned();
        if let Some(order) = slices {
            // An instance is a slice: they are blended in their order.
            let sign = match order {
                Order::FrontToBack => '+',
                Order::BackToFront => '-',
            };
            arguments.push_str(", @builtin(instance_index) instance: u32");
            members.push_str("    @location(0) @interpolate(flat) slice_mm: f32,\n");
            let _ = writeln!(
                body,
                "    slice_mm = f32(frame.first_slice {sign} i32(instance)) * frame.step_mm;"
            );
            assign.push_str("    out.slice_mm = slice_mm;\n");
            receive.push_str("    slice_mm = at.slice_mm;\n");
            location = 1;
        }
        for &i in vertex {
            let node = &self.graph.nodes[i];
            let What::Call {
                function,
                stage: Stage::Vertex(how),
                ..
            } = &node.what
            else {
                continue;
            };
            let how = match how {
                Interpolation::Perspective => "perspective",
                Interpolation::Linear => "linear",
                Interpolation::Flat => "flat",
            };
            let local = self.locals[i][0].clone();
            // Uniforms that it reads are called at the vertex, too.
            if let What::Call { arguments, .. } = &node.what {
                for argument in arguments {
                    if let Operand::Output(n, ..) = argument
                        && is_uniform(&self.graph.nodes[*n].what)
                    {
                        let line = format!("    let {} = {};\n", self.locals[*n][0], self.call(*n));
                        if !body.contains(&line) {
                            body.push_str(&line);
                        }
                    }
                }
            }
            if let What::Call { object, .. } = &node.what
                && let Some(text) = self.choice(*object)
            {
                let _ = writeln!(body, "    {text}");
            }
            let _ = writeln!(body, "    let {local} = {};", self.call(i));
            let mut outputs = Vec::new();
            for port in &function.outputs {
                let name = self.unique(&format!("varying_{}_{}", node.name, port.name));
                let global = self.unique(&format!("{name}_here"));
                let _ = writeln!(
                    members,
                    "    @location({location}) @interpolate({how}) {name}: {},",
                    port.ty
                );
                let from = if function.is_struct {
                    format!("{local}.{}", port.name)
                } else {
                    local.clone()
                };
                let _ = writeln!(assign, "    out.{name} = {from};");
                let _ = writeln!(receive, "    {global} = at.{name};");
                let text = format!("var<private> {global}: {};", port.ty);
                self.line(0, &text);
                location += 1;
                outputs.push(global);
            }
            if !function.is_struct {
                received.push((i, outputs[0].clone()));
            } else {
                let of = self.unique(&format!("{local}_here"));
                let members: Vec<_> = function
                    .outputs
                    .iter()
                    .zip(&outputs)
                    .map(|(port, global)| format!("{}: {global}", port.name))
                    .collect();
                debug_assert!(!members.is_empty());
                // A struct of the same member names, so that readers need not know.
                let fields: String = function
                    .outputs
                    .iter()
                    .map(|port| format!("    {}: {},\n", port.name, port.ty))
                    .collect();
                let ty = self.unique(&format!("Varyings_{}", node.name));
                self.line(
                    0,
                    &format!("struct {ty} {{\n{fields}}}\nvar<private> {of}: {ty};"),
                );
                let assigned: String = function
                    .outputs
                    .iter()
                    .zip(&outputs)
                    .map(|(port, global)| format!("    {of}.{} = {global};\n", port.name))
                    .collect();
                receive.push_str(&assigned);
                received.push((i, of));
            }
        }
        // From here on they are read where the fragment stage has put them.
        for (i, name) in received {
            self.locals[i] = vec![name];
        }
        let stages = format!(
            "struct VertexOut {{\n    @builtin(position) place: vec4f,\n{members}}}\n\n\
             @vertex\nfn vertex({arguments}) -> VertexOut {{\n    var out: VertexOut;\n    out.place = corner(index);\n{body}{assign}    return out;\n}}\n\n\
             fn receive(at: VertexOut) {{\n{receive}}}\n\n"
        );
        if slices.is_some() {
            return stages + &self.slice_entry();
        }
        stages
            + "@fragment\nfn fragment(at: VertexOut) -> @location(0) vec4f {\n    receive(at);\n    return pixel_at(at.place);\n}\n\n\
             @fragment\nfn fragment_with_depth(at: VertexOut) -> PixelWithDepth {\n    receive(at);\n    let color = pixel_at(at.place);\n    return PixelWithDepth(color, hit_mm);\n}\n"
    }

    /// What a pixel does with a slice: outside of everything it draws nothing.
    fn slice_entry(&self) -> String {
        let mut text = "@fragment\nfn fragment(at: VertexOut) -> @location(0) vec4f {\n    receive(at);\n    pixel_of_part = vec2u(at.place.xy);\n    let pixel = pixel_of_part + frame.origin;\n".to_owned();
        if self.what.objects > 1 {
            text.push_str("    var is_inside = false;\n");
            for object in 0..self.what.objects {
                let _ = writeln!(text, "    current = {object}u;");
                text.push_str("    is_inside = is_inside || slice_of_pixel(pixel).is_inside;\n");
            }
        } else {
            text.push_str("    let is_inside = slice_of_pixel(pixel).is_inside;\n");
        }
        text.push_str(
            "    if !is_inside {\n        discard;\n    }\n    return march(pixel);\n}\n",
        );
        text
    }
}

fn is_uniform(what: &What) -> bool {
    matches!(what, What::Call { function, .. } if matches!(&function.call, Call::Module(module) if module.main() == "uniform_value"))
}
