//! What need not be in the program: values that are known when it is made, copies, and what is there twice.
//!
//! Each round goes from sources to readers and finds, for outputs, what they are instead: a value, because all
//! that decides about it is known ([`PureFunction`] runs the function); an output of another node, because the function
//! hands it on as it is; or the same output of an equal node. Readers read that from then on. When nothing is
//! found any more, what nobody reads is left out: nodes, outputs of `if`s, variables of loops, textures.

use crate::check::{CheckedGraph, CheckedNode, Operand, What};
use crate::functions::{Call, Function, Port};
use crate::known::{Known, PureFunction};
use crate::model::Stage;
use crate::types::Type;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock};
use strahl_shader::{Module, PRELUDE, RayLoop, SLOTS, Selection, Slot, slot};

/// Rounds: each only finds what the one before has made possible.
const MOST_ROUNDS: usize = 16;

/// `graph` without what need not be in the program over `what`, whose slots hold `selection`.
pub fn folded(graph: CheckedGraph, what: &RayLoop, selection: &Selection) -> CheckedGraph {
    let mut graph = with_lines(graph);
    for node in &mut graph.nodes {
        if let What::Call { function, .. } = &mut node.what
            && let Call::Name(name) = function.call
        {
            function.pure = function_of_nothing(name, what, selection);
        }
    }
    for _ in 0..MOST_ROUNDS {
        if !replaced(&mut graph) {
            break;
        }
    }
    needed(graph)
}

/// The line of a ray in an object's voxel space as a node of its own, in front of those that begin by finding
/// it: so several of one ray find it once.
fn with_lines(graph: CheckedGraph) -> CheckedGraph {
    let mut place = Vec::with_capacity(graph.nodes.len());
    let mut lines = 0;
    for node in &graph.nodes {
        lines += usize::from(of_line(&node.what).is_some());
        place.push(place.len() + lines);
    }
    if lines == 0 {
        return graph;
    }
    let moved = |operand: &mut Operand| {
        if let Operand::Output(n, ..) | Operand::Carried(n, ..) | Operand::Last(n, ..) = operand {
            *n = place[*n];
        }
    };
    let mut nodes = Vec::with_capacity(graph.nodes.len() + lines);
    for mut node in graph.nodes {
        for_each_operand(&mut node.what, moved);
        let name = of_line(&node.what);
        if let What::Call {
            function,
            arguments,
            object,
            stage,
        } = &mut node.what
            && let Some(name) = name
        {
            let of_ray: Vec<_> = arguments.drain(..2).collect();
            arguments.insert(0, Operand::Output(nodes.len(), 0, Vec::new()));
            function.call = Call::Name(name);
            let line = Function {
                inputs: function.inputs.drain(..2).collect(),
                outputs: vec![Port {
                    name: "out".to_owned(),
                    ty: Type::Other("Line".to_owned()),
                    meaning: None,
                    default: None,
                    comment: String::new(),
                }],
                is_struct: false,
                call: Call::Name("line_of_ray"),
                pure: None,
                comment: String::new(),
            };
            nodes.push(CheckedNode {
                name: format!("line_of_{}", node.name),
                number: node.number,
                what: What::Call {
                    function: line,
                    arguments: of_ray,
                    object: *object,
                    stage: *stage,
                },
                loops: node.loops,
                comment: String::new(),
            });
        }
        nodes.push(node);
    }
    let mut roots = graph.roots;
    roots.iter_mut().for_each(|(_, root)| moved(root));
    CheckedGraph {
        nodes,
        roots,
        ..graph
    }
}

/// What a node calls instead when it gets a line in place of a ray's origin and direction.
fn of_line(what: &What) -> Option<&'static str> {
    let What::Call {
        function,
        stage: Stage::Pixel,
        ..
    } = what
    else {
        return None;
    };
    match function.call {
        Call::Name("sampled_extent_mm") => Some("extent_mm"),
        Call::Name("lattice_of_ray") => Some("lattice_of_line"),
        _ => None,
    }
}

/// What `name` does if it is the function of a slot that nothing is in, or of values that are all finite.
fn function_of_nothing(
    name: &str,
    what: &RayLoop,
    selection: &Selection,
) -> Option<Arc<PureFunction>> {
    type Nulls = HashMap<&'static str, (Option<&'static Slot>, Arc<PureFunction>)>;
    static NULLS: LazyLock<Nulls> = LazyLock::new(|| {
        let mut nulls = Nulls::new();
        let mut put = |name, slot, text: &str| {
            if let Some(pure) = PureFunction::of(text, name, PRELUDE) {
                nulls.insert(name, (slot, Arc::new(pure)));
            }
        };
        for slot in &SLOTS {
            if let (Some(null), [signature]) = (slot.null, slot.functions) {
                put(
                    signature.name,
                    Some(slot),
                    &format!("{signature} {{ {null} }}"),
                );
            }
        }
        put(
            "clipped_ray_mm",
            slot("clip_ray"),
            "fn clipped_ray_mm(origin_mm: vec3f, direction: vec3f, interval_mm: vec2f) -> vec2f { return interval_mm; }",
        );
        put(
            "is_value",
            None,
            "fn is_value(value: f32) -> bool { return true; }",
        );
        nulls
    });
    let (slot, pure) = NULLS.get(name)?;
    let does_nothing = match slot {
        Some(slot) => selection.of(slot).is_empty(),
        None => what.is_finite,
    };
    does_nothing.then(|| pure.clone())
}

/// What stands in place of outputs and variables.
#[derive(Default)]
struct Replacements {
    /// Node and output.
    outputs: HashMap<(usize, usize), Operand>,
    /// Loop and variable: those that never change, by their start.
    carried: HashMap<(usize, usize), Operand>,
}

/// What makes calls equal.
#[derive(PartialEq, Eq, Hash)]
enum Key {
    Name(&'static str, Vec<Operand>, usize, Stage),
    Module(Arc<Module>, Vec<Operand>, usize, Stage),
    If(Operand, Vec<(Operand, Operand)>),
}

/// Goes once from sources to readers; whether anybody reads something else than before.
fn replaced(graph: &mut CheckedGraph) -> bool {
    let mut instead = Replacements::default();
    // Variables are read before their loop comes, which is where it ends.
    for (i, node) in graph.nodes.iter().enumerate() {
        let What::Loop { carry, .. } = &node.what else {
            continue;
        };
        for (v, (_, _, start, next)) in carry.iter().enumerate() {
            let stays = matches!(next, Operand::Carried(n, w, path) if *n == i && *w == v && path.is_empty());
            if stays || (start == next && matches!(start, Operand::Constant(_))) {
                instead.carried.insert((i, v), start.clone());
            }
        }
    }
    let mut equal: HashMap<Key, usize> = HashMap::new();
    let mut is_changed = false;
    for i in 0..graph.nodes.len() {
        let node = &mut graph.nodes[i];
        for_each_operand(&mut node.what, |operand| {
            is_changed |= instead.replace(operand);
        });
        instead.find(i, node, &mut equal);
    }
    for (_, root) in &mut graph.roots {
        is_changed |= instead.replace(root);
    }
    is_changed
}

impl Replacements {
    /// Whether there is something in place of `operand`, which it is from then on.
    fn replace(&self, operand: &mut Operand) -> bool {
        // What is in its place may be a variable that never changes.
        for round in 0..MOST_ROUNDS {
            let (found, path) = match operand {
                Operand::Output(n, output, path) => (self.outputs.get(&(*n, *output)), path),
                Operand::Carried(n, v, path) | Operand::Last(n, v, path) => {
                    (self.carried.get(&(*n, *v)), path)
                }
                _ => return round > 0,
            };
            let Some(found) = found else { return round > 0 };
            *operand = with(found, path);
        }
        true
    }

    /// What outputs of node `i` are instead.
    fn find(&mut self, i: usize, node: &CheckedNode, equal: &mut HashMap<Key, usize>) {
        match &node.what {
            What::Call {
                function,
                arguments,
                object,
                stage,
            } => {
                if let Some(pure) = &function.pure {
                    let known: Vec<_> = (arguments.iter().enumerate())
                        .map(|(k, argument)| match argument {
                            Operand::Constant(literal) => Known::Value(literal.clone()),
                            // Arguments that are equal are one.
                            _ => {
                                let first = arguments.iter().position(|a| a == argument);
                                Known::Argument(first.unwrap_or(k), Vec::new())
                            }
                        })
                        .collect();
                    let is_vertex = *stage != Stage::Pixel;
                    self.put(i, function, arguments, is_vertex, pure.call(&known));
                }
                let key = match &function.call {
                    Call::Name(name) => Key::Name(name, arguments.clone(), *object, *stage),
                    // Values that can be set are not equal for good.
                    Call::Module(module) if module.parameter_bytes() > 0 => return,
                    Call::Module(module) => {
                        Key::Module(module.clone(), arguments.clone(), *object, *stage)
                    }
                };
                self.same(i, function.outputs.len(), key, equal);
            }
            What::If { condition, outputs } => {
                let decided = match condition {
                    Operand::Constant(literal) => literal.as_truth(),
                    _ => None,
                };
                for (output, (_, _, then, other)) in outputs.iter().enumerate() {
                    let taken = match decided {
                        Some(true) => then,
                        Some(false) => other,
                        None if then == other => then,
                        None => continue,
                    };
                    self.outputs.insert((i, output), taken.clone());
                }
                let branches = outputs.iter().map(|(_, _, a, b)| (a.clone(), b.clone()));
                let key = Key::If(condition.clone(), branches.collect());
                self.same(i, outputs.len(), key, equal);
            }
            What::Loop { .. } => {}
        }
    }

    fn same(&mut self, i: usize, outputs: usize, key: Key, equal: &mut HashMap<Key, usize>) {
        let first = *equal.entry(key).or_insert(i);
        if first == i {
            return;
        }
        for output in 0..outputs {
            let same = Operand::Output(first, output, Vec::new());
            self.outputs.entry((i, output)).or_insert(same);
        }
    }

    fn put(
        &mut self,
        i: usize,
        function: &Function,
        arguments: &[Operand],
        is_vertex: bool,
        result: Known,
    ) {
        let results = match result {
            Known::Members(members) if function.is_struct => members,
            one if !function.is_struct => vec![one],
            _ => return,
        };
        for (output, (known, port)) in results.into_iter().zip(&function.outputs).enumerate() {
            let operand = match known {
                Known::Value(literal) if literal.ty() == port.ty => Operand::Constant(literal),
                // Between the vertices copies are interpolated, each in its way.
                Known::Argument(k, path) if !is_vertex => match arguments.get(k) {
                    Some(argument) if !matches!(argument, Operand::Constant(_)) => {
                        with(argument, &path)
                    }
                    _ => continue,
                },
                _ => continue,
            };
            self.outputs.insert((i, output), operand);
        }
    }
}

/// `operand`, and members of it.
fn with(operand: &Operand, members: &[String]) -> Operand {
    let mut operand = operand.clone();
    match &mut operand {
        Operand::Constant(literal) => {
            for member in members {
                *literal = literal.components(member);
            }
        }
        Operand::Output(_, _, path) | Operand::Carried(_, _, path) | Operand::Last(_, _, path) => {
            path.extend(members.iter().cloned());
        }
        Operand::Texture(_) => {}
    }
    operand
}

/// Everything that a node reads.
fn for_each_operand(what: &mut What, mut f: impl FnMut(&mut Operand)) {
    match what {
        What::Call { arguments, .. } => arguments.iter_mut().for_each(f),
        What::If { condition, outputs } => {
            f(condition);
            for (_, _, then, other) in outputs {
                f(then);
                f(other);
            }
        }
        What::Loop {
            carry,
            while_,
            until,
            ..
        } => {
            for (_, _, start, next) in carry {
                f(start);
                f(next);
            }
            while_.iter_mut().chain(until).for_each(f);
        }
    }
}

/// What is read, of which nothing is left out: nodes, and outputs of `if`s or variables of loops.
struct Read {
    nodes: Vec<bool>,
    parts: Vec<Vec<bool>>,
    textures: Vec<bool>,
    open: Vec<(usize, Option<usize>)>,
}

impl Read {
    fn read(&mut self, operand: &Operand) {
        match operand {
            Operand::Constant(_) => {}
            Operand::Texture(i) => self.textures[*i] = true,
            Operand::Output(n, part, _)
            | Operand::Carried(n, part, _)
            | Operand::Last(n, part, _) => {
                if !std::mem::replace(&mut self.nodes[*n], true) {
                    self.open.push((*n, None));
                }
                if let Some(is_read) = self.parts[*n].get_mut(*part)
                    && !std::mem::replace(is_read, true)
                {
                    self.open.push((*n, Some(*part)));
                }
            }
        }
    }

    fn of(graph: &CheckedGraph) -> Read {
        let parts = |node: &CheckedNode| match &node.what {
            What::Call { .. } => 0,
            What::If { outputs, .. } => outputs.len(),
            What::Loop { carry, .. } => carry.len(),
        };
        let mut read = Read {
            nodes: vec![false; graph.nodes.len()],
            parts: graph.nodes.iter().map(|n| vec![false; parts(n)]).collect(),
            textures: vec![false; graph.textures.len()],
            open: Vec::new(),
        };
        for (_, root) in &graph.roots {
            read.read(root);
        }
        while let Some((n, part)) = read.open.pop() {
            match (&graph.nodes[n].what, part) {
                (What::Call { arguments, .. }, _) => arguments.iter().for_each(|a| read.read(a)),
                (What::If { condition, .. }, None) => read.read(condition),
                (What::Loop { while_, until, .. }, None) => {
                    while_.iter().chain(until).for_each(|c| read.read(c));
                }
                (What::If { outputs: list, .. } | What::Loop { carry: list, .. }, Some(part)) => {
                    read.read(&list[part].2);
                    read.read(&list[part].3);
                }
            }
        }
        read
    }
}

/// The place of each that is left, among those that are.
fn places(is_left: &[bool]) -> Vec<usize> {
    let mut next = 0;
    (is_left.iter())
        .map(|is_left| {
            let place = next;
            next += usize::from(*is_left);
            place
        })
        .collect()
}

/// `graph` without what nobody reads.
fn needed(graph: CheckedGraph) -> CheckedGraph {
    let read = Read::of(&graph);
    let node = places(&read.nodes);
    let part: Vec<_> = read.parts.iter().map(|parts| places(parts)).collect();
    let texture = places(&read.textures);
    let moved = |operand: &mut Operand| match operand {
        Operand::Constant(_) => {}
        Operand::Texture(i) => *i = texture[*i],
        Operand::Output(n, p, _) | Operand::Carried(n, p, _) | Operand::Last(n, p, _) => {
            if let Some(place) = part[*n].get(*p) {
                *p = *place;
            }
            *n = node[*n];
        }
    };
    let mut nodes = Vec::new();
    for (i, mut checked) in graph.nodes.into_iter().enumerate() {
        if !read.nodes[i] {
            continue;
        }
        if let What::If { outputs: list, .. } | What::Loop { carry: list, .. } = &mut checked.what {
            let mut is_read = read.parts[i].iter();
            list.retain(|_| is_read.next().copied().unwrap_or(true));
        }
        for_each_operand(&mut checked.what, moved);
        nodes.push(checked);
    }
    let mut roots = graph.roots;
    roots.iter_mut().for_each(|(_, root)| moved(root));
    let mut textures = graph.textures;
    let mut is_read = read.textures.iter();
    textures.retain(|_| is_read.next().copied().unwrap_or(true));
    CheckedGraph {
        nodes,
        roots,
        textures,
        warnings: graph.warnings,
    }
}
