use crate::engine;
use strahl_scene::{Clip, Headers, Method, Scene, TransferPoint, presets, resolve_with, schema};

fn message(text: &str) -> String {
    match Scene::parse("scene.json", text) {
        Ok(scene) => format!("accepted: {scene:?}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn comments_and_trailing_commas_keep_the_lines() {
    let text = "// a scene\n{\n  /* two\n  lines */ \"size\": [3, 4,], # here\n  \"preset\": \"a//b\",\n  \"sise\": 1\n}";
    let error = message(text);
    assert!(error.starts_with("scene.json:6:"), "{error}");
    let good = text.replace("sise", "threshold");
    let scene = Scene::parse("scene.json", &good).unwrap();
    assert_eq!(scene.size, Some([3, 4]));
    assert_eq!(scene.preset.as_deref(), Some("a//b"));
}

#[test]
fn mistakes_are_named() {
    let mistakes = [
        r#"{ "camra": {} }"#,
        r#"{ "camera": { "positon": [0, 0, 0] } }"#,
        r#"{ "camera": { "view": "frnot" } }"#,
        r#"{ "camera": { "position": [0, 0] } }"#,
        r#"{ "camera": { "zoom": "big" } }"#,
        r#"{ "method": "MIP" }"#,
        r#"{ "size": [-1, 20] }"#,
        r#"{ "size": 512 }"#,
        r#"{ "background": "blue" }"#,
        r##"{ "transfer_function": { "points": [[0, 0, "#000"], [1, 0, "#zzz"]] } }"##,
        r#"{ "transfer_function": { "points": [{ "value": 1, "opacty": 0 }] } }"#,
        r#"{ "transfer_function": { "points": [{ "opacity": 0 }] } }"#,
        r#"{ "transfer_function": { "points": [[1, 2, [0, 0, 0], 4]] } }"#,
        r#"{ "transfer_function": { "color_map": "virids" } }"#,
        r#"{ "clips": [{ "plan": { "normal": [1, 0, 0] } }] }"#,
        r#"{ "lights": [{ "kind": "head" }] }"#,
        r#"{ "step_mm": NaN }"#,
        r#"{ "step_mm": 1e999 }"#,
        r#"{ "size": [1, 2] "#,
        r#"{ "size": [1, 2] } more"#,
        "[]",
        r#"{ "camera": ["perspective"] }"#,
        r#"{ "clips": [{ "plane": [[1, 0, 0]] }] }"#,
        r#"{ "lights": [["head"]] }"#,
        "",
        "/* never closed",
    ];
    let methods = Method::ALL.map(Method::name).join(", ");
    let text: Vec<String> = mistakes
        .iter()
        // That there is a new method makes no message another one.
        .map(|text| format!("{text}\n  {}", message(text).replace(&methods, "METHODS")))
        .collect();
    insta::assert_snapshot!(text.join("\n"));
}

#[test]
fn all_unknown_keys_are_named_at_once() {
    let text = r#"{
  "camra": { "view": ["}", "front"] }, // the first
  "camera": { "positon": [0, 0, 0], "zoom": 2, "zom": 3, },
  "sise": [1, 2],
  "method": "MIP",
  "sice": "ä"
}"#;
    let said = message(text);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 5, "{said}");
    for (line, parts) in lines.iter().zip([
        [
            "scene.json:2:9: scene: unknown key \"camra\"",
            "\"camera\"? known are format",
        ],
        [
            "scene.json:3:23: camera: unknown key \"positon\"",
            "known are projection",
        ],
        [
            "scene.json:3:52: camera: unknown key \"zom\"",
            "did you mean \"zoom\"?",
        ],
        [
            "scene.json:4:8: scene: unknown key \"sise\"",
            "did you mean \"size\"?",
        ],
        // What follows a mistake of another kind is not known.
        [
            "scene.json:5:17: method: unknown value \"MIP\"",
            "did you mean \"mip\"?",
        ],
    ]) {
        assert!(parts.iter().all(|part| line.contains(part)), "{said}");
    }
    // The keys of an object are listed once.
    assert_eq!(said.matches("known are format").count(), 1, "{said}");
    let good = text.replace("\"method\": \"MIP\",", "");
    let said = message(&good);
    assert!(said.contains(":6:8: scene: unknown key \"sice\""), "{said}");
    assert_eq!(said.lines().count(), 5, "{said}");
    // A hundred are too many to be read, and a damaged value ends the search.
    let many: Vec<String> = (0..100).map(|i| format!("\"a{i}\": {{}}")).collect();
    let said = message(&format!("{{ {} }}", many.join(", ")));
    assert_eq!(said.lines().count(), 20, "{said}");
    let said = message(r#"{ "camra": [1, }"#);
    assert_eq!(said.lines().count(), 1, "{said}");
}

#[test]
fn a_rule_for_samples_in_place_of_one_for_runs_is_sent_to_its_key() {
    let text = message(r#"{ "composite": "opacity-peeling" }"#);
    assert!(text.contains("set `method` to it"), "{text}");
    let text = message(r#"{ "techniques": { "a": { "composite": "mida" } } }"#);
    assert!(text.contains("set `method` to it"), "{text}");
    let text = message(r#"{ "composite": "peeling" }"#);
    assert!(
        text.contains("unknown value") && !text.contains("method"),
        "{text}"
    );
}

#[test]
fn deep_and_long_texts_are_refused() {
    let deep = format!("{{ \"clips\": {} }}", "[".repeat(90_000));
    assert!(message(&deep).starts_with("scene.json:1:"));
    let nested = format!("{{ \"nothing\": {} }}", "{\"a\":".repeat(90_000));
    assert!(message(&nested).starts_with("scene.json:1:"));
    let long = " ".repeat(20 << 20);
    assert!(message(&long).contains("at most"));
}

#[test]
fn points_of_the_benchmark_cases_are_read_as_they_are() {
    let scene = Scene::parse(
        "case",
        r#"{ "transfer_function": { "points": [[0, 0.0, [0, 0, 0]], [200, 0.5, [1.0, 0.6, 0.2]]] } }"#,
    )
    .unwrap();
    let points = scene.transfer_function.unwrap().points.unwrap();
    assert_eq!(
        points[1],
        TransferPoint::new(200.0, 0.5, strahl_scene::Color([1.0, 0.6, 0.2]))
    );
}

#[test]
fn the_checked_in_schema_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scene.schema.json");
    let schema = schema();
    if std::env::var_os("STRAHL_UPDATE").is_some() {
        std::fs::write(path, &schema).unwrap();
    }
    let checked_in = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        checked_in == schema,
        "docs/scene.schema.json is not current; run STRAHL_UPDATE=1 cargo test -p strahl-scene schema"
    );
}

/// The keys and the names of values of one definition of the schema.
fn words(value: &serde_json::Value, found: &mut Vec<String>) {
    let serde_json::Value::Object(object) = value else {
        if let serde_json::Value::Array(items) = value {
            items.iter().for_each(|item| words(item, found));
        }
        return;
    };
    if let Some(serde_json::Value::Object(properties)) = object.get("properties") {
        found.extend(properties.keys().cloned());
    }
    let names = object.get("enum").and_then(|names| names.as_array());
    let names = names.into_iter().flatten().chain(object.get("const"));
    found.extend(names.filter_map(|name| name.as_str().map(str::to_owned)));
    let parts = object.iter().filter(|(key, _)| *key != "$defs");
    parts.for_each(|(_, value)| words(value, found));
}

fn manual() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scene.md");
    std::fs::read_to_string(path).unwrap()
}

/// A key that has the name of another one would be found anywhere: all words of a definition must stand in one section.
#[test]
fn a_section_of_the_manual_has_every_key_and_name_of_each_definition() {
    let manual = manual();
    let sections: Vec<_> = manual.split("\n#").collect();
    let has = |section: &str, word: &String| {
        section.contains(&format!("`{word}`")) || section.contains(&format!("\"{word}\""))
    };
    let schema: serde_json::Value = serde_json::from_str(&schema()).unwrap();
    let definitions = schema["$defs"].as_object().unwrap();
    let (mut number, whole) = (0, ("the scene", &schema));
    for (name, definition) in definitions
        .iter()
        .map(|(n, d)| (n.as_str(), d))
        .chain([whole])
    {
        let mut own = Vec::new();
        words(definition, &mut own);
        number += own.len();
        let missing = |section: &&str| own.iter().filter(|word| !has(section, word)).count();
        let nearest = sections
            .iter()
            .min_by_key(|section| missing(section))
            .unwrap();
        let left_out: Vec<_> = own.iter().filter(|word| !has(nearest, word)).collect();
        let heading = nearest.lines().next().unwrap_or_default();
        assert!(
            left_out.is_empty(),
            "docs/scene.md does not name {left_out:?} of {name} in {heading:?}"
        );
    }
    assert!(number > 200, "{number}");
    for preset in presets() {
        let presets = sections
            .iter()
            .find(|s| s.starts_with("# Presets"))
            .unwrap();
        assert!(has(presets, &preset.name.to_owned()), "{}", preset.name);
    }
}

#[test]
fn the_examples_of_the_manual_are_scenes() {
    let manual = manual();
    let examples: Vec<_> = manual.split("```json").skip(1).collect();
    assert!(examples.len() >= 3);
    for example in examples {
        let text = example.split("```").next().unwrap();
        let scene = Scene::parse("docs/scene.md", text).unwrap_or_else(|error| panic!("{error}"));
        let engine = engine();
        let masks = scene.clips.iter().flatten();
        let masks = masks.filter(|clip| matches!(clip, Clip::Mask(_)));
        let headers = Headers {
            masks: masks
                .map(|_| engine.grid)
                .chain(scene.importance.iter().map(|_| engine.grid))
                .collect(),
            ..Headers::from(engine.clone())
        };
        resolve_with(&scene, &headers).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    }
}
