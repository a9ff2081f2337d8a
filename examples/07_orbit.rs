//! Draws an orbit around a volume with the layers below [`strahl::Render`]. Derived data is kept. For each
//! picture, a scene is resolved to a Plan, drawn, and written.
//!
//!     cargo run --release --example 07_orbit [PICTURES]

use std::path::PathBuf;
use strahl::Control;
use strahl::cpu::{Options, Renderer};
use strahl::scene::resolve;
use strahl::{Camera, Encoding, Output, Phantom, Scene, write_picture};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: u32 = match std::env::args().nth(1) {
        Some(text) => text.parse()?,
        None => 12,
    };
    let volume = Phantom::Tree.volume([128, 128, 128])?;
    let header = volume.header();
    // The first picture makes bricks for skipping; the others find them.
    let renderer = Renderer::new(&volume);
    for i in 0..count {
        let scene = Scene {
            camera: Some(Camera {
                azimuth_deg: Some(360.0 * f64::from(i) / f64::from(count)),
                elevation_deg: Some(20.0),
                // The same for all, or the volume would breathe.
                zoom: Some(1.2),
                ..Camera::default()
            }),
            size: Some([400, 400]),
            ..Scene::default()
        };
        // Everything that can be wrong with a scene is found here, not while drawing.
        let plan = resolve(&scene, &header, None)?;
        let drawn = renderer.render(&plan, &Options::default(), &Control::NONE)?;

        let path = PathBuf::from(format!("07_orbit_{i:03}.png"));
        // The file gets its name when it is complete.
        let mut file = Output::create(&path)?;
        let image = &drawn.image;
        write_picture(image, None, &plan.display, Encoding::Png8, None, &mut file)?;
        file.finish()?;
        println!("{}: {:.2} s", path.display(), drawn.stats.draw_seconds);
    }
    Ok(())
}
