#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let files = strahl_fuzz::files(input, &["scan.vtk"]);
    strahl_fuzz::read("scan.vtk", &files, Default::default());
});
