#![no_main]
//! The name of a raw file is input too: its first line is the name, the rest the data.

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let end = input.iter().position(|&byte| byte == b'\n');
    let (name, data) = input.split_at(end.unwrap_or(0));
    let Ok(name) = std::str::from_utf8(name) else {
        return;
    };
    let data = data.get(1..).unwrap_or_default();
    let files = [(name.to_string(), data.to_vec())].into_iter().collect();
    strahl_fuzz::read(name, &files, Default::default());
});
