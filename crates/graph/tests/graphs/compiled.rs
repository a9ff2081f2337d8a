//! What the compiler makes of a graph, row by row of the source.

use super::*;
use strahl_graph::CompiledGraph;

fn graph(text: &str) -> Graph {
    let asked = read(text).unwrap_or_else(|error| panic!("{error}"));
    asked.graph.unwrap()
}

fn compiled(graph: &Graph, compiler: &mut Compiler) -> Result<CompiledGraph, String> {
    let functions = Functions::of(&PLAN, true, |_, threshold| f64::from(threshold)).unwrap();
    let what = loop_of(&PLAN, Texels::Float);
    let compiled = compiler.compile("test", graph, &what, &functions);
    compiled.map_err(|error| error.to_string())
}

/// The lines of `march`.
fn march(text: &str) -> Vec<String> {
    let compiled = compiled(&graph(text), &mut Compiler::default()).unwrap();
    let program = compiled.program.wgsl();
    let lines = program
        .lines()
        .skip_while(|line| !line.starts_with("fn march"));
    let body = lines.skip(1).take_while(|line| *line != "}");
    body.map(|line| line.trim().to_owned()).collect()
}

/// The example of S. Palmer (2008), Fig. 32: two roots; n1 reads n4, which reads n7; n2 reads n5 and n6; nobody
/// reads n3. Written in another order.
#[test]
fn nodes_come_by_their_depth() {
    let node = |name: &str, inputs: &str| {
        // Its number makes each a node of its own.
        format!(r#""{name}": {{ "pattern": "add", "inputs": {{ {inputs} }} }}"#)
    };
    let text = format!(
        r#"{{ "strahl_graph": 1, "nodes": {{
            "start": {{ "pattern": "step_mm" }},
            {}, {}, {}, {}, {}, {}, {},
            "pixel": {{ "wgsl": "fn two(a: f32) -> vec4f {{ return vec4f(a); }}", "inputs": {{ "a": "n1" }} }}
        }}, "roots": {{ "color": "pixel", "depth_mm": "n2" }} }}"#,
        node("n1", r#""a": "n4", "b": "n7""#),
        node("n2", r#""a": "n5", "b": "n6""#),
        node("n3", r#""a": "start", "b": 3"#),
        node("n4", r#""a": "n7", "b": 4"#),
        node("n5", r#""a": "start", "b": 5"#),
        node("n6", r#""a": "start", "b": 6"#),
        node("n7", r#""a": "start", "b": 7"#),
    );
    let lines = march(&text);
    let at = |name: &str| {
        let let_ = format!("let {name} = ");
        lines.iter().position(|line| line.starts_with(&let_))
    };
    let place = |name: &str| at(name).unwrap_or_else(|| panic!("{name}: {lines:#?}"));
    assert_eq!(at("n3"), None, "nobody reads it: {lines:#?}");
    for (first, then) in [
        ("n7", "n4"),
        ("n4", "n1"),
        ("n5", "n2"),
        ("n6", "n2"),
        ("n5", "n6"),
    ] {
        assert!(place(first) < place(then), "{first} {then}: {lines:#?}");
    }
    // Depth by depth: what is nearer to a root comes later, whichever root it is.
    assert!(
        place("n7") < place("n5") && place("n4") < place("n1"),
        "{lines:#?}"
    );
    let calls = lines
        .iter()
        .filter(|line| line.contains("node_sum("))
        .count();
    assert_eq!(calls, 6, "each once: {lines:#?}");
}

/// A node is a line with its name: its inputs are arguments, its outputs what it returns; its comment stands before.
#[test]
fn a_node_is_a_line_with_its_name() {
    let lines = march(
        r#"{ "strahl_graph": 1, "nodes": {
            "ray": { "pattern": "ray" },
            "steep": { "wgsl": "fn steepness(direction: vec3f, weight: f32) -> f32 { return weight * direction.z; }",
                "inputs": { "direction": "ray.direction", "weight": 2 }, "comment": "how steep the ray is" },
            "pixel": { "pattern": "pixel", "inputs": { "color": "ray.direction", "opacity": "steep" } }
        }, "roots": { "color": "pixel" } }"#
            .replace(r#""color": "ray.direction""#, r#""color": 0.5"#)
            .as_str(),
    );
    let at = lines
        .iter()
        .position(|line| line.starts_with("let steep = "))
        .unwrap();
    assert_eq!(lines[at - 1], "// how steep the ray is");
    assert!(lines[at].contains(".direction, 2.0)"), "{}", lines[at]);
    assert!(lines[at + 1].contains("steep"), "{lines:#?}");
}

fn counting(carry: &str, root: &str) -> String {
    format!(
        r#"{{ "strahl_graph": 1, "nodes": {{
            "walk": {{ "loop": {{ "carry": {{ "out": {{ "type": "f32", "start": 0 {carry} }} }}, "while": "more" }} }},
            "next": {{ "pattern": "add", "inputs": {{ "a": "walk.out", "b": 1 }} }},
            "more": {{ "wgsl": ["struct More {{ is_more: bool }}", "fn more(k: f32) -> More {{ return More(k < 9.0); }}"], "inputs": {{ "k": "walk.out" }} }},
            "seen": {{ "wgsl": ["struct Seen {{ pixel: vec4f }}", "fn seen(k: f32) -> Seen {{ return Seen(vec4f(k / 9.0)); }}"], "inputs": {{ "k": "{root}" }} }}
        }}, "roots": {{ "color": "seen.pixel" }} }}"#
    )
}

/// A variable without a next value takes the only output of its name.
#[test]
fn variables_are_carried_by_name() {
    let said = counting(r#", "next": "next""#, "walk.last.out");
    let unsaid = counting("", "walk.last.out");
    assert_eq!(march(&said), march(&unsaid));
}

/// What changes inside a loop is read outside as the last value, and the way out is named.
#[test]
fn loops_are_closed() {
    let open = graph(&counting(r#", "next": "next""#, "next"));
    let error = compiled(&open, &mut Compiler::default()).unwrap_err();
    assert!(
        error.contains("roots.color: ") && error.contains("walk → next → seen"),
        "{error}"
    );
    assert!(error.contains("NAME.last.VARIABLE"), "{error}");
}

/// What does not change but in its values, and what has been there before, is not compiled again.
#[test]
fn a_shape_is_compiled_once() {
    let mut compiler = Compiler::default();
    let with = |value: f64, pattern: &str| {
        graph(&format!(
            r#"{{ "strahl_graph": 1, "nodes": {{
                "value": {{ "uniform": "f32", "value": {value} }},
                "grey": {{ "pattern": "{pattern}", "inputs": {{ "a": "value", "b": 0.5 }} }},
                "pixel": {{ "wgsl": "fn grey_pixel(a: f32) -> vec4f {{ return vec4f(a); }}", "inputs": {{ "a": "grey" }} }}
            }}, "roots": {{ "color": "pixel" }} }}"#
        ))
    };
    let first = compiled(&with(1.0, "add"), &mut compiler).unwrap();
    let other_value = compiled(&with(2.0, "add"), &mut compiler).unwrap();
    assert!(Arc::ptr_eq(&first.program, &other_value.program));
    assert_ne!(first.parameters, other_value.parameters);
    let other_shape = compiled(&with(1.0, "least"), &mut compiler);
    let other_shape = other_shape.unwrap_or_else(|error| panic!("{error}"));
    assert!(!Arc::ptr_eq(&first.program, &other_shape.program));
    // What nothing reads is looked for each time.
    let mut idle = with(1.0, "add");
    idle.nodes[0].params.push(("x".to_owned(), vec![1.0]));
    let error = compiled(&idle, &mut compiler).unwrap_err();
    assert!(error.contains("nodes.value.params.x"), "{error}");
    let again = compiled(&with(1.0, "add"), &mut compiler).unwrap();
    assert!(Arc::ptr_eq(&first.program, &again.program));
    assert_eq!(first.parameters, again.parameters);
}

/// The order of slices is part of the shape; their blend is not, but is looked at each time.
#[test]
fn slices_are_remembered_by_their_order() {
    let mut compiler = Compiler::default();
    let mut of = |slicing: &str| {
        let text = format!(
            r#"{{ "strahl_graph": 1, "slicing": {slicing}, "nodes": {{
                "slice": {{ "pattern": "slice" }},
                "pixel": {{ "wgsl": "fn far(mm: f32) -> vec4f {{ return vec4f(mm); }}", "inputs": {{ "mm": "slice.distance_mm" }} }}
            }}, "roots": {{ "color": "pixel" }} }}"#
        );
        compiled(&graph(&text), &mut compiler)
    };
    let larger = of(r#"{ "blend": "larger" }"#).unwrap();
    let front = of(r#"{ "blend": "front-to-back" }"#).unwrap();
    let back = of(r#"{ "order": "back-to-front", "blend": "larger" }"#).unwrap();
    assert!(Arc::ptr_eq(&larger.program, &front.program));
    assert_ne!(larger.slicing, front.slicing);
    assert!(!Arc::ptr_eq(&larger.program, &back.program));
    let wrong = of(r#"{ "order": "back-to-front", "blend": "front-to-back" }"#).unwrap_err();
    assert!(wrong.contains("slicing.order"), "{wrong}");
}

/// Another transfer function is another table, and no other program.
#[test]
fn a_transfer_function_compiles_nothing() {
    let mut compiler = Compiler::default();
    let mut program = |scene: &str| {
        let plan = plan(scene);
        let functions = Functions::of(&plan, true, |_, threshold| f64::from(threshold)).unwrap();
        let what = loop_of(&plan, Texels::Float);
        let graph = standard(&plan).unwrap();
        let compiled = compiler.compile("test", &graph, &what, &functions);
        (compiled.unwrap().program, plan.technique().table.clone())
    };
    let (first, table) = program(
        r##"{ "transfer_function": { "points": [[0, 0, "#ff0000"], [1, 1, "#ffffff"]] } }"##,
    );
    let (second, other) = program(
        r##"{ "transfer_function": { "points": [[0, 0.5, "#00ff00"], [0.3, 0, "#0000ff"]] } }"##,
    );
    assert_ne!(table.entries(), other.entries());
    assert!(Arc::ptr_eq(&first, &second));
}
