//! Graphs: the examples, and `strahl graph`.

use super::*;
use std::fs;
use strahl::{Backend, Image, Render, Scene, SceneFile};

pub fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/graphs")
}

/// An example, small and over few voxels.
fn example(name: &str) -> Scene {
    let path = examples().join(format!("{name}.json"));
    let mut scene = SceneFile::open(&path).unwrap().unwrap().scene;
    scene.size = Some([96, 72]);
    if let Some(volume) = &mut scene.volume
        && volume.phantom.as_deref() == Some("anatomy")
    {
        volume.dims = Some([48, 60, 76]);
    }
    scene
}

pub fn drawn(scene: &Scene, backend: Backend) -> Image {
    let render = Render::scene(scene.clone()).backend(backend);
    render
        .picture()
        .unwrap_or_else(|error| panic!("{error}"))
        .image
}

pub fn has_gpu() -> bool {
    let is_there = !strahl::gpu::adapters().is_empty();
    assert!(
        is_there || std::env::var("CI").as_deref() != Ok("true"),
        "no graphics adapter"
    );
    is_there
}

/// Peak signal to noise in dB, of all channels; and the share of pixels with a channel off by more than 8/255.
pub fn agreement(a: &Image, b: &Image) -> (f64, f64) {
    let (mut square, mut far) = (0.0, 0usize);
    for (p, q) in a.pixels().iter().zip(b.pixels()) {
        let off = (0..4).map(|c| f64::from((p[c] - q[c]).abs()));
        square += off.clone().map(|d| d * d).sum::<f64>();
        far += usize::from(off.fold(0.0, f64::max) > 8.0 / 255.0);
    }
    let n = a.pixels().len() as f64;
    (-10.0 * (square / (4.0 * n)).log10(), far as f64 / n)
}

#[test]
fn every_example_is_one_picture_on_all_backends() {
    let mut seen = 0;
    for entry in fs::read_dir(examples()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "json") {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let scene = example(&name);
        let here = drawn(&scene, Backend::Cpu);
        let colored = here
            .pixels()
            .iter()
            .filter(|p| p[0] != here.pixels()[0][0])
            .count();
        assert!(
            colored > 200,
            "{name}: only {colored} pixels are not background"
        );
        seen += 1;
        if !has_gpu() {
            println!("{name}: skipped on the graphics processor: no adapter");
            continue;
        }
        let there = drawn(&scene, Backend::Gpu { adapter: None });
        let (psnr, far) = agreement(&here, &there);
        println!("{name}: {psnr:.1} dB, {far:.5} far");
        assert!(
            psnr >= 50.0 && far <= 0.002,
            "{name}: {psnr:.1} dB, {far} far"
        );
    }
    assert!(seen >= 10, "{seen}");
}

#[test]
fn what_settings_can_say_is_their_picture() {
    // Fusing by the node `beside` is what the settings do; a ray caster of nodes alone is emission-absorption.
    for name in ["two-volumes", "ray-caster"] {
        let scene = example(name);
        let settings = Scene {
            graph: None,
            ..scene.clone()
        };
        let (psnr, far) = agreement(
            &drawn(&scene, Backend::Cpu),
            &drawn(&settings, Backend::Cpu),
        );
        assert!(psnr >= 85.0 && far == 0.0, "{name}: {psnr:.1} dB, {far}");
    }
}

/// A slot's function may be named in the graph, too.
#[test]
fn jitter_by_a_node_is_jitter_by_the_settings() {
    let scene = |text: &str| {
        let head = r#""volume": { "phantom": "tree", "dims": [48, 48, 48] }, "step_voxels": 2, "size": [96, 72]"#;
        Scene::parse("jitter", &format!("{{ {head}, {text} }}")).unwrap()
    };
    let settings = scene(r#""jitter": { "seed": 7 }"#);
    let graph = scene(
        r#""graph": { "edits": [{ "name": "jitter", "commands": [
            { "add": { "hash": { "function": "jitter/hash", "params": { "seed": 7 },
                "inputs": { "pixel": "before_jitter", "frame": "ray.frame" } } } },
            { "replace": { "stage": "jitter", "by": "hash" } }
        ] }] }"#,
    );
    let none = scene(r#""preset": "mip""#);
    let (psnr, _) = agreement(
        &drawn(&settings, Backend::Cpu),
        &drawn(&graph, Backend::Cpu),
    );
    assert!(psnr >= 90.0, "{psnr}");
    let (psnr, _) = agreement(&drawn(&none, Backend::Cpu), &drawn(&graph, Backend::Cpu));
    assert!(psnr < 60.0, "jitter changes nothing: {psnr}");
}

/// Thin peaks: the table sees what lies between the samples, as long as values go straight from one to the next.
#[test]
fn pre_integration_is_nearer_to_the_truth() {
    let scene = example("pre-integrated");
    let plain = Scene {
        graph: None,
        ..scene.clone()
    };
    let truth = drawn(
        &Scene {
            step_mm: Some(0.05),
            ..plain.clone()
        },
        Backend::Cpu,
    );
    for (step_mm, gain_db) in [(0.5, 2.0), (0.25, 3.5)] {
        let at_step = |scene: &Scene| Scene {
            step_mm: Some(step_mm),
            ..scene.clone()
        };
        let (with, _) = agreement(&truth, &drawn(&at_step(&scene), Backend::Cpu));
        let (without, _) = agreement(&truth, &drawn(&at_step(&plain), Backend::Cpu));
        assert!(
            with > without + gain_db,
            "{step_mm} mm: {with:.1} dB with, {without:.1} dB without the table"
        );
    }
}

#[test]
fn a_picture_carries_its_graph() {
    let folder = tempfile::tempdir().unwrap();
    let path = examples().join("lit-sphere.json");
    let scene = path.to_str().unwrap();
    run_well(
        folder.path(),
        &["render", scene, "-o", "a.png", "--size", "40x30", "-q"],
    );
    run_well(folder.path(), &["render", "a.png", "-o", "b.png", "-q"]);
    assert_eq!(
        fs::read(folder.path().join("a.png")).unwrap(),
        fs::read(folder.path().join("b.png")).unwrap()
    );
}

#[test]
fn graphs_are_shown_checked_and_printed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let write = |name: &str, text: &str| fs::write(at.join(name), text).unwrap();
    write(
        "red.graph.json",
        r#"{
  "strahl_graph": 1,
  // One node between shading and compositing.
  "edits": [{ "name": "reddish", "commands": [
    { "add": { "red": { "wgsl_file": "red.wgsl" } } },
    { "insert": { "node": "red", "into": "after_shade_color" } }
  ] }]
}"#,
    );
    write(
        "red.wgsl",
        "fn red(color: vec3f) -> vec3f {\n    return color * vec3f(1.0, 0.4, 0.3);\n}\n",
    );
    let said = run_well(at, &["graph", "check", "red.graph.json"]);
    assert!(
        said.starts_with("red.graph.json: ") && said.contains(" nodes; at most "),
        "{said}"
    );
    let shown = run_well(at, &["graph", "show", "red.graph.json"]);
    assert!(
        shown.contains(r#""after_shade_color": { "anchor": "red" }"#),
        "{shown}"
    );
    // What is shown is a graph of its own, and the same picture.
    write("whole.graph.json", &shown);
    assert_eq!(run_well(at, &["graph", "show", "whole.graph.json"]), shown);
    for name in ["red", "whole"] {
        let graph = format!("{name}.graph.json");
        let picture = format!("{name}.png");
        let args = [
            "demo", "shells", "--dims", "32,32,32", "--size", "40x30", "-q", "--graph", &graph,
            "-o", &picture,
        ];
        run_well(at, &args);
    }
    let decoded = |name: &str| {
        let mut reader = png::Decoder::new(std::io::BufReader::new(
            fs::File::open(at.join(name)).unwrap(),
        ))
        .read_info()
        .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    };
    assert_eq!(decoded("red.png"), decoded("whole.png"));
    let program = run_well(at, &["graph", "wgsl", "red.graph.json"]);
    assert!(
        program.contains("fn march(pixel: vec2u) -> vec4f {")
            && program.contains("vec3f(1.0, 0.4, 0.3)"),
        "{program}"
    );
    let drawing = run_well(at, &["graph", "dot", "red.graph.json", "--details"]);
    assert!(
        drawing.starts_with("digraph") && drawing.contains("WGSL"),
        "{drawing}"
    );
    let patterns = run_well(at, &["graph", "patterns", "silhouette"]);
    assert!(
        patterns.contains("normal: vec3f (direction.world)"),
        "{patterns}"
    );
    let schema = run_well(at, &["graph", "schema"]);
    assert!(schema.contains("strahl_graph"));
}

#[test]
fn what_is_wrong_with_a_graph_is_said_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = |text: &str| {
        fs::write(folder.path().join("w.graph.json"), text).unwrap();
        let said = run(folder.path(), &["graph", "check", "w.graph.json"]);
        assert_eq!(said.code, Some(1), "{text}: {}", said.out);
        said.err
    };
    // Cut off, as by a full disk: still a graph, by its name.
    let said = wrong("{ \"strahl_graph\": 1, \"nodes\": {");
    assert!(
        said.contains("w.graph.json:1:") && !said.contains("unknown key"),
        "{said}"
    );
    let edits = |commands: &str| {
        format!(
            "{{ \"strahl_graph\": 1,\n \"edits\": [{{ \"name\": \"mine\", \"commands\": [\n{commands}\n] }}] }}"
        )
    };
    let newer = wrong(r#"{ "strahl_graph": 2, "lines": [] }"#);
    assert!(newer.contains("reads up to 1: use a newer one"), "{newer}");
    let twice = wrong("{ \"strahl_graph\": 1, \"nodes\": {\n \"a\": {},\n \"a\": {} } }");
    assert!(
        twice.contains("w.graph.json:3:") && twice.contains("`a` stands there twice"),
        "{twice}"
    );
    let unknown =
        wrong("{ \"strahl_graph\": 1,\n \"nodes\": { \"a\": { \"patern\": \"over\" } } }");
    assert!(
        unknown.contains("w.graph.json:2:") && unknown.contains("nodes.a"),
        "{unknown}"
    );
    let pattern = wrong(&edits(
        r#"{ "add": { "a": { "pattern": "silhuette" } } }, { "insert": { "node": "a", "into": "after_shade_opacity" } }"#,
    ));
    assert!(pattern.contains("did you mean `silhouette`?"), "{pattern}");
    let gone = wrong(&edits(
        r#"{ "connect": { "lits.color": "ray.direction" } }"#,
    ));
    assert!(
        gone.contains("edits.mine.commands[0].connect.lits.color")
            && gone.contains("did you mean `lit`?"),
        "{gone}"
    );
    let meaning = wrong(&edits(r#"{ "connect": { "lit.normal": "gradient" } }"#));
    assert!(
        meaning.contains("nodes.lit.inputs.normal")
            && meaning.contains("the pattern `normal_of_gradient` makes it so"),
        "{meaning}"
    );
    let body = wrong(&edits(
        "{ \"add\": { \"bad\": { \"wgsl\": [\"fn bad(color: vec3f) -> vec3f {\", \"    return colour;\", \"}\"] } } },\n{ \"insert\": { \"node\": \"bad\", \"into\": \"after_shade_color\" } }",
    ));
    assert!(
        body.contains("bad") && body.contains("colour") && body.contains(":2:"),
        "{body}"
    );
    let circle = wrong(&edits(
        r#"{ "connect": { "before_classify": "after_shade_opacity" } }"#,
    ));
    assert!(
        circle.contains("reads itself") || circle.contains("circle"),
        "{circle}"
    );
}

/// Two lists that want the same place: the later one has it, and both places are named.
#[test]
fn conflicts_name_both_places() {
    let folder = tempfile::tempdir().unwrap();
    let list = |name: &str, by: &str| {
        format!(
            r#"{{ "name": "{name}", "commands": [{{ "connect": {{ "after_shade_color": "{by}" }} }}] }}"#
        )
    };
    let text = format!(
        r#"{{ "strahl_graph": 1, "edits": [{}, {}] }}"#,
        list("first", "before_shade.color"),
        list("second", "lit")
    );
    fs::write(folder.path().join("two.graph.json"), text).unwrap();
    let said = run(folder.path(), &["graph", "check", "two.graph.json"]);
    assert_eq!(said.code, Some(0), "{}", said.err);
    assert!(
        said.err
            .contains("edits.second.commands[0].connect.after_shade_color")
            && said
                .err
                .contains("edits.first.commands[0].connect.after_shade_color"),
        "{}",
        said.err
    );
}
