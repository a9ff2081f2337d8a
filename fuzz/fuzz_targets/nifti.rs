#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.hdr", "scan.img"]);
    strahl_fuzz::read("scan.hdr", &files, Default::default());
});
