//! Draws data computed by a program: two interfering waves.
//!
//!     cargo run --release --example 05_own_data

use strahl::glam::DVec3;
use strahl::scene::PointsIn;
use strahl::volume::{Grid, Metadata, Rescale, Samples};
use strahl::{Color, ColorMap, Render, TransferFunction, TransferPoint, Volume};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 96 × 96 × 64 voxels, 0.5 mm apart, around the world's origin.
    let grid = Grid::centered([96, 96, 64], DVec3::splat(0.5))?;
    let [nx, ny, nz] = grid.dims();
    let sources = [DVec3::new(-9.0, 0.0, 0.0), DVec3::new(9.0, 0.0, 0.0)];
    let mut samples = Vec::with_capacity(grid.voxel_count());
    // x runs fastest.
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let voxel = DVec3::new(x as f64, y as f64, z as f64);
                let place_mm = grid.world_from_voxel().transform_point3(voxel);
                let wave: f64 = sources
                    .iter()
                    .map(|source| place_mm.distance(*source))
                    .map(|r| (1.6 * r).cos() / (1.0 + 0.1 * r))
                    .sum();
                samples.push(wave as f32);
            }
        }
    }
    let volume = Volume::new(
        grid,
        Samples::F32(samples),
        Rescale::IDENTITY,
        Metadata::default(),
    )?;

    // Points that count in the window (0 is its low end, 1 its high end): only the crests are seen.
    let opacity = |value, opacity| TransferPoint {
        value,
        opacity: Some(opacity),
        color: None,
    };
    Render::volume(&volume)
        .transfer_function(TransferFunction {
            points: Some(vec![
                opacity(0.62, 0.0),
                opacity(0.75, 0.1),
                opacity(1.0, 0.6),
            ]),
            points_in: Some(PointsIn::Window),
            window: Some(3.0),
            level: Some(0.0),
            color_map: Some(ColorMap::Viridis),
            ..TransferFunction::default()
        })
        .background(strahl::Background::Color(Color::WHITE))
        .size(800, 600)
        .save("05_own_data.png")?;
    Ok(())
}
