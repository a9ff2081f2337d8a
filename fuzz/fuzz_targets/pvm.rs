#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.pvm"]);
    strahl_fuzz::read("scan.pvm", &files, Default::default());
});
