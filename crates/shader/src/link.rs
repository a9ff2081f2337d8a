//! Linking: from one module per slot to the text of one program.
//!
//! Signatures and bodies have been checked when the modules were read. What is left is to find out
//! which functions are needed at all, to give every name a place of its own, to make one call of
//! several functions, and to write it all down so that a person can read it.

use crate::error::Error;
use crate::module::{Module, PRELUDE, validate_program};
use crate::program::{Block, Passage, Program};
use crate::registry::Function;
use crate::skeleton::{Skeleton, bindings};
use crate::slot::{Fold, SLOTS, SUPPLIED, Signature, Slot};
use crate::technique;
use crate::token::{DeclarationKind, Token, closing, declarations, tokens};
use naga::TypeInner;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::fmt::Write;
use std::ops::Range;
use std::sync::Arc;

/// How many times all loops of a user's module, or of a graph, may turn per ray, together.
pub const MOST_TURNS: u32 = 65_536;

/// The functions that are chosen, slot by slot. Slots that are not filled get their null function.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Selection {
    modules: BTreeMap<usize, Vec<Arc<Module>>>,
    /// The slots of which the technique of a sample chooses the function.
    chosen: BTreeSet<usize>,
}

impl Selection {
    /// Nothing in any slot.
    pub fn new() -> Selection {
        Selection::default()
    }

    /// Puts a function into its slot, after those that are there. Whether there may be several is
    /// found when linking.
    #[must_use]
    pub fn with(mut self, module: Arc<Module>) -> Selection {
        let slot = index(module.slot());
        self.modules.entry(slot).or_default().push(module);
        self
    }

    /// Puts the functions into a slot among which the technique of each sample chooses, by their place in
    /// `modules`; the number of them, if the slot has a null function, chooses that one. Their parameters
    /// belong to the technique, too.
    #[must_use]
    pub fn with_choice(mut self, slot: &Slot, modules: Vec<Arc<Module>>) -> Selection {
        self.chosen.insert(index(slot));
        self.modules.insert(index(slot), modules);
        self
    }

    /// Whether the technique of each sample chooses the function of a slot.
    pub fn is_choice(&self, slot: &Slot) -> bool {
        self.chosen.contains(&index(slot))
    }

    /// Whether all functions are of the library.
    pub fn is_built_in(&self) -> bool {
        self.modules.values().flatten().all(|m| m.is_built_in())
    }

    /// The functions in a slot.
    pub fn of(&self, slot: &Slot) -> &[Arc<Module>] {
        self.modules.get(&index(slot)).map_or(&[], Vec::as_slice)
    }
}

fn index(slot: &Slot) -> usize {
    SLOTS.iter().position(|other| other == slot).unwrap_or(0)
}

/// Links, and remembers what it has linked.
#[derive(Debug, Default)]
pub struct Linker {
    linked: HashMap<(Skeleton, Selection), Arc<Program>>,
}

impl Linker {
    /// A linker that remembers nothing yet.
    pub fn new() -> Linker {
        Linker::default()
    }

    /// The program of `selection` in `skeleton`: a combination that was seen before costs nothing.
    ///
    /// # Errors
    /// A needed slot is empty or overfull, or the functions call one another in a circle.
    pub fn link(
        &mut self,
        skeleton: &Skeleton,
        selection: &Selection,
    ) -> Result<Arc<Program>, Error> {
        let key = (skeleton.clone(), selection.clone());
        if let Some(program) = self.linked.get(&key) {
            return Ok(program.clone());
        }
        let program = Arc::new(link(skeleton, selection)?);
        self.linked.insert(key, program.clone());
        Ok(program)
    }
}

/// A function that the program needs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Requirement {
    Slot(&'static Slot),
    /// The folded call of all lights.
    Lighting,
    /// Of a part of the skeleton, by its number.
    Part(usize),
}

fn link(skeleton: &Skeleton, selection: &Selection) -> Result<Program, Error> {
    let composite = SLOTS.iter().find(|slot| slot.name == "composite");
    let composite = composite.and_then(|slot| selection.of(slot).first());
    if let Some(composite) = composite
        && skeleton.objects > 1
        && !composite.needs().contains(&"look")
    {
        return Err(Error::OneObject {
            composite: composite.name().to_owned(),
            objects: skeleton.objects,
        });
    }
    let is_back_to_front = composite.is_some_and(|module| module.is_back_to_front());
    let order = &skeleton.orders[usize::from(is_back_to_front)];
    let reach = Reach::of(skeleton, order, selection)?;
    let mut writer = Writer::new(skeleton, selection);
    writer.line(&format!("// {}, linked from:", skeleton.name));
    for slot in reach.slots() {
        let names: Vec<_> = selection.of(slot).iter().map(|m| m.name()).collect();
        let names = if names.is_empty() {
            "null".into()
        } else {
            names.join(", ")
        };
        writer.line(&format!("//   {}: {names}", slot.name));
    }
    writer.line("");
    writer.line(PRELUDE);
    for slot in reach.slots() {
        if selection.is_choice(slot) {
            writer.choice(slot, selection.of(slot))?;
        } else {
            writer.slot(slot, selection.of(slot));
        }
    }
    if reach.lighting {
        writer.lighting();
    }
    for (label, module) in &skeleton.functions {
        writer.module(module, label.clone());
    }
    writer.parameters();
    writer.line(&format!("// ---- {} ----", skeleton.name));
    writer.line(&skeleton.wgsl);
    writer.line(order);
    for (part, is_needed) in skeleton.parts.iter().zip(&reach.parts) {
        if *is_needed {
            writer.line(part);
        }
    }
    writer.finish()
}

/// The functions that `text` calls (and the types that it makes).
fn calls<'t>(text: &'t str, tokens: &[Token]) -> Vec<&'t str> {
    let is_call = |i: usize| {
        tokens.get(i + 1).is_some_and(|next| next.is(b'('))
            && !(i > 0 && tokens[i - 1].text(text) == "fn")
    };
    let called = (0..tokens.len()).filter(|i| is_call(*i));
    called.map(|i| tokens[i].text(text)).collect()
}

/// What a part of the skeleton defines and calls.
struct Part<'s> {
    functions: Vec<String>,
    calls: Vec<&'s str>,
}

/// Which functions the skeleton reaches.
struct Reach<'s> {
    selection: &'s Selection,
    of_parts: Vec<Part<'s>>,
    slots: Vec<&'static Slot>,
    parts: Vec<bool>,
    lighting: bool,
    /// The functions being followed, for circles.
    path: Vec<(Requirement, String)>,
}

impl<'s> Reach<'s> {
    fn of(
        skeleton: &'s Skeleton,
        order: &'s str,
        selection: &'s Selection,
    ) -> Result<Reach<'s>, Error> {
        let part = |text: &'s Arc<str>| {
            let tokens = tokens(text);
            let declared = declarations(text, &tokens).into_iter();
            Part {
                functions: declared
                    .filter(|d| d.kind == DeclarationKind::Function)
                    .map(|d| d.name)
                    .collect(),
                calls: calls(text, &tokens),
            }
        };
        let mut reach = Reach {
            selection,
            of_parts: skeleton.parts.iter().map(part).collect(),
            slots: Vec::new(),
            parts: vec![false; skeleton.parts.len()],
            lighting: false,
            path: Vec::new(),
        };
        for text in [&*skeleton.wgsl, order] {
            for name in calls(text, &tokens(text)) {
                if let Some(needed) = reach.needed(name) {
                    reach.follow(needed, &skeleton.name)?;
                }
            }
        }
        for (label, module) in &skeleton.functions {
            for need in module.needs() {
                if let Some(needed) = reach.needed(need) {
                    reach.follow(needed, label)?;
                }
            }
        }
        Ok(reach)
    }

    /// Who may be asked for by name.
    fn needed(&self, name: &str) -> Option<Requirement> {
        if name == "lighting" {
            return Some(Requirement::Lighting);
        }
        let defines = |part: &Part| part.functions.iter().any(|function| function == name);
        if let Some(part) = self.of_parts.iter().position(defines) {
            return Some(Requirement::Part(part));
        }
        let slot = SLOTS
            .iter()
            .find(|slot| slot.functions.iter().any(|f| f.name == name))?;
        Some(Requirement::Slot(slot))
    }

    /// In the order of the ray.
    fn slots(&self) -> impl Iterator<Item = &'static Slot> {
        SLOTS.iter().filter(|slot| self.slots.contains(slot))
    }

    fn follow(&mut self, needed: Requirement, needed_by: &str) -> Result<(), Error> {
        if let Some(start) = self.path.iter().position(|(n, _)| *n == needed) {
            let mut path: Vec<_> = self.path[start..].iter().map(|(_, n)| n.clone()).collect();
            path.push(path[0].clone());
            return Err(Error::Circle { path });
        }
        match needed {
            Requirement::Lighting => {
                if !std::mem::replace(&mut self.lighting, true) {
                    self.path.push((needed, "lighting".into()));
                    for name in ["light", "illuminate"] {
                        // Without lights there is nothing to illuminate.
                        let is_light = SLOTS.iter().find(|slot| slot.name == "light");
                        if is_light.is_some_and(|slot| self.selection.of(slot).is_empty()) {
                            continue;
                        }
                        if let Some(next) = self.needed(name) {
                            self.follow(next, "lighting")?;
                        }
                    }
                    self.path.pop();
                }
                Ok(())
            }
            Requirement::Slot(slot) => self.follow_slot(slot, needed_by),
            Requirement::Part(part) => self.follow_part(part),
        }
    }

    fn follow_part(&mut self, part: usize) -> Result<(), Error> {
        if std::mem::replace(&mut self.parts[part], true) {
            return Ok(());
        }
        let name = self.of_parts[part].functions[0].clone();
        self.path.push((Requirement::Part(part), name.clone()));
        for call in self.of_parts[part].calls.clone() {
            match self.needed(call) {
                // Its own functions.
                Some(Requirement::Part(own)) if own == part => {}
                Some(next) => self.follow(next, &name)?,
                None => {}
            }
        }
        self.path.pop();
        Ok(())
    }

    fn follow_slot(&mut self, slot: &'static Slot, needed_by: &str) -> Result<(), Error> {
        if self.slots.contains(&slot) {
            return Ok(());
        }
        let modules = self.selection.of(slot);
        if modules.is_empty() && slot.null.is_none() {
            return Err(Error::Empty {
                slot: slot.name,
                needed_by: needed_by.to_owned(),
                known: Function::names(slot.name).join(", "),
            });
        }
        if modules.len() > 1 && slot.fold == Fold::One && !self.selection.is_choice(slot) {
            return Err(Error::Crowded {
                slot: slot.name,
                modules: modules.iter().map(|m| m.name().to_owned()).collect(),
            });
        }
        for module in modules {
            let who = format!("{} ({})", slot.name, module.name());
            self.path.push((Requirement::Slot(slot), who.clone()));
            for need in module.needs() {
                if let Some(next) = self.needed(need) {
                    self.follow(next, &who)?;
                }
            }
            self.path.pop();
        }
        self.slots.push(slot);
        Ok(())
    }
}

/// The program as it is written.
struct Writer<'s> {
    wgsl: String,
    passages: Vec<Passage>,
    blocks: Vec<Block>,
    /// Every name of the modules, the skeleton and the linker.
    names: HashSet<String>,
    /// What the linker's own things are called; no module has such a word.
    parameters: String,
    parameters_type: String,
    loop_turns: String,
    lights: Vec<String>,
    bounded: bool,
    skeleton: &'s Skeleton,
}

impl<'s> Writer<'s> {
    fn new(skeleton: &'s Skeleton, selection: &Selection) -> Writer<'s> {
        let mut names = HashSet::new();
        let mut take = |source: &str, tokens: &[Token]| {
            names.extend(tokens.iter().map(|t| t.text(source).to_owned()));
        };
        let texts = std::iter::once(&skeleton.wgsl).chain(&skeleton.parts);
        for text in texts.chain(&skeleton.orders) {
            take(text, &tokens(text));
        }
        take(PRELUDE, &tokens(PRELUDE));
        let own = skeleton.functions.iter().map(|(_, module)| module);
        for module in selection.modules.values().flatten().chain(own) {
            take(module.source(), &module.tokens);
        }
        let mut writer = Writer {
            wgsl: String::new(),
            passages: Vec::new(),
            blocks: Vec::new(),
            names,
            parameters: String::new(),
            parameters_type: String::new(),
            loop_turns: String::new(),
            lights: Vec::new(),
            bounded: false,
            skeleton,
        };
        writer.parameters = writer.unique("parameters".into());
        writer.loop_turns = writer.unique("loop_turns_of_ray".into());
        writer
    }

    fn line(&mut self, text: &str) {
        self.wgsl.push_str(text);
        self.wgsl.push('\n');
    }

    /// A name that nobody has, like `wish`.
    fn unique(&mut self, wish: String) -> String {
        let mut name = wish;
        while !self.names.insert(name.clone()) {
            name.push('_');
        }
        name
    }

    /// All functions of a slot, and the one call that the others make.
    fn slot(&mut self, slot: &'static Slot, modules: &[Arc<Module>]) {
        match modules {
            [] => {
                self.line(&format!("// ---- {}: null ----", slot.name));
                let null = slot.null.unwrap_or_default();
                for function in slot.functions {
                    self.line(&format!("{function} {{\n    {null}\n}}\n"));
                }
            }
            [module] if slot.fold != Fold::Lights => self.module(module, slot.name.to_owned()),
            _ => {
                let mut calls = Vec::new();
                for (i, module) in modules.iter().enumerate() {
                    let label = self.unique(format!("{}_{i}", slot.name));
                    self.module(module, label.clone());
                    calls.push(label);
                }
                if slot.fold == Fold::Lights {
                    self.lights = calls;
                } else if let Some(body) = folded(slot, &calls) {
                    let function = &slot.functions[0];
                    self.line(&format!(
                        "// ---- {}: {} functions in one call ----",
                        slot.name,
                        calls.len()
                    ));
                    self.line(&format!("{function} {{\n{body}}}\n"));
                }
            }
        }
    }

    /// All functions of a slot, and the call that chooses one by the technique of the sample.
    fn choice(&mut self, slot: &'static Slot, modules: &[Arc<Module>]) -> Result<(), Error> {
        let number = modules.len() + usize::from(slot.null.is_some());
        let (mut labels, mut states) = (Vec::new(), Vec::new());
        for (i, module) in modules.iter().enumerate() {
            let label = match number {
                1 => slot.name.to_owned(),
                _ => self.unique(format!("{}_{i}", slot.name)),
            };
            states.extend(self.module_in(module, label.clone(), number > 1, true)?);
            labels.push(label);
        }
        if number > 1 {
            self.line(&format!(
                "// ---- {}: the function of the technique ----",
                slot.name
            ));
            let place = technique::place(slot);
            let text = match slot.functions {
                [function] => technique::one_of(function, slot.null, &labels, place),
                functions => technique::rule_of(functions, &labels, &states, place),
            };
            self.line(&text);
        }
        Ok(())
    }

    /// The text of a module with its names made its own.
    fn module(&mut self, module: &Arc<Module>, label: String) {
        // Only choices can be refused.
        let _ = self.module_in(module, label, false, false);
    }

    /// The same; the functions of one that is `numbered` are called by its label, and the parameters of one
    /// that is `chosen` are those of the technique. Gives the name of its type `State`, if it has one.
    fn module_in(
        &mut self,
        module: &Arc<Module>,
        label: String,
        numbered: bool,
        chosen: bool,
    ) -> Result<Option<String>, Error> {
        let mut names = HashMap::new();
        for declaration in &module.declarations {
            let own = &declaration.name;
            let is_function_of_slot = module.slot().functions.iter().any(|f| f.name == own);
            let name = if label == "composite" && own == "State" {
                // Graphs carry it along their rays under this name.
                "CompositeState".to_owned()
            } else if own == module.main() && module.slot().functions.len() < 2 {
                label.clone()
            } else if is_function_of_slot && !numbered {
                continue;
            } else if matches!(
                declaration.kind,
                DeclarationKind::Struct | DeclarationKind::Alias
            ) {
                self.unique(camel_case(&label) + own)
            } else {
                self.unique(format!("{label}_{own}"))
            };
            names.insert(own.as_str(), name);
        }
        if module.parameter_bytes() > 0 && chosen {
            let load = self.unique(format!("{label}_params"));
            self.line(&technique::parameters(module, &load, &names["Params"])?);
            names.insert("params", load + "()");
        } else if module.parameter_bytes() > 0 {
            names.insert("params", format!("{}.{label}", self.parameters));
            self.blocks.push(Block {
                label: label.clone(),
                type_name: names["Params"].clone(),
                module: module.clone(),
                offset: 0,
            });
        }
        self.line(&format!(
            "// ---- {}: {} ({}) ----",
            label,
            module.name(),
            module.file()
        ));
        let members = members(module);
        let bounds = if module.is_built_in() {
            HashSet::new()
        } else {
            loop_bodies(module)
        };
        let source = module.source();
        let mut copied = 0;
        for (i, token) in module.tokens.iter().enumerate() {
            self.wgsl.push_str(&source[copied..token.span.start]);
            copied = token.span.end;
            self.passages.push(Passage {
                start: self.wgsl.len(),
                module: module.clone(),
                from: token.span.start,
            });
            let text = token.text(source);
            let after_dot =
                i > 0 && (module.tokens[i - 1].is(b'.') || module.tokens[i - 1].is(b'@'));
            match names.get(text) {
                Some(name) if !after_dot && !members.contains(&i) => self.wgsl.push_str(name),
                _ => self.wgsl.push_str(text),
            }
            if bounds.contains(&i) {
                self.bounded = true;
                let _ = write!(self.wgsl, " if {}() {{ break; }}", self.loop_turns);
            }
        }
        self.passages.push(Passage {
            start: self.wgsl.len(),
            module: module.clone(),
            from: copied,
        });
        self.wgsl.push_str(&source[copied..]);
        self.line("\n");
        Ok(names.remove("State"))
    }

    fn lighting(&mut self) {
        self.line(&format!(
            "// ---- lighting: the light of {} lights adds up ----",
            self.lights.len()
        ));
        if let Some(signature) = SUPPLIED.iter().find(|s| s.name == "lighting") {
            self.line(&format!("{signature} {{"));
        }
        self.line("    var sum = vec3f(0.0);");
        if !self.lights.is_empty() {
            self.line("    let place = place_mm(position);");
        }
        for light in std::mem::take(&mut self.lights) {
            self.line(&format!(
                "    sum += illuminate(color, normal, to_eye, {light}(place, to_eye));"
            ));
        }
        self.line("    return sum;\n}\n");
    }

    /// The uniform block of all parameters, and the counter of bounded loops.
    fn parameters(&mut self) {
        if self.bounded {
            let turns = self.unique("loop_turns".into());
            self.line(&format!(
                "// Loops of modules that are not built in end together after {MOST_TURNS} turns per ray.\n\
                 var<private> {turns}: u32 = 0u;\n\
                 fn {}() -> bool {{\n    {turns} += 1u;\n    return {turns} > {MOST_TURNS}u;\n}}\n",
                self.loop_turns
            ));
        }
        if self.blocks.is_empty() {
            return;
        }
        self.line("// ---- the parameters of all functions ----");
        let type_name = self.unique("Parameters".into());
        self.line(&format!("struct {type_name} {{"));
        let mut text = String::new();
        for block in &self.blocks {
            // Uniform memory wants structs at multiples of 16 bytes.
            let _ = writeln!(text, "    @align(16) {}: {},", block.label, block.type_name);
        }
        self.line(&text);
        self.line(&format!(
            "}}\n@group(0) @binding({}) var<uniform> {}: {type_name};\n",
            bindings::PARAMETERS,
            self.parameters
        ));
        self.parameters_type = type_name;
    }

    fn finish(mut self) -> Result<Program, Error> {
        let naga = validate_program(&self.wgsl).map_err(|message| Error::Program {
            skeleton: self.skeleton.name.clone(),
            message,
        })?;
        let mut parameter_bytes = 0;
        for (_, ty) in naga.types.iter() {
            if ty.name.as_deref() != Some(self.parameters_type.as_str()) {
                continue;
            }
            if let TypeInner::Struct { members, span } = &ty.inner {
                parameter_bytes = *span;
                for (block, member) in self.blocks.iter_mut().zip(members) {
                    block.offset = member.offset;
                }
            }
        }
        Ok(Program::new(
            self.wgsl,
            self.blocks,
            parameter_bytes,
            self.passages,
            naga,
        ))
    }
}

/// The body of the function that calls all of `calls`.
fn folded(slot: &Slot, calls: &[String]) -> Option<String> {
    let Signature { arguments, .. } = &slot.functions[0];
    let names: Vec<_> = arguments.iter().map(|(name, _)| *name).collect();
    let mut body = String::new();
    match slot.fold {
        Fold::Chain => {
            let (last, first) = names.split_last()?;
            let first: String = first.iter().map(|name| format!("{name}, ")).collect();
            let _ = writeln!(body, "    var result = {last};");
            for call in calls {
                let _ = writeln!(body, "    result = {call}({first}result);");
            }
            body.push_str("    return result;\n");
        }
        Fold::Any => {
            let list = names.join(", ");
            let calls: Vec<_> = calls.iter().map(|call| format!("{call}({list})")).collect();
            let _ = writeln!(body, "    return {};", calls.join(" || "));
        }
        Fold::One | Fold::Lights => return None,
    }
    Some(body)
}

/// The tokens that are names of struct members where they are declared.
fn members(module: &Module) -> HashSet<usize> {
    let is_struct = |d: &&crate::token::Declaration| d.kind == DeclarationKind::Struct;
    let bodies = module.declarations.iter().filter(is_struct);
    bodies
        .flat_map(|d| d.tokens.clone())
        .filter(|&i| module.tokens.get(i + 1).is_some_and(|next| next.is(b':')))
        .collect()
}

/// The tokens `{` that open the bodies of loops.
fn loop_bodies(module: &Module) -> HashSet<usize> {
    let tokens = &module.tokens;
    let opening = |mut range: Range<usize>| range.find(|&i| tokens[i].is(b'{'));
    tokens
        .iter()
        .enumerate()
        .filter_map(|(i, token)| match token.text(module.source()) {
            "loop" | "while" => opening(i + 1..tokens.len()),
            "for" => opening(closing(tokens, i + 1, b'(', b')') + 1..tokens.len()),
            _ => None,
        })
        .collect()
}

/// `clip_ray_0` → `ClipRay0`.
fn camel_case(label: &str) -> String {
    label
        .split('_')
        .map(|word| {
            let (first, rest) = word.split_at(word.len().min(1));
            first.to_ascii_uppercase() + rest
        })
        .collect()
}
