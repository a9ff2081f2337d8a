//! `cargo xtask mutate-runs`: the command line with files that were damaged at random, each in a process of its own with
//! little memory and little time. Every run has to end by itself, with a picture or a message.
//!
//! The files come from the program itself: volumes in every format that it writes, scenes, graphs, shader functions,
//! meshes, pictures. What broke it is kept under `target/mutate-runs/found`, with the call in its name's place.

use crate::command::cargo;
use anyhow::{Context, Result, ensure};
use clap::Args;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// What is asked for.
#[derive(Args)]
pub struct Arguments {
    /// Runs of the program.
    #[arg(long, default_value_t = 2000)]
    runs: u64,
    /// Where the random numbers begin: the same seed gives the same files.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The program; without, it is built for it.
    #[arg(long)]
    program: Option<PathBuf>,
}

/// Address space of a run, and how long it may take.
const MEMORY_KIBIBYTES: u64 = 2 << 20;
const MOST_TIME: Duration = Duration::from_secs(20);

/// Calls of the program; `@` stands for the name of the file that is damaged.
type Calls = &'static [&'static [&'static str]];

/// A file that is damaged, and the calls that read it.
struct Seed {
    name: String,
    calls: Calls,
}

const VOLUME: Calls = &[
    &["info", "@"],
    &["render", "@", "-o", "out.png", "--size", "48x32"],
    &["convert", "@", "out.nrrd"],
];
const SCENE: Calls = &[
    &["render", "@", "-o", "out.png", "--size", "48x32"],
    &["scene", "check", "@"],
    &["scene", "show", "@"],
];
const GRAPH: Calls = &[
    &["graph", "check", "@"],
    &[
        "render",
        "volume.nrrd",
        "--graph",
        "@",
        "-o",
        "out.png",
        "--size",
        "24x16",
    ],
];
const MODULE: Calls = &[
    &["shader", "check", "@"],
    &[
        "render",
        "function.json",
        "-o",
        "out.png",
        "--size",
        "24x16",
    ],
];
const MESH: Calls = &[&["render", "mesh.json", "-o", "out.png", "--size", "48x32"]];

/// Files that the program writes itself, and texts.
const OWN: &[(&str, Calls)] = &[
    ("volume.nrrd", VOLUME),
    ("plain.nrrd", VOLUME),
    ("volume.nii", VOLUME),
    ("volume.nii.gz", VOLUME),
    ("volume.mha", VOLUME),
    ("volume.npy", VOLUME),
    ("picture.png", SCENE),
    ("picture.exr", SCENE),
    ("graph.png", SCENE),
    ("plain.json", SCENE),
    ("objects.json", SCENE),
    ("function.json", SCENE),
    ("edits.graph.json", GRAPH),
    ("standard.graph.json", GRAPH),
    ("classify.wgsl", MODULE),
    ("mesh.obj", MESH),
];

/// Fuzz targets whose seeds are volumes.
const OF_VOLUMES: [&str; 13] = [
    "dat",
    "dicom",
    "metaimage",
    "mgh",
    "mrc",
    "nifti",
    "npy",
    "npz",
    "nrrd",
    "png",
    "pvm",
    "tiff",
    "vti",
];

/// The same, and the seeds of the fuzz targets.
fn all_seeds(root: &Path, folder: &Path) -> Result<Vec<Seed>> {
    let own = OWN.iter().map(|(name, calls)| Seed {
        name: (*name).to_owned(),
        calls,
    });
    let mut seeds: Vec<Seed> = own.collect();
    for target in OF_VOLUMES {
        for entry in fs::read_dir(root.join("fuzz/seeds").join(target))? {
            let entry = entry?;
            let name = format!("{target}-{}", entry.file_name().to_string_lossy());
            fs::copy(entry.path(), folder.join(&name))?;
            seeds.push(Seed {
                name,
                calls: VOLUME,
            });
        }
    }
    // In the same order on every machine.
    seeds.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(seeds)
}

/// Texts among the seeds.
const TEXTS: &[(&str, &str)] = &[
    (
        "plain.json",
        r##"{ "volume": { "path": "volume.nrrd" }, "preset": "ct-bone", "size": [48, 32], "step_voxels": 0.7,
  "camera": { "view": "left", "zoom": 1.2, "projection": "perspective", "view_angle_deg": 30 },
  "lights": [{ "type": "directional", "azimuth_deg": 20 }], "background": "#102030",
  "clips": [{ "plane": { "normal": [0, 0, 1], "distance_mm": 1 } }], "sampling": { "rule": "refine" } }"##,
    ),
    (
        "objects.json",
        r##"{ "volume": { "phantom": "tree", "dims": [16, 16, 16] }, "size": [48, 32], "frames": 2, "jitter": { "seed": 7 },
  "objects": [{ "name": "a", "volume": { "path": "volume.nrrd" }, "transform": { "translate_mm": [3, 0, 0] } },
    { "name": "b", "parent": "a", "like": "volume", "transform": { "rotate_deg": [10, 20, 30] } },
    { "mesh": "mesh.obj", "color": "#ff0000" }] }"##,
    ),
    (
        "function.json",
        r##"{ "volume": { "path": "volume.nrrd" }, "size": [24, 16], "functions": { "classify": { "module": "classify.wgsl" } } }"##,
    ),
    (
        "mesh.json",
        r##"{ "volume": { "phantom": "tree", "dims": [8, 8, 8] }, "size": [24, 16], "objects": [{ "mesh": "mesh.obj" }] }"##,
    ),
    (
        "edits.graph.json",
        r##"{ "strahl_graph": 1, "edits": [{ "name": "reddish", "commands": [
  { "add": { "red": { "wgsl": "fn red(color: vec3f) -> vec3f { return color * vec3f(1.0, 0.4, 0.3); }" } } },
  { "insert": { "node": "red", "into": "after_shade_color" } }] }] }"##,
    ),
    (
        "classify.wgsl",
        "//! A ramp.\nstruct Params {\n    /// default 0.5, range 0 to 1\n    share: f32,\n}\nfn ramp(a: f32) -> f32 {\n    var sum = 0.0;\n    for (var i = 0; i < 4; i++) { if a > f32(i) { sum += a; } else { sum -= 1.0; } }\n    return sum;\n}\nfn classify(value: f32, position: vec3f) -> Surface {\n    let surface = table(value);\n    return Surface(surface.color * ramp(value), params.share * surface.opacity);\n}\n",
    ),
    (
        "mesh.obj",
        "# SPACE=RAS\nv 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nvn 0 0 1\nf 1 2 3\nf 1//1 3//1 4//1\nf -4 -3 -2 -1\n",
    ),
];

/// Runs it; whether every run ended as it has to.
pub fn run(root: &Path, arguments: &Arguments) -> Result<bool> {
    let program = match &arguments.program {
        Some(program) => program.canonicalize().context("--program")?,
        None => built(root)?,
    };
    let folder = root.join("target/mutate-runs");
    let (seeds, work, found) = (
        folder.join("seeds"),
        folder.join("work"),
        folder.join("found"),
    );
    for folder in [&seeds, &work, &found] {
        fs::create_dir_all(folder)?;
    }
    make_seeds(&program, &seeds)?;
    let all = all_seeds(root, &seeds)?;
    let mut random = Random(arguments.seed);
    let (mut failures, mut codes) = (0, [0u64; 3]);
    let start = Instant::now();
    for number in 0..arguments.runs {
        let seed = &all[random.below(all.len())];
        let call = seed.calls[random.below(seed.calls.len())];
        for entry in fs::read_dir(&seeds)? {
            let entry = entry?;
            fs::copy(entry.path(), work.join(entry.file_name()))?;
        }
        let mut bytes = fs::read(seeds.join(&seed.name))?;
        random.damage(&mut bytes);
        fs::write(work.join(&seed.name), &bytes)?;
        let call: Vec<&str> = call
            .iter()
            .map(|part| if *part == "@" { &seed.name } else { *part })
            .collect();
        match ended(&program, &work, &call)? {
            Ok(code) => codes[code] += 1,
            Err(why) => {
                failures += 1;
                let name = format!("{}-{number}-{}", arguments.seed, seed.name);
                fs::write(found.join(&name), &bytes)?;
                println!(
                    "run {number}: strahl {}: {why}; kept as {name}",
                    call.join(" ")
                );
            }
        }
        if number % 200 == 199 {
            let seconds = start.elapsed().as_secs();
            println!(
                "{} runs in {seconds} s, {failures} of them wrong",
                number + 1
            );
        }
    }
    let [done, refused, usage] = codes;
    println!(
        "{done} made a picture or an answer, {refused} a message, {usage} were wrong usage; {failures} wrong"
    );
    Ok(failures == 0)
}

fn built(root: &Path) -> Result<PathBuf> {
    let status = cargo(root)
        .args(["build", "--release", "-p", "strahl-cli"])
        .status()?;
    ensure!(status.success(), "the program cannot be built");
    Ok(root.join("target/release/strahl"))
}

/// Has the program write what it can write, and the texts.
fn make_seeds(program: &Path, folder: &Path) -> Result<()> {
    for (name, text) in TEXTS {
        fs::write(folder.join(name), text)?;
    }
    let size = ["--size", "40x30"];
    let small = [
        &["demo", "tree", "--dims", "12,10,8", "-o", "shells.png"][..],
        &size,
    ]
    .concat();
    let raw: Vec<u8> = (0..12 * 10 * 8u32).map(|i| (i * i % 251) as u8).collect();
    fs::write(folder.join("raw_12x10x8_uint8.raw"), raw)?;
    for call in [
        &small[..],
        &["convert", "raw_12x10x8_uint8.raw", "volume.nrrd"],
        &["convert", "volume.nrrd", "plain.nrrd", "--uncompressed"],
        &["convert", "volume.nrrd", "volume.nii"],
        &["convert", "volume.nrrd", "volume.nii.gz"],
        &["convert", "volume.nrrd", "volume.mha"],
        &["convert", "volume.nrrd", "volume.npy"],
        &["render", "plain.json", "-o", "picture.png"],
        &["render", "plain.json", "-o", "picture.exr"],
        &[
            "render",
            "volume.nrrd",
            "--graph",
            "edits.graph.json",
            "-o",
            "graph.png",
            "--size",
            "24x16",
        ],
    ] {
        let status = Command::new(program)
            .args(call)
            .current_dir(folder)
            .stderr(Stdio::null())
            .status()?;
        ensure!(
            status.success(),
            "strahl {} does not make a seed",
            call.join(" ")
        );
    }
    let graph = Command::new(program)
        .args(["graph", "show", "volume.nrrd"])
        .current_dir(folder)
        .output()?;
    ensure!(
        graph.status.success(),
        "strahl graph show does not make a seed"
    );
    fs::write(folder.join("standard.graph.json"), graph.stdout)?;
    Ok(())
}

/// The exit code of a run within its memory and time, or what was wrong with how it ended.
fn ended(program: &Path, folder: &Path, call: &[&str]) -> Result<Result<usize, String>> {
    let said = folder.join("stderr.txt");
    let limited = format!("ulimit -v {MEMORY_KIBIBYTES}; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limited])
        .arg(program)
        .args(call)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&said)?)
        .spawn()
        .context("this needs a shell")?;
    let Some(status) = wait(&mut child)? else {
        return Ok(Err(format!("not ended after {} s", MOST_TIME.as_secs())));
    };
    let said = fs::read(&said)?;
    let said = String::from_utf8_lossy(&said);
    let has_message = said.lines().any(|line| line.starts_with("error: "));
    Ok(match status.code() {
        None => Err(format!(
            "{status}: {}",
            said.lines().next().unwrap_or_default()
        )),
        Some(0) => Ok(0),
        Some(1) if has_message => Ok(1),
        Some(2) if !said.is_empty() => Ok(2),
        Some(_) => {
            let first = said.lines().next().unwrap_or("no message").to_owned();
            Err(format!("{status}: {first}"))
        }
    })
}

/// How it ended; `None` if it had to be killed.
fn wait(child: &mut Child) -> Result<Option<ExitStatus>> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() > MOST_TIME {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(3));
    }
}

/// Random numbers (S. Vigna's SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `end`, which is above 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// Changes `bytes` at one to six places.
    fn damage(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..1 + self.below(6) {
            if bytes.is_empty() {
                return;
            }
            // The beginning says what the rest is.
            let end = match self.below(2) {
                0 => bytes.len(),
                _ => bytes.len().min(512),
            };
            let at = self.below(end);
            match self.below(8) {
                0 => bytes[at] ^= 1 << self.below(8),
                1 => bytes[at] = self.next() as u8,
                2 => self.number(bytes, at),
                3 => self.word(bytes, at),
                4 => {
                    let length = self.below(bytes.len() - at + 1).min(64);
                    bytes.drain(at..at + length);
                }
                5 => {
                    let length = self.below(bytes.len() - at + 1).min(64);
                    let piece = bytes[at..at + length].to_vec();
                    let to = self.below(bytes.len());
                    bytes.splice(to..to, piece);
                }
                6 => {
                    let piece = bytes[at..(at + 8).min(bytes.len())].to_vec();
                    let times = 1 << self.below(14);
                    bytes.splice(at..at, piece.repeat(times));
                }
                _ if self.below(4) == 0 => bytes.truncate(at),
                _ => bytes[at] = 0xFF,
            }
        }
    }

    /// A binary number of those that make trouble.
    fn number(&mut self, bytes: &mut [u8], at: usize) {
        const NUMBERS: [u64; 10] = [
            0,
            1,
            u64::MAX,
            0x7FFF_FFFF,
            0x8000_0000,
            0x7FFF,
            0xFFFF,
            0x1_0000,
            0x7F80_0000,
            0x7FF0_0000_0000_0000,
        ];
        let number = NUMBERS[self.below(NUMBERS.len())];
        let size = [1, 2, 4, 8][self.below(4)];
        let mut written = number.to_le_bytes();
        if self.below(2) == 0 {
            written[..size].reverse();
        }
        for (byte, new) in bytes[at..].iter_mut().zip(&written[..size]) {
            *byte = *new;
        }
    }

    /// The next number of a text, replaced by one of those that make trouble.
    fn word(&mut self, bytes: &mut Vec<u8>, at: usize) {
        const WORDS: [&str; 14] = [
            "0",
            "-1",
            "1e308",
            "-1e-308",
            "65535",
            "4294967295",
            "1000000",
            "1e9",
            "0.0001",
            "null",
            "[]",
            "\"\"",
            "true",
            "99999999999999999999",
        ];
        let is_digit = |byte: &u8| byte.is_ascii_digit();
        let Some(start) = bytes[at..].iter().position(is_digit).map(|i| at + i) else {
            return;
        };
        let length = bytes[start..].iter().take_while(|b| is_digit(b)).count();
        let word = WORDS[self.below(WORDS.len())];
        bytes.splice(start..start + length, word.bytes());
    }
}
