//! One packed frame behind a header that fits it: the decoders of DICOM's transfer syntaxes.
#![no_main]

use strahl_fuzz::dicom_frame::file_around;

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let Some(file) = file_around(input) else {
        return;
    };
    let files = [("a.dcm".to_owned(), file)].into();
    strahl_fuzz::read("a.dcm", &files, Default::default());
});
