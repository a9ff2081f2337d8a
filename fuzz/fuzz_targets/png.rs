#![no_main]
//! A sequence of slices: PNG or TIFF, told apart by their bytes.

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let names = ["slice_8.png", "slice_9.png", "slice_10.png", "slice_11.png"];
    let files = strahl_fuzz::files(input, &names);
    strahl_fuzz::read(names[0], &files, Default::default());
    strahl_fuzz::read_all(&files);
});
