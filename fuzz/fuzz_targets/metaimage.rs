#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.mhd", "scan.raw", "scan.1.raw"]);
    strahl_fuzz::read("scan.mhd", &files, Default::default());
});
