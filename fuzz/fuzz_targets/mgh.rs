#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.mgh"]);
    strahl_fuzz::read("scan.mgh", &files, Default::default());
});
