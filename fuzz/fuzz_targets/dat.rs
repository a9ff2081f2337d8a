#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.dat", "scan.raw"]);
    strahl_fuzz::read("scan.dat", &files, Default::default());
});
