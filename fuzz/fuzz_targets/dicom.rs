#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let names = ["a.dcm", "b.dcm", "c.dcm", "d.dcm", "e.dcm"];
    let files = strahl_fuzz::files(input, &names);
    strahl_fuzz::read(names[0], &files, Default::default());
    strahl_fuzz::read_all(&files);
});
