#![no_main]
//! Edits of a graph: two texts, a graph and edits of it. Commands that are carried out one after the other
//! give what all at once give, and what one of them says is never left out in silence.

use strahl_fuzz::{SEPARATOR, graph};
use strahl_graph::{Edit, EditList};

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let Ok(text) = std::str::from_utf8(input) else {
        return;
    };
    let separator = std::str::from_utf8(SEPARATOR).unwrap_or_default();
    let (base, edits) = text.split_once(separator).unwrap_or(("{}", text));
    let (Some(base), Some(asked)) = (graph::read(base), graph::read(edits)) else {
        return;
    };
    let first = base.graph.unwrap_or_else(graph::standard);
    let all = graph::changed(&first, &asked.edits);
    let mut one_by_one = Some(first);
    for list in &asked.edits {
        for command in &list.commands {
            let Some(before) = &one_by_one else { break };
            let alone = EditList {
                name: list.name.clone(),
                commands: vec![command.clone()],
            };
            let after = graph::changed(before, &[alone]);
            if let (Edit::Add(nodes), Some(after)) = (command, &after) {
                assert_eq!(after.nodes.len(), before.nodes.len() + nodes.len());
            }
            if let (Edit::Root(roots), Some(after)) = (command, &after) {
                assert!(roots.iter().all(|root| after.roots.contains(root)));
            }
            if let (Edit::Remove(names), Some(after)) = (command, &after) {
                assert!(names.iter().all(|name| after.node(name).is_none()));
            }
            one_by_one = after;
        }
    }
    assert_eq!(all, one_by_one);
    if let Some(changed) = all {
        graph::compile(&changed);
    }
});
