//! Prints a slice through a head as text, to show what a volume is.
//!
//!     cargo run --release --example 01_slice_in_the_terminal [FILE]

use strahl::Phantom;
use strahl::glam::DVec3;
use strahl::volume::read::ReadOptions;

/// From dark to bright.
const INK: &[u8] = b" .:-=+*#%@";
const COLUMNS: usize = 96;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A file of any kind that Strahl reads, or the built-in head at 2 mm.
    let volume = match std::env::args().nth(1) {
        Some(path) => strahl::load(path, &ReadOptions::default())?.volume,
        None => Phantom::Anatomy.volume([96, 120, 152])?,
    };
    let (lo, hi) = volume.grid().bounds_mm();
    let voxel_from_world = volume.grid().world_from_voxel().inverse();
    let dims = volume.grid().dims();

    // Air is dark, bone is bright: the window is what most of the values lie in.
    let [dark, bright] = [0.01, 0.98].map(|share| volume.statistics().quantile(share));

    // Half way up, seen from the feet as radiologists do: the patient's right is on the left, the face
    // is on top. Places are in millimeters; the affine says which voxel lies there.
    let size = hi - lo;
    let column_mm = size.x / COLUMNS as f64;
    // Characters are about twice as high as wide.
    let rows = (size.y / column_mm / 2.0).round() as usize;
    for row in 0..rows {
        let line: String = (0..COLUMNS)
            .map(|column| {
                let x = hi.x - (column as f64 + 0.5) * column_mm;
                let y = hi.y - (row as f64 + 0.5) * 2.0 * column_mm;
                let world = DVec3::new(x, y, lo.z + 0.55 * size.z);
                let voxel = voxel_from_world.transform_point3(world).round();
                let [i, j, k] = [voxel.x, voxel.y, voxel.z].map(|index| index.max(0.0) as usize);
                let value =
                    volume.value(i.min(dims[0] - 1), j.min(dims[1] - 1), k.min(dims[2] - 1));
                let share = ((value - dark) / (bright - dark)).clamp(0.0, 1.0);
                INK[(share * (INK.len() - 1) as f64).round() as usize] as char
            })
            .collect();
        println!("{}", line.trim_end());
    }
    Ok(())
}
