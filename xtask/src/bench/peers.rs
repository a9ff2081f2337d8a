//! `cargo xtask bench-peers`: frame times and errors beside VTK's ray caster for processors.

use super::cases::{CaseFilter, title};
use super::pictures::{Difference, Picture};
use super::{Table, median, milliseconds, number, numbers, only_line, publish};
use crate::apt;
use crate::command::succeeds;
use crate::older_commit::built_example;
use crate::python::{environment, shared_data, target_folder};
use anyhow::{Result, bail};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What VTK loads, in Debian and Ubuntu.
const PACKAGES: [&str; 4] = ["libgl1", "libxrender1", "libegl1", "libosmesa6"];

/// How much finer than the timed step the converged pictures are sampled.
const CONVERGED: f64 = 16.0;

/// What is to be compared.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    asked: CaseFilter,
    /// Pictures of one orbit.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', default_value = "1,2", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Vec<u32>,
    /// How often each renderer has its turn.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Leaves out the errors against converged pictures.
    #[arg(long)]
    no_errors: bool,
    /// Keeps the tables as docs/performance/peers.md.
    #[arg(long)]
    write: bool,
}

/// Times both in turns and prints tables; whether all was there.
///
/// # Errors
/// A renderer cannot be built, installed or run.
pub fn run(root: &Path, arguments: &Arguments) -> Result<bool> {
    let names = arguments.asked.cases(root)?;
    if names.is_empty() {
        return Ok(true);
    }
    let peers = Peers {
        strahl: built_example(root, "strahl-cpu", "time_frames")?,
        python: python_with_vtk(root)?,
        script: root.join("bench/vtk_peer.py"),
        scratch: target_folder(root)?.join("bench"),
        data: shared_data(root),
    };
    std::fs::create_dir_all(&peers.scratch)?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let modes = arguments.asked.modes();
    let mut body = peers.times(arguments, &names, &modes)?;
    println!("{body}");
    if !arguments.no_errors {
        let (errors, others) = peers.errors(&names, &modes)?;
        println!("{errors}");
        body += "\n";
        body += &errors;
        if !others.is_empty() {
            let times = peers.times_otherwise(arguments, &others)?;
            println!("{times}");
            body += "\n";
            body += &times;
        }
    }
    let title = "CPU renderer compared with VTK";
    publish(root, "peers", title, &body, arguments.write)?;
    Ok(true)
}

/// A Python that can draw with VTK.
fn python_with_vtk(root: &Path) -> Result<PathBuf> {
    let python = environment(root, "bench-venv", "bench/requirements.txt")?;
    let draws = || {
        let text = "import vtk; w = vtk.vtkRenderWindow(); w.SetOffScreenRendering(1); w.SetSize(8, 8); w.Render()";
        let mut command = Command::new(&python);
        succeeds(command.args(["-c", text]).stderr(Stdio::null()))
    };
    if draws()? {
        return Ok(python);
    }
    println!("VTK cannot draw: libraries of the system are missing");
    if cfg!(target_os = "linux") && apt::install(&PACKAGES)? && draws()? {
        return Ok(python);
    }
    bail!(
        "VTK cannot open a window off screen; run `{} -c 'import vtk; vtk.vtkRenderWindow().Render()'` to see why",
        python.display()
    )
}

/// Another way to sample than once per voxel.
#[derive(Clone, Copy)]
struct Sampling {
    /// In voxels.
    step: f64,
    /// The key of a scene; empty for a sample at every step.
    rule: &'static str,
    /// What tables call it.
    title: &'static str,
}

/// A case sampled otherwise, and what VTK's and Strahl's errors are then.
struct ResampledCase<'a> {
    case: &'a str,
    mode: &'a str,
    sampling: Sampling,
    errors: [f64; 2],
}

const ONE_VOXEL: Sampling = Sampling {
    step: 1.0,
    rule: "",
    title: "1 voxel",
};

/// Shorter steps, the longest first.
const SHORTER: [Sampling; 5] = [
    shorter(0.9, "0.9 voxel"),
    shorter(0.8, "0.8 voxel"),
    shorter(0.7, "0.7 voxel"),
    shorter(0.6, "0.6 voxel"),
    shorter(0.5, "0.5 voxel"),
];

const fn shorter(step: f64, title: &'static str) -> Sampling {
    Sampling {
        step,
        rule: "",
        title,
    }
}

/// The rule of sampling that suits a mode.
fn rule_of(mode: &str) -> Option<Sampling> {
    match mode {
        "unshaded" | "shaded" => Some(Sampling {
            step: 0.5,
            rule: r#"{ "rule": "by-opacity" }"#,
            title: "`by-opacity`, 0.5 to 2 voxels",
        }),
        "mip" => Some(Sampling {
            step: 1.0,
            rule: r#"{ "rule": "refine" }"#,
            title: "`refine`, 1 voxel",
        }),
        _ => None,
    }
}

/// Both renderers, ready to run.
struct Peers {
    strahl: PathBuf,
    python: PathBuf,
    script: PathBuf,
    scratch: PathBuf,
    data: PathBuf,
}

/// Seconds of all rounds.
#[derive(Clone, Default)]
struct Seconds {
    frames: Vec<f64>,
    first: Vec<f64>,
}

impl Seconds {
    fn add(&mut self, line: &Value) -> Result<()> {
        self.frames.extend(numbers(line, "seconds")?);
        self.first.push(number(line, "first_s")?);
        Ok(())
    }
}

impl Peers {
    fn vtk(&self, case: &str, mode: &str) -> Command {
        let mut command = Command::new(&self.python);
        command.arg(&self.script).arg("--data").arg(&self.data);
        command.args(["--case", case, "--mode", mode]);
        command
    }

    fn strahl(&self, case: &str, mode: &str, sampling: Sampling) -> Command {
        let mut command = Command::new(&self.strahl);
        command.args([format!("case={case}"), format!("mode={mode}")]);
        command.arg(format!("step={}", sampling.step));
        if !sampling.rule.is_empty() {
            command.arg(format!("sampling={}", sampling.rule));
        }
        // The folder of scans was found by the rules that the example has, too.
        command
    }

    /// The table of times.
    fn times(&self, arguments: &Arguments, cases: &[&str], modes: &[&str]) -> Result<String> {
        let mut table = Table::new(&[
            "case",
            "threads",
            "VTK",
            "Strahl",
            "ratio",
            "VTK, first",
            "Strahl, first",
        ]);
        let mut version = String::new();
        let mut window = Vec::new();
        for case in cases {
            for mode in modes {
                let threads = &arguments.threads;
                let of_threads =
                    self.in_turns(arguments, case, mode, threads, ONE_VOXEL, |line| {
                        version = line["renderer"].as_str().unwrap_or("VTK").to_owned();
                        window.push(number(line, "window_s")?);
                        Ok(())
                    })?;
                for ([vtk, strahl], threads) in of_threads.iter().zip(threads) {
                    let (theirs, ours) = (median(&vtk.frames), median(&strahl.frames));
                    table.row(&[
                        format!("{case}, {}", title(mode)),
                        threads.to_string(),
                        milliseconds(theirs),
                        milliseconds(ours),
                        format!("1/{:.1}", theirs / ours),
                        milliseconds(median(&vtk.first)),
                        milliseconds(median(&strahl.first)),
                    ]);
                    eprintln!("{case}, {mode}, {threads} threads: 1/{:.1}", theirs / ours);
                }
            }
        }
        Ok(format!(
            "    cargo xtask bench-peers\n\n\
             Frame times are medians of {} rounds of {} frames, with both renderers alternating. {version} draws with its \
             `vtkFixedPointVolumeRayCastMapper`. Camera, transfer function and step come from `bench/cases.json`. *First* is the \
             time from the decoded volume to the first picture (median of the rounds). VTK draws into an off-screen window; an empty \
             frame takes {}. {}\n\n{}",
            arguments.rounds,
            arguments.frames,
            milliseconds(median(&window)),
            FIRST_HIT_NOTE,
            table.text
        ))
    }

    /// The seconds of VTK and of Strahl in turns, the latter with a `sampling`, for each number of threads; `look` gets
    /// what VTK has printed.
    fn in_turns(
        &self,
        arguments: &Arguments,
        case: &str,
        mode: &str,
        threads: &[u32],
        sampling: Sampling,
        mut look: impl FnMut(&Value) -> Result<()>,
    ) -> Result<Vec<[Seconds; 2]>> {
        let mut of_threads = vec![[Seconds::default(), Seconds::default()]; threads.len()];
        for round in 0..arguments.rounds {
            // Neither is always the one that finds the machine warm.
            for turn in [round % 2, 1 - round % 2] {
                for ([vtk, strahl], threads) in of_threads.iter_mut().zip(threads) {
                    if turn == 0 {
                        let (frames, threads) = (arguments.frames.to_string(), threads.to_string());
                        let mut command = self.vtk(case, mode);
                        command.args(["--frames", &frames, "--threads", &threads]);
                        let line = only_line(&mut command)?;
                        look(&line)?;
                        vtk.add(&line)?;
                    } else {
                        let mut command = self.strahl(case, mode, sampling);
                        command.arg(format!("frames={}", arguments.frames));
                        command.arg(format!("threads={threads}"));
                        strahl.add(&only_line(&mut command)?)?;
                    }
                }
            }
        }
        Ok(of_threads)
    }

    /// The table of times where Strahl samples otherwise than once per voxel.
    fn times_otherwise(&self, arguments: &Arguments, others: &[ResampledCase]) -> Result<String> {
        let mut table = Table::new(&[
            "case",
            "Strahl's sampling",
            "VTK's error",
            "Strahl's",
            "threads",
            "VTK",
            "Strahl",
            "ratio",
        ]);
        let threads = arguments.threads.iter().copied().max().unwrap_or(1);
        for ResampledCase {
            case,
            mode,
            sampling,
            errors,
        } in others
        {
            let seconds =
                self.in_turns(arguments, case, mode, &[threads], *sampling, |_| Ok(()))?;
            let [theirs, ours] = [0, 1].map(|who| median(&seconds[0][who].frames));
            table.row(&[
                format!("{case}, {}", title(mode)),
                sampling.title.to_owned(),
                format!("{:.2}", errors[0]),
                format!("{:.2}", errors[1]),
                threads.to_string(),
                milliseconds(theirs),
                milliseconds(ours),
                format!("1/{:.1}", theirs / ours),
            ]);
        }
        Ok(format!(
            "The same with the rule of `sampling` that suits the mode, and, where Strahl's error at one voxel is above VTK's, with the \
             longest of the steps 0.9, 0.8 … 0.5 voxel at which it is not. VTK's step stays one voxel.\n\n{}",
            table.text
        ))
    }

    /// The table of errors: one frame, against the same renderer with a finer step; and those of other ways to sample.
    fn errors<'a>(
        &self,
        cases: &[&'a str],
        modes: &[&'a str],
    ) -> Result<(String, Vec<ResampledCase<'a>>)> {
        let mut others = Vec::new();
        let mut table = Table::new(&[
            "case",
            "VTK",
            "Strahl",
            "Strahl, linear light",
            "between the converged",
        ]);
        for case in cases {
            for mode in modes {
                // In colors, an error of a value counts as much as the transfer function is steep there.
                let drawn = if *mode == "mip" { "mip-values" } else { mode };
                let vtk = |step: f64| {
                    let path = self.scratch.join("vtk.raw");
                    let mut command = self.vtk(case, drawn);
                    let step = step.to_string();
                    command.args(["--frames", "1", "--step", &step, "--raw"]);
                    only_line(command.arg(&path))?;
                    Picture::from_bytes(&path)
                };
                let strahl = |sampling: Sampling, compositing: &str| {
                    let path = self.scratch.join("strahl.raw");
                    let mut command = self.strahl(case, drawn, sampling);
                    command.arg("frames=1");
                    command.arg(format!("compositing={compositing}"));
                    command.arg(format!("raw={}", path.display()));
                    only_line(&mut command)?;
                    Picture::from_linear(&path)
                };
                let fine = Sampling {
                    step: 1.0 / CONVERGED,
                    ..ONE_VOXEL
                };
                let (theirs, ours) = (vtk(fine.step)?, strahl(fine, "display")?);
                let linear = strahl(fine, "linear")?;
                let of_vtk = vtk(1.0)?.difference(&theirs)?;
                let of_strahl = strahl(ONE_VOXEL, "display")?.difference(&ours)?;
                let error =
                    |sampling| anyhow::Ok(strahl(sampling, "display")?.difference(&ours)?.rms);
                let mut add = |sampling, rms| {
                    others.push(ResampledCase {
                        case,
                        mode,
                        sampling,
                        errors: [of_vtk.rms, rms],
                    });
                };
                if let Some(sampling) = rule_of(mode) {
                    add(sampling, error(sampling)?);
                }
                if of_strahl.rms > of_vtk.rms {
                    for sampling in SHORTER {
                        let rms = error(sampling)?;
                        if rms <= of_vtk.rms {
                            add(sampling, rms);
                            break;
                        }
                    }
                }
                let row = [
                    of_vtk,
                    of_strahl,
                    strahl(ONE_VOXEL, "linear")?.difference(&linear)?,
                    theirs.difference(&ours)?,
                ]
                .map(|Difference { rms, max }| format!("{rms:.2} / {max}"));
                let what = if drawn == *mode {
                    title(mode)
                } else {
                    "MIP, values"
                };
                let mut cells = vec![format!("{case}, {what}")];
                cells.extend(row);
                table.row(&cells);
            }
        }
        let text = format!(
            "Errors of one frame against the picture that the same renderer makes with 1/{CONVERGED} of the step: root of \
             the mean square / maximum, in display values from 0 to 255 over all pixels and channels. VTK adds up \
             numbers of the screen; so does Strahl with `\"compositing\": \"display\"`, in the second column, while the third \
             shows what its default, linear light, makes on the screen. MIP is compared in values, black to white over 0 to \
             255. VTK converts opacities to its step and keeps them with 15 bits, so that its fine picture is not exact, and \
             nor are its normals, of 13 bits, at any step. The last column shows that both draw the same thing.\n\n{}",
            table.text
        );
        Ok((text, others))
    }
}

const FIRST_HIT_NOTE: &str = "The mapper has no isosurfaces; its first hit is a stand-in, an \
    opacity of 1 from the threshold on, shaded, which stops at the first sample beyond the threshold and does not \
    search for the place between samples, as Strahl does.";
