//! `strahl scene`: what scenes may say, whether one is right, and all that one means.

use super::draw;
use crate::flags::{SceneCheckFlags, SceneCommand, SceneShowFlags};
use crate::print;
use crate::progress::Stages;
use anyhow::{Result, bail};
use std::io::Write;
use std::path::Path;
use strahl::{Output, Render, SceneFile, seen_from};

pub fn run(command: &SceneCommand, quiet: bool) -> Result<()> {
    match command {
        #[cfg(feature = "schema")]
        SceneCommand::Schema => print::out(&strahl::scene::schema()),
        SceneCommand::Check(flags) => check(flags, quiet),
        SceneCommand::Show(flags) => show(flags, quiet),
    }
}

/// Every file gets its line on stdout or its message on stderr.
fn check(flags: &SceneCheckFlags, quiet: bool) -> Result<()> {
    let mut wrong = 0;
    for path in &flags.scenes {
        match check_one(path, quiet) {
            Ok(verdict) => print::out(&format!("{}: {verdict}\n", path.display()))?,
            Err(error) => {
                print::message(&format!("error: {}", print::chain(&error)));
                wrong += 1;
            }
        }
    }
    match (wrong, flags.scenes.len()) {
        (0, _) => Ok(()),
        (wrong, all) => bail!("{wrong} of {all} scenes cannot be drawn"),
    }
}

fn check_one(path: &Path, quiet: bool) -> Result<&'static str> {
    let Some(file) = SceneFile::open(path)? else {
        bail!(
            "{}: not a scene; a scene is JSON, or a picture that Strahl made",
            path.display()
        );
    };
    draw::note_cut(&file, quiet);
    if file.scene.volume.is_none() {
        return Ok("every key is known; it names no volume, so only its keys were checked");
    }
    let stages = Stages::new(quiet);
    let notes = Render::scene_file(file)
        .control(stages.control())
        .scene_notes()?;
    drop(stages);
    for note in draw::notes(notes.iter()) {
        print::note(&format!("{}: {note}", path.display()), quiet);
    }
    Ok("can be drawn")
}

fn show(flags: &SceneShowFlags, quiet: bool) -> Result<()> {
    let output = flags.output.as_deref().map(Output::create).transpose()?;
    let subject = draw::over(
        draw::subject_within(&flags.inputs, &flags.read, &flags.trust, quiet)?,
        &flags.draw,
    )?;
    let stages = Stages::new(quiet);
    let scene = subject.control(stages.control()).settled_scene();
    drop(stages);
    let scene = scene.map_err(|error| draw::of_missing_data(error.into(), &flags.inputs))?;
    match output {
        None => print::out(&seen_from(Path::new("."), &scene).to_json()),
        Some(mut output) => {
            let scene = seen_from(output.folder(), &scene);
            output.write_all(scene.to_json().as_bytes())?;
            Ok(output.finish()?)
        }
    }
}
