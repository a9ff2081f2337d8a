#![no_main]

use std::collections::BTreeSet;

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let Ok(labels) = strahl_volume::read::read_label_table("table", input) else {
        return;
    };
    let ids: BTreeSet<u32> = labels.iter().map(|label| label.id).collect();
    assert_eq!(ids.len(), labels.len());
    let mut channels = labels.iter().filter_map(|label| label.color).flatten();
    assert!(channels.all(|channel| (0.0..=1.0).contains(&channel)));
});
