#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.npz"]);
    strahl_fuzz::read("scan.npz", &files, Default::default());
});
