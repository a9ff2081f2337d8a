//! `strahl graph`: the graph that draws a scene, and graphs of one's own.

use crate::commands::draw;
use crate::flags::{
    GraphCommand, GraphDotFlags, GraphInputFlags, GraphPatternsFlags, GraphShowFlags, ReadFlags,
};
use crate::print;
use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use strahl::graph::{Detail, Patterns, dot, schema};
use strahl::scene::VolumeSource;
use strahl::{Render, SceneFile, SceneGraph};

pub fn run(command: &GraphCommand, quiet: bool) -> Result<()> {
    match command {
        GraphCommand::Show(flags) => show(flags, quiet),
        GraphCommand::Check(flags) => check(flags, quiet),
        GraphCommand::Wgsl(flags) => wgsl(flags, quiet),
        GraphCommand::Dot(flags) => drawing(flags, quiet),
        GraphCommand::Run(flags) => draw::render(flags, quiet),
        GraphCommand::Patterns(flags) => patterns(flags),
        GraphCommand::Schema => print::out(&schema()),
    }
}

/// A graph alone is looked at over this; what its standard graph is depends on settings, not on voxels.
const STAND_IN: &str = "shells";

fn subject(inputs: &[PathBuf], quiet: bool) -> Result<Render<'static>> {
    if let [only] = inputs
        && let Some(file) = SceneFile::open(only)?
        && file.scene.volume.is_none()
    {
        return Ok(Render::scene_file(file).with(|scene| {
            scene.volume = Some(VolumeSource {
                phantom: Some(STAND_IN.to_owned()),
                ..VolumeSource::default()
            });
        }));
    }
    draw::subject(inputs, &ReadFlags::default(), quiet)
}

fn show(flags: &GraphShowFlags, quiet: bool) -> Result<()> {
    let subject = draw::over(subject(&flags.inputs, quiet)?, &flags.draw)?;
    let edited = subject.graph()?.graph(&subject.plan()?)?;
    for conflict in &edited.conflicts {
        print::note(&conflict.to_string(), quiet);
    }
    print::out(&edited.graph.to_text())
}

/// Every file gets its line on stdout or its message on stderr.
fn check(flags: &GraphInputFlags, quiet: bool) -> Result<()> {
    let mut wrong = 0;
    for path in &flags.inputs {
        match check_one(path, quiet) {
            Ok(verdict) => print::out(&format!("{}: {verdict}\n", path.display()))?,
            Err(error) => {
                print::message(&format!("error: {}", print::chain(&error)));
                wrong += 1;
            }
        }
    }
    match (wrong, flags.inputs.len()) {
        (0, _) => Ok(()),
        (wrong, all) => bail!("{wrong} of {all} graphs cannot be drawn"),
    }
}

fn check_one(path: &Path, quiet: bool) -> Result<String> {
    let subject = subject(std::slice::from_ref(&path.to_owned()), quiet)?;
    let (graph, plan) = (subject.graph()?, subject.plan()?);
    let ready = graph.program(&plan)?;
    for note in &ready.notes {
        print::note(note, quiet);
    }
    let edited = graph.graph(&plan)?.graph;
    let cost = ready.compiled.program.cost();
    // A program that draws slices has no loop: each pixel of a slice is a sample.
    let (work, of) = match edited.slicing {
        Some(_) => (cost.per_ray + cost.per_sample, "pixel of a slice"),
        None => (cost.per_sample, "sample"),
    };
    Ok(format!(
        "{} nodes; at most {} texture reads per {of}",
        edited.nodes.len(),
        work.texture_reads
    ))
}

fn wgsl(flags: &GraphInputFlags, quiet: bool) -> Result<()> {
    let subject = subject(&flags.inputs, quiet)?;
    let ready = subject.graph()?.program(&subject.plan()?)?;
    for note in &ready.notes {
        print::note(note, quiet);
    }
    print::out(ready.compiled.program.wgsl())
}

fn drawing(flags: &GraphDotFlags, quiet: bool) -> Result<()> {
    let subject = draw::over(subject(&flags.inputs, quiet)?, &flags.draw)?;
    let graph: SceneGraph = subject.graph()?;
    let detail = if flags.details {
        Detail::All
    } else {
        Detail::Names
    };
    let text = dot(
        &graph.graph(&subject.plan()?)?.graph,
        graph.patterns(),
        detail,
    );
    match &flags.svg {
        None => print::out(&text),
        Some(path) => svg(&text, path),
    }
}

/// Has Graphviz lay it out.
fn svg(text: &str, path: &Path) -> Result<()> {
    use std::io::Write;
    let child = Command::new("dot")
        .args(["-Tsvg", "-o"])
        .arg(path)
        .stdin(Stdio::piped())
        .spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => bail!(
            "--svg needs the program `dot` of Graphviz, which is not installed (Debian/Ubuntu: apt-get install graphviz); without --svg the drawing is printed in its language"
        ),
        Err(error) => return Err(error).context("cannot run dot"),
    };
    if let Some(mut stdin) = child.stdin.take() {
        stdin
            .write_all(text.as_bytes())
            .context("cannot hand the drawing to dot")?;
    }
    let status = child.wait().context("dot did not end")?;
    if !status.success() {
        bail!("dot could not write {}", path.display());
    }
    Ok(())
}

fn patterns(flags: &GraphPatternsFlags) -> Result<()> {
    let known = Patterns::new();
    let mut all = Vec::new();
    let mut text = String::new();
    for name in known.names() {
        if flags
            .names
            .iter()
            .any(|wanted| !name.contains(wanted.as_str()))
        {
            continue;
        }
        let function = known.function(&name).map_err(anyhow::Error::msg)?;
        let port = |port: &strahl::graph::Port| -> Value {
            json!({
                "name": port.name,
                "type": port.ty.to_string(),
                "meaning": port.meaning.map(|m| m.to_string()),
                "default": port.default.as_ref().map(ToString::to_string),
                "comment": port.comment,
            })
        };
        if flags.json {
            let inputs: Vec<_> = function.inputs.iter().map(port).collect();
            let outputs: Vec<_> = function.outputs.iter().map(port).collect();
            all.push(json!({ "name": name, "comment": function.comment, "inputs": inputs, "outputs": outputs }));
            continue;
        }
        let list = |ports: &[strahl::graph::Port]| {
            let ports: Vec<_> = ports
                .iter()
                .map(|port| {
                    let meaning = port.meaning.map(|m| format!(" ({m})")).unwrap_or_default();
                    let default = port
                        .default
                        .as_ref()
                        .map(|d| format!(" = {d}"))
                        .unwrap_or_default();
                    format!("{}: {}{meaning}{default}", port.name, port.ty)
                })
                .collect();
            ports.join(", ")
        };
        let _ = writeln!(
            text,
            "{name}({})\n    -> {}\n    {}",
            list(&function.inputs),
            list(&function.outputs),
            function.comment
        );
    }
    if flags.json {
        return print::out(&(serde_json::to_string_pretty(&all)? + "\n"));
    }
    if text.is_empty() {
        bail!(
            "there is no pattern with {} in its name",
            flags.names.join(" and ")
        );
    }
    print::out(&text)
}
