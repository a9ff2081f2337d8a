#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.npy"]);
    strahl_fuzz::read("scan.npy", &files, Default::default());
});
