#![no_main]
//! The text of a graph. What is understood is written so that it means the same, and what comes of its edits
//! is a program or refused with words.

use strahl_fuzz::graph;

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let Ok(text) = std::str::from_utf8(input) else {
        return;
    };
    let Some(asked) = graph::read(text) else {
        return;
    };
    let base = asked.graph.clone().unwrap_or_else(graph::standard);
    if let Some(changed) = graph::changed(&base, &asked.edits) {
        graph::compile(&changed);
    }
});
