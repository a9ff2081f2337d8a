//! Makes a scene in code, writes it as JSON, and reads it back: users can edit what a program made.
//!
//!     cargo run --release --example 06_scene_in_code

use strahl::scene::{Light, VolumeSource};
use strahl::{Background, Camera, Color, Method, Render, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Missing keys are filled in from a preset and from the data when the scene is drawn.
    let scene = Scene {
        volume: Some(VolumeSource {
            phantom: Some("anatomy".into()),
            ..VolumeSource::default()
        }),
        method: Some(Method::FirstHit),
        threshold: Some(-300.0), // the skin, in Hounsfield units
        lights: Some(vec![
            Light::from_camera(-50.0, 35.0, 0.9),
            Light {
                color: Some(Color::from_hex("#6f8fc8")?),
                ..Light::from_camera(75.0, 10.0, 0.7)
            },
        ]),
        camera: Some(Camera {
            azimuth_deg: Some(-35.0),
            elevation_deg: Some(8.0),
            ..Camera::default()
        }),
        background: Some(Background::Color(Color::from_hex("#1b1d22")?)),
        size: Some([600, 700]),
        ..Scene::default()
    };

    let text = scene.to_json();
    println!("{text}");
    std::fs::write("06_scene_in_code.json", &text)?;

    // `strahl render 06_scene_in_code.json -o same.png` draws the same.
    let read = Scene::parse("06_scene_in_code.json", &text)?;
    assert_eq!(read, scene);
    Render::scene(read).save("06_scene_in_code.png")?;
    Ok(())
}
