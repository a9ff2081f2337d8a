//! Draws the built-in head with a preset, seen from the patient's left.
//!
//!     cargo run --release --example 03_phantom_and_preset

use strahl::{Phantom, Render, View};

fn main() -> Result<(), strahl::Error> {
    let picture = Render::phantom(Phantom::Anatomy)
        .preset("ct-soft-tissue")
        .view(View::Left)
        .size(600, 700)
        .save("03_phantom_and_preset.png")?;
    println!("drawn in {:.2} s", picture.stats.draw_seconds);
    Ok(())
}
