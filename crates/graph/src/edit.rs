//! Edits of a graph: named lists of commands, carried out again whenever the settings make a new one.

use crate::error::Problem;
use crate::functions::{self, Patterns, nearest};
use crate::group::unfolded;
use crate::model::{CarriedVariable, Constant, Graph, Input, Kind, Node, Reference};
use std::collections::{HashMap, HashSet};

/// A list of commands with a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditList {
    /// Unique, for messages.
    pub name: String,
    /// What is done, one after the other.
    pub commands: Vec<Edit>,
}

/// A command.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// More nodes (S3-46: merge).
    Add(Vec<Node>),
    /// Inputs, by their paths, read something else than they did (connect with override).
    Connect(Vec<(String, Input)>),
    /// A node between an input and what that read.
    Insert {
        /// The node, which is there already.
        node: String,
        /// `NODE.INPUT`, or an anchor's name.
        into: String,
        /// The input of the node that reads what `into` read; its first unconnected one if not said.
        input: Option<String>,
        /// The output that `into` reads now; its only one if not said.
        output: Option<String>,
    },
    /// Whoever reads a node reads another one.
    ReplaceNode {
        /// Who is read no more.
        node: String,
        /// Who is read.
        by: Replacement,
    },
    /// A stage of the standard graph is something else.
    ReplaceStage {
        /// Its name.
        stage: String,
        /// What comes out of it.
        by: Replacement,
    },
    /// More variables that a loop carries: `LOOP.VARIABLE`.
    Carry(Vec<(String, CarriedVariable)>),
    /// Values of parameters and uniforms: `NODE.PARAMETER`, `NODE.value`.
    Set(Vec<(String, Vec<f64>)>),
    /// Roots, in place of those of the same name.
    Root(Vec<(String, Reference)>),
    /// Roots that are wanted no more.
    RemoveRoot(Vec<String>),
    /// Nodes that are there no more.
    Remove(Vec<String>),
    /// Another graph in place of everything.
    Everything(Graph),
}

impl Edit {
    /// The names of the nodes that have to be there already, and that the command changes.
    fn changed_nodes(&self) -> Vec<String> {
        let node = |path: &str| path.split('.').next().unwrap_or_default().to_owned();
        match self {
            Edit::Connect(inputs) => inputs.iter().map(|(to, _)| node(to)).collect(),
            Edit::Insert {
                node: name, into, ..
            } => vec![name.clone(), node(into)],
            Edit::ReplaceNode { node, .. } => vec![node.clone()],
            Edit::ReplaceStage { stage, .. } => stage_of(stage).map_or_else(Vec::new, |stage| {
                stage.ends().into_iter().map(|(_, end)| end).collect()
            }),
            Edit::Carry(variables) => variables.iter().map(|(to, _)| node(to)).collect(),
            Edit::Set(values) => values.iter().map(|(to, _)| node(to)).collect(),
            Edit::Remove(names) => names.clone(),
            Edit::Add(_) | Edit::Root(_) | Edit::RemoveRoot(_) | Edit::Everything(_) => Vec::new(),
        }
    }
}

/// A stage, of the graph or of a group in it.
struct StageOfGroup<'s> {
    /// What the names of the group's nodes begin with.
    prefix: &'s str,
    name: &'static str,
    parts: &'static [&'static str],
}

impl StageOfGroup<'_> {
    /// The anchors behind it, each with its part.
    fn ends(&self) -> Vec<(&'static str, String)> {
        let Self {
            prefix,
            name,
            parts,
        } = self;
        match parts {
            [] => vec![("", format!("{prefix}after_{name}"))],
            _ => (parts.iter())
                .map(|part| (*part, format!("{prefix}after_{name}_{part}")))
                .collect(),
        }
    }
}

/// The stage called `stage`, or `GROUP_stage` of a group.
fn stage_of(stage: &str) -> Option<StageOfGroup<'_>> {
    STAGES.iter().find_map(|(name, parts)| {
        let prefix = stage.strip_suffix(name)?;
        (prefix.is_empty() || prefix.ends_with('_')).then_some(StageOfGroup {
            prefix,
            name,
            parts,
        })
    })
}

/// What comes in place of something.
#[derive(Clone, Debug, PartialEq)]
pub enum Replacement {
    /// One node, or one output.
    One(Reference),
    /// Part by part.
    Parts(Vec<(String, Input)>),
}

/// The stages of the standard graph, each between two anchors or, where it has parts, two for each.
pub const STAGES: [(&str, &[&str]); 7] = [
    ("clip_ray", &[]),
    ("jitter", &[]),
    ("sample", &[]),
    ("clip_sample", &[]),
    ("classify", &[]),
    ("shade", &["color", "opacity"]),
    ("composite", &["color", "opacity"]),
];

/// An edited graph.
#[derive(Clone, Debug)]
pub struct EditedGraph {
    /// The graph.
    pub graph: Graph,
    /// Where two lists want the same place: the later one has it.
    pub conflicts: Vec<Problem>,
}

/// `graph` after all commands of all lists, in their order.
///
/// # Errors
/// Every command that cannot be carried out, with its place. A graph that is wrong afterwards is found when it
/// is compiled.
pub fn edited(
    graph: Graph,
    lists: &[EditList],
    patterns: &Patterns,
) -> Result<EditedGraph, Vec<Problem>> {
    let mut editor = Editor {
        graph,
        patterns,
        problems: Vec::new(),
        conflicts: Vec::new(),
        written: HashMap::new(),
        touched: HashSet::new(),
        list: 0,
        lists,
    };
    for (i, list) in lists.iter().enumerate() {
        editor.list = i;
        for (j, command) in list.commands.iter().enumerate() {
            editor.carry_out(command, &format!("edits.{}.commands[{j}]", list.name));
            editor.follow_edit();
        }
    }
    if !editor.problems.is_empty() {
        return Err(editor.problems);
    }
    Ok(EditedGraph {
        graph: editor.graph,
        conflicts: editor.conflicts,
    })
}

struct Editor<'e> {
    graph: Graph,
    patterns: &'e Patterns,
    problems: Vec<Problem>,
    conflicts: Vec<Problem>,
    /// What has been written: by which list, and where that says so.
    written: HashMap<String, (usize, String)>,
    /// Nodes whose results the command may change.
    touched: HashSet<String>,
    list: usize,
    lists: &'e [EditList],
}

impl Editor<'_> {
    fn wrong(&mut self, place: impl Into<String>, why: impl Into<String>) {
        if self.problems.len() < 50 {
            self.problems.push(Problem::new(place, why));
        }
    }

    /// Remembers that `target` is written at `place`; another list's word on it is a conflict.
    fn write(&mut self, target: &str, place: &str) {
        let before = self
            .written
            .insert(target.to_owned(), (self.list, place.to_owned()));
        if let Some((list, earlier)) = before
            && list != self.list
        {
            let name = &self.lists[list].name;
            let why = format!(
                "`{target}` is set by the list `{name}`, too, at {earlier}; this one is later and counts"
            );
            self.conflicts.push(Problem::new(place, why));
        }
    }

    fn no_node(&self, name: &str) -> String {
        let names = || self.graph.nodes.iter().map(|n| n.name.as_str());
        let mut why = format!("there is no node `{name}` in the graph as it is");
        if let Some(near) = nearest(name, names()) {
            why.push_str(&format!("; did you mean `{near}`?"));
        } else {
            let anchors: Vec<_> = names().filter(|n| n.starts_with("after_")).collect();
            if !anchors.is_empty() {
                let anchors = anchors.join(", ");
                why.push_str(&format!(
                    "; with other settings there are other nodes, but always {anchors}"
                ));
            }
        }
        why
    }

    /// Unfolds groups if a command names a node inside one, by the name that it has then.
    fn unfold_for(&mut self, command: &Edit) {
        let names = command.changed_nodes();
        let is_within = |name: &str| {
            let of_group = |node: &Node| {
                matches!(node.kind, Kind::Group(_))
                    && name
                        .strip_prefix(&node.name)
                        .is_some_and(|n| n.starts_with('_'))
            };
            self.graph.node(name).is_none() && self.graph.nodes.iter().any(of_group)
        };
        if !names.iter().any(|name| is_within(name)) {
            return;
        }
        // What is wrong with a group is found when the graph is compiled.
        if let Ok(whole) = unfolded(&self.graph)
            && names
                .iter()
                .any(|name| is_within(name) && whole.node(name).is_some())
        {
            self.graph = whole;
        }
    }

    fn carry_out(&mut self, command: &Edit, place: &str) {
        self.unfold_for(command);
        match command {
            Edit::Add(nodes) => {
                for node in nodes {
                    let place = format!("{place}.add.{}", node.name);
                    if self.graph.node(&node.name).is_some() {
                        let owner = self.written.get(&node.name).map(|(list, at)| {
                            format!("; the list `{}` adds it at {at}", self.lists[*list].name)
                        });
                        let owner = owner.unwrap_or_default();
                        self.wrong(
                            &place,
                            format!(
                                "there is a node `{}` already{owner}; rename this one",
                                node.name
                            ),
                        );
                        continue;
                    }
                    self.write(&node.name, &place);
                    self.graph.nodes.push(node.clone());
                }
            }
            Edit::Connect(inputs) => {
                for (to, from) in inputs {
                    let place = format!("{place}.connect.{to}");
                    self.connect(to, from.clone(), &place);
                }
            }
            Edit::Insert {
                node,
                into,
                input,
                output,
            } => self.insert(
                node,
                into,
                input.as_deref(),
                output.as_deref(),
                &format!("{place}.insert"),
            ),
            Edit::ReplaceNode { node, by } => {
                self.replace_node(node, by, &format!("{place}.replace"))
            }
            Edit::ReplaceStage { stage, by } => {
                self.replace_stage(stage, by, &format!("{place}.replace"))
            }
            Edit::Carry(variables) => {
                for (to, carried) in variables {
                    self.carry(to, carried, &format!("{place}.carry.{to}"));
                }
            }
            Edit::Set(values) => {
                for (to, value) in values {
                    self.set(to, value, &format!("{place}.set.{to}"));
                }
            }
            Edit::Root(roots) => {
                for (name, from) in roots {
                    let place = format!("{place}.root.{name}");
                    self.write(&format!("roots.{name}"), &place);
                    match self.graph.roots.iter_mut().find(|(n, _)| n == name) {
                        Some((_, root)) => *root = from.clone(),
                        None => self.graph.roots.push((name.clone(), from.clone())),
                    }
                }
            }
            Edit::RemoveRoot(names) => {
                for name in names {
                    let place = format!("{place}.remove_root");
                    match self.graph.roots.iter().position(|(n, _)| n == name) {
                        Some(i) => {
                            self.write(&format!("roots.{name}"), &place);
                            self.graph.roots.remove(i);
                        }
                        None => {
                            let names: Vec<_> =
                                self.graph.roots.iter().map(|(n, _)| n.as_str()).collect();
                            let names = names.join(", ");
                            self.wrong(
                                place,
                                format!("there is no root `{name}`; there are {names}"),
                            );
                        }
                    }
                }
            }
            Edit::Remove(names) => {
                for name in names {
                    let place = format!("{place}.remove");
                    match self.graph.nodes.iter().position(|n| n.name == *name) {
                        Some(i) => {
                            self.write(name, &place);
                            self.graph.nodes.remove(i);
                        }
                        None => {
                            let why = self.no_node(name);
                            self.wrong(place, why);
                        }
                    }
                }
            }
            Edit::Everything(graph) => {
                let place = format!("{place}.everything");
                // Whatever other lists have done before is gone.
                let before: Vec<_> = self.written.drain().collect();
                let mut others: Vec<_> = before
                    .into_iter()
                    .filter(|(_, (list, _))| *list != self.list)
                    .collect();
                others.sort();
                if let Some((_, (list, earlier))) = others.into_iter().next() {
                    let name = &self.lists[list].name;
                    let why = format!(
                        "this graph takes the place of everything, also of what the list `{name}` has done, such as at {earlier}; put this list first"
                    );
                    self.conflicts.push(Problem::new(place, why));
                }
                self.graph = graph.clone();
            }
        }
    }

    /// The place that `to` names, to be read and written.
    fn input(&mut self, to: &str) -> Result<Target<'_>, String> {
        let Some((name, rest)) = to.split_once('.') else {
            return match self.graph.node(to).map(|node| &node.kind) {
                Some(Kind::Anchor) => self.input(&format!("{to}.in")),
                Some(_) => Err(format!("name an input of `{to}`: `{to}.INPUT`")),
                None => Err(self.no_node(to)),
            };
        };
        let Some(i) = self.graph.nodes.iter().position(|n| n.name == name) else {
            return Err(self.no_node(name));
        };
        let node = &mut self.graph.nodes[i];
        if let Kind::Loop(region) = &mut node.kind {
            return match rest.split_once('.') {
                None if rest == "while" => Ok(Target::Condition(&mut region.while_)),
                None if rest == "until" => Ok(Target::Condition(&mut region.until)),
                Some((variable, key)) => {
                    let known: Vec<_> = region.carry.iter().map(|c| c.name.clone()).collect();
                    let found = region.carry.iter_mut().find(|c| c.name == variable);
                    let Some(carried) = found else {
                        return Err(format!(
                            "the loop `{name}` has no variable `{variable}`; it carries {}",
                            known.join(", ")
                        ));
                    };
                    match key {
                        "start" => Ok(Target::Carried(&mut carried.start)),
                        "next" => Ok(Target::Carried(&mut carried.next)),
                        _ => Err(format!(
                            "a loop's variable has `start` and `next`, not `{key}`"
                        )),
                    }
                }
                None => Err(format!(
                    "`{to}` is no place of a loop; there are `{name}.VARIABLE.start`, `{name}.VARIABLE.next`, `{name}.while`, `{name}.until`"
                )),
            };
        }
        Ok(Target::Input(&mut node.inputs, rest.to_owned()))
    }

    fn connect(&mut self, to: &str, from: Input, place: &str) {
        self.touch(to);
        let done = self.input(to).and_then(|mut target| target.set(from));
        match done {
            Ok(()) => {
                let to = self.normal(to);
                self.write(&to, place);
            }
            Err(why) => self.wrong(place, why),
        }
    }

    /// `to` with the input of an anchor said.
    fn normal(&self, to: &str) -> String {
        match self.graph.node(to) {
            Some(_) => format!("{to}.in"),
            None => to.to_owned(),
        }
    }

    fn insert(
        &mut self,
        node: &str,
        into: &str,
        input: Option<&str>,
        output: Option<&str>,
        place: &str,
    ) {
        let before = match self.input(into).map(|target| target.get()) {
            Ok(Some(before)) => before,
            Ok(None) => {
                self.wrong(
                    format!("{place}.into"),
                    format!("`{into}` reads nothing; connect it instead"),
                );
                return;
            }
            Err(why) => {
                self.wrong(format!("{place}.into"), why);
                return;
            }
        };
        let Some(between) = self.graph.node(node) else {
            let why = self.no_node(node);
            self.wrong(format!("{place}.node"), why);
            return;
        };
        let input = match input {
            Some(input) => input.to_owned(),
            None => match self.first_free(between) {
                Ok(input) => input,
                Err(why) => {
                    self.wrong(format!("{place}.input"), why);
                    return;
                }
            },
        };
        let mut from = Reference::new(node);
        if let Some(output) = output {
            from.path.extend(output.split('.').map(str::to_owned));
        }
        self.touch(into);
        // Both ends, without a word about a conflict: lists may insert at one place one after the other.
        let read = self
            .input(&format!("{node}.{input}"))
            .and_then(|mut target| target.set(before));
        let written = self
            .input(into)
            .and_then(|mut target| target.set(Input::From(from)));
        if let Err(why) = read.and(written) {
            self.wrong(place, why);
        }
    }

    /// The first input of a node that nothing is connected to.
    fn first_free(&self, node: &Node) -> Result<String, String> {
        let function = match &node.kind {
            Kind::Slot(slot) => functions::of_slot(slot),
            Kind::Function(path) => functions::of_library(path),
            Kind::Pattern(name) => self.patterns.function(name),
            Kind::Wgsl(source) => functions::of_wgsl(&node.name, &node.name, source),
            Kind::Anchor => return Ok("in".to_owned()),
            Kind::Group(graph) => {
                let free = graph.inputs.iter().find(|i| node.reads(&i.name).is_none());
                return free.map(|i| i.name.clone()).ok_or_else(|| {
                    "all inputs of the group are connected; set `input`".to_owned()
                });
            }
            _ => return Err("set `input` to the input that reads the previous value".to_owned()),
        };
        let function = function?;
        let free = function
            .inputs
            .iter()
            .find(|port| node.reads(&port.name).is_none());
        free.map(|port| port.name.clone())
            .ok_or_else(|| format!("all inputs of `{}` are connected; set `input`", node.name))
    }

    fn replace_node(&mut self, node: &str, by: &Replacement, place: &str) {
        if self.graph.node(node).is_none() {
            let why = self.no_node(node);
            self.wrong(format!("{place}.node"), why);
            return;
        }
        let own: Vec<String> = match by {
            Replacement::One(reference) => vec![reference.node.clone()],
            Replacement::Parts(parts) => (parts.iter())
                .filter_map(|(_, from)| match from {
                    Input::From(reference) => Some(reference.node.clone()),
                    Input::Constant(_) => None,
                })
                .collect(),
        };
        own.iter().for_each(|name| self.touch(name));
        let mut problems = Vec::new();
        let mut has_reader = false;
        self.graph.for_each_reference_mut(|at, reference| {
            // What takes its place may read it.
            let is_own = own.iter().any(|name| at.strip_prefix("nodes.").is_some_and(|rest| {
                rest.split('.').next() == Some(name)
            }));
            if reference.node != node || is_own {
                return;
            }
            has_reader = true;
            match by {
                Replacement::One(target) => {
                    let rest = std::mem::take(&mut reference.path);
                    *reference = target.clone();
                    reference.path.extend(rest);
                }
                Replacement::Parts(parts) => {
                    let part = reference.path.first().and_then(|first| parts.iter().find(|(p, _)| p == first));
                    match part {
                        Some((_, Input::From(target))) => {
                            let rest = reference.path.split_off(1);
                            *reference = target.clone();
                            reference.path.extend(rest);
                        }
                        Some((part, Input::Constant(_))) => problems.push(format!(
                            "`{part}` is read at {at}: a node takes its place; for a number, connect that input"
                        )),
                        None => problems.push(format!("{at} reads `{reference}`, which `by` does not replace")),
                    }
                }
            }
        });
        if !has_reader {
            self.wrong(
                format!("{place}.node"),
                format!("nothing else reads `{node}`, so nothing would change; connect what is to read another node"),
            );
            return;
        }
        for why in problems {
            self.wrong(format!("{place}.by"), why);
        }
        self.write(&format!("{node} as a whole"), place);
    }

    fn replace_stage(&mut self, stage: &str, by: &Replacement, place: &str) {
        let Some(found) = stage_of(stage) else {
            let names: Vec<_> = STAGES.iter().map(|(name, _)| *name).collect();
            self.wrong(
                format!("{place}.stage"),
                format!("there is no stage `{stage}`; they are {}", names.join(", ")),
            );
            return;
        };
        let (name, parts, anchors) = (found.name, found.parts, found.ends());
        let ends: Vec<(String, Input)> = match by {
            Replacement::One(reference) => (anchors.into_iter())
                .map(|(part, anchor)| {
                    let mut reference = reference.clone();
                    if !part.is_empty() {
                        reference.path.push(part.to_owned());
                    }
                    (format!("{anchor}.in"), Input::From(reference))
                })
                .collect(),
            Replacement::Parts(given) => {
                if given.is_empty() {
                    self.wrong(
                        format!("{place}.by"),
                        "it has nothing to replace the stage with",
                    );
                    return;
                }
                for (part, _) in given {
                    if !parts.contains(&part.as_str()) {
                        let why = match parts {
                            [] => format!(
                                "the stage {stage} has no parts; write \"by\": \"node.output\""
                            ),
                            _ => format!("the stage {stage} has the parts {}", parts.join(", ")),
                        };
                        self.wrong(format!("{place}.by.{part}"), why);
                        return;
                    }
                }
                let anchor = |part: &str| anchors.iter().find(|(p, _)| *p == part);
                (given.iter())
                    .filter_map(|(part, from)| {
                        Some((format!("{}.in", anchor(part)?.1), from.clone()))
                    })
                    .collect()
            }
        };
        if let (Replacement::One(reference), "classify") = (by, name)
            && let Err(why) = self.is_surface(reference)
        {
            self.wrong(format!("{place}.by"), why);
            return;
        }
        for (to, from) in ends {
            self.connect(&to, from, place);
        }
    }

    /// Checks that what replaces the classification is one value.
    fn is_surface(&self, reference: &Reference) -> Result<(), String> {
        let Some(node) = self.graph.node(&reference.node) else {
            return Ok(());
        };
        let function = match &node.kind {
            Kind::Pattern(name) => self.patterns.function(name),
            Kind::Wgsl(source) => functions::of_wgsl(&node.name, &node.name, source),
            _ => return Ok(()),
        };
        // What is wrong with it is found where it is compiled.
        let Ok(function) = function else {
            return Ok(());
        };
        let outputs: Vec<_> = function
            .outputs
            .iter()
            .map(|port| port.name.as_str())
            .collect();
        if outputs.len() < 2 || !reference.path.is_empty() {
            return Ok(());
        }
        Err(format!(
            "`{}` has the outputs {}, but the stage classify needs a single Surface: let the function return `-> Surface`, made by `Surface(color, opacity)`",
            node.name,
            outputs.join(", ")
        ))
    }

    /// Remembers that what the node of `to` computes may change.
    fn touch(&mut self, to: &str) {
        let name = to.split('.').next().unwrap_or(to);
        self.touched.insert(name.to_owned());
    }

    /// Computes every sample if the command may show some that the scene's transfer function and clips do not.
    fn follow_edit(&mut self) {
        let touched = std::mem::take(&mut self.touched);
        if !touched.is_empty() && self.skips() && self.decide_what_is_seen(&touched) {
            self.stop_skipping();
        }
    }

    fn skips(&self) -> bool {
        let mut nodes = self.graph.nodes.iter().filter(|node| skips(node));
        nodes.any(|node| matches!(node.reads("empty"), Some(Input::From(_))))
    }

    /// Whether one of the nodes `names` decides where a ray runs, and how opaque a sample of it is.
    fn decide_what_is_seen(&self, names: &HashSet<String>) -> bool {
        let ends = [
            "after_clip_ray",
            "after_clip_sample",
            "after_sample",
            "after_classify",
            "after_shade_opacity",
        ];
        let nodes = self.graph.nodes.iter();
        let by_name: HashMap<_, _> = nodes.map(|node| (node.name.as_str(), node)).collect();
        // Each of several objects has such an anchor, and so has each unfolded group.
        let is_end = |name: &&str| ends.iter().any(|end| name.contains(end));
        let mut open: Vec<&str> = by_name.keys().copied().filter(is_end).collect();
        let mut seen: HashSet<&str> = HashSet::new();
        while let Some(name) = open.pop() {
            if !seen.insert(name) {
                continue;
            }
            if names.contains(name) {
                return true;
            }
            // A variable of a loop holds what earlier samples have left, not what this one is.
            let inputs = by_name.get(name).into_iter().flat_map(|node| &node.inputs);
            open.extend(inputs.filter_map(|(_, input)| match input {
                Input::From(reference) => Some(reference.node.as_str()),
                Input::Constant(_) => None,
            }));
        }
        false
    }

    /// What is empty is known for the scene's transfer function at the places of the lattice only.
    /// What an edit has connected in place of the map stays.
    fn stop_skipping(&mut self) {
        let of_map = self.nodes_of_map();
        for node in self.graph.nodes.iter_mut().filter(|node| skips(node)) {
            for (name, input) in &mut node.inputs {
                let reads_map = matches!(input, Input::From(from) if of_map.contains(&from.node));
                if name == "empty" && reads_map {
                    *input = Input::Constant(Constant::Numbers(vec![0.0]));
                }
            }
        }
    }

    /// The names of the nodes that are computed from the map of empty space.
    fn nodes_of_map(&self) -> HashSet<String> {
        let is_map = |node: &&Node| matches!(&node.kind, Kind::Pattern(pattern) if pattern == "empty_points");
        let maps = self.graph.nodes.iter().filter(is_map);
        let mut of_map: HashSet<String> = maps.map(|node| node.name.clone()).collect();
        loop {
            let before = of_map.len();
            for node in &self.graph.nodes {
                let mut inputs = node.inputs.iter().map(|(_, input)| input);
                if inputs.any(|i| matches!(i, Input::From(from) if of_map.contains(&from.node))) {
                    of_map.insert(node.name.clone());
                }
            }
            if of_map.len() == before {
                return of_map;
            }
        }
    }

    fn carry(&mut self, to: &str, carried: &CarriedVariable, place: &str) {
        let Some((name, variable)) = to.split_once('.') else {
            self.wrong(place, "name the loop and its variable: LOOP.VARIABLE");
            return;
        };
        let why = self.no_node(name);
        match self.graph.node_mut(name).map(|node| &mut node.kind) {
            Some(Kind::Loop(region)) => {
                if region.carry.iter().any(|c| c.name == variable) {
                    self.wrong(place, format!("the loop `{name}` carries `{variable}` already; rename it, or connect `{to}.next`"));
                    return;
                }
                region.carry.push(CarriedVariable {
                    name: variable.to_owned(),
                    ..carried.clone()
                });
                self.write(to, place);
            }
            Some(_) => self.wrong(place, format!("`{name}` is no loop")),
            None => self.wrong(place, why),
        }
    }

    fn set(&mut self, to: &str, value: &[f64], place: &str) {
        let Some((name, parameter)) = to.split_once('.') else {
            self.wrong(place, "name the node and its parameter: NODE.PARAMETER");
            return;
        };
        let why = self.no_node(name);
        let Some(node) = self.graph.node_mut(name) else {
            self.wrong(place, why);
            return;
        };
        match (&mut node.kind, parameter) {
            (Kind::Uniform { value: old, .. }, "value") => *old = value.to_vec(),
            _ => match node.params.iter_mut().find(|(n, _)| n == parameter) {
                Some((_, old)) => *old = value.to_vec(),
                None => node.params.push((parameter.to_owned(), value.to_vec())),
            },
        }
        self.touch(name);
        self.write(to, place);
    }
}

/// Whether a node leaves samples out by the map of empty space.
fn skips(node: &Node) -> bool {
    matches!(&node.kind, Kind::Pattern(pattern) if pattern == "is_seen" || pattern == "advance")
}

/// An input that an edit names.
enum Target<'t> {
    Input(&'t mut Vec<(String, Input)>, String),
    Carried(&'t mut Option<Input>),
    Condition(&'t mut Option<Reference>),
}

impl Target<'_> {
    fn get(&self) -> Option<Input> {
        match self {
            Target::Input(inputs, name) => inputs
                .iter()
                .find(|(n, _)| n == name)
                .map(|(_, i)| i.clone()),
            Target::Carried(input) => (*input).clone(),
            Target::Condition(reference) => (**reference).clone().map(Input::From),
        }
    }

    fn set(&mut self, from: Input) -> Result<(), String> {
        match self {
            Target::Input(inputs, name) => match inputs.iter_mut().find(|(n, _)| n == name) {
                Some((_, input)) => *input = from,
                None => inputs.push((name.clone(), from)),
            },
            Target::Carried(input) => **input = Some(from),
            Target::Condition(reference) => match from {
                Input::From(from) => **reference = Some(from),
                Input::Constant(_) => {
                    return Err("when a loop ends is the output of a node, no constant".to_owned());
                }
            },
        }
        Ok(())
    }
}
