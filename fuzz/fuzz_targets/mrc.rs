#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.mrc"]);
    strahl_fuzz::read("scan.mrc", &files, Default::default());
});
