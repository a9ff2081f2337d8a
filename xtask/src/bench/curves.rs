//! `cargo xtask bench-curves`: how time and memory grow.

use super::plot::Plot;
use super::{Table, lines, median, milliseconds, number, numbers, publish};
use crate::older_commit::built_example;
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// What is to be measured.
#[derive(clap::Args)]
pub struct Arguments {
    /// Only this curve.
    #[arg(long, value_parser = ["volume", "picture", "threads", "step", "opacity"])]
    curve: Option<String>,
    /// Pictures of each point.
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Leaves out volumes with more voxels along an edge (1024³ takes 1.5 GiB).
    #[arg(long, default_value_t = 1024)]
    max_edge: u32,
    /// Keeps tables and plots in docs/performance.
    #[arg(long)]
    write: bool,
}

/// A curve: what the example calls it, the name of its quantity, whether it is plotted.
const CURVES: [(&str, &str, &str, bool); 5] = [
    ("volume", "edge of the volume, voxels", "Volume", true),
    ("picture", "edge of the picture, pixels", "Picture", true),
    ("step", "step, voxels", "Step", true),
    ("opacity", "factor of all opacities", "Opacity", true),
    ("threads", "threads", "Threads", false),
];

const MODES: [&str; 3] = ["unshaded", "shaded", "mip"];

const EDGES: [u32; 5] = [64, 128, 256, 512, 1024];

/// Measures and prints tables; draws plots if they are to be kept.
///
/// # Errors
/// The example cannot be built or run, or a file cannot be written.
pub fn run(root: &Path, arguments: &Arguments) -> Result<bool> {
    let program = built_example(root, "strahl-cpu", "cost_curves")?;
    let mut body = format!(
        "    cargo xtask bench-curves\n\n\
         Medians of {} frames of an 8-bit phantom. Each curve varies one quantity; the others are 256³ voxels, 512² \
         pixels, a step of one voxel, and two threads.\n",
        arguments.frames
    );
    for (curve, x, heading, is_plotted) in CURVES {
        if arguments.curve.as_ref().is_some_and(|only| only != curve) {
            continue;
        }
        eprintln!("{curve}");
        let phantoms: &[&str] = if curve == "volume" {
            &["shells", "tree"]
        } else {
            &["shells"]
        };
        let mut measured = Vec::new();
        for phantom in phantoms {
            let run = |at: Option<u32>| {
                let mut command = Command::new(&program);
                command.arg(format!("curve={curve}"));
                command.arg(format!("phantom={phantom}"));
                command.arg(format!("frames={}", arguments.frames));
                if let Some(at) = at {
                    command.arg(format!("at={at}"));
                }
                lines(&mut command)
            };
            if curve == "volume" {
                // A process each: the peak of memory is that of the process.
                for edge in EDGES.into_iter().filter(|edge| *edge <= arguments.max_edge) {
                    measured.extend(run(Some(edge))?);
                }
            } else {
                measured.extend(run(None)?);
            }
        }
        let points = measured
            .iter()
            .map(Point::new)
            .collect::<Result<Vec<_>>>()?;
        body += &format!("\n## {heading}\n\n");
        if is_plotted {
            body += &format!("![Time of a frame against {x}]({curve}.svg)\n\n");
        }
        body += &times(x, &points, phantoms);
        if curve == "volume" {
            body += &format!("\n## Memory\n\n{MEMORY_NOTE}\n\n{}", memory(&points));
        }
        if is_plotted && arguments.write {
            let folder = root.join("docs/performance");
            std::fs::create_dir_all(&folder)?;
            plot(x, &points, phantoms).write(&folder.join(format!("{curve}.svg")))?;
        }
    }
    println!("{body}");
    publish(root, "curves", "What a frame costs", &body, arguments.write)?;
    Ok(true)
}

/// Of 512² pixels in single precision.
const PICTURE_KIB: f64 = 4.0 * 1024.0;

const MEMORY_NOTE: &str = "Peak memory of a process that computes a phantom, prepares it, and draws it unshaded, shaded \
    and as MIP, at 512². The last column excludes the picture and the program itself, which is the memory in addition to the \
    samples after the phantom was computed.";

/// A line of the example.
struct Point {
    phantom: String,
    mode: String,
    x: f64,
    seconds: f64,
    samples: f64,
    raw_kib: f64,
    made_kib: Option<f64>,
    peak_kib: Option<f64>,
}

impl Point {
    fn new(line: &Value) -> Result<Point> {
        let text = |key: &str| {
            let text = line[key].as_str().map(str::to_owned);
            text.with_context(|| format!("no {key} in {line}"))
        };
        Ok(Point {
            phantom: text("phantom")?,
            mode: text("mode")?,
            x: number(line, "x")?,
            seconds: median(&numbers(line, "seconds")?),
            samples: number(line, "samples")?,
            raw_kib: number(line, "raw_kib")?,
            made_kib: line["made_kib"].as_f64(),
            peak_kib: line["peak_kib"].as_f64(),
        })
    }
}

/// The values of the quantity, in their order.
fn values(points: &[Point]) -> Vec<f64> {
    let mut values: Vec<f64> = points.iter().map(|point| point.x).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

fn find<'p>(points: &'p [Point], phantom: &str, mode: &str, x: f64) -> Option<&'p Point> {
    points
        .iter()
        .find(|point| point.phantom == phantom && point.mode == mode && point.x == x)
}

fn curve_name(phantom: &str, mode: &str, phantoms: &[&str]) -> String {
    let mode = if mode == "mip" { "MIP" } else { mode };
    match phantoms {
        [_] => mode.to_owned(),
        _ => format!("{phantom}, {mode}"),
    }
}

fn times(x: &str, points: &[Point], phantoms: &[&str]) -> String {
    let mut heads = vec![x.to_owned()];
    for phantom in phantoms {
        heads.extend(MODES.map(|mode| curve_name(phantom, mode, phantoms)));
        heads.push(match phantoms {
            [_] => "million samples, unshaded".to_owned(),
            _ => format!("{phantom}, million samples, unshaded"),
        });
    }
    let mut table = Table::new(&heads.iter().map(String::as_str).collect::<Vec<_>>());
    for value in values(points) {
        let mut cells = vec![value.to_string()];
        for phantom in phantoms {
            let at = |mode: &str| find(points, phantom, mode, value);
            let time = |mode| at(mode).map_or("–".to_owned(), |p| milliseconds(p.seconds));
            cells.extend(MODES.map(time));
            let samples = at("unshaded").map(|p| format!("{:.2}", p.samples / 1e6));
            cells.push(samples.unwrap_or("–".to_owned()));
        }
        table.row(&cells);
    }
    table.text
}

fn memory(points: &[Point]) -> String {
    let mut table = Table::new(&[
        "volume",
        "raw",
        "after making it",
        "after drawing",
        "of the raw size",
        "without program and picture",
    ]);
    let mib = |kib: f64| format!("{:.1} MiB", kib / 1024.0);
    // The last mode of each process has its peak.
    let last = MODES[MODES.len() - 1];
    for point in points.iter().filter(|point| point.mode == last) {
        let or_dash = |kib: Option<f64>| kib.map_or("–".to_owned(), mib);
        let share = point.peak_kib.map(|peak| peak / point.raw_kib);
        let program_kib = point.made_kib.map(|made| made - point.raw_kib);
        let own = program_kib
            .zip(share)
            .map(|(program, share)| share - (program + PICTURE_KIB) / point.raw_kib);
        table.row(&[
            format!("{} {}³", point.phantom, point.x),
            mib(point.raw_kib),
            or_dash(point.made_kib),
            or_dash(point.peak_kib),
            share.map_or("–".to_owned(), |share| format!("{share:.2} ×")),
            own.map_or("–".to_owned(), |share| format!("{share:.2} ×")),
        ]);
    }
    table.text
}

fn plot<'t>(x: &'t str, points: &[Point], phantoms: &[&str]) -> Plot<'t> {
    let mut curves = Vec::new();
    for phantom in phantoms {
        for mode in MODES {
            let at = |x: f64| Some((x, 1e3 * find(points, phantom, mode, x)?.seconds));
            let points = values(points).into_iter().filter_map(at).collect();
            curves.push((curve_name(phantom, mode, phantoms), points));
        }
    }
    Plot {
        title: "Time of a frame",
        x,
        y: "time, ms",
        curves,
    }
}
