//! `strahl shader`.

use super::*;
use std::fs;

#[test]
fn the_library_is_listed_and_printed() {
    let folder = tempfile::tempdir().unwrap();
    let list = run_well(folder.path(), &["shader", "list"]);
    assert!(list.contains("fn classify(value: f32, position: vec3f) -> Surface"));
    assert!(list.contains("  blinn_phong "));
    let json = run_well(folder.path(), &["shader", "list", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let slots = json.as_array().unwrap();
    let illuminate = slots.iter().find(|s| s["slot"] == "illuminate").unwrap();
    let phong = illuminate["modules"]
        .as_array()
        .unwrap()
        .iter()
        .find(|m| m["name"] == "phong")
        .unwrap();
    assert_eq!(phong["parameters"][2]["name"], "shininess");
    assert_eq!(phong["parameters"][2]["default"][0], 32.0);

    let text = run_well(folder.path(), &["shader", "show", "classify/table"]);
    assert!(text.contains("fn classify("));
    let wrong = run(folder.path(), &["shader", "show", "blin_phong"]);
    assert_eq!(wrong.code, Some(1));
    assert!(
        wrong.err.contains("did you mean illuminate/blinn_phong?"),
        "{}",
        wrong.err
    );
}

#[test]
fn modules_are_checked_all_of_them() {
    let folder = tempfile::tempdir().unwrap();
    // What the documentation shows is right.
    let page = include_str!("../../../../docs/shader-functions.md");
    let example = page.split("```wgsl\n").nth(1).unwrap();
    let example = example.split("```").next().unwrap();
    fs::write(folder.path().join("fade.wgsl"), example).unwrap();
    let said = run_well(folder.path(), &["shader", "check", "fade.wgsl"]);
    assert_eq!(
        said,
        "fade.wgsl: a function for the slot classify; takes from_mm: f32, over_mm: f32; needs place_mm, table\n"
    );

    let wrong = example.replace("-> Surface", "-> vec4f");
    fs::write(folder.path().join("wrong.wgsl"), wrong).unwrap();
    let both = run(
        folder.path(),
        &["shader", "check", "wrong.wgsl", "fade.wgsl", "gone.wgsl"],
    );
    assert_eq!(both.code, Some(1));
    assert!(both.out.starts_with("fade.wgsl: "), "{}", both.out);
    assert!(both.err.contains("wrong.wgsl:"), "{}", both.err);
    assert!(both.err.contains("gone.wgsl"), "{}", both.err);
    assert!(both.err.contains("2 of 3 modules"), "{}", both.err);
}

fn folder_with_scene(module: &str, source: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(module), source).unwrap();
    let scene = format!(
        r#"{{ "volume": {{ "phantom": "tree", "dims": [24, 24, 24] }}, "size": [40, 32],
              "functions": {{ "classify": {{ "module": "{module}" }} }} }}"#
    );
    fs::write(folder.path().join("scene.json"), scene).unwrap();
    folder
}

const RED: &str = "struct Params {
    /// How red.
    /// default 0.75, range 0 to 1
    red: f32,
}
fn classify(value: f32, position: vec3f) -> Surface {
    return Surface(vec3f(params.red, 0.0, 0.0), table(value).opacity);
}";

#[test]
fn the_program_of_a_scene_is_printed_and_its_cost_counted() {
    let folder = folder_with_scene("red.wgsl", RED);
    let text = run_well(folder.path(), &["shader", "wgsl", "scene.json"]);
    // Every function has a heading that says where it is from.
    assert!(
        text.contains("// ---- classify: red (red.wgsl) ----"),
        "{text}"
    );
    assert!(text.contains("// ---- gradient: central (library/gradient/central.wgsl) ----"));
    let cost = run_well(folder.path(), &["shader", "cost", "scene.json", "--json"]);
    let cost: serde_json::Value = serde_json::from_str(&cost).unwrap();
    // One for the value, two for the table, six for the gradient, one for the bricks.
    assert_eq!(cost["per_sample"]["texture_reads"], 10);
    assert_eq!(cost["per_ray"]["texture_reads"], 0);
    let table = run_well(folder.path(), &["shader", "cost", "scene.json"]);
    assert!(
        table.contains("per visible sample               10"),
        "{table}"
    );
    let gone = run(folder.path(), &["shader", "wgsl", "gone.json"]);
    assert_eq!(gone.code, Some(1));
    assert!(gone.err.contains("gone.json"), "{}", gone.err);
}

fn render(folder: &Path, backend: &str) -> Run {
    let args = [
        "render",
        "scene.json",
        "-o",
        "out.png",
        "--backend",
        backend,
    ];
    run(folder, &args)
}

/// How many pixels of the picture are red and nothing else.
fn red_pixels(folder: &Path) -> usize {
    let file = std::io::BufReader::new(fs::File::open(folder.join("out.png")).unwrap());
    let mut picture = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; picture.output_buffer_size().unwrap()];
    let info = picture.next_frame(&mut pixels).unwrap();
    let each = info.color_type.samples();
    // The background is nearly black: what is red is the tree.
    let red = pixels
        .chunks(each)
        .filter(|p| p[0] > 60 && p[1] < 40 && p[2] < 40);
    red.count()
}

#[test]
fn a_function_of_a_file_is_drawn_on_every_backend() {
    let folder = folder_with_scene("red.wgsl", RED);
    let drawn = render(folder.path(), "cpu");
    assert_eq!(drawn.code, Some(0), "{}", drawn.err);
    assert!(drawn.err.contains("the function red"), "{}", drawn.err);
    assert!(drawn.err.contains("--backend gpu"), "{}", drawn.err);
    let on_cpu = red_pixels(folder.path());
    assert!(on_cpu > 20);
    let auto = render(folder.path(), "auto");
    assert_eq!(auto.code, Some(0), "{}", auto.err);
    let args = [
        "render",
        "scene.json",
        "-o",
        "out.png",
        "--threads",
        "1",
        "--stats",
        "json",
    ];
    let stats = run_well(folder.path(), &args);
    let stats: serde_json::Value = serde_json::from_str(&stats).unwrap();
    assert_eq!(stats["backend"], "evaluator");
    assert_eq!(stats["threads"], 1);
    if strahl::gpu::adapters().is_empty() {
        return println!("skipped: no graphics adapter");
    }
    let drawn = render(folder.path(), "gpu");
    assert_eq!(drawn.code, Some(0), "{}", drawn.err);
    assert!(red_pixels(folder.path()).abs_diff(on_cpu) <= 1);
}

/// An endless loop, and array and texture indices far outside: a picture, not a hang or a crash.
#[test]
fn hostile_functions_end_and_touch_nothing_else() {
    let mut backends = vec!["cpu"];
    if strahl::gpu::adapters().is_empty() {
        println!("skipped: no graphics adapter");
    } else {
        backends.push("gpu");
    }
    for source in [
        "fn classify(value: f32, position: vec3f) -> Surface {
            var x = value;
            loop { x += 1.0; if x < 0.0 { break; } }
            return Surface(vec3f(x), 1.0);
        }",
        "fn classify(value: f32, position: vec3f) -> Surface {
            var x = 0.0;
            for (var i = 0u; i < 4000000000u; i++) { for (var k = 0; k >= 0; k++) { x += 1.0; } }
            return Surface(vec3f(x), 1.0);
        }",
        "fn classify(value: f32, position: vec3f) -> Surface {
            var numbers = array<f32, 4>(1.0, 0.5, 0.2, 0.1);
            let at = i32(value * 1e6) - 7;
            numbers[at] = 2.0;
            return Surface(vec3f(numbers[at + 1000000]), texel(vec3i(at)));
        }",
    ] {
        let folder = folder_with_scene("mean.wgsl", source);
        for backend in &backends {
            let start = std::time::Instant::now();
            let drawn = render(folder.path(), backend);
            assert_eq!(drawn.code, Some(0), "{source}: {}", drawn.err);
            assert!(start.elapsed().as_secs() < 120, "{backend}: {source}");
        }
    }
}
