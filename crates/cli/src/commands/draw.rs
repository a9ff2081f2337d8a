//! `strahl render` and `strahl demo`: a picture.

use crate::args;
use crate::flags::{
    DemoFlags, DrawFlags, PictureFlags, ReadFlags, RenderFlags, StatsFormat, TrustFlags,
};
use crate::print;
use crate::progress::{Progress, Stages};
use crate::remedy;
use anyhow::{Error, Result, anyhow, bail};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::io::ErrorKind;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use strahl::scene::plan::Display;
use strahl::scene::{VolumeSource, WithoutEffect};
use strahl::volume::Phantom;
use strahl::{
    Confinement, DrawnBy, Encoding, Image, Note, Output, Picture, Render, Scene, SceneFile, Told,
    cpu,
};

pub fn render(flags: &RenderFlags, quiet: bool) -> Result<()> {
    let own = flags.inputs.first().filter(|first| is_own_picture(first));
    let others = flags.inputs.iter().filter(|input| Some(*input) != own);
    let read = others.chain(&flags.draw.labels).chain(&flags.draw.graph);
    refuse_to_replace(&flags.output, read)?;
    let subject = subject_within(&flags.inputs, &flags.read, &flags.trust, quiet)?;
    let drawn = draw(subject, &flags.draw, &flags.file, &flags.output, quiet);
    drawn.map_err(|error| of_missing_data(error, &flags.inputs))
}

/// Whether a file is a picture with a scene, which may be drawn again in its place.
fn is_own_picture(path: &Path) -> bool {
    crate::flags::is_picture(path) && matches!(strahl::Recipe::of_file(path), Ok(Some(_)))
}

/// Refuses to write where something is read, also behind links.
pub fn refuse_to_replace<'p>(
    output: &Path,
    mut read: impl Iterator<Item = &'p PathBuf>,
) -> Result<()> {
    let Ok(target) = output.canonicalize() else {
        return Ok(());
    };
    let is_target = |path: &&PathBuf| path.canonicalize().is_ok_and(|real| real == target);
    match read.find(is_target) {
        Some(path) => bail!(
            "{} is {}, which is read: it would be lost; write another file",
            output.display(),
            if path == output {
                "the input".to_owned()
            } else {
                format!("the same file as {}", path.display())
            }
        ),
        None => Ok(()),
    }
}

/// Says of a file that a picture names, and that is not where it says, how to name it.
pub fn of_missing_data(error: Error, inputs: &[PathBuf]) -> Error {
    let [picture] = inputs else {
        return error;
    };
    match error.downcast_ref() {
        Some(strahl::Error::Path { path, error: why })
            if why.kind() == ErrorKind::NotFound
                && crate::flags::is_picture(picture)
                && path != picture =>
        {
            let (name, picture) = (path.file_name().unwrap_or_default(), picture.display());
            anyhow!(
                "{picture} carries a scene, not the data: it names {}, and there is no such file; put it there, or name the volume after the picture, `{picture} FOLDER/{}`, and labels with --labels",
                path.display(),
                name.display()
            )
        }
        _ => error,
    }
}

/// What `strahl demo` draws when nobody says how: the anatomy phantom, cut open.
const CUT_OPEN: &str = include_str!("../demo.json");

pub fn demo(flags: &DemoFlags, quiet: bool) -> Result<()> {
    let look_is_said = flags.draw.preset.is_some() || flags.draw.method.is_some();
    let mut scene = if flags.phantom == Phantom::Anatomy.name() && !look_is_said {
        Scene::parse("demo.json", CUT_OPEN)?
    } else {
        Scene::default()
    };
    if !(flags.draw.highlight.is_empty() && flags.draw.only.is_empty()) {
        // Segments have looks of their own.
        (scene.method, scene.transfer_function) = (None, None);
    }
    scene.volume = Some(VolumeSource {
        phantom: Some(flags.phantom.clone()),
        dims: flags.dims.as_deref().map(args::dims).transpose()?,
        ..VolumeSource::default()
    });
    let subject = Render::scene(scene);
    draw(subject, &flags.draw, &flags.file, &flags.output, quiet)
}

/// What the files that were named ask to draw: a volume, a scene, or a scene with another volume.
#[cfg(feature = "graph")]
pub fn subject(inputs: &[PathBuf], read: &ReadFlags, quiet: bool) -> Result<Render<'static>> {
    subject_within(inputs, read, &TrustFlags::default(), quiet)
}

/// The same, with what a scene may read.
pub fn subject_within(
    inputs: &[PathBuf],
    read: &ReadFlags,
    trust: &TrustFlags,
    quiet: bool,
) -> Result<Render<'static>> {
    let confinement = trust.confine.as_deref().map(Confinement::to).transpose()?;
    let [first, others @ ..] = inputs else {
        bail!("no scene and no volume is named");
    };
    let mut source = VolumeSource::default();
    let render = match SceneFile::open_within(first, confinement.as_ref())? {
        Some(file) => {
            if let Some(software) = &file.software {
                note_other_software(first, software, quiet);
            }
            note_cut(&file, quiet);
            if others.is_empty() {
                source = file.scene.volume.clone().unwrap_or_default();
            }
            let render = Render::scene_file(file);
            match others {
                [] => render,
                _ => render.with_files(others.to_vec()),
            }
        }
        None => {
            refuse_misplaced_pictures(first, others)?;
            Render::files(inputs.to_vec())
        }
    };
    let source = args::read_over(read, source)?;
    let said = source != VolumeSource::default();
    Ok(render.with(|scene| scene.volume = said.then_some(source)))
}

/// Refuses flags for segments where there are none: the whole volume is not what was asked for.
fn check_labels_are_there(flags: &DrawFlags, notes: &[Note]) -> Result<()> {
    let flag = [
        ("--only", &flags.only),
        ("--highlight", &flags.highlight),
        ("--show", &flags.show),
        ("--hide", &flags.hide),
    ];
    let Some((flag, texts)) = flag.into_iter().find(|(_, texts)| !texts.is_empty()) else {
        return Ok(());
    };
    match notes.contains(&Note::NoLabels) {
        true => bail!(
            "{flag} is {}, and the volume has no labels; give them with --labels FILE, or draw intervals of values with --layers",
            texts[0]
        ),
        false => Ok(()),
    }
}

/// Says that another version has made a picture, or something else that calls itself so.
fn note_other_software(picture: &Path, software: &str, quiet: bool) {
    /// Of a name that came with a file.
    const MOST_CHARS: usize = 60;
    if software.eq_ignore_ascii_case(strahl::SOFTWARE) {
        return;
    }
    let maker = match software.trim() {
        "" => "something that does not tell its name".to_owned(),
        name if name.chars().count() > MOST_CHARS => {
            format!("{} …", name.chars().take(MOST_CHARS).collect::<String>())
        }
        name => name.to_owned(),
    };
    print::note(
        &format!(
            "{} was made by {maker}, this is {}; it may look different",
            picture.display(),
            strahl::SOFTWARE
        ),
        quiet,
    );
}

/// Says that a picture is cut off whose scene is used.
pub fn note_cut(file: &SceneFile, quiet: bool) {
    if file.is_cut {
        let path = file.path.display();
        let note = format!("{path} is cut off: its last pixels are missing; its scene is whole");
        print::note(&note, quiet);
    }
}

/// Refuses pictures behind a volume that is no picture. Several files are slices, so they would be drawn in place of
/// the volume.
fn refuse_misplaced_pictures(first: &Path, others: &[PathBuf]) -> Result<()> {
    let ending = first.extension().unwrap_or_default().to_ascii_lowercase();
    let of_slices = ["png", "exr", "tif", "tiff", "bmp", "jpg", "jpeg"];
    if of_slices.iter().any(|known| ending == *known) {
        return Ok(());
    }
    let Some(picture) = others.iter().find(|path| crate::flags::is_picture(path)) else {
        return Ok(());
    };
    let (first, name) = (first.display(), picture.display());
    match SceneFile::open(picture) {
        Ok(Some(_)) => bail!(
            "{name} stands behind {first}: it is a picture with a scene; to draw this scene with this volume, write `{name} {first}`; to write the picture, `-o {name}`"
        ),
        _ => bail!(
            "{name} stands behind {first}: several files are slices of one volume, and {first} is no picture; to write the picture, use `-o {name}`"
        ),
    }
}

fn draw(
    subject: Render,
    flags: &DrawFlags,
    file: &PictureFlags,
    path: &Path,
    quiet: bool,
) -> Result<()> {
    let start = Instant::now();
    let encoding = Encoding::for_path(path, file.bits)?;
    if file.depth && matches!(encoding, Encoding::Png8 | Encoding::Png16) {
        bail!(
            "--depth is given for {}: PNG holds no depth; name a file that ends in .exr",
            path.display()
        );
    }
    let mut sets_display = false;
    let mut subject = over(subject, flags)?.with(|scene| sets_display = scene.display.is_some());
    if file.depth {
        subject = subject.with_depth();
    }
    let budget = args::budget(&file.limits)?;
    if let Some(seconds) = file.limits.max_time {
        end_after(seconds)?;
    }
    // Before the long work, so that a place that cannot be written is found first.
    let output = Output::create(path)?;
    let folder_of_picture = output.folder().to_owned();
    let stages = Stages::new(quiet);
    let folder = file.stages.clone();
    if let Some(folder) = &folder {
        std::fs::create_dir_all(folder).map_err(|why| {
            anyhow!(
                "--stages is {}: the folder cannot be created: {why}",
                folder.display()
            )
        })?;
    }
    let failed = Mutex::new(None);
    let show = |picture: &Image, display: &Display, stage: cpu::Stage| {
        let name = format!("stage-{}.png", stage.number);
        let path = folder.iter().map(|folder| folder.join(&name)).next();
        let written = path.map_or(Ok(()), |path| write_stage(picture, display, &path));
        match written {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                ControlFlow::Break(())
            }
        }
    };
    if folder.is_some() {
        subject = subject.in_stages(&show);
    }
    let picture = subject
        .threads(file.threads.unwrap_or(0))
        .backend(args::backend(file)?)
        .budget(budget)
        .control(stages.control())
        .picture();
    drop(stages);
    if let Some(error) = failed.lock().unwrap_or_else(PoisonError::into_inner).take() {
        return Err(error.into());
    }
    let picture = picture?;
    check_labels_are_there(flags, &picture.notes)?;
    let write_start = Instant::now();
    let writing = Progress::new("writing", quiet);
    let told = match (file.no_recipe, file.anonymous) {
        (true, _) => Told::Nothing,
        (_, true) => Told::Anonymous,
        _ => Told::Scene,
    };
    picture.write_telling(told, encoding, output)?;
    drop(writing);
    let write_seconds = write_start.elapsed().as_secs_f64();
    let untold = match told {
        Told::Scene => picture.untold_places(&folder_of_picture),
        _ => None,
    };
    for note in notes(picture.notes.iter().chain(&untold)) {
        print::note(&note, quiet);
    }
    if sets_display && !matches!(encoding, Encoding::Png8 | Encoding::Png16) {
        print::note(
            "display changes nothing: EXR files hold linear light",
            quiet,
        );
    }
    let total_seconds = start.elapsed().as_secs_f64();
    if !quiet {
        let (width, height) = (picture.image.width(), picture.image.height());
        let path = path.display();
        let preset = match &picture.scene.preset {
            Some(preset) => format!(", preset {preset}"),
            None => String::new(),
        };
        print::message(&format!(
            "wrote {path}: {width} × {height} pixels in {total_seconds:.1} s{preset}"
        ));
    }
    if let Some(StatsFormat::Json) = file.stats {
        let stats = stats(path, &picture, write_seconds, total_seconds);
        print::out(&(serde_json::to_string_pretty(&stats)? + "\n"))?;
    }
    Ok(())
}

/// What to print of `notes`, with what to do. Keys that change nothing for the same reason share one.
pub fn notes<'n>(notes: impl Iterator<Item = &'n Note>) -> Vec<String> {
    /// More would not be read.
    const MOST: usize = 40;
    let mut texts: Vec<String> = Vec::new();
    // How often each of them stands there, and where.
    let mut repeated: Vec<usize> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    // Where each reason stands, and which keys it has.
    let mut reasons: Vec<(usize, &str, Vec<&str>)> = Vec::new();
    for note in notes {
        if let Note::WithoutEffect(WithoutEffect { key, why }) = note {
            if let Some((at, _, keys)) = reasons.iter_mut().find(|reason| reason.1 == why) {
                keys.push(key);
                let (last, others) = (key, keys[..keys.len() - 1].join(", "));
                texts[*at] = format!("{others} and {last} change nothing: {why}");
                continue;
            }
            reasons.push((texts.len(), why, vec![key]));
        }
        let text = match remedy::of_note(note) {
            Some(remedy) => format!("{note}; {remedy}"),
            None => note.to_string(),
        };
        match places.get(&text) {
            Some(at) => repeated[*at] += 1,
            None => {
                places.insert(text.clone(), texts.len());
                texts.push(text);
                repeated.push(1);
            }
        }
    }
    for (text, times) in texts
        .iter_mut()
        .zip(repeated)
        .filter(|(_, times)| *times > 1)
    {
        text.push_str(&format!(" ({times} times)"));
    }
    if texts.len() > MOST {
        let more = texts.len() - MOST;
        texts.truncate(MOST);
        texts.push(format!("{more} more notes are left out"));
    }
    texts
}

/// Ends the program after so many seconds, wherever it is then.
fn end_after(seconds: f64) -> Result<()> {
    let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    let clock = std::thread::Builder::new().spawn(move || {
        std::thread::sleep(limit);
        strahl::abandon_outputs();
        print::message(&format!(
            "error: the picture is not finished after {seconds} seconds, the limit of --max-time"
        ));
        std::process::exit(1);
    });
    match clock {
        Ok(_) => Ok(()),
        Err(error) => {
            bail!("--max-time is {seconds}, and there is no thread for its clock: {error}")
        }
    }
}

/// Writes the picture of a stage, which has no recipe: no scene gives it alone.
fn write_stage(picture: &Image, display: &Display, path: &Path) -> Result<(), strahl::Error> {
    let mut output = Output::create(path)?;
    let encoding = Encoding::Png8;
    strahl::write_picture(picture, None, display, encoding, None, &mut output)?;
    output.finish()
}

/// `subject` with what was typed put over its scene.
pub fn over<'a>(subject: Render<'a>, flags: &DrawFlags) -> Result<Render<'a>> {
    let mut result = Ok(());
    let subject = subject.with(|scene| result = args::draw_over(flags, scene));
    result?;
    // What was typed may lie anywhere, whatever the scene may read.
    Ok(match &flags.labels {
        Some(labels) => subject.allowing(labels)?,
        None => subject,
    })
}

/// What `--stats json` prints; `docs/cli.md` explains the fields.
fn stats(path: &Path, picture: &Picture, write_seconds: f64, total_seconds: f64) -> Value {
    let mut all = json!({
        "picture": path.display().to_string(),
        "width": picture.image.width(),
        "height": picture.image.height(),
        "preset": picture.scene.preset,
        "method": picture.scene.method,
    });
    let mut seconds = json!({
        "read": picture.read_seconds,
        "draw": picture.stats.draw_seconds,
        "write": write_seconds,
        "total": total_seconds,
    });
    let stats = &picture.stats;
    match &picture.drawn_by {
        DrawnBy::Cpu => {
            all["backend"] = "cpu".into();
            all["threads"] = stats.threads.into();
            seconds["bricks"] = stats.bricks_seconds.into();
        }
        DrawnBy::Evaluator => {
            all["backend"] = "evaluator".into();
            all["threads"] = stats.threads.into();
            seconds["link"] = stats.link_seconds.into();
        }
        DrawnBy::Gpu { adapter } => {
            all["backend"] = "gpu".into();
            all["adapter"] = adapter.as_str().into();
            seconds["upload"] = stats.upload_seconds.into();
            seconds["link"] = stats.link_seconds.into();
        }
    }
    if picture.drawn_by != DrawnBy::Evaluator {
        seconds["prepare"] = stats.prepare_seconds.into();
    }
    if let Some(counts) = &stats.counts {
        all["rays"] = counts.rays.into();
        all["rays_in_volume"] = counts.rays_in_volume.into();
        all["rays_ended_early"] = counts.rays_ended_early.into();
        all["lattice_points"] = counts.lattice_points.into();
        all["samples"] = counts.samples.into();
        all["samples_visible"] = counts.samples_visible.into();
        all["points_skipped"] = counts.points_skipped.into();
        all["skipped_mm"] = counts.skipped_mm.into();
    }
    all["seconds"] = seconds;
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_notes_are_printed_once_and_many_are_cut() {
        let of = |n: usize| Note::Data(format!("note {n}"));
        let twice = [of(1), of(2), of(1)];
        assert_eq!(notes(twice.iter()), ["note 1 (2 times)", "note 2"]);
        let many: Vec<Note> = (0..300_000).map(of).collect();
        let printed = notes(many.iter());
        assert_eq!(printed.len(), 41);
        assert_eq!(printed[40], "299960 more notes are left out");
    }

    #[test]
    fn keys_without_effect_for_one_reason_share_a_note() {
        let of = |key: &str, why: &str| {
            Note::WithoutEffect(WithoutEffect {
                key: key.into(),
                why: why.into(),
            })
        };
        let all = [
            of("a", "of one"),
            Note::Data("data".into()),
            of("b", "of two"),
            of("c", "of one"),
            of("d", "of one"),
        ];
        let expected = [
            "a, c and d change nothing: of one",
            "data",
            "b changes nothing: of two",
        ];
        assert_eq!(notes(all.iter()), expected);
        assert_eq!(
            notes([&all[0], &all[3]].into_iter()),
            ["a and c change nothing: of one"]
        );
    }
}
