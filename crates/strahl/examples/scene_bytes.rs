//! Draws random scenes and prints a hash of the bytes of each picture, one line of JSON per scene.
//!
//!     cargo run --release -p strahl --example scene_bytes -- folder=target/scene-bytes [scenes=1000] [from=0]
//!
//! `folder` takes the volumes, masks and meshes of the scenes. `cargo xtask same-bytes` builds this file in an
//! older commit, too, and compares the hashes: it uses only what was there then. What a scene cannot mean is
//! refused; such scenes have the word `refused` instead of a hash.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use strahl::{Render, Scene};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |name: &str| {
        let named = |a: &String| Some(a.strip_prefix(name)?.strip_prefix('=')?.to_owned());
        arguments.iter().find_map(named)
    };
    let number = |name: &str, default: u64| {
        argument(name).map_or(default, |text| text.parse().expect("a whole number"))
    };
    let folder = PathBuf::from(argument("folder").expect("folder=…"));
    std::fs::create_dir_all(&folder).expect("a folder that can be made");
    let from = number("from", 0);
    for seed in from..from + number("scenes", 1000) {
        let text = Random::new(seed).scene(&folder, seed);
        if argument("print").is_some() {
            println!("{text}");
        }
        let scene = Scene::parse("scene", &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        match Render::scene(scene).with_depth().threads(2).picture() {
            Ok(picture) => {
                let mut hash = Hash::new();
                for pixel in picture.image.pixels() {
                    pixel.iter().for_each(|number| hash.add(*number));
                }
                for depth_mm in picture.depth_mm.iter().flatten() {
                    hash.add(*depth_mm);
                }
                let first = picture.image.pixels()[0];
                let is_plain = picture.image.pixels().iter().all(|pixel| *pixel == first);
                println!(
                    r#"{{"seed":{seed},"hash":"{:016x}","shows_something":{}}}"#,
                    hash.0, !is_plain
                );
            }
            Err(error) => {
                let error = error.to_string().replace(['"', '\\', '\n'], " ");
                println!(
                    r#"{{"seed":{seed},"hash":"refused","shows_something":false,"why":"{error}"}}"#
                );
            }
        }
    }
}

/// FNV-1a over the bits of numbers.
struct Hash(u64);

impl Hash {
    fn new() -> Hash {
        Hash(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, number: f32) {
        for byte in number.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5CE4_E5B9)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// From `low` to `high`, in thousandths of the way, so that texts stay short.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.below(1001) as f64 / 1000.0
    }

    fn once_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    fn pick<'t>(&mut self, all: &[&'t str]) -> &'t str {
        all[self.below(all.len() as u64) as usize]
    }

    fn color(&mut self) -> String {
        format!("\"#{:06x}\"", self.below(1 << 24))
    }

    /// A scene as text.
    fn scene(&mut self, folder: &Path, seed: u64) -> String {
        let mut keys = vec![
            format!(
                r#""size": [{}, {}]"#,
                8 + self.below(30),
                6 + self.below(26)
            ),
            format!(r#""volume": {}"#, self.volume(folder, &format!("{seed}"))),
        ];
        let has_several = self.once_in(4);
        let has_mesh = self.once_in(8);
        let functions = self.rule(&mut keys, has_several);
        self.look(&mut keys, functions);
        self.view(&mut keys);
        if has_several || has_mesh {
            keys.push(self.objects(folder, seed, has_several, has_mesh));
        }
        if self.once_in(2) {
            keys.push(self.clips(folder, seed));
        }
        format!("{{ {} }}", keys.join(", "))
    }

    /// How samples are taken and become a pixel; the functions that this needs.
    fn rule(&mut self, keys: &mut Vec<String>, has_several: bool) -> Vec<String> {
        let mut functions = Vec::new();
        let rule = if has_several { 0 } else { self.below(12) };
        match rule {
            0..=3 => keys.push(r#""method": "emission-absorption""#.to_owned()),
            4..=8 => {
                let method = self.pick(&["mip", "minip", "average", "gmip", "mida", "first-hit"]);
                keys.push(format!(r#""method": "{method}""#));
                if method == "mida" {
                    keys.push(format!(r#""blend": {}"#, self.between(-1.0, 0.0)));
                }
            }
            9 => {
                let view = self.pick(&[
                    "entry",
                    "exit",
                    "normal",
                    "gradient-raw",
                    "gradient-magnitude",
                    "sample-count",
                    "depth",
                ]);
                keys.push(format!(r#""debug": "{view}""#));
            }
            10 => functions.push(r#""composite": { "module": "back_to_front" }"#.to_owned()),
            _ => keys.push(format!(
                r#""preset": "{}""#,
                self.pick(&["vessels", "solid", "grey", "x-ray", "mr"])
            )),
        }
        if rule <= 3 && !has_several && self.once_in(2) {
            let rule = self.pick(&[
                "refine",
                "split",
                "split-cubic",
                "integrated",
                "adaptive",
                "by-opacity",
            ]);
            keys.push(format!(r#""sampling": {{ "rule": "{rule}" }}"#));
        } else if rule == 4 && self.once_in(2) {
            keys.push(r#""sampling": { "rule": "refine" }"#.to_owned());
        }
        if self.once_in(2) {
            keys.push(format!(r#""step_voxels": {}"#, self.between(0.3, 1.6)));
        }
        if self.once_in(3) {
            let jitter = self.pick(&[
                r#"{ "seed": 7 }"#,
                r#"{ "white-tile": 3 }"#,
                r#"{ "blue-tile": 3 }"#,
            ]);
            keys.push(format!(
                r#""jitter": {jitter}, "frames": {}"#,
                1 + self.below(3)
            ));
        }
        if self.once_in(4) {
            keys.push(format!(
                r#""early_termination": {}"#,
                self.pick(&["0", "0.2", "1"])
            ));
        }
        functions
    }

    /// Reconstruction, classification, light.
    fn look(&mut self, keys: &mut Vec<String>, mut functions: Vec<String>) {
        if self.once_in(3) {
            let all = [
                "nearest",
                "b-spline",
                "b-spline-interpolating",
                "catmull-rom",
            ];
            keys.push(format!(r#""reconstruct": "{}""#, self.pick(&all)));
        }
        if self.once_in(3) {
            let all = [
                "forward",
                "backward",
                "central",
                "central-9",
                "sobel",
                "b-spline",
            ];
            let of = self.pick(&["value", "value", "opacity"]);
            keys.push(format!(
                r#""gradient": {{ "method": "{}", "of": "{of}" }}"#,
                self.pick(&all)
            ));
        }
        if self.once_in(2) {
            let all = [
                "unlit",
                "lambert",
                "phong",
                "blinn-phong",
                "cook-torrance",
                "gradient-opacity",
            ];
            let keeps = self.once_in(3);
            let model = self.pick(&all);
            keys.push(format!(
                r#""shading": {{ "model": "{model}", "keep_last_normal": {keeps} }}"#
            ));
        }
        if self.once_in(3) {
            let (azimuth, color) = (self.between(-90.0, 90.0), self.color());
            let point = self.between(-60.0, 60.0);
            keys.push(format!(
                r#""lights": [{{ "type": "directional", "azimuth_deg": {azimuth}, "color": {color} }}, {{ "type": "point", "position": [{point}, 90, 20], "reach_mm": 80 }}]"#
            ));
        }
        if self.once_in(3) {
            let mut points = String::new();
            let mut at = -0.2;
            while at < 1.1 {
                let opacity = if self.once_in(3) {
                    0.0
                } else {
                    self.between(0.0, 1.0)
                };
                let color = self.color();
                let _ = write!(points, "[{at:.3}, {opacity}, {color}], ");
                at += self.between(0.02, 0.5);
            }
            keys.push(format!(
                r#""transfer_function": {{ "points": [{points}], "points_in": "window" }}"#
            ));
        }
        if self.once_in(5) {
            functions.push(match self.below(4) {
                0 => r#""classify": { "module": "gradient_table", "params": { "low_per_mm": 0.5, "high_per_mm": 30 } }"#,
                1 => r#""classify": { "module": "threshold", "params": { "threshold": 60, "black": 0, "white": 255 } }"#,
                2 => r#""classify": { "module": "identity", "params": { "black": 0, "white": 255 } }"#,
                _ => r#""classify": { "module": "pre_classified" }"#,
            }.to_owned());
        }
        if self.once_in(10) {
            let fetch = self.pick(&["noise", "marschner_lobb"]);
            functions.push(format!(r#""fetch": {{ "module": "{fetch}" }}"#));
        }
        if !functions.is_empty() {
            keys.push(format!(r#""functions": {{ {} }}"#, functions.join(", ")));
        }
        if self.once_in(5) {
            keys.push(r#""compositing": "display""#.to_owned());
        }
    }

    fn view(&mut self, keys: &mut Vec<String>) {
        let (azimuth, elevation) = (self.between(-180.0, 180.0), self.between(-80.0, 80.0));
        let projection = self.pick(&["perspective", "orthographic"]);
        let zoom = self.between(0.8, 3.0);
        keys.push(format!(
            r#""camera": {{ "azimuth_deg": {azimuth}, "elevation_deg": {elevation}, "projection": "{projection}", "zoom": {zoom} }}"#
        ));
        if self.once_in(2) {
            let background = if self.once_in(3) {
                "\"transparent\"".to_owned()
            } else {
                self.color()
            };
            keys.push(format!(r#""background": {background}"#));
        }
        if self.once_in(12) {
            keys.push(format!(
                r#""quality": "{}""#,
                self.pick(&["null", "minimum", "maximum"])
            ));
        }
    }

    fn objects(&mut self, folder: &Path, seed: u64, has_several: bool, has_mesh: bool) -> String {
        let mut objects = Vec::new();
        if has_several {
            let (turn, shift) = (self.between(-90.0, 90.0), self.between(-15.0, 15.0));
            let transform = format!(
                r#""transform": {{ "rotate_deg": [0, {turn}, 20], "translate_mm": [{shift}, 2, 0] }}"#
            );
            let what = if self.once_in(2) {
                r#""like": "volume""#.to_owned()
            } else {
                format!(r#""volume": {}"#, self.volume(folder, &format!("{seed}-b")))
            };
            objects.push(format!(r#"{{ "name": "second", {what}, {transform} }}"#));
            if self.once_in(2) {
                let preset = self.pick(&["solid", "grey", "vessels"]);
                objects.push(format!(r#"{{ "name": "third", "like": "volume", "parent": "second", "preset": "{preset}" }}"#));
            }
        }
        if has_mesh {
            let path = folder.join("corner.stl");
            write_corner(&path);
            let color = self.color();
            objects.push(format!(
                r#"{{ "mesh": {:?}, "color": {color} }}"#,
                path.display().to_string()
            ));
        }
        format!(r#""objects": [{}]"#, objects.join(", "))
    }

    fn clips(&mut self, folder: &Path, seed: u64) -> String {
        let mut clips = Vec::new();
        for i in 0..1 + self.below(3) {
            let keep = self.pick(&["inside", "outside"]);
            clips.push(match self.below(5) {
                0 => {
                    let (x, y) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
                    format!(r#"{{ "plane": {{ "normal": [{x}, {y}, 0.5] }} }}"#)
                }
                kind @ 1..=3 => {
                    let shape = ["box", "ellipsoid", "cylinder"][kind as usize - 1];
                    let low = self.between(0.0, 0.5);
                    format!(
                        r#"{{ "{shape}": {{ "min": [{low}, 0.1, 0.2], "max": [0.9, 0.8, 1], "space": "fraction", "keep": "{keep}" }} }}"#
                    )
                }
                _ => {
                    let path = folder.join(format!("{seed}-mask-{i}.nrrd"));
                    self.write_volume(&path, 0);
                    let path = path.display().to_string();
                    format!(r#"{{ "mask": {{ "path": {path:?}, "threshold": 90, "keep": "{keep}" }} }}"#)
                }
            });
        }
        format!(r#""clips": [{}]"#, clips.join(", "))
    }

    /// A phantom or a file of random blobs.
    fn volume(&mut self, folder: &Path, name: &str) -> String {
        let dims = [0; 3].map(|_| 4 + self.below(24));
        if self.once_in(3) {
            let phantom = self.pick(&[
                "shells",
                "thin-shells",
                "fog",
                "tree",
                "hydrogen",
                "anatomy",
                "ramp",
            ]);
            return format!(r#"{{ "phantom": "{phantom}", "dims": {dims:?} }}"#);
        }
        let path = folder.join(format!("{name}.nrrd"));
        let kind = self.below(8);
        self.write_volume(&path, kind);
        format!(r#"{{ "path": {:?} }}"#, path.display().to_string())
    }

    /// Soft blobs and some noise on an oblique grid, as samples of the type number `kind`.
    fn write_volume(&mut self, path: &Path, kind: u64) {
        let dims = [0; 3].map(|_| 3 + self.below(24) as usize);
        let names = [
            "uint8", "uint16", "int16", "float", "int8", "uint32", "int32", "double",
        ];
        let blobs: Vec<[f64; 4]> = (0..1 + self.below(4))
            .map(|_| [0; 4].map(|_| self.between(0.15, 0.85)))
            .collect();
        let noise = self.between(0.0, 30.0);
        let has_nan = matches!(kind, 3 | 7) && self.once_in(3);
        let mut bytes = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let at = [x, y, z];
                    let place = [0, 1, 2].map(|i| at[i] as f64 / dims[i] as f64);
                    let mut value: f64 = 0.0;
                    for blob in &blobs {
                        let squares =
                            [0, 1, 2].map(|i| (place[i] - blob[i]) * (place[i] - blob[i]));
                        let away = squares.iter().sum::<f64>() / (0.2 * blob[3] * blob[3]);
                        value = value.max(1.0 - away);
                    }
                    let value = (110.0 * value + self.between(0.0, noise)).clamp(0.0, 127.0);
                    let value = if has_nan && self.once_in(40) {
                        f64::NAN
                    } else {
                        value
                    };
                    match kind {
                        0 => bytes.push(2 * value as u8),
                        1 => bytes.extend(((20.0 * value) as u16).to_le_bytes()),
                        2 => bytes.extend(((15.0 * value) as i16 - 900).to_le_bytes()),
                        3 => bytes.extend((value as f32).to_le_bytes()),
                        4 => bytes.push(value as i8 as u8),
                        5 => bytes.extend(((3.0 * value) as u32).to_le_bytes()),
                        6 => bytes.extend(((3.0 * value) as i32 - 100).to_le_bytes()),
                        _ => bytes.extend(value.to_le_bytes()),
                    }
                }
            }
        }
        let axes = [0; 3].map(|_| self.between(0.5, 2.0));
        let shear = self.between(-0.3, 0.3);
        let header = format!(
            "NRRD0004\ntype: {}\ndimension: 3\nsizes: {} {} {}\nspace: right-anterior-superior\n\
             space directions: ({},{shear},0) (0,{},{shear}) (0,0,{})\nspace origin: (-10,-12,-9)\n\
             endian: little\nencoding: raw\n\n",
            names[kind as usize], dims[0], dims[1], dims[2], axes[0], axes[1], axes[2],
        );
        std::fs::write(path, [header.as_bytes(), &bytes].concat())
            .expect("a file that can be written");
    }
}

/// Three faces of a tetrahedron.
fn write_corner(path: &Path) {
    let corners = [[0, 0, 0], [14, 0, 0], [0, 14, 0], [0, 0, 14]];
    let mut text = "solid corner\n".to_owned();
    for face in [[0, 1, 2], [0, 2, 3], [0, 3, 1]] {
        text += "facet normal 0 0 0\nouter loop\n";
        for corner in face {
            let [x, y, z]: [i32; 3] = corners[corner];
            let _ = writeln!(text, "vertex {x} {y} {z}");
        }
        text += "endloop\nendfacet\n";
    }
    text += "endsolid corner\n";
    std::fs::write(path, text).expect("a file that can be written");
}
