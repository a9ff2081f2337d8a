//! Texts that are almost right.

use super::*;
use proptest::prelude::*;

/// Words that mean something to the reader.
const WORDS: [&str; 40] = [
    "\"strahl_graph\": 1",
    "\"nodes\"",
    "\"roots\"",
    "\"edits\"",
    "\"pattern\"",
    "\"wgsl\"",
    "\"slot\"",
    "\"inputs\"",
    "\"loop\"",
    "\"carry\"",
    "\"while\"",
    "\"if\"",
    "\"then\"",
    "\"anchor\"",
    "\"uniform\"",
    "\"value\"",
    "\"texture\"",
    "\"params\"",
    "\"stage\": \"vertex\"",
    "\"slicing\": { \"blend\": \"larger\" }",
    "\"replace\"",
    "\"everything\"",
    "\"graph\"",
    "1e39",
    "-0.0",
    "18446744073709551616",
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\"a.b.c\"",
    "\"over\"",
    "\"classify\"",
    "// x\n",
    "/*",
    "*/",
    ",",
    "\u{feff}",
    "\\ud800",
];

fn seeds(random: &mut Random) -> String {
    match random.below(3) {
        0 => random.of(&STANDARD).to_text(),
        1 => random.of(&EXAMPLES).clone(),
        _ => super::edits::random_graph(random).to_text(),
    }
}

/// Cuts, doubles, swaps and overwrites pieces of a text, at the ends of words where it can.
fn damaged(mut text: String, random: &mut Random) -> String {
    for _ in 0..1 + random.below(4) {
        let cuts: Vec<usize> = (text.char_indices())
            .filter(|(_, c)| random.chance(30) || "\"{}[],:".contains(*c))
            .map(|(at, _)| at)
            .collect();
        if cuts.is_empty() {
            return text;
        }
        let from = *random.of(&cuts);
        let near: Vec<_> = cuts
            .iter()
            .filter(|at| (from..from + 60).contains(*at))
            .collect();
        let to = **random.of(&near);
        match random.below(5) {
            0 => text.replace_range(from..to, ""),
            1 => {
                let piece = text[from..to].to_owned();
                text.insert_str(from, &piece);
            }
            2 => text.insert_str(from, WORDS[random.below(WORDS.len())]),
            3 => text.replace_range(from..to, WORDS[random.below(WORDS.len())]),
            _ => {
                let other = *random.of(&cuts);
                let piece = text[from..to].to_owned();
                text.insert_str(other, &piece);
            }
        }
    }
    text
}

/// What was read is written so that it means the same, and is written the same again.
fn assert_stable(asked: &GraphUse) {
    let written = asked.to_text();
    let again = read(&written).unwrap_or_else(|error| panic!("{error}\n{written}"));
    assert_eq!(&again, asked, "{written}");
    assert_eq!(again.to_text(), written);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn damaged_texts_are_refused_or_graphs(seed: u64) {
        let mut random = Random(seed);
        let text = damaged(seeds(&mut random), &mut random);
        match read(&text) {
            Err(error) => prop_assert!(error.to_string().len() > "test: ".len()),
            Ok(asked) => {
                assert_stable(&asked);
                let base = asked.graph.clone().unwrap_or_else(|| STANDARD[0].clone());
                if let Ok(graph) = changed(&base, &asked.edits)
                    && let Err(error) = compiles(&graph)
                {
                    prop_assert!(error.to_string().contains(": "), "{error}");
                }
            }
        }
    }
}

#[test]
fn whole_texts_are_stable() {
    for text in EXAMPLES.iter() {
        assert_stable(&read(text).unwrap());
    }
    for scene in SCENES {
        let mut graph = standard(&plan(scene)).unwrap();
        let asked = read(&graph.to_text()).unwrap();
        // In which order inputs stand means nothing.
        for node in &mut graph.nodes {
            let sorted = |name: &str| {
                ["if", "then.", "else."]
                    .iter()
                    .position(|p| name.starts_with(p))
            };
            node.inputs.sort_by_key(|(name, _)| sorted(name));
        }
        assert_eq!(asked.graph.as_ref(), Some(&graph));
        assert_stable(&asked);
    }
}

/// Parts that nothing reads are refused, not left out.
#[test]
fn nothing_is_left_out_in_silence() {
    let refused = |text: &str, place: &str| {
        let said = match read(text) {
            Err(error) => error.to_string(),
            Ok(asked) => {
                let base = asked.graph.clone().unwrap_or_else(|| STANDARD[0].clone());
                match changed(&base, &asked.edits) {
                    Err(said) => said,
                    Ok(graph) => compiles(&graph).unwrap_err().to_string(),
                }
            }
        };
        assert!(said.contains(place), "{place}: {said}");
    };
    let graph = |more: &str| {
        format!(
            r#"{{ "strahl_graph": 1, "nodes": {{ "a": {{ "pattern": "pixel", "inputs": {{ "color": 1, "opacity": 1 }} }}, {more} }}, "roots": {{ "color": "a" }} }}"#
        )
    };
    refused(
        &graph(r#""b": { "anchor": "a", "params": { "x": 1 } }"#),
        "nodes.b.params.x",
    );
    refused(
        &graph(r#""b": { "anchor": "a", "stage": "vertex" }"#),
        "nodes.b.stage",
    );
    refused(
        &graph(r#""b": { "uniform": "f32", "value": 1, "params": { "value": 2 } }"#),
        "nodes.b.params.value",
    );
    refused(
        &graph(
            r#""b": { "graph": { "nodes": { "c": { "anchor": 1 } }, "roots": { "out": "c" } }, "stage": "vertex" }"#,
        ),
        "nodes.b.stage",
    );
    refused(
        &graph(r#""b": { "anchor": "a" }"#).replace(
            r#""roots""#,
            r#""inputs": { "x": { "default": 1 } }, "roots""#,
        ),
        "inputs.x",
    );
    refused(
        &graph(r#""b": { "texture": { "size": [1, 1], "texels": [[1e39, 0, 0, 0]] } }"#),
        "nodes.b.texture.texels",
    );
    let edit = |command: &str| {
        format!(r#"{{ "strahl_graph": 1, "edits": [{{ "name": "e", "commands": [{command}] }}] }}"#)
    };
    refused(
        &edit(
            r#"{ "add": { "lone": { "pattern": "step_mm" } } }, { "replace": { "node": "lone", "by": "before_jitter" } }"#,
        ),
        "edits.e.commands[1].replace.node",
    );
    refused(
        &edit(r#"{ "replace": { "stage": "shade", "by": {} } }"#),
        "edits.e.commands[0].replace.by",
    );
    let both = GraphUse::read(
        "test",
        &graph(r#""b": { "anchor": "a" }"#).replace(r#""nodes""#, r#""file": "other", "nodes""#),
        &mut |_| Ok(graph(r#""b": { "anchor": "a" }"#)),
    );
    assert!(
        both.unwrap_err()
            .to_string()
            .contains("has a graph already")
    );
}
