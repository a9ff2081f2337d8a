//! `strahl render` and `strahl demo`: a picture.

use crate::args;
use crate::flags::{
    DemoFlags, DrawFlags, PictureFlags, ReadFlags, RenderFlags, StatsFormat, TrustFlags,
};
use crate::print;
use crate::progress::{Progress, Stages};
use crate::remedy;
use anyhow::{Result, anyhow, bail};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use strahl::scene::VolumeSource;
use strahl::scene::plan::Display;
use strahl::volume::Phantom;
use strahl::{
    Confinement, DrawnBy, Encoding, Image, Output, Picture, Render, Scene, SceneFile, Told, cpu,
};

pub fn render(flags: &RenderFlags, quiet: bool) -> Result<()> {
    let subject = subject_within(&flags.inputs, &flags.read, &flags.trust, quiet)?;
    draw(subject, &flags.draw, &flags.file, &flags.output, quiet)
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
            if let Some(software) = file.software.as_ref().filter(|s| **s != strahl::SOFTWARE) {
                print::note(
                    &format!(
                        "{} was made by {software}, this is {}; it may look different",
                        first.display(),
                        strahl::SOFTWARE
                    ),
                    quiet,
                );
            }
            if others.is_empty() {
                source = file.scene.volume.clone().unwrap_or_default();
            }
            let render = Render::scene_file(file);
            match others {
                [] => render,
                _ => render.with_files(others.to_vec()),
            }
        }
        None => Render::files(inputs.to_vec()),
    };
    let source = args::read_over(read, source)?;
    let said = source != VolumeSource::default();
    Ok(render.with(|scene| scene.volume = said.then_some(source)))
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
        end_after(seconds);
    }
    // Before the long work, so that a place that cannot be written is found first.
    let output = Output::create(path)?;
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
    for note in &picture.notes {
        match remedy::of_note(note) {
            Some(remedy) => print::note(&format!("{note}; {remedy}"), quiet),
            None => print::note(&note.to_string(), quiet),
        }
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
        print::message(&format!(
            "wrote {path}: {width} × {height} pixels in {total_seconds:.1} s"
        ));
    }
    if let Some(StatsFormat::Json) = file.stats {
        let stats = stats(path, &picture, write_seconds, total_seconds);
        print::out(&(serde_json::to_string_pretty(&stats)? + "\n"))?;
    }
    Ok(())
}

/// Ends the program after so many seconds, wherever it is then.
fn end_after(seconds: f64) {
    let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    std::thread::spawn(move || {
        std::thread::sleep(limit);
        strahl::abandon_outputs();
        print::message(&format!(
            "error: the picture is not finished after {seconds} seconds, the limit of --max-time"
        ));
        std::process::exit(1);
    });
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
    result.map(|()| subject)
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
