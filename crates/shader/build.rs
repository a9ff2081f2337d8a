//! Makes Rust of the registry: reads `library/registry.txt` and the WGSL texts that it names, and writes the table of
//! functions with their parameters, the enums of the Plan, and the macro that lists them (`src/registry.rs`).

use std::env;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

#[allow(dead_code, reason = "the crate uses the rest")]
#[path = "src/parameter.rs"]
mod parameter;

use parameter::{Parameter, ParameterRelation, Scalar};

/// An enum of the Plan: its name, what it is, and variants that are no function of their own.
type Enum = (&'static str, &'static str, &'static str);

const ENUMS: [Enum; 10] = [
    ("Fetch", "What a voxel holds.", ""),
    ("Reconstruct", "How a value between voxels is found.", ""),
    ("Classify", "Value → colour and opacity.", ""),
    (
        "GradientInput",
        "What the gradient is taken of.",
        "",
    ),
    (
        "GradientMethod",
        "An estimate of the gradient: differences of the input along the voxel axes, turned into world space by the inverse transpose of `world_from_voxel`.",
        "",
    ),
    (
        "Illuminate",
        "What a surface does with one light. Diffuse parts are multiplied by the surface colour, highlights are white; nothing where the light comes from behind.",
        "",
    ),
    (
        "Shade",
        "How a sample's colour is made.",
        "/// The classified colour.
    Unlit,
    /// Ambient light and all lights, with the gradient as normal, turned towards the eye (two-sided): `lit`, or `lit_last_normal`.
    Lit {
        /// Share of the surface colour that is always there, ≥ 0.
        ambient: f32,
        /// What a surface does with one light.
        illuminate: Illuminate,
        /// Where the gradient is zero: the last normal of the ray; else, or if there is none yet, unlit.
        keep_last_normal: bool,
    },",
    ),
    (
        "Illustrate",
        "What illustration changes in the colour of a shaded sample; its opacity stays.",
        "/// Nothing.
    #[default]
    Plain,",
    ),
    (
        "Composite",
        "How the samples of a ray become a pixel (before the background).",
        "/// Not a picture of the data but of how it is made.
    Debug(DebugView),",
    ),
    (
        "DebugView",
        "What a debug view shows, opaque. \"The first sample\" is the first that the transfer function does not make transparent.",
        "",
    ),
];

/// A line of the registry, and what its text says.
struct Function {
    slot: String,
    name: String,
    plan: String,
    more: Vec<String>,
    meaning: String,
    parameters: Vec<Parameter>,
    adds_looks: bool,
}

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    println!("cargo::rerun-if-changed=library");
    println!("cargo::rerun-if-changed=src/parameter.rs");
    let mut functions = Vec::new();
    for (i, line) in fs::read_to_string("library/registry.txt")?
        .lines()
        .enumerate()
    {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let function = Function::read(line);
        functions.push(function.map_err(|e| format!("registry.txt, line {}: {e}", i + 1))?);
    }
    let mut text = String::new();
    table(&functions, &mut text)?;
    for of in &ENUMS {
        plan_enum(of, &functions, &mut text)?;
    }
    macro_of_lists(&functions, &mut text)?;
    fs::write(Path::new(&env::var("OUT_DIR")?).join("registry.rs"), text)?;
    Ok(())
}

impl Function {
    fn read(line: &str) -> Result<Function> {
        let words: Vec<_> = line.split_whitespace().map(str::to_owned).collect();
        let [slot, name, plan, more @ ..] = &words[..] else {
            return Err("a line has a slot, a function and its enum in the Plan".into());
        };
        if plan != "-" && !ENUMS.iter().any(|(of, ..)| of == plan) {
            return Err(format!("{plan} is no enum of the Plan").into());
        }
        let mut function = Function {
            slot: slot.clone(),
            name: name.clone(),
            plan: plan.clone(),
            more: more.to_vec(),
            meaning: String::new(),
            parameters: Vec::new(),
            adds_looks: false,
        };
        let file = format!("library/{}.wgsl", function.path());
        let source = fs::read_to_string(&file).map_err(|e| format!("{file}: {e}"))?;
        let lines = source.lines().map_while(|line| line.strip_prefix("//!"));
        function.meaning = lines.map(str::trim).collect::<Vec<_>>().join(" ");
        function.parameters = parameters(&source).map_err(|e| format!("{file}: {e}"))?;
        function.adds_looks = slot == "composite" && source.contains("= look(sample)");
        Ok(function)
    }

    /// The word behind `key:` or every one of them, separated by commas.
    fn word(&self, key: &str) -> Option<&str> {
        self.more
            .iter()
            .find_map(|more| more.strip_prefix(key)?.strip_prefix(':'))
    }

    fn has(&self, flag: &str) -> bool {
        self.more.iter().any(|more| more == flag)
    }

    /// Its text, in the library.
    fn path(&self) -> String {
        format!("{}/{}", self.slot, self.word("text").unwrap_or(&self.name))
    }

    fn variant(&self) -> String {
        let mut variant = String::new();
        for part in self.name.split('_') {
            let (first, rest) = part.split_at(1);
            variant += &first.to_uppercase();
            variant += rest;
        }
        variant
    }

    /// The variant with a name for each field.
    fn fields(&self) -> String {
        let names: Vec<_> = self.parameters.iter().map(|p| &*p.name).collect();
        match &names[..] {
            [] => String::new(),
            names => format!(" {{ {} }}", names.join(", ")),
        }
    }
}

/// The members of `struct Params`: a line each, their comments before them.
fn parameters(source: &str) -> Result<Vec<Parameter>> {
    let mut found = Vec::new();
    let Some((_, rest)) = source.split_once("struct Params {\n") else {
        return Ok(found);
    };
    let (body, _) = rest.split_once('}').ok_or("struct Params has no end")?;
    let (mut comment, mut end) = (Vec::new(), 0);
    for line in body.lines().map(str::trim) {
        if line.starts_with("///") {
            comment.push(line);
            continue;
        }
        let member = line.trim_end_matches(',').split_once(": ");
        let (name, ty) = member.ok_or_else(|| format!("`{line}` is no member of a struct"))?;
        let (scalar, components) = match ty {
            "f32" => (Scalar::F32, 1),
            "u32" => (Scalar::U32, 1),
            "i32" => (Scalar::I32, 1),
            "vec3f" => (Scalar::F32, 3),
            "vec4f" => (Scalar::F32, 4),
            _ => return Err(format!("{ty} is not known for parameters of the library").into()),
        };
        // The layout of WGSL: vectors of three are aligned as those of four.
        let align = 4 * if components == 3 {
            4
        } else {
            components as u32
        };
        let offset = u32::next_multiple_of(end, align);
        end = offset + 4 * components as u32;
        let mut parameter = Parameter::new(name.to_owned(), scalar, components, offset);
        parameter
            .describe(comment.drain(..))
            .map_err(|why| format!("parameter `{name}` {why}"))?;
        found.push(parameter);
    }
    Ok(found)
}

fn table(functions: &[Function], text: &mut String) -> Result<()> {
    writeln!(text, "/// Every function of the library, by slot.")?;
    writeln!(
        text,
        "pub static FUNCTIONS: [Function; {}] = [",
        functions.len()
    )?;
    for function in functions {
        let was: Vec<_> = function
            .word("was")
            .iter()
            .flat_map(|w| w.split(','))
            .collect();
        let skips = match function.word("skips") {
            None => "Nothing",
            Some("clear") => "Clear",
            Some("own") => "Own",
            Some(other) => return Err(format!("skips:{other} is not known").into()),
        };
        writeln!(
            text,
            "    Function {{\n        slot: {:?},\n        name: {:?},\n        word: {:?},\n        was: &{was:?},\n        has_text: {},\n        is_way_of: {:?},\n        text: include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/library/{}.wgsl\")),\n        meaning: {:?},\n        parameters: &[",
            function.slot,
            function.name,
            function.name.replace('_', "-"),
            function.word("text").is_none(),
            function.word("for"),
            function.path(),
            function.meaning,
        )?;
        for p in &function.parameters {
            let borrowed = |text: &str| format!("Cow::Borrowed({text:?})");
            let beside = match &p.beside {
                None => "None".to_owned(),
                Some(ParameterRelation::Not(other)) => {
                    format!("Some(ParameterRelation::Not({}))", borrowed(other))
                }
                Some(ParameterRelation::Above(other)) => {
                    format!("Some(ParameterRelation::Above({}))", borrowed(other))
                }
            };
            let unit = match &p.unit {
                None => "None".to_owned(),
                Some(unit) => format!("Some({})", borrowed(unit)),
            };
            writeln!(
                text,
                "            Parameter {{ name: {}, scalar: Scalar::{:?}, components: {}, offset: {}, meaning: {}, default: Cow::Borrowed(&{:?}), range: {:?}, unit: {unit}, beside: {beside} }},",
                borrowed(&p.name),
                p.scalar,
                p.components,
                p.offset,
                borrowed(&p.meaning),
                p.default,
                p.range,
            )?;
        }
        writeln!(
            text,
            "        ],\n        skips: Skips::{skips},\n        adds_looks: {},\n        mixes_layers: {},\n        keeps_one_number: {},\n        has_place: {},\n    }},",
            function.adds_looks,
            function.has("mixes"),
            function.has("one-number"),
            !function.has("no-place"),
        )?;
    }
    writeln!(text, "];\n")?;
    Ok(())
}

/// The meaning of a parameter, and what it may be, as far as that is said.
fn described(p: &Parameter) -> String {
    let mut text = p.meaning.to_string();
    let [low, high] = p.range;
    if low > f64::from(f32::MIN) && high < f64::from(u32::MAX) {
        text += &format!(" {low} to {high}.");
    }
    if let Some(ParameterRelation::Not(other)) = &p.beside {
        text += &format!(" Not `{other}`.");
    }
    if let Some(ParameterRelation::Above(other)) = &p.beside {
        text += &format!(" Above `{other}`.");
    }
    text
}

fn plan_enum(
    (name, meaning, more): &Enum,
    functions: &[Function],
    text: &mut String,
) -> Result<()> {
    let own = || {
        functions
            .iter()
            .enumerate()
            .filter(|(_, f)| f.plan == *name)
    };
    let has_numbers = own().any(|(_, f)| !f.parameters.is_empty()) || !more.is_empty();
    let eq = match has_numbers {
        true if more.contains("#[default]") => ", Default",
        true => "",
        false => ", Eq, Hash",
    };
    writeln!(text, "#[doc = {meaning:?}]")?;
    writeln!(
        text,
        "#[derive(Clone, Copy, Debug, PartialEq{eq})]\npub enum {name} {{"
    )?;
    for (_, function) in own() {
        writeln!(text, "    #[doc = {:?}]", function.meaning)?;
        let mut fields = String::new();
        for p in &function.parameters {
            let ty = p.type_name();
            write!(
                fields,
                "\n        #[doc = {:?}]\n        {}: {ty},",
                described(p),
                p.name
            )?;
        }
        match &fields[..] {
            "" => writeln!(text, "    {},", function.variant())?,
            fields => writeln!(text, "    {} {{{fields}\n    }},", function.variant())?,
        }
    }
    if !more.is_empty() {
        writeln!(text, "    {more}")?;
    }
    writeln!(text, "}}\n\nimpl {name} {{")?;

    let rest = match *name {
        "Composite" => "            Composite::Debug(view) => view.function(),\n",
        "Shade" => "            Shade::Unlit | Shade::Lit { .. } => None,\n",
        "Illustrate" => "            Illustrate::Plain => None,\n",
        _ => "",
    };
    // `Unlit` and `Plain` are no functions, `Lit` is one of two.
    let is_some = ["Shade", "Illustrate"].contains(name);
    let (ty, open, close) = match is_some {
        true => ("Option<&'static Function>", "Some(", ")"),
        false => ("&'static Function", "", ""),
    };
    writeln!(
        text,
        "    /// Its line in the registry.\n    pub fn function(self) -> {ty} {{\n        match self {{"
    )?;
    for (i, function) in own() {
        let fields = if function.parameters.is_empty() {
            ""
        } else {
            " { .. }"
        };
        writeln!(
            text,
            "            {name}::{}{fields} => {open}&FUNCTIONS[{i}]{close},",
            function.variant()
        )?;
    }
    writeln!(text, "{rest}        }}\n    }}\n")?;

    writeln!(
        text,
        "    /// The values of its parameters.\n    pub fn values(self) -> Vec<(&'static str, f64)> {{\n        match self {{"
    )?;
    for (_, function) in own() {
        let values = function
            .parameters
            .iter()
            .map(|p| format!("({:?}, f64::from({}))", p.name, p.name));
        let values = values.collect::<Vec<_>>().join(", ");
        writeln!(
            text,
            "            {name}::{}{} => vec![{values}],",
            function.variant(),
            function.fields()
        )?;
    }
    match *name {
        "Composite" => writeln!(text, "            Composite::Debug(view) => view.values(),")?,
        "Shade" => writeln!(
            text,
            "            Shade::Unlit | Shade::Lit {{ .. }} => vec![],"
        )?,
        "Illustrate" => writeln!(text, "            Illustrate::Plain => vec![],")?,
        _ => {}
    }
    writeln!(text, "        }}\n    }}\n")?;

    writeln!(
        text,
        "    /// The variant of a function by its name in the library, with the values that `value` gives for its parameters;\n    /// `None` if there is none.\n    pub fn of(name: &str, value: impl Fn(&str) -> f64) -> Option<{name}> {{"
    )?;
    if !own().any(|(_, f)| !f.parameters.is_empty()) && *name != "Composite" {
        writeln!(text, "        let _ = value;")?;
    }
    writeln!(text, "        Some(match name {{")?;
    for (_, function) in own() {
        let fields = function
            .parameters
            .iter()
            .map(|p| format!("{}: value({:?}) as {}", p.name, p.name, p.type_name()));
        let fields = fields.collect::<Vec<_>>().join(", ");
        let fields = if fields.is_empty() {
            fields
        } else {
            format!(" {{ {fields} }}")
        };
        writeln!(
            text,
            "            {:?} => {name}::{}{fields},",
            function.name,
            function.variant()
        )?;
    }
    let rest = match *name {
        "Composite" => "Composite::Debug(DebugView::of(name, value)?)",
        _ => "return None",
    };
    writeln!(text, "            _ => {rest},\n        }})\n    }}\n}}\n")?;
    Ok(())
}

/// `for_each_function!(Composite => then! { given })` is `then! { given …one entry per rule… }`.
fn macro_of_lists(functions: &[Function], text: &mut String) -> Result<()> {
    writeln!(
        text,
        "/// Calls the macro `$then` with what is given and the functions of an enum of the Plan, an entry each:\n/// `; \"What it does.\" Variant name \"word\" {{ field, field }}`.\n#[macro_export]\nmacro_rules! for_each_function {{"
    )?;
    for (name, ..) in &ENUMS {
        writeln!(
            text,
            "    ({name} => $then:ident ! {{ $($given:tt)* }}) => {{ $then! {{ $($given)*"
        )?;
        for function in functions.iter().filter(|f| f.plan == *name) {
            let fields: Vec<_> = function.parameters.iter().map(|p| &*p.name).collect();
            writeln!(
                text,
                "        ; {:?} {} {} {:?} {{ {} }}",
                function.meaning,
                function.variant(),
                function.name,
                function.name.replace('_', "-"),
                fields.join(", "),
            )?;
        }
        writeln!(text, "    }} }};")?;
    }
    writeln!(text, "}}")?;
    Ok(())
}
