//! `strahl graph`, and graphs in pictures.

use super::*;
use std::fs;

#[test]
fn a_picture_carries_its_graph() {
    let folder = tempfile::tempdir().unwrap();
    // A picture reads what lies beside it only.
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/graphs");
    for name in ["lit-sphere.json", "clay.png", "brass.png"] {
        fs::copy(examples.join(name), folder.path().join(name)).unwrap();
    }
    let scene = "lit-sphere.json";
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
    // Every pixel of a slice is a sample.
    let slices = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/graphs/slicing.json"
    );
    let reads = run_well(at, &["graph", "check", slices]);
    let per_slice = reads.contains("per pixel of a slice") && !reads.contains("at most 0 ");
    assert!(per_slice, "{reads}");
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
    // The variables of the loop have circles; what they get for the next turn goes against the flow.
    let back = r#""seen":"out color" -> "samples":"in color.next" [constraint=false"#;
    assert!(
        drawing.contains("○\\ color.next") && drawing.contains(back),
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

#[test]
fn a_debug_view_has_no_graph_and_the_message_names_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let list = r#"{ "name": "a", "commands": [{ "connect": { "after_shade_color": "lit" } }] }"#;
    let text = format!(r#"{{ "strahl_graph": 1, "edits": [{list}] }}"#);
    fs::write(folder.path().join("a.graph.json"), text).unwrap();
    let args = "demo shells --dims 8,8,8 --size 8x8 --graph a.graph.json --quality null";
    let drawn = run(folder.path(), &args.split(' ').collect::<Vec<_>>());
    assert_eq!(drawn.code, Some(1), "{}", drawn.err);
    let words =
        r#"debug: a graph cannot draw a debug view, which `debug` or quality "null" asks for"#;
    assert!(drawn.err.contains(words), "{}", drawn.err);
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
