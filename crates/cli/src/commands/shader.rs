//! `strahl shader`: the functions of the ray, the library of them, and a check of one's own.

use crate::commands::draw;
use crate::flags::{
    ReadFlags, ShaderCheckFlags, ShaderCommand, ShaderCostFlags, ShaderListFlags, ShaderSceneFlags,
    ShaderShowFlags,
};
use crate::print;
use anyhow::{Result, bail};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use strahl::shader::{Module, Parameter, Program, SLOTS, Slot, Work, library};

pub fn run(command: &ShaderCommand) -> Result<()> {
    match command {
        ShaderCommand::List(flags) => list(flags),
        ShaderCommand::Show(flags) => show(flags),
        ShaderCommand::Check(flags) => check(flags),
        ShaderCommand::Wgsl(flags) => wgsl(flags),
        ShaderCommand::Cost(flags) => cost(flags),
    }
}

fn program(input: &Path) -> Result<std::sync::Arc<Program>> {
    let subject = draw::subject(&[input.to_owned()], &ReadFlags::default(), true)?;
    Ok(strahl::program::program(&subject.plan()?)?)
}

fn wgsl(flags: &ShaderSceneFlags) -> Result<()> {
    print::out(program(&flags.input)?.wgsl())
}

fn cost(flags: &ShaderCostFlags) -> Result<()> {
    let cost = program(&flags.input)?.cost();
    if flags.json {
        let work = |work: &Work| json!({ "texture_reads": work.texture_reads, "instructions": work.instructions });
        let functions: Vec<_> = (cost.functions.iter())
            .map(|(name, of)| json!({ "name": name, "work": work(of) }))
            .collect();
        let all = json!({
            "per_ray": work(&cost.per_ray),
            "per_sample": work(&cost.per_sample),
            "functions": functions,
        });
        return print::out(&(serde_json::to_string_pretty(&all)? + "\n"));
    }
    let mut text = String::new();
    let mut line = |name: &str, work: &Work| {
        let (reads, instructions) = (work.texture_reads, work.instructions);
        let _ = writeln!(text, "{name:<28} {reads:>6} {instructions:>8}");
    };
    line("per ray", &cost.per_ray);
    line("per visible sample", &cost.per_sample);
    for (name, work) in &cost.functions {
        line(&format!("  {name}"), work);
    }
    let head = format!("{:<28} {:>6} {:>8}\n", "at most", "reads", "instr.");
    print::out(&(head + &text))
}

fn list(flags: &ShaderListFlags) -> Result<()> {
    if flags.json {
        let slots: Vec<Value> = SLOTS.iter().map(slot_json).collect();
        return print::out(&(serde_json::to_string_pretty(&slots)? + "\n"));
    }
    let mut text = String::new();
    for slot in &SLOTS {
        let _ = writeln!(text, "{}: {}", slot.name, slot.meaning);
        for function in slot.functions {
            let _ = writeln!(text, "    {function}");
        }
        for module in of_slot(slot) {
            let first = first_sentence(module.meaning());
            let _ = writeln!(text, "  {:<18} {first}", module.name());
            let parameters: Vec<String> = module.parameters().iter().map(of_parameter).collect();
            if !parameters.is_empty() {
                let _ = writeln!(text, "  {:<18} ({})", "", parameters.join(", "));
            }
        }
        text.push('\n');
    }
    print::out(&text)
}

/// The first sentence of a meaning, on one line. A dot behind a single letter is that of an initial.
fn first_sentence(meaning: &str) -> String {
    let line = meaning.split_whitespace().collect::<Vec<_>>().join(" ");
    let ends = line.match_indices(". ").find(|(at, _)| {
        let word = line[..*at].rsplit([' ', '(']).next().unwrap_or_default();
        word.chars().count() > 1 && !line[..*at].ends_with(" al")
    });
    match ends {
        Some((at, _)) => line[..=at].to_owned(),
        None => line,
    }
}

/// The name, default and range of a parameter.
fn of_parameter(parameter: &Parameter) -> String {
    let [low, high] = parameter.range;
    let default: Vec<String> = parameter.default.iter().map(f64::to_string).collect();
    let default = match default.len() {
        0 => String::new(),
        1 => format!(" {}", default[0]),
        _ => format!(" [{}]", default.join(", ")),
    };
    format!("{}{default}: {low} to {high}", parameter.name)
}

fn of_slot(slot: &Slot) -> impl Iterator<Item = &'static Module> {
    let modules = library().iter().map(std::convert::AsRef::as_ref);
    modules.filter(move |module: &&Module| module.slot() == slot)
}

fn slot_json(slot: &Slot) -> Value {
    let functions: Vec<String> = slot.functions.iter().map(ToString::to_string).collect();
    let modules: Vec<Value> = of_slot(slot).map(module_json).collect();
    json!({
        "slot": slot.name,
        "meaning": slot.meaning,
        "functions": functions,
        "optional": slot.null.is_some(),
        "modules": modules,
    })
}

fn module_json(module: &Module) -> Value {
    let parameters: Vec<Value> = module
        .parameters()
        .iter()
        .map(|p| {
            json!({
                "name": p.name,
                "type": p.type_name(),
                "meaning": p.meaning,
                "default": p.default,
                "range": p.range,
                "unit": p.unit,
            })
        })
        .collect();
    json!({
        "name": module.name(),
        "meaning": module.meaning(),
        "needs": module.needs(),
        "parameters": parameters,
    })
}

fn show(flags: &ShaderShowFlags) -> Result<()> {
    let wanted = &flags.name;
    let (slot, name) = match wanted.split_once('/') {
        Some((slot, name)) => (Some(slot), name),
        None => (None, wanted.as_str()),
    };
    let fits = |m: &&Module| m.name() == name && slot.is_none_or(|slot| m.slot().name == slot);
    let modules = || library().iter().map(std::convert::AsRef::as_ref);
    let found: Vec<&Module> = modules().filter(fits).collect();
    match found.as_slice() {
        [module] => print::out(module.source()),
        [] => {
            let near = modules()
                .filter(|m| strsim::damerau_levenshtein(m.name(), name) <= 2)
                .map(|m| format!("{}/{}", m.slot().name, m.name()));
            let near: Vec<_> = near.collect();
            let advice = if near.is_empty() {
                "`strahl shader list` lists what there is".to_owned()
            } else {
                format!("did you mean {}?", near.join(" or "))
            };
            bail!("there is no shader function {wanted}; {advice}")
        }
        several => {
            let names: Vec<_> = several
                .iter()
                .map(|m| format!("{}/{}", m.slot().name, m.name()))
                .collect();
            bail!(
                "several functions are called {name}; name one of {}",
                names.join(", ")
            )
        }
    }
}

/// Every file gets its line on stdout or its message on stderr.
fn check(flags: &ShaderCheckFlags) -> Result<()> {
    let mut wrong = 0;
    for path in &flags.files {
        match check_one(path) {
            Ok(verdict) => print::out(&format!("{}: {verdict}\n", path.display()))?,
            Err(error) => {
                print::message(&format!("error: {}", print::chain(&error)));
                wrong += 1;
            }
        }
    }
    match (wrong, flags.files.len()) {
        (0, _) => Ok(()),
        (wrong, all) => bail!("{wrong} of {all} modules cannot be used"),
    }
}

fn check_one(path: &Path) -> Result<String> {
    let file = path.display().to_string();
    let source = strahl::read_text(path, 4 * strahl::shader::MOST_MODULE_BYTES)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let module = Module::parse(&name, &file, &source)?;
    let parameters: Vec<_> = module
        .parameters()
        .iter()
        .map(|p| format!("{}: {}", p.name, p.type_name()))
        .collect();
    let list = |what: &str, names: &[String]| match names {
        [] => String::new(),
        names => format!("; {what} {}", names.join(", ")),
    };
    let needs: Vec<_> = module.needs().iter().map(ToString::to_string).collect();
    Ok(format!(
        "a function for the slot {}{}{}",
        module.slot().name,
        list("takes", &parameters),
        list("needs", &needs)
    ))
}
