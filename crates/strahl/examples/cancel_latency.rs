//! How long after it is cancelled a picture ends, at any moment of reading, preparing and drawing:
//! `cargo run --release -p strahl --example cancel_latency -- edge=256 tries=200`.
//!
//! A volume of `edge`³ voxels is written to a file. Then a session reads and draws it anew for each try, and a thread cancels
//! it after a random share of the time that all of it takes. Prints one line of JSON with milliseconds,
//! and of the three slowest tries after which share of the time they were cancelled.

use std::time::{Duration, Instant};
use strahl::scene::VolumeSource;
use strahl::{Control, Error, Phantom, Scene, Session};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let number = |name: &str, default: usize| {
        let prefix = format!("{name}=");
        let given = std::env::args().find_map(|a| a.strip_prefix(&prefix).map(str::to_owned));
        given.map_or(Ok(default), |text| text.parse())
    };
    let (edge, tries) = (number("edge", 256)?, number("tries", 200)?);
    let folder = tempfile::tempdir()?;
    let path = folder
        .path()
        .join(format!("shells_{edge}x{edge}x{edge}_uint8.raw"));
    let volume = Phantom::Shells.volume([edge; 3])?;
    std::fs::write(&path, volume.samples().as_bytes())?;
    drop(volume);
    let scene = Scene {
        size: Some([512, 512]),
        volume: Some(VolumeSource {
            path: path.to_str().map(str::to_owned),
            ..VolumeSource::default()
        }),
        ..Scene::parse("scene", r#"{ "reconstruct": "b-spline" }"#)?
    };
    let start = Instant::now();
    Session::new().draw(&scene, &Control::NONE)?;
    let whole = start.elapsed();
    let mut late_ms = Vec::new();
    let (mut state, mut finished) = (1u64, 0);
    while late_ms.len() < tries {
        // P. L'Ecuyer's multiplier.
        state = state
            .wrapping_mul(2_862_933_555_777_941_757)
            .wrapping_add(3_037_000_493);
        let share = (state >> 11) as f64 / (1u64 << 53) as f64;
        let (session, control) = (Session::new(), Control::new());
        let other = control.clone();
        let cancelling = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_secs_f64(share * whole.as_secs_f64()));
            let at = Instant::now();
            other.cancel();
            at
        });
        let drawn = session.draw(&scene, &control);
        let ended = Instant::now();
        match drawn {
            Err(Error::Cancelled) => {
                let cancelled = cancelling.join().map_err(|_| "the thread has panicked")?;
                let late = ended.saturating_duration_since(cancelled);
                late_ms.push((1e3 * late.as_secs_f64(), share));
            }
            Ok(_) => finished += 1,
            Err(error) => return Err(error.into()),
        }
    }
    late_ms.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |share: f64| late_ms[((tries - 1) as f64 * share).round() as usize].0;
    // When those were cancelled that took longest.
    let latest: Vec<_> = late_ms.iter().rev().take(3).collect();
    println!(
        r#"{{"edge":{edge},"tries":{tries},"finished":{finished},"whole_ms":{:.0},"p50_ms":{:.2},"p99_ms":{:.2},"most_ms":{:.2},"latest_ms_and_share":{latest:?}}}"#,
        1e3 * whole.as_secs_f64(),
        at(0.5),
        at(0.99),
        at(1.0)
    );
    Ok(())
}
