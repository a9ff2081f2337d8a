//! Draws a scan. The data determines all settings.
//!
//!     cargo run --release --example 02_file_to_picture head.nii.gz head.png

fn main() -> Result<(), strahl::Error> {
    let mut args = std::env::args().skip(1);
    let (Some(volume), Some(picture)) = (args.next(), args.next()) else {
        eprintln!("usage: 02_file_to_picture VOLUME PICTURE");
        std::process::exit(2);
    };
    strahl::render_file(volume, picture)
}
