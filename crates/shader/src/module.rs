//! A module: the WGSL text of one function for one slot.

use crate::error::Error;
use crate::nesting::{DEEPEST, deepest, with_stack};
use crate::parameter::{Parameter, ParameterRelation, Scalar};
use crate::report::Report;
use crate::slot::{SLOTS, SUPPLIED, Signature, Slot};
use crate::token::{Declaration, DeclarationKind, Token, declarations, tokens};
use naga::front::wgsl;
use naga::proc::GlobalCtx;
use naga::valid::{
    CallError, Capabilities, FunctionError, ValidationError, ValidationFlags, Validator,
};
use naga::{
    Expression, Function, Handle, ScalarKind, ShaderStage, Statement, TypeInner, VectorSize,
};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashSet};
use std::fmt::Write;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

/// The types that every module may use, and what they mean.
pub const PRELUDE: &str = include_str!("prelude.wgsl");

/// A text longer than this is not a shader function.
pub const MOST_MODULE_BYTES: usize = 256 << 10;

/// Calls that one call of a function may lead to, those of loops counted once.
const MOST_CALLS: u64 = 1 << 16;

/// Functions that call one another in a chain.
const DEEPEST_CALLS: usize = 200;

/// What waits for others, which rays never do.
const BARRIERS: [&str; 4] = [
    "workgroupBarrier",
    "storageBarrier",
    "textureBarrier",
    "workgroupUniformLoad",
];

/// No variable of a function may take more, because a GPU has to keep it for every ray at once.
const LARGEST_TYPE: u32 = 16 << 10;

/// A checked shader function: its slot, parameters and needs, all read from its text.
#[derive(Clone, Debug)]
pub struct Module {
    slot: &'static Slot,
    /// The function that stands for the module: of its slot, or the one of a node.
    main: String,
    signature: Arc<Ports>,
    name: String,
    file: String,
    source: Arc<str>,
    meaning: String,
    parameters: Vec<Parameter>,
    parameter_bytes: u32,
    needs: Vec<&'static str>,
    remembers: bool,
    is_back_to_front: bool,
    is_built_in: bool,
    hash: u64,
    pub(crate) tokens: Vec<Token>,
    pub(crate) declarations: Vec<Declaration>,
}

/// What the main function of a module takes and gives.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ports {
    /// Name and type of each argument.
    pub arguments: Vec<(String, String)>,
    /// The type of the result, empty for none.
    pub result: String,
    /// The members of the result if it is a struct that the module itself declares: name, type and comment.
    pub members: Vec<(String, String, String)>,
    /// The lines of the function's comment.
    pub comment: Vec<String>,
}

impl Module {
    /// Reads and checks a function that stands in no slot but is a node of a graph: any arguments, any
    /// result. Of several functions it is the one that no other calls. Functions with names of functions that every
    /// module may call get other names.
    ///
    /// # Errors
    /// As [`Module::parse`]; and if no function or several could be meant, or one has the name of a slot's.
    pub fn node(name: &str, file: &str, source: &str) -> Result<Module, Error> {
        Module::checked(name, file, &with_free_names(source), false, true)
    }

    /// Reads and checks a node of a library: its loops end.
    ///
    /// # Errors
    /// As [`Module::node`].
    pub fn trusted_node(name: &str, file: &str, source: &str) -> Result<Module, Error> {
        Module::checked(name, file, source, true, true)
    }

    /// Every word of its text.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        self.tokens.iter().map(|token| token.text(&self.source))
    }

    /// The name of the function that stands for the module.
    pub fn main(&self) -> &str {
        &self.main
    }

    /// What its main function takes and gives.
    pub fn ports(&self) -> &Ports {
        &self.signature
    }

    /// Reads and checks a module of a user. `name` is what it is called, `file` where it stands;
    /// both for messages.
    ///
    /// # Errors
    /// [`Error::Text`] with the place and what would be right: if the text is not WGSL, defines no
    /// function of a slot or one with another signature, binds resources, is an entry point, takes
    /// names that are taken, or has parameters that do not say their default.
    pub fn parse(name: &str, file: &str, source: &str) -> Result<Module, Error> {
        Module::checked(name, file, source, false, false)
    }

    pub(crate) fn built_in(name: &str, file: &str, source: &str) -> Result<Module, Error> {
        Module::checked(name, file, source, true, false)
    }

    /// The slot that it can stand in.
    pub fn slot(&self) -> &'static Slot {
        self.slot
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file it comes from.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Its text.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// What it does: its comments of the form `//!`.
    pub fn meaning(&self) -> &str {
        &self.meaning
    }

    /// Its parameters, in the order of the struct.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The size of its struct `Params` in bytes, 0 without one.
    pub fn parameter_bytes(&self) -> u32 {
        self.parameter_bytes
    }

    /// The functions of slots, and those that the renderer supplies, that it calls; sorted.
    pub fn needs(&self) -> &[&'static str] {
        &self.needs
    }

    /// Whether it has variables that live as long as the ray.
    pub fn remembers(&self) -> bool {
        self.remembers
    }

    /// Whether it is a composite that gets the samples of a ray from the last to the first. It says so
    /// by `const BACK_TO_FRONT: bool = true;`.
    pub fn is_back_to_front(&self) -> bool {
        self.is_back_to_front
    }

    /// Whether it belongs to the library.
    pub fn is_built_in(&self) -> bool {
        self.is_built_in
    }

    fn checked(
        name: &str,
        file: &str,
        source: &str,
        is_built_in: bool,
        is_node: bool,
    ) -> Result<Module, Error> {
        let text = Text { file, source };
        if source.len() > MOST_MODULE_BYTES {
            return Err(text.error(
                format!(
                    "the text has {} bytes; a module has at most {MOST_MODULE_BYTES}",
                    source.len()
                ),
                0..0,
                "",
                [],
            ));
        }
        let tokens = tokens(source);
        let depth = text.check_nesting(&tokens)?;
        let declarations = declarations(source, &tokens);
        text.check_declarations(&tokens, &declarations, is_node)?;
        let slot = if is_node {
            text.no_slot(&declarations)?;
            &NODE
        } else {
            text.slot(&declarations)?
        };
        let has_parameters = declarations
            .iter()
            .any(|d| d.kind == DeclarationKind::Struct && d.name == "Params");

        let surroundings = surroundings(slot, has_parameters);
        let whole = format!("{source}\n{surroundings}");
        let naga = with_stack(depth, || text.parsed(&whole))?;
        let functions = if is_node {
            vec![text.main(&declarations, &naga)?]
        } else {
            text.check_signatures(slot, &declarations, &naga)?
        };
        text.check_sizes(&declarations, &naga)?;
        text.check_calls(&declarations, &naga)?;
        let (parameters, parameter_bytes) = text.parameters(&declarations, &naga)?;

        let mut hasher = DefaultHasher::new();
        (source, is_built_in).hash(&mut hasher);
        let main = functions
            .first()
            .and_then(|f| naga.functions[*f].name.clone());
        let signature = functions.first().map(|f| ports(&naga, *f, &declarations));
        Ok(Module {
            slot,
            main: main.unwrap_or_default(),
            signature: Arc::new(signature.unwrap_or_default()),
            name: name.to_owned(),
            file: file.to_owned(),
            source: source.into(),
            meaning: meaning(source),
            parameters,
            parameter_bytes,
            needs: needs(slot, &naga, &functions),
            remembers: declarations
                .iter()
                .any(|d| d.kind == DeclarationKind::Private),
            is_back_to_front: slot.name == "composite" && is_true(&naga, "BACK_TO_FRONT"),
            is_built_in,
            hash: hasher.finish(),
            tokens,
            declarations,
        })
    }
}

impl PartialEq for Module {
    /// Modules with the same text link to the same program, whatever they are called.
    fn eq(&self, other: &Module) -> bool {
        self.is_built_in == other.is_built_in && self.source == other.source
    }
}

impl Eq for Module {}

impl Hash for Module {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.hash.hash(state);
    }
}

/// What nodes of graphs stand in.
static NODE: Slot = Slot {
    name: "node",
    meaning: "a node of a graph",
    functions: &[],
    fold: crate::slot::Fold::One,
    null: None,
};

fn ports(naga: &naga::Module, handle: Handle<Function>, found: &[Declaration]) -> Ports {
    let function = &naga.functions[handle];
    let argument = |a: &naga::FunctionArgument| {
        let name = a.name.clone().unwrap_or_default();
        (name, type_name(naga, a.ty))
    };
    let comments = naga.doc_comments.as_deref();
    let lines = |text: &Vec<String>| -> Vec<String> {
        let lines = text.iter().flat_map(|text| text.lines());
        let bare = lines.map(|line| line.trim_start_matches('/').trim().to_owned());
        bare.collect()
    };
    let comment = comments.and_then(|c| c.functions.get(&handle));
    let mut ports = Ports {
        arguments: function.arguments.iter().map(argument).collect(),
        comment: comment.map(lines).unwrap_or_default(),
        ..Ports::default()
    };
    let Some(result) = &function.result else {
        return ports;
    };
    ports.result = type_name(naga, result.ty);
    let is_own = |d: &Declaration| d.kind == DeclarationKind::Struct && d.name == ports.result;
    if let TypeInner::Struct { members, .. } = &naga.types[result.ty].inner
        && found.iter().any(is_own)
    {
        let members = members.iter().enumerate().map(|(i, member)| {
            let comment = comments.and_then(|c| c.struct_members.get(&(result.ty, i)));
            let name = member.name.clone().unwrap_or_default();
            let comment = comment.map(lines).unwrap_or_default().join("\n");
            (name, type_name(naga, member.ty), comment)
        });
        ports.members = members.collect();
    }
    ports
}

/// Whether there is a constant of this name, and it is true.
fn is_true(naga: &naga::Module, name: &str) -> bool {
    let mut constants = naga.constants.iter();
    let found = constants.find(|(_, constant)| constant.name.as_deref() == Some(name));
    found.is_some_and(|(_, constant)| {
        let value = &naga.global_expressions[constant.init];
        matches!(value, Expression::Literal(naga::Literal::Bool(true)))
    })
}

/// The comments of the form `//!`.
fn meaning(source: &str) -> String {
    let lines = source.lines().map_while(|line| line.strip_prefix("//!"));
    lines.map(str::trim).collect::<Vec<_>>().join("\n")
}

/// What stands around a module when it is checked alone: the prelude, every function that it could
/// need, its parameter block. It comes after the module, so that places in the text stay as they are.
fn surroundings(own: &Slot, has_parameters: bool) -> String {
    let others = SLOTS.iter().filter(|slot| *slot != own);
    let mut text = PRELUDE.to_owned();
    for function in others.flat_map(|slot| slot.functions).chain(&SUPPLIED) {
        // The state of a composite is known only to itself, and nobody calls its functions.
        if function.name.starts_with("composite_") {
            continue;
        }
        let _ = match function.result {
            "" => writeln!(text, "{function} {{}}"),
            result => writeln!(text, "{function} {{ return {result}(); }}"),
        };
    }
    if has_parameters {
        text.push_str("@group(0) @binding(0) var<uniform> params: Params;\n");
    }
    text
}

/// The text under check, for messages.
struct Text<'t> {
    file: &'t str,
    source: &'t str,
}

impl Text<'_> {
    fn error<const N: usize>(
        &self,
        message: impl Into<String>,
        place: Range<usize>,
        label: impl Into<String>,
        notes: [String; N],
    ) -> Error {
        Error::Text(Box::new(Report {
            message: message.into(),
            file: self.file.to_owned(),
            source: self.source.into(),
            labels: vec![(place, label.into())],
            notes: notes.into(),
        }))
    }

    /// How deep the text nests.
    ///
    /// # Errors
    /// Deeper than any function that a person writes.
    fn check_nesting(&self, tokens: &[Token]) -> Result<usize, Error> {
        let (depth, place) = deepest(self.source, tokens);
        if depth <= DEEPEST {
            return Ok(depth);
        }
        Err(self.error(
            format!("the text nests {depth} deep; at most {DEEPEST} is read"),
            place,
            "the deepest place",
            ["brackets and operators count; give parts of it a name by `let`".into()],
        ))
    }

    /// Refuses functions that lead to more calls, or deeper ones, than is sensible for a ray.
    fn check_calls(&self, found: &[Declaration], naga: &naga::Module) -> Result<(), Error> {
        // Number and depth; functions come after those that they call.
        let mut calls = vec![(0u64, 0usize); naga.functions.len()];
        for (handle, function) in naga.functions.iter() {
            let mut direct = Vec::new();
            called(&function.body, &mut direct);
            let (mut number, mut depth) = (0u64, 0);
            for callee in direct {
                let (of_callee, depth_of_callee) = calls[callee.index()];
                number = number.saturating_add(of_callee).saturating_add(1);
                depth = depth.max(1 + depth_of_callee);
            }
            calls[handle.index()] = (number, depth);
            let name = function.name.as_deref().unwrap_or_default();
            let (what, note) = if number > MOST_CALLS {
                (
                    format!(
                        "`{name}` leads to {number} calls of functions; at most {MOST_CALLS} are allowed"
                    ),
                    "every ray makes them at every sample; call what is needed twice once, and keep its result",
                )
            } else if depth > DEEPEST_CALLS {
                (
                    format!(
                        "`{name}` calls functions {depth} deep; at most {DEEPEST_CALLS} are allowed"
                    ),
                    "let fewer functions do more",
                )
            } else {
                continue;
            };
            let declaration = found.iter().find(|d| d.name == name);
            let place = declaration.map_or(0..0, |d| d.span.clone());
            return Err(self.error(what, place, "declared here", [note.into()]));
        }
        Ok(())
    }

    /// Refuses what belongs to whole programs, and names that are taken.
    fn check_declarations(
        &self,
        tokens: &[Token],
        found: &[Declaration],
        is_node: bool,
    ) -> Result<(), Error> {
        // Nodes may not have a `var<private>`: a graph keeps state in the variables of loops.
        let instead = match is_node {
            true => {
                "a node gets its data as arguments; numbers that are set from outside are members of `struct Params`"
            }
            false => {
                "numbers that are set from outside are members of `struct Params`; voxels are read with `fetch`, `texel` or `reconstruct`; a `var<private>` keeps state along the ray"
            }
        };
        for declaration in found {
            let place = declaration.span.clone();
            let name = &declaration.name;
            match declaration.kind {
                DeclarationKind::Resource => {
                    return Err(self.error(
                        "a module cannot bind resources",
                        place,
                        "declared here",
                        [instead.into()],
                    ));
                }
                DeclarationKind::Directive => {
                    return Err(self.error(
                        "a module cannot enable extensions",
                        place,
                        "enabled here",
                        ["it has to run on every adapter; remove the line".into()],
                    ));
                }
                _ => {}
            }
            if is_taken(name) {
                return Err(self.error(
                    format!("the name `{name}` is taken"),
                    place,
                    "declared here",
                    [format!(
                        "`{name}` is a name that every module can use as it is; choose another one"
                    )],
                ));
            }
        }
        for pair in tokens.windows(2) {
            let attribute = pair[1].text(self.source);
            if !pair[0].is(b'@') {
                continue;
            }
            let wrong = match attribute {
                "vertex" | "fragment" | "compute" | "workgroup_size" | "builtin" | "location" => {
                    "a module has no entry point; it defines the function of a slot"
                }
                "group" | "binding" | "id" => "a module cannot bind resources",
                _ => continue,
            };
            return Err(self.error(wrong, pair[0].span.start..pair[1].span.end, "here", []));
        }
        for token in tokens {
            let word = token.text(self.source);
            if BARRIERS.contains(&word) {
                return Err(self.error(
                    format!("a module does not wait: `{word}`"),
                    token.span.clone(),
                    "here",
                    ["rays are drawn alone, in any order; leave it out".into()],
                ));
            }
        }
        // `params` is put in by the linker, so nothing else may have that name.
        for window in tokens.windows(2) {
            let [word, name] = [window[0].text(self.source), window[1].text(self.source)];
            if matches!(word, "let" | "var" | "const" | "fn") && name == "params" {
                return Err(self.error(
                    "the name `params` is taken",
                    window[1].span.clone(),
                    "declared here",
                    ["`params` holds the values of `struct Params`; choose another name".into()],
                ));
            }
        }
        Ok(())
    }

    /// The one slot whose function is defined.
    fn slot(&self, found: &[Declaration]) -> Result<&'static Slot, Error> {
        let functions = || found.iter().filter(|d| d.kind == DeclarationKind::Function);
        let mut slots = functions().filter_map(|d| {
            let slot = SLOTS
                .iter()
                .find(|slot| slot.functions.iter().any(|f| f.name == d.name))?;
            Some((slot, d))
        });
        let Some((slot, first)) = slots.next() else {
            let names: Vec<_> = SLOTS.iter().map(|slot| slot.name).collect();
            let near = functions().find_map(|d| {
                let near = names
                    .iter()
                    .find(|name| strsim::damerau_levenshtein(name, &d.name) <= 2)?;
                Some((d, near))
            });
            let (place, label) = match near {
                Some((d, near)) => (d.span.clone(), format!("did you mean `{near}`?")),
                None => (0..0, String::new()),
            };
            return Err(self.error(
                "the module defines no function of a slot",
                place,
                label,
                [format!(
                    "its main function is named after the slot that it stands in: {}",
                    names.join(", ")
                )],
            ));
        };
        if let Some((_, other)) = slots.find(|(other, _)| *other != slot) {
            return Err(self.error(
                "the module defines functions of two slots",
                other.span.clone(),
                format!("`{}` was defined before", first.name),
                [
                    "one module fills one slot; put the other function into a module of its own"
                        .into(),
                ],
            ));
        }
        for function in slot.functions {
            if !functions().any(|d| d.name == function.name) {
                return Err(self.error(
                    format!("the function `{}` is missing", function.name),
                    first.span.clone(),
                    format!("the slot {} needs it beside this one", slot.name),
                    [format!("add `{function}`")],
                ));
            }
        }
        Ok(slot)
    }

    /// Refuses functions that have the name of a slot's.
    fn no_slot(&self, found: &[Declaration]) -> Result<(), Error> {
        let of_slot = |d: &&Declaration| {
            let mut functions = SLOTS.iter().flat_map(|slot| slot.functions);
            d.kind == DeclarationKind::Function && functions.any(|f| f.name == d.name)
        };
        let Some(taken) = found.iter().find(of_slot) else {
            return Ok(());
        };
        Err(self.error(
            format!("the name `{}` is that of a slot", taken.name),
            taken.span.clone(),
            "declared here",
            ["a node's function has a name of its own; it may call those of slots".into()],
        ))
    }

    /// The function that no other calls.
    fn main(&self, found: &[Declaration], naga: &naga::Module) -> Result<Handle<Function>, Error> {
        let declared = |name: &str| {
            let mut functions = found.iter().filter(|d| d.kind == DeclarationKind::Function);
            functions.find(|d| d.name == name)
        };
        let mut called_by_others = Vec::new();
        let mut own = Vec::new();
        for (handle, function) in naga.functions.iter() {
            if let Some(declaration) = function.name.as_deref().and_then(declared) {
                own.push((handle, declaration));
                called(&function.body, &mut called_by_others);
            }
        }
        own.retain(|(handle, _)| !called_by_others.contains(handle));
        match own[..] {
            [(handle, declaration)] => {
                if naga.functions[handle].result.is_none() {
                    return Err(self.error(
                        format!("`{}` gives no result", declaration.name),
                        declaration.span.clone(),
                        "declared here",
                        ["a node is what it returns; several results are a struct".into()],
                    ));
                }
                Ok(handle)
            }
            [] => Err(self.error("the text defines no function", 0..0, "", [])),
            [(_, first), (_, second), ..] => Err(self.error(
                format!(
                    "both `{}` and `{}` could be the node",
                    first.name, second.name
                ),
                second.span.clone(),
                "no other function calls it",
                ["of several functions the node is the one that no other calls".into()],
            )),
        }
    }

    /// Parses and validates the module with its surroundings.
    fn parsed(&self, whole: &str) -> Result<naga::Module, Error> {
        let own = |span: naga::Span| {
            let range = span.to_range()?;
            (range.end <= self.source.len()).then_some(range)
        };
        let options = wgsl::Options {
            parse_doc_comments: true,
            capabilities: Capabilities::empty(),
        };
        let parsed = wgsl::Frontend::new_with_options(options).parse(whole);
        let module = parsed.map_err(|error| {
            let found = error
                .labels()
                .filter_map(|(span, text)| Some((own(span)?, text.to_owned())));
            let mut notes: Vec<_> = error.notes().map(str::to_owned).collect();
            if error.message().contains("`params`") {
                notes.push("`params` is there when the module declares `struct Params`".into());
            }
            let mut labels: Vec<_> = found.collect();
            let mut message = error.message().to_owned();
            // The parser's own limit, below ours for brackets in brackets; it names no place.
            if notes.iter().any(|note| note.contains("recursion limit")) {
                let (depth, place) = deepest(self.source, &tokens(self.source));
                message =
                    format!("the text nests {depth} deep, which the parser of WGSL cannot follow");
                labels = vec![(place, "here".to_owned())];
                notes = vec!["brackets in one another are read up to about 120 deep".to_owned()];
            }
            Error::Text(Box::new(Report {
                message,
                file: self.file.to_owned(),
                source: self.source.into(),
                labels,
                notes,
            }))
        })?;
        Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .map_err(|error| {
                let mut labels: Vec<_> = error
                    .spans()
                    .filter_map(|(span, text)| Some((own(*span)?, text.clone())))
                    .collect();
                // The innermost place is the one that the innermost reason speaks of.
                labels.sort_by_key(|(range, _)| range.len());
                labels.truncate(2);
                for (_, text) in &mut labels {
                    // Names of the compiler's own types tell nobody anything.
                    if text.starts_with("naga::") {
                        text.clear();
                    }
                }
                Error::Text(Box::new(Report {
                    message: reason(error.as_inner(), &module),
                    file: self.file.to_owned(),
                    source: self.source.into(),
                    labels,
                    notes: Vec::new(),
                }))
            })?;
        Ok(module)
    }

    /// Compares the functions with the signatures of the slot.
    fn check_signatures(
        &self,
        slot: &'static Slot,
        found: &[Declaration],
        naga: &naga::Module,
    ) -> Result<Vec<Handle<Function>>, Error> {
        let mut handles = Vec::new();
        for wanted in slot.functions {
            let Some((handle, function)) = naga
                .functions
                .iter()
                .find(|(_, f)| f.name.as_deref() == Some(wanted.name))
            else {
                continue; // `slot` has seen that it is there
            };
            handles.push(handle);
            let arguments: Vec<_> = function
                .arguments
                .iter()
                .map(|a| (a.name.clone().unwrap_or_default(), type_name(naga, a.ty)))
                .collect();
            let result = function
                .result
                .as_ref()
                .map_or("nothing".to_owned(), |r| type_name(naga, r.ty));
            let types = arguments.iter().map(|(_, kind)| kind.as_str());
            if types.eq(wanted.arguments.iter().map(|(_, kind)| *kind)) && result == wanted.result {
                continue;
            }
            let list: Vec<_> = arguments.iter().map(|(n, k)| format!("{n}: {k}")).collect();
            let place = found
                .iter()
                .find(|d| d.kind == DeclarationKind::Function && d.name == wanted.name)
                .map_or(0..0, |d| d.span.clone());
            return Err(self.error(
                format!("`{}` has another signature than its slot", wanted.name),
                place,
                format!("expected `{wanted}`"),
                [
                    format!(
                        "found    `fn {}({}) -> {result}`",
                        wanted.name,
                        list.join(", ")
                    ),
                    format!(
                        "a function in the slot {} computes {}",
                        slot.name, slot.meaning
                    ),
                ],
            ));
        }
        Ok(handles)
    }

    /// Refuses types that no GPU can keep for every ray.
    fn check_sizes(&self, found: &[Declaration], naga: &naga::Module) -> Result<(), Error> {
        for (_, ty) in naga.types.iter() {
            let size = ty.inner.try_size(context(naga));
            if size.is_some_and(|bytes| bytes <= LARGEST_TYPE) {
                continue;
            }
            let size = size.map_or("more bytes than can be counted".into(), |n| {
                format!("{n} bytes")
            });
            let place = found
                .iter()
                .find(|d| Some(&d.name) == ty.name.as_ref())
                .map_or(0..0, |d| d.span.clone());
            return Err(self.error(
                format!("a type of the module takes {size}"),
                place,
                "",
                [format!(
                    "every ray keeps its own; at most {LARGEST_TYPE} bytes are allowed. Larger tables belong into the volume or the transfer function"
                )],
            ));
        }
        Ok(())
    }

    /// The members of `Params`.
    fn parameters(
        &self,
        found: &[Declaration],
        naga: &naga::Module,
    ) -> Result<(Vec<Parameter>, u32), Error> {
        let Some((handle, ty)) = naga
            .types
            .iter()
            .find(|(_, ty)| ty.name.as_deref() == Some("Params"))
        else {
            return Ok((Vec::new(), 0));
        };
        let TypeInner::Struct { members, span } = &ty.inner else {
            return Ok((Vec::new(), 0));
        };
        let place = found
            .iter()
            .find(|d| d.name == "Params")
            .map_or(0..0, |d| d.span.clone());
        let comments = naga.doc_comments.as_ref().map(|c| &c.struct_members);
        let mut parameters = Vec::new();
        for (i, member) in members.iter().enumerate() {
            let name = member.name.clone().unwrap_or_default();
            let wrong = |problem: String| {
                self.error(
                    format!("parameter `{name}` {problem}"),
                    place.clone(),
                    "",
                    [],
                )
            };
            let (scalar, components) = match naga.types[member.ty].inner {
                TypeInner::Scalar(scalar) => (scalar.kind, 1),
                TypeInner::Vector { size, scalar } => (scalar.kind, size as usize),
                _ => {
                    return Err(wrong(format!(
                        "is a {}; a parameter is f32, i32, u32 or a vector of them",
                        type_name(naga, member.ty)
                    )));
                }
            };
            let scalar = match scalar {
                ScalarKind::Sint => Scalar::I32,
                ScalarKind::Uint => Scalar::U32,
                _ => Scalar::F32,
            };
            let mut parameter = Parameter::new(name.clone(), scalar, components, member.offset);
            let lines = comments.and_then(|c| c.get(&(handle, i)));
            let lines = lines.into_iter().flatten().flat_map(|text| text.lines());
            parameter.describe(lines).map_err(wrong)?;
            parameters.push(parameter);
        }
        for parameter in &parameters {
            let other = parameter.beside.as_ref().map(ParameterRelation::other);
            if let Some(other) = other
                && !parameters.iter().any(|p| p.name == other)
            {
                let problem = format!(
                    "parameter `{}` is compared with `{other}`, which is no parameter",
                    parameter.name
                );
                return Err(self.error(problem, place, "", []));
            }
        }
        Ok((parameters, *span))
    }
}

/// The innermost reason, with types by name where the compiler has only their numbers.
fn reason(error: &ValidationError, naga: &naga::Module) -> String {
    if let ValidationError::Function { name, source, .. } = error {
        match source {
            FunctionError::InvalidCall {
                function,
                error:
                    CallError::ArgumentType {
                        index, required, ..
                    },
            } => {
                let called = naga.functions[*function].name.as_deref().unwrap_or("it");
                return format!(
                    "argument {} of `{called}` has to be of type {}, and is not",
                    index + 1,
                    type_name(naga, *required)
                );
            }
            FunctionError::InvalidReturnType {
                expected_ty: Some(expected),
                ..
            } => {
                return format!(
                    "`{name}` has to return a value of type {} wherever it ends",
                    type_name(naga, *expected)
                );
            }
            _ => {}
        }
    }
    let mut reason: &dyn std::error::Error = error;
    while let Some(source) = reason.source() {
        reason = source;
    }
    reason.to_string()
}

/// `source`, in which no function of its own has a name of [`SUPPLIED`].
fn with_free_names(source: &str) -> Cow<'_, str> {
    let tokens = tokens(source);
    let own = declarations(source, &tokens).into_iter();
    let taken: Vec<String> = own
        .filter(|own| own.kind == DeclarationKind::Function)
        .map(|own| own.name)
        .filter(|name| SUPPLIED.iter().any(|function| function.name == name))
        .collect();
    if taken.is_empty() {
        return source.into();
    }
    let words: HashSet<&str> = tokens.iter().map(|token| token.text(source)).collect();
    let mut text = String::with_capacity(source.len());
    let mut copied = 0;
    for pair in tokens.windows(2) {
        let name = pair[0].text(source);
        // Only names of functions stand before a parenthesis.
        if pair[1].is(b'(') && taken.iter().any(|taken| taken == name) {
            let mut free = format!("own_{name}");
            while words.contains(free.as_str()) {
                free.insert_str(0, "own_");
            }
            text.push_str(&source[copied..pair[0].span.start]);
            text.push_str(&free);
            copied = pair[0].span.end;
        }
    }
    text.push_str(&source[copied..]);
    text.into()
}

fn is_taken(name: &str) -> bool {
    let types = ["Surface", "Light", "Ray", "Sample"];
    types.contains(&name) || SUPPLIED.iter().any(|function| function.name == name)
}

fn context(naga: &naga::Module) -> GlobalCtx<'_> {
    naga.to_ctx()
}

/// The type as the signatures of slots write it.
fn type_name(naga: &naga::Module, handle: Handle<naga::Type>) -> String {
    let ty = &naga.types[handle];
    if let Some(name) = &ty.name {
        return name.clone();
    }
    let scalar = |scalar: naga::Scalar| match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => ("f32", "f"),
        (ScalarKind::Sint, 4) => ("i32", "i"),
        (ScalarKind::Uint, 4) => ("u32", "u"),
        (ScalarKind::Bool, _) => ("bool", "<bool>"),
        _ => ("unsupported scalar", "<unsupported scalar>"),
    };
    let digit = |size: VectorSize| size as u8;
    match ty.inner {
        TypeInner::Scalar(s) => scalar(s).0.to_owned(),
        TypeInner::Vector { size, scalar: s } => format!("vec{}{}", digit(size), scalar(s).1),
        TypeInner::Matrix {
            columns,
            rows,
            scalar: s,
        } => format!("mat{}x{}{}", digit(columns), digit(rows), scalar(s).1),
        TypeInner::Image {
            dim: naga::ImageDimension::D2,
            arrayed: false,
            class:
                naga::ImageClass::Sampled {
                    kind: ScalarKind::Float,
                    multi: false,
                },
        } => "texture_2d<f32>".to_owned(),
        TypeInner::Array { base, .. } => format!("array<{}, …>", type_name(naga, base)),
        TypeInner::Pointer { base, .. } => format!("ptr<…, {}>", type_name(naga, base)),
        TypeInner::Sampler { .. } => "sampler".to_owned(),
        TypeInner::Image { .. } => "texture".to_owned(),
        TypeInner::Atomic(s) => format!("atomic<{}>", scalar(s).0),
        _ => "unsupported type".to_owned(),
    }
}

/// The names of slots' and supplied functions that are called from `from` on.
fn needs(own: &Slot, naga: &naga::Module, from: &[Handle<Function>]) -> Vec<&'static str> {
    let outside: Vec<&Signature> = SLOTS
        .iter()
        .filter(|slot| *slot != own)
        .flat_map(|slot| slot.functions)
        .chain(&SUPPLIED)
        .collect();
    let mut found = BTreeSet::new();
    let mut seen = BTreeSet::new();
    let mut open = from.to_vec();
    while let Some(handle) = open.pop() {
        let function = &naga.functions[handle];
        let outside = outside
            .iter()
            .find(|f| function.name.as_deref() == Some(f.name));
        if let Some(signature) = outside {
            found.insert(signature.name);
        } else if seen.insert(handle) {
            called(&function.body, &mut open);
        }
    }
    found.into_iter().collect()
}

/// The functions that `block` calls.
fn called(block: &naga::Block, into: &mut Vec<Handle<Function>>) {
    for statement in block {
        match statement {
            Statement::Call { function, .. } => into.push(*function),
            Statement::Block(block) => called(block, into),
            Statement::If { accept, reject, .. } => {
                called(accept, into);
                called(reject, into);
            }
            Statement::Switch { cases, .. } => {
                cases.iter().for_each(|case| called(&case.body, into));
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                called(body, into);
                called(continuing, into);
            }
            _ => {}
        }
    }
}

/// Checks a whole program, which is not a module: all of its text is generated from checked parts.
///
/// # Errors
/// What naga says, in naga's words.
pub(crate) fn validate_program(wgsl: &str) -> Result<naga::Module, String> {
    let (depth, _) = deepest(wgsl, &tokens(wgsl));
    with_stack(depth, || validate_text(wgsl))
}

fn validate_text(wgsl: &str) -> Result<naga::Module, String> {
    let module = wgsl::parse_str(wgsl).map_err(|error| error.emit_to_string(wgsl))?;
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| error.emit_to_string(wgsl))?;
    debug_assert!(
        module
            .entry_points
            .iter()
            .any(|e| e.stage == ShaderStage::Fragment)
    );
    Ok(module)
}
