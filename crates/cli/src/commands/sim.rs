//! `strahl sim`: a picture on the modeled processor, its Spec, its studies.

use super::load::load;
use crate::args;
use crate::flags::{
    ReadFlags, SimCommand, SimRunFlags, SimScriptFlags, SimSpecFlags, SimStatsFormat, SimStudyFlags,
};
use crate::print;
use crate::progress::{Progress, shown_by};
use anyhow::{Context, Result, bail};
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use strahl::glam::DVec3;
use strahl::scene::plan;
use strahl::sim::local_bus::LocalBus;
use strahl::sim::pipeline_diagram::PipelineDiagram;
use strahl::sim::report::{Report, Table, html};
use strahl::sim::spec::{Optimisation, Projection, RowRule, Shape};
use strahl::sim::statistics::{Statistics, counts};
use strahl::sim::study::{Lab, STUDIES};
use strahl::sim::waveform::Waveform;
use strahl::sim::{
    Frame, NoObserver, Picture, Run, Spec, Subject, VolumeStore, gray_png, host_script, jaw,
    messages,
};
use strahl::volume::read::mesh::read_mesh;
use strahl::volume::{Mesh, Phantom};
use strahl::{Folder, Output, Render, SceneFile, Volume};

/// Whether a run is under way that can end with what it has.
static RUNNING: AtomicBool = AtomicBool::new(false);
static STOP: AtomicBool = AtomicBool::new(false);

/// Asks a run to end with what it has; whether there is one. The second time there is none.
pub fn stop() -> bool {
    RUNNING.load(Ordering::Relaxed) && !STOP.swap(true, Ordering::Relaxed)
}

fn stopped() -> ControlFlow<()> {
    match STOP.load(Ordering::Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

/// No Spec and no script is longer.
const MOST_TEXT_BYTES: usize = 64 << 20;

pub fn run(command: &SimCommand, quiet: bool) -> Result<()> {
    match command {
        SimCommand::Run(flags) => run_frame(flags, quiet),
        SimCommand::Spec(flags) => spec(flags),
        SimCommand::Study(flags) => study(flags, quiet),
        SimCommand::Script(flags) => script(flags),
    }
}

fn script(flags: &SimScriptFlags) -> Result<()> {
    let file = flags.script.display().to_string();
    let text = strahl::read_text(&flags.script, MOST_TEXT_BYTES)?;
    let spec = read_spec(flags.spec.as_deref())?.unwrap_or_default();
    let output = flags.output.as_deref().map(Output::create).transpose()?;
    let read = host_script::run(&file, &text, &spec.with(&flags.set)?)?;
    match output {
        Some(output) => write(Some(output), read.as_bytes()),
        None => print::out(&read),
    }
}

fn spec(flags: &SimSpecFlags) -> Result<()> {
    if flags.schema {
        return print::out(&Spec::schema());
    }
    let mut spec = read_spec(flags.spec.as_deref())?.unwrap_or_default();
    if flags.wide {
        spec.widths = strahl::sim::spec::Widths::wide();
    }
    let spec = spec.with(&flags.set)?;
    if flags.wires {
        let mut text = String::new();
        for wire in messages::wires(&spec) {
            let name = format!("{}.{}", wire.unit, wire.name);
            let _ = writeln!(text, "{name:<26} {:>3} bit  {}", wire.bits, wire.meaning);
        }
        return print::out(&text);
    }
    print::out(&spec.to_commented_json())
}

fn read_spec(path: Option<&Path>) -> Result<Option<Spec>> {
    let Some(path) = path else {
        return Ok(None);
    };
    let file = path.display().to_string();
    let text = strahl::read_text(path, MOST_TEXT_BYTES)?;
    Ok(Some(Spec::parse(&file, &text)?))
}

fn run_frame(flags: &SimRunFlags, quiet: bool) -> Result<()> {
    let window = window(&flags.window)?;
    // Before the long work, so that a place that cannot be written is found first.
    let create = |path: &Option<PathBuf>| path.as_deref().map(Output::create).transpose();
    let output = create(&flags.output)?;
    let row_changes = create(&flags.row_changes)?;
    let vcd = create(&flags.vcd)?;
    let diagram = create(&flags.diagram)?;
    let report = create(&flags.report)?;
    let host_script = create(&flags.host_script)?;

    let given = read_spec(flags.spec.as_deref())?;
    let mut spec = given.clone().unwrap_or_default();
    let store = first_volume(flags, given.is_some(), &mut spec, quiet)?;
    if flags.brute_force {
        spec.optimisation = Optimisation::none();
    }
    let spec = spec.with(&flags.set)?;
    let subject = Subject {
        volume: &store,
        others: others(&spec, quiet)?,
        mesh: mesh(&spec, quiet)?,
    };
    let preparing = Progress::new("loading", quiet);
    let picture = Picture::new(&spec, &subject)?;
    drop(preparing);
    if host_script.is_some() {
        let frame = Frame::new(&spec, &store)?;
        let text = host_script::of_tile(&frame, &store, flags.tile)?;
        // That it can be run at all is found now.
        LocalBus::new(&spec)?;
        write(host_script, text.as_bytes())?;
    }

    let rays = (spec.queue.bundle[0] * spec.queue.bundle[1]) as usize;
    let mut observers = (
        Waveform::new(&spec, window.clone()),
        PipelineDiagram::new(window, rays),
    );
    let is_observed = vcd.is_some() || diagram.is_some() || report.is_some();
    let start = Instant::now();
    let drawn = {
        let bar = Progress::new("simulating", quiet);
        let progress = |drawn: usize, all: usize| {
            bar.update(drawn as f64 / all as f64);
            stopped()
        };
        RUNNING.store(true, Ordering::Relaxed);
        let drawn = match is_observed {
            true => picture.draw(&mut observers, &progress),
            false => picture.draw(&mut NoObserver, &progress),
        };
        RUNNING.store(false, Ordering::Relaxed);
        drawn?
    };
    let seconds = start.elapsed().as_secs_f64();
    let statistics = Statistics::new(&store.name, &spec, &drawn);
    if !drawn.is_complete {
        print::note(
            "stopped before the end; the picture and all counts are those so far",
            quiet,
        );
    }

    let png = drawn.png(flags.bits.parse()?)?;
    write(output, &png)?;
    if row_changes.is_some() {
        let map = gray_png::encode_counts(drawn.size, changes(&spec, &drawn), None)?;
        write(row_changes, &map)?;
    }
    if vcd.is_some() {
        write(vcd, observers.0.to_vcd().as_bytes())?;
    }
    let svg = observers.1.to_svg();
    write(diagram, svg.as_bytes())?;
    if report.is_some() {
        let page = page(&statistics, &drawn, &spec, svg)?;
        write(report, page.to_html().as_bytes())?;
    }
    match flags.stats {
        Some(SimStatsFormat::Json) => print::out(&statistics.to_json()?)?,
        Some(SimStatsFormat::Csv) => print::out(&statistics.to_csv())?,
        None => print::out(&summary(&statistics))?,
    }
    if !quiet {
        let speed = statistics.counters.clocks as f64 / seconds / 1e6;
        print::message(&format!(
            "simulated in {seconds:.2} s, {speed:.1} million clocks per second"
        ));
    }
    Ok(())
}

fn changes<'r>(spec: &Spec, drawn: &'r Run) -> &'r [u32] {
    match spec.memory.row_rule {
        RowRule::Thesis => &drawn.thesis_changes_of_pixel,
        RowRule::Exact => &drawn.stalls_of_pixel,
    }
}

fn write(output: Option<Output>, bytes: &[u8]) -> Result<()> {
    if let Some(mut output) = output {
        output.write_all(bytes)?;
        output.finish()?;
    }
    Ok(())
}

/// `A..B`.
fn window(text: &str) -> Result<Range<u64>> {
    let parts = text.split_once("..").and_then(|(a, b)| {
        let (a, b) = (a.trim().parse().ok()?, b.trim().parse().ok()?);
        Some(a..b)
    });
    match parts {
        Some(window) if window.start < window.end && window.end - window.start <= 100_000 => {
            Ok(window)
        }
        _ => bail!(
            "--window is {text}; it must be two clocks such as 300..400, at most 100000 apart"
        ),
    }
}

/// The volume that was named; a scene also sets view, step and opacity.
fn first_volume(
    flags: &SimRunFlags,
    has_spec: bool,
    spec: &mut Spec,
    quiet: bool,
) -> Result<VolumeStore> {
    let [first, others @ ..] = flags.inputs.as_slice() else {
        bail!("no volume is named");
    };
    let dims = flags.voxels.as_deref().map(args::dims).transpose()?;
    let name = first.to_str().unwrap_or_default();
    if !first.exists() && others.is_empty() {
        if name == "jaw" && !has_spec {
            spec.look.opacity = vec![[1000.0, 0.0], [4095.0, 1.0]];
        }
        if let Some(store) = phantom(name, dims)? {
            return Ok(store);
        }
    }
    if dims.is_some() {
        bail!("--voxels is given for {name}, which is no phantom");
    }
    if let Some(file) = SceneFile::open(first)? {
        if !others.is_empty() {
            bail!("a scene is named with other files; put the volume into the scene");
        }
        return scene(file, has_spec, spec, quiet);
    }
    let loaded = load(&flags.inputs, &flags.read, quiet)?;
    for note in &loaded.notes {
        print::note(note, quiet);
    }
    Ok(VolumeStore::new(&loaded.volume)?)
}

/// A phantom by its name.
fn phantom(name: &str, dims: Option<[usize; 3]>) -> Result<Option<VolumeStore>> {
    let volume = match (name, Phantom::from_name(name)) {
        ("jaw", _) => jaw(dims.unwrap_or([128, 128, 64]))?,
        (_, Some(phantom)) => phantom.volume(dims.unwrap_or_else(|| phantom.dims_for_edge(128)))?,
        _ => return Ok(None),
    };
    Ok(Some(VolumeStore::new(&volume)?))
}

/// The volumes that `merge.volumes` names.
fn others(spec: &Spec, quiet: bool) -> Result<Vec<VolumeStore>> {
    let volumes = spec.merge.volumes.iter().map(|placed| {
        let path = PathBuf::from(&placed.path);
        if !path.exists()
            && let Some(store) = phantom(&placed.path, None)?
        {
            return Ok(store);
        }
        let loaded = load(&[path], &ReadFlags::default(), quiet)?;
        for note in &loaded.notes {
            print::note(note, quiet);
        }
        Ok(VolumeStore::new(&loaded.volume)?)
    });
    volumes.collect()
}

/// The mesh that `polygons.shape` names.
fn mesh(spec: &Spec, quiet: bool) -> Result<Option<Mesh>> {
    let Shape::File { path } = &spec.polygons.shape else {
        return Ok(None);
    };
    let file = Path::new(path);
    fs::metadata(file).with_context(|| format!("cannot read {path}"))?;
    let name = file
        .file_name()
        .with_context(|| format!("{path} names no file"))?;
    let loaded = read_mesh(&name.to_string_lossy(), &Folder::around(file), None)?;
    for note in &loaded.notes {
        print::note(note, quiet);
    }
    Ok(Some(loaded.mesh))
}

fn scene(file: SceneFile, has_spec: bool, spec: &mut Spec, quiet: bool) -> Result<VolumeStore> {
    let source = file.scene.volume.clone().unwrap_or_default();
    let plan = Render::scene_file(file).plan()?;
    let volume: Volume = match (&source.phantom, &source.path) {
        (Some(name), _) => {
            let phantom =
                Phantom::from_name(name).with_context(|| format!("there is no phantom {name}"))?;
            phantom.volume(source.dims.unwrap_or_else(|| phantom.default_dims()))?
        }
        (None, Some(path)) => {
            let progress = Progress::new("reading", quiet);
            let paths = [PathBuf::from(path)];
            let options = source.read_options()?;
            strahl::load_under(&paths, &options, &shown_by(&progress))?.volume
        }
        (None, None) => bail!("the scene names no volume"),
    };
    if plan.layers.len() > 1 {
        bail!(
            "the scene has {} volumes; the processor draws one at a time",
            plan.layers.len()
        );
    }
    if !plan.meshes.is_empty() || !plan.ray_clips.is_empty() || !plan.sample_clips.is_empty() {
        bail!("the scene has meshes or clips, which the processor does not know; take them out");
    }
    if plan.field().is_moved {
        bail!(
            "the scene moves its volume, which the processor does not know; turn the camera instead"
        );
    }
    if !has_spec {
        over(spec, &plan, quiet)?;
    }
    Ok(VolumeStore::new(&volume)?)
}

/// Takes view, step and opacity from a Plan. The rest (colors, lights, framing) the processor has in its own way.
fn over(spec: &mut Spec, plan: &plan::Plan, quiet: bool) -> Result<()> {
    let voxel_from_world = plan.field().grid.voxel_from_world().matrix3;
    // Directions only: voxels count as cubes.
    let turned = |v: DVec3| {
        let columns = [0, 1, 2].map(|i| voxel_from_world.row(i).normalize());
        DVec3::new(columns[0].dot(v), columns[1].dot(v), columns[2].dot(v)).normalize()
    };
    let forward = turned(plan.camera.forward);
    let up = turned(plan.camera.up);
    let tilt = (-forward.z).clamp(-1.0, 1.0).asin();
    spec.view.rotate_x_deg = tilt.to_degrees();
    spec.view.rotate_z_deg = forward.x.atan2(forward.y).to_degrees();
    let level = DVec3::new(
        spec.view.rotate_z_deg.to_radians().sin(),
        spec.view.rotate_z_deg.to_radians().cos(),
        0.0,
    );
    let upright = DVec3::Z * tilt.cos() + level * tilt.sin();
    if up.dot(upright) < 0.99 {
        bail!(
            "the scene's camera is rolled or looks along z; the processor keeps z upright (view.rotate_z_deg, rotate_x_deg)"
        );
    }
    let table = &plan.technique().table;
    let spacing = plan.field().grid.mean_spacing_mm();
    spec.view.step = (plan.lattice.step_mm / spacing).clamp(0.05, 3.0);
    let [lo, hi] = table.domain();
    let exponent = f64::from(plan.lattice.step_mm as f32) / f64::from(table.reference_mm());
    let points = 512;
    spec.look.opacity = (0..=points)
        .map(|i| {
            let value = lo + (hi - lo) * i as f32 / points as f32;
            let opacity = f64::from(table.at(value)[3]).clamp(0.0, 1.0);
            [f64::from(value), 1.0 - (1.0 - opacity).powf(exponent)]
        })
        .collect();
    spec.look.gradient_weighting = false;
    spec.widths.length = 13;
    spec.widths.key = 13;
    if let plan::Projection::Perspective { tan_half_height } = plan.camera.projection {
        let aspect = (f64::from(plan.width) / f64::from(plan.height)).max(1.0);
        let angle = 2.0 * (tan_half_height * aspect).atan().to_degrees();
        spec.view.projection = Projection::Perspective {
            angle_deg: angle.clamp(1.0, 120.0),
        };
    }
    print::note(
        "direction, step and opacity are the scene's; colors, lights, size and framing are the processor's own",
        quiet,
    );
    Ok(())
}

/// What is said without --stats.
fn summary(s: &Statistics) -> String {
    let c = &s.counters;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {} × {} pixels, {} rays",
        s.volume, s.size[0], s.size[1], c.rays
    );
    let _ = writeln!(
        text,
        "  {} clocks, {:.2} frames per second at {} MHz, {:.1} % of clocks read",
        c.clocks,
        s.frames_per_second,
        s.spec.clock_mhz,
        100.0 * s.utilisation
    );
    let [leapt, ended, distance, sampled] = s.percent_of_samples;
    let _ = writeln!(
        text,
        "  {} samples: {leapt:.1} % leapt over, {ended:.1} % behind the end of rays, {distance:.1} % only a distance, {sampled:.1} % read",
        c.samples
    );
    let _ = writeln!(
        text,
        "  row changes: {} as the document counts ({:.3} % of reads), {} reads waiting for {} rows of modules ({:.3} %)",
        c.thesis_row_changes,
        100.0 * s.thesis_changes_per_read,
        c.row_stalls,
        c.row_changes,
        100.0 * s.stalls_per_read
    );
    let _ = writeln!(
        text,
        "  frozen: {} for rows, {} for words, {} for refreshes; without a read: {}",
        c.frozen_for_rows,
        c.frozen_for_words,
        c.frozen_for_refresh,
        c.bubbles()
    );
    if c.distance_row_changes > 0 {
        let _ = writeln!(
            text,
            "  distance store: {} row changes, {} clocks frozen beyond those for voxels",
            c.distance_row_changes, c.frozen_for_distances
        );
    }
    if c.coding_clocks > 0 {
        let _ = writeln!(
            text,
            "  distance engine: {} clocks, once per classification",
            c.coding_clocks
        );
    }
    if c.light_samples > 0 {
        let _ = writeln!(
            text,
            "  light pass: {} reads for {} samples",
            c.light_reads, c.light_samples
        );
    }
    if !s.clocks_of_part.is_empty() {
        let clocks: Vec<String> = s.clocks_of_part.iter().map(u64::to_string).collect();
        let what = if s.spec.view.slabs > 1 {
            "slab"
        } else {
            "board"
        };
        let _ = writeln!(text, "  clocks of each {what}: {}", clocks.join(", "));
    }
    text
}

fn page(s: &Statistics, drawn: &Run, spec: &Spec, svg: String) -> Result<Report> {
    let mut table = Table::new("counts", &["count", "number"]);
    for (name, number) in counts(&s.counters) {
        table
            .rows
            .push(vec![name.replace('_', " "), number.to_string()]);
    }
    let mut clocks = Table::new("clocks", &["clocks", "number", "%"]);
    let c = &s.counters;
    for (name, number) in [
        ("reads", c.reads),
        ("reads of light rays", c.light_reads),
        ("frozen for rows", c.frozen_for_rows),
        ("frozen for words", c.frozen_for_words),
        ("frozen for refreshes", c.frozen_for_refresh),
        ("frozen for distances", c.frozen_for_distances),
        ("no ray waits", c.bubbles_empty),
        ("the ray has ended", c.bubbles_ended),
        ("no ray has its rows", c.bubbles_rows),
        ("filling", c.bubbles_filling),
        ("host", c.bubbles_host),
    ] {
        let percent = 100.0 * number as f64 / c.clocks.max(1) as f64;
        clocks.rows.push(vec![
            name.to_owned(),
            number.to_string(),
            format!("{percent:.3}"),
        ]);
    }
    Ok(Report {
        name: "run".to_owned(),
        title: format!("{} on the pipeline processor", s.volume),
        text: vec![summary(s)],
        tables: vec![clocks, table],
        pictures: vec![
            (
                "picture".to_owned(),
                "the picture".to_owned(),
                drawn.png(8)?,
            ),
            (
                "row-changes".to_owned(),
                "row changes by the pixel whose ray met them".to_owned(),
                gray_png::encode_counts(drawn.size, changes(spec, drawn), None)?,
            ),
        ],
        drawings: vec![("pipeline".to_owned(), svg)],
        ..Report::default()
    })
}

fn study(flags: &SimStudyFlags, quiet: bool) -> Result<()> {
    if flags.list {
        let mut text = String::new();
        for study in &STUDIES {
            let _ = writeln!(text, "{:<14} {}", study.name, study.about);
        }
        return print::out(&text);
    }
    let (Some(name), Some(folder)) = (&flags.name, &flags.output) else {
        bail!("name a study and a folder");
    };
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let names: Vec<&str> = match name.as_str() {
        "all" => STUDIES.iter().map(|study| study.name).collect(),
        name => vec![name],
    };
    let bar = Progress::new("studying", quiet);
    let progress = |_| stopped();
    let mut lab = Lab::new(&progress);
    lab.with_large = flags.large;
    for path in &flags.volume {
        let loaded = load(std::slice::from_ref(path), &ReadFlags::default(), quiet)?;
        let mut store = VolumeStore::new(&loaded.volume)?;
        if let Some(stem) = path.file_name() {
            store.name = stem
                .to_string_lossy()
                .split('.')
                .next()
                .unwrap_or_default()
                .to_owned();
        }
        lab.volumes.push((store, Vec::new()));
    }
    for name in &flags.phantom {
        if let Some(store) = phantom(name, None)? {
            lab.volumes.push((store, Vec::new()));
        }
    }
    RUNNING.store(true, Ordering::Relaxed);
    let mut reports = Vec::new();
    for (i, name) in names.iter().enumerate() {
        bar.update(i as f64 / names.len() as f64);
        let made = lab.study(name);
        match made {
            Err(strahl::sim::Error::Stopped) => {
                print::note(
                    &format!("stopped in the study {name}; what was made before it is written"),
                    quiet,
                );
                break;
            }
            made => {
                let report = made?;
                report.write_parts(folder)?;
                reports.push(report);
            }
        }
    }
    RUNNING.store(false, Ordering::Relaxed);
    drop(bar);
    let page = folder.join("report.html");
    let mut output = Output::create(&page)?;
    output.write_all(html(&reports).as_bytes())?;
    output.finish()?;
    if !quiet {
        print::message(&format!(
            "wrote {} with {} studies",
            page.display(),
            reports.len()
        ));
    }
    Ok(())
}
