//! Reads a volume and prints its decoded bytes and the seconds that it took: what `cargo xtask oracle
//! --time` runs beside Python scripts that do the same with other libraries.

use std::time::Instant;
use strahl::volume::read::ReadOptions;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args_os().nth(1).ok_or("name a volume")?;
    let start = Instant::now();
    let volume = strahl::load(&path, &ReadOptions::default())?.volume;
    let [low, high] = volume.statistics().range;
    let (bytes, seconds) = (volume.samples().as_bytes().len(), start.elapsed());
    println!("{bytes} {} {low} {high}", seconds.as_secs_f64());
    Ok(())
}
