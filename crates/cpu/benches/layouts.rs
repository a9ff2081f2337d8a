//! Ways to lay voxels in memory: what they take, and samples per second along rays in several directions, one thread.
//!
//!     cargo bench -p strahl-cpu --features bench-kernels --bench layouts [-- EDGE …]
//!
//! `STRAHL_SIMD` chooses the instructions. Layouts take turns, the fastest of five rounds counts.

use std::time::Instant;
use strahl_cpu::kernels::instructions;
use strahl_cpu::kernels::layout::{LaidOutVoxels, Layout};
use strahl_volume::Grid;

const DIRECTIONS: [(&str, [f64; 3]); 4] = [
    ("x", [1.0, 0.0, 0.0]),
    ("y", [0.0, 1.0, 0.0]),
    ("z", [0.0, 0.0, 1.0]),
    ("oblique", [0.6, 0.5, 0.7]),
];

const ROUNDS: usize = 5;

fn main() {
    let edges: Vec<usize> = std::env::args()
        .filter_map(|text| text.parse().ok())
        .collect();
    let edges = if edges.is_empty() {
        vec![256, 512]
    } else {
        edges
    };
    let set = instructions().expect("instructions");
    println!(
        "| edge | layout | laid in | memory | {} |",
        DIRECTIONS.map(|d| d.0).join(" | ")
    );
    for edge in edges {
        let grid = Grid::centered([edge; 3], glam::DVec3::ONE).expect("a grid");
        let number = grid.voxel_count();
        let voxels: Vec<u8> = (0..number)
            .map(|i| (i.wrapping_mul(2_654_435_761) >> 20) as u8)
            .collect();
        let mut fastest = [[f64::INFINITY; DIRECTIONS.len() + 1]; Layout::ALL.len()];
        let mut bytes = [0; Layout::ALL.len()];
        let mut sums = [[0.0; DIRECTIONS.len()]; Layout::ALL.len()];
        for _ in 0..ROUNDS {
            for (i, layout) in Layout::ALL.into_iter().enumerate() {
                let start = Instant::now();
                let laid = LaidOutVoxels::new(layout, grid, &voxels);
                let took = start.elapsed().as_secs_f64();
                fastest[i][0] = fastest[i][0].min(took);
                bytes[i] = laid.bytes();
                for (j, (_, direction)) in DIRECTIONS.into_iter().enumerate() {
                    let start = Instant::now();
                    let (samples, sum) = laid.cross(set, direction);
                    let each = start.elapsed().as_secs_f64() / samples as f64;
                    fastest[i][j + 1] = fastest[i][j + 1].min(each);
                    sums[i][j] = sum;
                }
            }
        }
        assert!(
            sums.iter().all(|sums_of| *sums_of == sums[0]),
            "layouts read other voxels"
        );
        for (i, layout) in Layout::ALL.into_iter().enumerate() {
            let speeds = fastest[i][1..]
                .iter()
                .map(|each| format!("{:.0}", 1e-6 / each));
            println!(
                "| {edge} | {layout:?} | {:.1} ms | {:.2} × | {} |",
                fastest[i][0] * 1e3,
                bytes[i] as f64 / number as f64,
                speeds.collect::<Vec<_>>().join(" | ")
            );
        }
    }
    println!("Directions in million samples a second.");
}
