//! What nodes can be: the functions of slots and of the library, patterns, and WGSL of one's own; each with
//! its ports.

use crate::error::Problem;
use crate::known::PureFunction;
use crate::model::Constant;
use crate::types::{Meaning, Type};
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex};
use strahl_shader::{Module, PRELUDE, SLOTS, built_in};

/// An input or output of a function.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// What its numbers are, if it matters.
    pub meaning: Option<Meaning>,
    /// What an input is that nothing is connected to; without one it has to be connected.
    pub default: Option<Constant>,
    /// A word for people.
    pub comment: String,
}

/// A function that a node can be.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its inputs, in the order of the call.
    pub inputs: Vec<Port>,
    /// Its outputs: `out`, or the members of its struct.
    pub outputs: Vec<Port>,
    /// Whether the outputs are members of what it returns.
    pub is_struct: bool,
    /// What is called.
    pub call: Call,
    /// The same, to be computed when a graph is compiled; `None` if it reads more than its arguments.
    pub(crate) pure: Option<Arc<PureFunction>>,
    /// A word for people.
    pub comment: String,
}

/// What a node calls.
#[derive(Clone, Debug, PartialEq)]
pub enum Call {
    /// A function of the loop's surroundings or of a slot, by its name.
    Name(&'static str),
    /// A function that the program gets for this node.
    Module(Arc<Module>),
}

/// The patterns that graphs can use: those that come with Strahl, and a project's own.
#[derive(Clone, Debug, Default)]
pub struct Patterns {
    own: HashMap<String, Arc<Module>>,
}

impl Patterns {
    /// Only those that come with Strahl.
    pub fn new() -> Patterns {
        Patterns::default()
    }

    /// Adds a pattern of the project's own: the WGSL of one function, in a file `name.wgsl`.
    ///
    /// # Errors
    /// The text is no node, or the name is taken.
    pub fn add(&mut self, name: &str, file: &str, source: &str) -> Result<(), Problem> {
        let taken =
            BUILT_IN.iter().any(|b| b.name == name) || TEXTS.iter().any(|(n, _)| *n == name);
        if taken || self.own.contains_key(name) {
            return Err(Problem::new(
                file,
                format!("there is a pattern `{name}` already; call the file otherwise"),
            ));
        }
        let module = Module::node(name, file, source);
        let module = module.map_err(|error| Problem::new(file, error.to_string()))?;
        self.own.insert(name.to_owned(), Arc::new(module));
        Ok(())
    }

    /// The names of all patterns, sorted.
    pub fn names(&self) -> Vec<String> {
        let built_in = BUILT_IN.iter().map(|b| b.name);
        let texts = TEXTS.iter().map(|(name, _)| *name);
        let mut names: Vec<String> = built_in.chain(texts).map(str::to_owned).collect();
        names.extend(self.own.keys().cloned());
        names.sort();
        names
    }

    /// The function of this name.
    ///
    /// # Errors
    /// There is none; the message names one like it.
    pub fn function(&self, name: &str) -> Result<Function, String> {
        if let Some(built_in) = BUILT_IN.iter().find(|b| b.name == name) {
            return Ok(built_in.function());
        }
        if let Some(module) = self.own.get(name) {
            return of_module(module.clone());
        }
        if let Some((_, text)) = TEXTS.iter().find(|(n, _)| *n == name) {
            return pattern(name, text);
        }
        let names = self.names();
        let near = nearest(name, names.iter().map(String::as_str));
        Err(match near {
            Some(near) => format!("there is no pattern `{name}`; did you mean `{near}`?"),
            None => format!(
                "there is no pattern `{name}`; there are: {}",
                names.join(", ")
            ),
        })
    }
}

/// The word among `known` that is hardly different.
pub(crate) fn nearest<'k>(word: &str, known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    known
        .map(|k| (strsim::damerau_levenshtein(word, k), k))
        .filter(|(distance, k)| *distance <= 2.max(k.len() / 4))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}

/// A function of the loop's surroundings as a node.
struct BuiltIn {
    name: &'static str,
    call: &'static str,
    comment: &'static str,
    inputs: &'static [(&'static str, &'static str, &'static str)],
    outputs: &'static [(&'static str, &'static str, &'static str)],
}

impl BuiltIn {
    fn function(&self) -> Function {
        let port = |(name, ty, meaning): &(&str, &str, &str)| Port {
            name: (*name).to_owned(),
            ty: Type::of(ty),
            meaning: Meaning::of(meaning),
            default: None,
            comment: String::new(),
        };
        Function {
            inputs: self.inputs.iter().map(port).collect(),
            outputs: self.outputs.iter().map(port).collect(),
            is_struct: self.outputs[0].0 != "out",
            call: Call::Name(self.call),
            pure: None,
            comment: self.comment.to_owned(),
        }
    }
}

/// The name of the pattern that is the ray itself, whose only argument is the pixel.
pub const RAY: &str = "ray";

/// What both ways to add a sample take.
const SAMPLE: [(&str, &str, &str); 5] = [
    ("state", "CompositeState", ""),
    ("value", "f32", "value"),
    ("lattice_point", "f32", "lattice_point"),
    ("position", "vec3f", "position.voxel"),
    ("to_eye", "vec3f", "direction.world"),
];

/// The same with what it looks like.
const SAMPLE_WITH_LOOK: [(&str, &str, &str); 7] = [
    SAMPLE[0],
    SAMPLE[1],
    SAMPLE[2],
    SAMPLE[3],
    SAMPLE[4],
    ("color", "vec3f", "color.linear"),
    ("opacity", "f32", "opacity.step"),
];

static BUILT_IN: [BuiltIn; 26] = [
    BuiltIn {
        name: RAY,
        call: "ray_of_pixel",
        comment: "The ray of the pixel.",
        inputs: &[],
        outputs: &[
            ("pixel", "vec2u", ""),
            ("frame", "u32", ""),
            ("origin_mm", "vec3f", "position.world"),
            ("direction", "vec3f", "direction.world"),
            ("to_eye", "vec3f", "direction.world"),
        ],
    },
    BuiltIn {
        name: "extent",
        call: "sampled_extent_mm",
        comment: "Where a ray is inside the sampled extent of the object: from and to, mm from its start.",
        inputs: &[
            ("origin_mm", "vec3f", "position.world"),
            ("direction", "vec3f", "direction.world"),
        ],
        outputs: &[("out", "vec2f", "length.mm")],
    },
    BuiltIn {
        name: "clip_ray",
        call: "clipped_ray_mm",
        comment: "What the scene's ray clips leave of an interval.",
        inputs: &[
            ("origin_mm", "vec3f", "position.world"),
            ("direction", "vec3f", "direction.world"),
            ("interval_mm", "vec2f", "length.mm"),
        ],
        outputs: &[("out", "vec2f", "length.mm")],
    },
    BuiltIn {
        name: "lattice",
        call: "lattice_of_ray",
        comment: "Where the samples of a ray lie: sample k at entry + (k + jitter) * step, voxel space.",
        inputs: &[
            ("origin_mm", "vec3f", "position.world"),
            ("direction", "vec3f", "direction.world"),
            ("interval_mm", "vec2f", "length.mm"),
            ("entry_at_mm", "f32", "length.mm"),
            ("jitter", "f32", ""),
        ],
        outputs: &[
            ("entry", "vec3f", "position.voxel"),
            ("step", "vec3f", ""),
            ("count", "f32", ""),
        ],
    },
    BuiltIn {
        name: "empty_points",
        call: "empty_points",
        comment: "How many lattice points from a position on lie where nothing can be seen under the scene's transfer function.",
        inputs: &[
            ("position", "vec3f", "position.voxel"),
            ("step", "vec3f", ""),
        ],
        outputs: &[("out", "f32", "")],
    },
    BuiltIn {
        name: "slice",
        call: "slice_of_pixel",
        comment: "The point of a slice that a pixel sees: distances along its ray, the way to the next slice, the position in the object's voxel space.",
        inputs: &[],
        outputs: &[
            ("pixel", "vec2u", ""),
            ("place_mm", "vec3f", "position.world"),
            ("distance_mm", "f32", "length.mm"),
            ("length_mm", "f32", "length.mm"),
            ("position", "vec3f", "position.voxel"),
            ("is_inside", "bool", ""),
            ("origin_mm", "vec3f", "position.world"),
            ("direction", "vec3f", "direction.world"),
            ("to_eye", "vec3f", "direction.world"),
        ],
    },
    BuiltIn {
        name: "slice_mm",
        call: "slice_distance_mm",
        comment: "How far in front of the eye, or of the plane of an orthographic picture, the slice lies along the view axis.",
        inputs: &[],
        outputs: &[("out", "f32", "length.mm")],
    },
    BuiltIn {
        name: "corner",
        call: "corner_of_picture",
        comment: "A corner of what is drawn, for nodes of the vertex stage: its place in the picture, in the slice (or where rays begin), and the way of one mm along the view axis.",
        inputs: &[],
        outputs: &[
            ("picture", "vec2f", ""),
            ("place_mm", "vec3f", "position.world"),
            ("along", "vec3f", ""),
        ],
    },
    BuiltIn {
        name: "is_value",
        call: "is_value",
        comment: "Whether a value is neither infinite nor NaN.",
        inputs: &[("value", "f32", "value")],
        outputs: &[("out", "bool", "")],
    },
    BuiltIn {
        name: "composite_start",
        call: "composite_start",
        comment: "What the scene's composite remembers of a ray without samples.",
        inputs: &[],
        outputs: &[("out", "CompositeState", "")],
    },
    BuiltIn {
        name: "composite_of_look",
        call: "composite_of_look",
        comment: "A sample with its look, added by the scene's composite; the opacity is that of a step.",
        inputs: &SAMPLE_WITH_LOOK,
        outputs: &[("out", "CompositeState", "")],
    },
    BuiltIn {
        name: "composite_of_sample",
        call: "composite_of_sample",
        comment: "A sample, added by a composite of the scene that asks for no look.",
        inputs: &SAMPLE,
        outputs: &[("out", "CompositeState", "")],
    },
    BuiltIn {
        name: "composite_done",
        call: "composite_done",
        comment: "Whether the scene's composite needs no more samples of the ray.",
        inputs: &[("state", "CompositeState", "")],
        outputs: &[("out", "bool", "")],
    },
    BuiltIn {
        name: "composite_finish",
        call: "composite_finish",
        comment: "The pixel that the scene's composite makes: color, premultiplied, and opacity.",
        inputs: &[("state", "CompositeState", "")],
        outputs: &[("out", "vec4f", "")],
    },
    BuiltIn {
        name: "enter_segment",
        call: "enter_segment",
        comment: "The segment at a position: that whose labels have the largest weight around it. Functions of techniques read the position that comes out.",
        inputs: &[("position", "vec3f", "position.voxel")],
        outputs: &[
            ("segment", "u32", ""),
            ("position", "vec3f", "position.voxel"),
        ],
    },
    BuiltIn {
        name: "no_runs",
        call: "no_runs",
        comment: "What a ray has seen before its first run.",
        inputs: &[],
        outputs: &[("out", "Runs", "")],
    },
    BuiltIn {
        name: "entered",
        call: "entered",
        comment: "The runs where the ray is in a segment: if it has left a group, this makes one sample.",
        inputs: &[("runs", "Runs", ""), ("segment", "u32", "")],
        outputs: &[("out", "Runs", "")],
    },
    BuiltIn {
        name: "technique_of_new_run",
        call: "technique_of_new_run",
        comment: "The technique of a run that begins, counted from 1; 0 if its segment is hidden, or covered by the runs before it.",
        inputs: &[("segment", "u32", ""), ("runs", "Runs", "")],
        outputs: &[("out", "u32", "")],
    },
    BuiltIn {
        name: "is_technique",
        call: "is_technique",
        comment: "Whether the technique of a run is this one, which is counted from 0.",
        inputs: &[("technique", "u32", ""), ("number", "u32", "")],
        outputs: &[("out", "bool", "")],
    },
    BuiltIn {
        name: "run_of_look",
        call: "run_of_look",
        comment: "A sample with its look, added to the run by the composite of the node's technique; the opacity is that of a step.",
        inputs: &SAMPLE_WITH_LOOK,
        outputs: &[("out", "CompositeState", "")],
    },
    BuiltIn {
        name: "run_of_sample",
        call: "run_of_sample",
        comment: "A sample, added to the run by a composite of the node's technique that asks for no look.",
        inputs: &SAMPLE,
        outputs: &[("out", "CompositeState", "")],
    },
    BuiltIn {
        name: "is_run_done",
        call: "is_run_done",
        comment: "Whether the composite of the run's technique needs no more samples.",
        inputs: &[("state", "CompositeState", ""), ("technique", "u32", "")],
        outputs: &[("out", "bool", "")],
    },
    BuiltIn {
        name: "with_place",
        call: "with_place",
        comment: "The importance of the places of a run, with one more; 0 without an importance volume.",
        inputs: &[
            ("by_place", "f32", ""),
            ("position", "vec3f", "position.voxel"),
        ],
        outputs: &[("out", "f32", "")],
    },
    BuiltIn {
        name: "with_closed_run",
        call: "with_closed_run",
        comment: "The runs with one more, which ends here; by the scene's rule for runs.",
        inputs: &[
            ("runs", "Runs", ""),
            ("state", "CompositeState", ""),
            ("by_place", "f32", ""),
            ("segment", "u32", ""),
            ("technique", "u32", ""),
        ],
        outputs: &[("out", "Runs", "")],
    },
    BuiltIn {
        name: "is_covered",
        call: "is_complete",
        comment: "Whether nothing behind the runs can be seen.",
        inputs: &[("runs", "Runs", "")],
        outputs: &[("out", "bool", "")],
    },
    BuiltIn {
        name: "pixel_of_runs",
        call: "pixel_of",
        comment: "The pixel that the runs make: color, premultiplied, and opacity.",
        inputs: &[("runs", "Runs", "")],
        outputs: &[("out", "vec4f", "")],
    },
];

/// Patterns that only a scene with segments has.
pub(crate) const OF_SEGMENTS: [&str; 12] = [
    "enter_segment",
    "entered",
    "no_runs",
    "technique_of_new_run",
    "is_technique",
    "run_of_look",
    "run_of_sample",
    "is_run_done",
    "with_place",
    "with_closed_run",
    "is_covered",
    "pixel_of_runs",
];

/// Patterns that a scene with segments does not have: each of its techniques has a composite of its own, and what
/// can be seen depends on the segment.
pub(crate) const NOT_OF_SEGMENTS: [&str; 4] = [
    "empty_points",
    "composite_of_look",
    "composite_of_sample",
    "composite_done",
];

macro_rules! texts {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../patterns/", $name, ".wgsl")))),+]
    };
}

static TEXTS: &[(&str, &str)] = include!("../patterns/list.in");

/// Patterns are read when they are first used.
fn pattern(name: &str, text: &str) -> Result<Function, String> {
    static READ: LazyLock<Mutex<HashMap<String, Function>>> = LazyLock::new(Mutex::default);
    let Ok(mut read) = READ.lock() else {
        return Err("a thread has failed while it read the patterns".to_owned());
    };
    if let Some(function) = read.get(name) {
        return Ok(function.clone());
    }
    let file = format!("patterns/{name}.wgsl");
    let module = Module::trusted_node(name, &file, text).map_err(|error| error.to_string())?;
    let function = of_module(Arc::new(module))?;
    read.insert(name.to_owned(), function.clone());
    Ok(function)
}

/// Slots that can be nodes, and the meanings of their ports and result.
type SlotRow = (
    &'static str,
    &'static [(&'static str, &'static str)],
    &'static str,
);

const OF_SLOTS: [SlotRow; 9] = [
    ("jitter", &[], ""),
    ("clip_sample", &[("place_mm", "position.world")], ""),
    ("reconstruct", &[("position", "position.voxel")], "value"),
    (
        "classify",
        &[("value", "value"), ("position", "position.voxel")],
        "",
    ),
    ("gradient_input", &[("position", "position.voxel")], ""),
    (
        "gradient",
        &[("position", "position.voxel")],
        "gradient.per_mm",
    ),
    (
        "illuminate",
        &[
            ("color", "color.linear"),
            ("normal", "direction.world"),
            ("to_eye", "direction.world"),
        ],
        "color.linear",
    ),
    (
        "shade",
        &[
            ("position", "position.voxel"),
            ("to_eye", "direction.world"),
        ],
        "",
    ),
    (
        "illustrate",
        &[
            ("color", "color.linear"),
            ("position", "position.voxel"),
            ("to_eye", "direction.world"),
        ],
        "color.linear",
    ),
];

/// The function that the settings put into `slot`.
///
/// # Errors
/// There is no such slot, or it is no single function of a sample.
pub fn of_slot(slot: &str) -> Result<Function, String> {
    let names = || OF_SLOTS.iter().map(|(name, ..)| *name);
    let Some((name, meanings, result)) = OF_SLOTS.iter().find(|(name, ..)| *name == slot) else {
        let known: Vec<_> = names().collect();
        return Err(match slot {
            "composite" | "light" | "clip_ray" => format!(
                "the slot {slot} is not one function; patterns take its place: over, under, larger, smaller, lighting, clip_ray"
            ),
            _ => format!(
                "there is no slot {slot} for nodes; they are {}",
                known.join(", ")
            ),
        });
    };
    let Some(signature) = (SLOTS.iter())
        .find(|s| s.name == *name)
        .and_then(|s| s.functions.first())
    else {
        return Err(format!("there is no slot {slot}"));
    };
    let meaning = |port: &str| {
        let found = meanings.iter().find(|(name, _)| *name == port);
        found.and_then(|(_, meaning)| Meaning::of(meaning))
    };
    let inputs = signature.arguments.iter().map(|(name, ty)| Port {
        name: (*name).to_owned(),
        ty: Type::of(ty),
        meaning: meaning(name),
        default: None,
        comment: String::new(),
    });
    Ok(Function {
        inputs: inputs.collect(),
        outputs: vec![Port {
            name: "out".to_owned(),
            ty: Type::of(signature.result),
            meaning: Meaning::of(result),
            default: None,
            comment: String::new(),
        }],
        is_struct: false,
        call: Call::Name(signature.name),
        pure: None,
        comment: format!("The scene's {slot}."),
    })
}

/// A function of the shader library, `slot/name`.
///
/// # Errors
/// There is none, or it cannot be a node.
pub fn of_library(path: &str) -> Result<Function, String> {
    let Some((slot, name)) = path.split_once('/') else {
        return Err(format!(
            "`{path}` is no function of the library; write slot/name, such as classify/table"
        ));
    };
    let module = built_in(slot, name).map_err(|error| error.to_string())?;
    if module.remembers() {
        return Err(format!(
            "{path} remembers something along the ray, which a graph carries openly; use a loop's carried variable"
        ));
    }
    let mut function = match slot {
        "fetch" | "light" => of_module(module.clone())?,
        _ => of_slot(slot)?,
    };
    function.comment = module.meaning().to_owned();
    function.call = Call::Module(module);
    Ok(function)
}

/// WGSL of one's own.
///
/// # Errors
/// What is wrong with it, with the place marked.
pub fn of_wgsl(name: &str, file: &str, source: &str) -> Result<Function, String> {
    let module = Module::node(name, file, source).map_err(|error| error.to_string())?;
    of_module(Arc::new(module))
}

/// The text of a node that is a uniform.
pub fn of_uniform(ty: &str) -> Result<Function, String> {
    let (
        Type::Vector(_, n),
        "f32" | "i32" | "u32" | "vec2f" | "vec3f" | "vec4f" | "vec2i" | "vec3i" | "vec4i" | "vec2u"
        | "vec3u" | "vec4u",
    ) = (Type::of(ty), ty)
    else {
        return Err(format!(
            "a uniform cannot be a {ty}; it is f32, i32, u32 or a vector of them, such as vec3f"
        ));
    };
    let default = match n {
        1 => "0".to_owned(),
        n => format!("({})", vec!["0"; n].join(", ")),
    };
    let source = format!(
        "struct Params {{\n    /// default {default}\n    value: {ty},\n}}\n\nfn uniform_value() -> {ty} {{\n    return params.value;\n}}\n"
    );
    let module = Module::trusted_node("uniform", "uniform", &source);
    of_module(Arc::new(module.map_err(|error| error.to_string())?))
}

fn is_derivative(word: &str) -> bool {
    let function = word.trim_end_matches("Fine").trim_end_matches("Coarse");
    matches!(function, "dpdx" | "dpdy" | "fwidth")
}

/// Reads what the comment of the function says of its ports: lines `name: meaning, default X, words`.
fn of_module(module: Arc<Module>) -> Result<Function, String> {
    let ports = module.ports().clone();
    if module.remembers() {
        return Err(format!(
            "{} has a `var<private>`; a graph carries what it remembers openly, in a loop's variables",
            module.file()
        ));
    }
    if let Some(derivative) = module.words().find(|word| is_derivative(word)) {
        return Err(format!(
            "{} calls `{derivative}`, which needs neighboring pixels; functions of a ray cannot use derivatives",
            module.file()
        ));
    }
    let mut inputs: Vec<Port> = (ports.arguments.iter())
        .map(|(name, ty)| Port {
            name: name.clone(),
            ty: Type::of(ty),
            meaning: None,
            default: None,
            comment: String::new(),
        })
        .collect();
    let mut result = Port {
        name: "out".to_owned(),
        ty: Type::of(&ports.result),
        meaning: None,
        default: None,
        comment: String::new(),
    };
    let mut comment = Vec::new();
    for line in &ports.comment {
        let described = line.split_once(':').and_then(|(name, rest)| {
            let port = match name.trim() {
                "result" => Some(&mut result),
                name => inputs.iter_mut().find(|p| p.name == name),
            }?;
            Some((port, rest))
        });
        match described {
            Some((port, rest)) => describe(port, rest).map_err(|why| {
                format!("{}: the comment of `{}` {why}", module.file(), port.name)
            })?,
            None => comment.push(line.clone()),
        }
    }
    let is_struct = !ports.members.is_empty();
    let outputs = if is_struct {
        let member = |(name, ty, text): &(String, String, String)| {
            let mut port = Port {
                name: name.clone(),
                ty: Type::of(ty),
                meaning: None,
                default: None,
                comment: String::new(),
            };
            describe(&mut port, text).map(|()| port)
        };
        let members: Result<Vec<_>, _> = ports.members.iter().map(member).collect();
        members.map_err(|why| format!("{}: the comment of a member {why}", module.file()))?
    } else {
        vec![result]
    };
    let words = match module.meaning() {
        "" => comment.join(" "),
        meaning => meaning.replace('\n', " "),
    };
    let is_pure = module.parameter_bytes() == 0 && module.needs().is_empty();
    let pure = is_pure
        .then(|| PureFunction::of(module.source(), module.main(), PRELUDE))
        .flatten();
    Ok(Function {
        inputs,
        outputs,
        is_struct,
        call: Call::Module(module),
        pure: pure.map(Arc::new),
        comment: words.trim().to_owned(),
    })
}

fn describe(port: &mut Port, text: &str) -> Result<(), String> {
    let mut words = Vec::new();
    // Commas inside parentheses belong to a vector.
    let mut depth = 0;
    let parts = text.split(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth == 0
    });
    for part in parts {
        let part = part.trim();
        if let Some(meaning) = Meaning::of(part) {
            port.meaning = Some(meaning);
        } else if let Some(value) = part.strip_prefix("default ") {
            port.default = Some(constant(value).ok_or_else(|| {
                format!("has the default {value}; write a number, (1, 2, 3), true or false")
            })?);
        } else {
            let is_like = part.starts_with("position.")
                || part.starts_with("color.")
                || part.starts_with("opacity.")
                || part.starts_with("gradient.")
                || part.starts_with("direction.");
            if is_like && !part.contains(' ') {
                let known: Vec<_> = Meaning::names().collect();
                return Err(format!(
                    "has the meaning {part}, which is none of {}",
                    known.join(", ")
                ));
            }
            words.push(part);
        }
    }
    port.comment = words.join(", ");
    Ok(())
}

fn constant(text: &str) -> Option<Constant> {
    match text.trim() {
        "true" => Some(Constant::Bool(true)),
        "false" => Some(Constant::Bool(false)),
        text => {
            let inner = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'));
            let numbers = inner.unwrap_or(text).split(',').map(|n| n.trim().parse());
            Some(Constant::Numbers(numbers.collect::<Result<_, _>>().ok()?))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pattern_is_a_node() {
        for name in Patterns::new().names() {
            let function = Patterns::new().function(&name).expect(&name);
            assert!(!function.outputs.is_empty(), "{name}");
            assert!(!function.comment.is_empty(), "{name} has no comment");
        }
    }
}
