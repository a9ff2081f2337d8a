#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.vti"]);
    strahl_fuzz::read("scan.vti", &files, Default::default());
});
