//! Sets a transfer function, a camera and a clip plane.
//!
//!     cargo run --release --example 04_transfer_function_and_camera

use strahl::scene::PlaneClip;
use strahl::{Camera, Clip, Color, Phantom, Render, TransferFunction, TransferPoint};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let color = |hex| Color::from_hex(hex);
    // Values are Hounsfield units. Opacity refers to one reference length, so the picture
    // depends neither on the step nor on the resolution of the volume.
    let points = vec![
        TransferPoint::new(-300.0, 0.0, color("#c98a6b")?),
        TransferPoint::new(-50.0, 0.25, color("#d9a582")?), // skin and fat
        TransferPoint::new(10.0, 0.35, color("#8c4a3e")?),
        TransferPoint::new(60.0, 0.6, color("#a8514a")?), // muscle and brain
        TransferPoint::new(200.0, 0.8, color("#c0392b")?), // vessels with contrast medium
        TransferPoint::new(400.0, 0.9, color("#efe2c8")?), // bone
        TransferPoint::new(1500.0, 1.0, color("#ffffff")?),
    ];
    Render::phantom(Phantom::Anatomy)
        .transfer_function(TransferFunction {
            points: Some(points),
            reference_mm: Some(1.0),
            ..TransferFunction::default()
        })
        // World space is RAS in mm: +x is the patient's right. Keep that half.
        .clip(Clip::Plane(PlaneClip {
            normal: [1.0, 0.0, 0.0],
            ..PlaneClip::default()
        }))
        // From the front, then a quarter turn towards the patient's left, a little from above.
        .camera(Camera {
            azimuth_deg: Some(60.0),
            elevation_deg: Some(15.0),
            ..Camera::default()
        })
        .size(700, 700)
        .save("04_transfer_function_and_camera.png")?;
    Ok(())
}
