#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.tif"]);
    strahl_fuzz::read("scan.tif", &files, Default::default());
});
