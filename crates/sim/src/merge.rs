//! Several volumes, or several boards with a volume each: pictures drawn apart and merged with *over* (document §8.3).
//!
//! Every volume has its own memory and its own pictures; only what has moved is drawn again. The volumes lie side by side,
//! one entirely before the other. What a board sends is its picture before black and how much light its rays let pass.

use crate::counters::Counters;
use crate::processor::Run;

/// The picture of volumes that lie one behind the other, nearest first, before a background of 0 to 1. Every run has to
/// be drawn with `look.background` 0.
///
/// # Panics
/// If the pictures differ in size, or there is none.
pub fn over(nearest_first: &[&Run], background: f32) -> Vec<f32> {
    let size = nearest_first[0].size;
    let mut passing = vec![1.0f32; nearest_first[0].picture.len()];
    let mut picture = vec![0.0f32; passing.len()];
    for run in nearest_first {
        assert_eq!(run.size, size, "pictures of different size");
        for (i, passing) in passing.iter_mut().enumerate() {
            picture[i] += *passing * run.picture[i];
            *passing *= run.passing[i];
        }
    }
    for (pixel, passing) in picture.iter_mut().zip(passing) {
        *pixel = (*pixel + passing * background).min(1.0);
    }
    picture
}

/// Clocks until all boards are done, which is when the slowest is, and what they count together.
pub fn boards(runs: &[&Run]) -> Counters {
    let mut all = Counters::default();
    for run in runs {
        all.add(&run.counters);
    }
    all.clocks = runs
        .iter()
        .map(|run| run.counters.clocks)
        .max()
        .unwrap_or(0);
    all
}
