#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    strahl_fuzz::read_mesh("mesh.obj", input);
});
