//! Tiles of noise for jitter, repeated over the picture.

use crate::plan::Jitter;
use std::sync::Arc;
use strahl_volume::{Cancelled, Control, Key, Store};

/// A square of numbers in [0, 1), all different, that repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseTile {
    edge: u32,
    values: Arc<[f32]>,
}

impl NoiseTile {
    /// 32 × 32 numbers without any order.
    pub fn white(seed: u32) -> NoiseTile {
        const EDGE: u32 = 32;
        NoiseTile::ranked(EDGE, &shuffled(EDGE * EDGE, seed))
    }

    /// 64 × 64 numbers of blue noise: each threshold leaves an even spread of pixels, so that the
    /// grain has no coarse parts. By void and cluster (R. Ulichney 1993), which takes a moment.
    ///
    /// # Errors
    /// It was cancelled.
    pub fn blue(seed: u32, control: &Control) -> Result<NoiseTile, Cancelled> {
        let ranks = void_and_cluster(seed, control)?;
        Ok(NoiseTile::ranked(BLUE_EDGE as u32, &ranks))
    }

    /// The tile that `jitter` reads, if it reads one: found in `store`, or made.
    ///
    /// # Errors
    /// It was cancelled.
    pub fn find(
        jitter: Jitter,
        store: &Store,
        control: &Control,
    ) -> Result<Option<Arc<NoiseTile>>, Cancelled> {
        let make = |tile: &dyn Fn() -> Result<NoiseTile, Cancelled>| {
            store.find(&NoiseTileKey(jitter), control, tile).map(Some)
        };
        match jitter {
            Jitter::Center | Jitter::Hash(_) | Jitter::SineHash => Ok(None),
            Jitter::WhiteTile(seed) => make(&|| Ok(NoiseTile::white(seed))),
            Jitter::BlueTile(seed) => make(&|| NoiseTile::blue(seed, control)),
        }
    }

    /// Pixels along an edge.
    pub fn edge(&self) -> u32 {
        self.edge
    }

    /// All numbers, row by row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The number for the pixel in column `x`, row `y` of the picture.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        self.values[(y % self.edge * self.edge + x % self.edge) as usize]
    }

    /// Ranks as numbers: rank r of n is r/n.
    fn ranked(edge: u32, ranks: &[u32]) -> NoiseTile {
        let n = (edge * edge) as f32;
        NoiseTile {
            edge,
            values: ranks.iter().map(|&rank| rank as f32 / n).collect(),
        }
    }
}

/// Key of the tile that a jitter reads.
#[derive(Clone, PartialEq)]
struct NoiseTileKey(Jitter);

impl Key for NoiseTileKey {
    type Value = NoiseTile;

    const NAME: &str = "noise tiles";

    fn bytes(&self, value: &NoiseTile) -> usize {
        size_of_val(value.values())
    }
}

/// C. Wellons' `lowbias32`, as `docs/plan.md` uses it for jitter.
fn hash(x: u32, seed: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9E37_79B1) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7FEB_352D);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846C_A68B);
    h ^ (h >> 16)
}

/// The numbers below `n` in an order that the seed decides.
fn shuffled(n: u32, seed: u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..n).collect();
    order.sort_by_key(|&i| (hash(i, seed), i));
    order
}

const BLUE_EDGE: usize = 64;
const BLUE_PIXELS: usize = BLUE_EDGE * BLUE_EDGE;

/// How full the neighborhood of each pixel of a repeated pattern is: a Gaussian of 1.5 pixels, the
/// width that the paper recommends, in whole numbers so that every machine finds the same extremes.
struct Fullness {
    kernel: Vec<u64>,
    set: Vec<bool>,
    energy: Vec<u64>,
}

impl Fullness {
    fn new() -> Fullness {
        let edge = BLUE_EDGE as i32;
        let kernel = (0..edge * edge).map(|i| {
            let apart = |d: i32| f64::from(d.min(edge - d));
            let (dx, dy) = (apart(i % edge), apart(i / edge));
            ((-(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5)).exp() * f64::from(1 << 30)) as u64
        });
        Fullness {
            kernel: kernel.collect(),
            set: vec![false; BLUE_PIXELS],
            energy: vec![0; BLUE_PIXELS],
        }
    }

    fn toggle(&mut self, at: usize) {
        self.set[at] = !self.set[at];
        let (x, y) = (at % BLUE_EDGE, at / BLUE_EDGE);
        for (row, energies) in self.energy.chunks_mut(BLUE_EDGE).enumerate() {
            let dy = (row + BLUE_EDGE - y) % BLUE_EDGE;
            for (column, energy) in energies.iter_mut().enumerate() {
                let dx = (column + BLUE_EDGE - x) % BLUE_EDGE;
                let part = self.kernel[dy * BLUE_EDGE + dx];
                if self.set[at] {
                    *energy += part;
                } else {
                    *energy -= part;
                }
            }
        }
    }

    /// The set pixel with the fullest neighborhood.
    fn cluster(&self) -> usize {
        let set = (0..BLUE_PIXELS).filter(|&i| self.set[i]);
        set.max_by_key(|&i| (self.energy[i], i)).unwrap_or(0)
    }

    /// The free pixel with the emptiest neighborhood.
    fn void(&self) -> usize {
        let free = (0..BLUE_PIXELS).filter(|&i| !self.set[i]);
        free.min_by_key(|&i| (self.energy[i], i)).unwrap_or(0)
    }
}

/// The rank of each pixel.
fn void_and_cluster(seed: u32, control: &Control) -> Result<Vec<u32>, Cancelled> {
    let mut pattern = Fullness::new();
    let first = BLUE_PIXELS / 10;
    for &at in &shuffled(BLUE_PIXELS as u32, seed)[..first] {
        pattern.toggle(at as usize);
    }
    // Moves pixels from clusters to voids until that changes nothing.
    loop {
        control.check()?;
        let cluster = pattern.cluster();
        pattern.toggle(cluster);
        let void = pattern.void();
        pattern.toggle(void);
        if void == cluster {
            break;
        }
    }
    let mut ranks = vec![0; BLUE_PIXELS];
    let spread: Vec<usize> = (0..BLUE_PIXELS).filter(|&i| pattern.set[i]).collect();
    for rank in (0..first).rev() {
        control.check()?;
        let cluster = pattern.cluster();
        ranks[cluster] = rank as u32;
        pattern.toggle(cluster);
    }
    for at in spread {
        pattern.toggle(at);
    }
    // Beyond half full, the void among the free is the cluster of what is free: the same pixel.
    for rank in first..BLUE_PIXELS {
        control.check()?;
        let void = pattern.void();
        ranks[void] = rank as u32;
        pattern.toggle(void);
    }
    Ok(ranks)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blue(seed: u32) -> NoiseTile {
        NoiseTile::blue(seed, &Control::NONE).unwrap()
    }

    #[test]
    fn a_store_makes_each_tile_once() {
        let (store, control) = (Store::default(), Control::NONE);
        let find = |jitter| NoiseTile::find(jitter, &store, &control).unwrap();
        for _ in 0..2 {
            assert_eq!(*find(Jitter::BlueTile(1)).unwrap(), blue(1));
            assert_eq!(*find(Jitter::WhiteTile(1)).unwrap(), NoiseTile::white(1));
            assert!(find(Jitter::Hash(1)).is_none());
        }
        assert_eq!(store.counts().made, 2);
    }

    #[test]
    fn making_a_tile_can_be_cancelled() {
        let control = Control::new();
        control.cancel();
        assert!(NoiseTile::blue(0, &control).is_err());
    }

    /// The share of a tile's energy below an eighth of its finest frequency.
    fn coarse_share(tile: &NoiseTile) -> f64 {
        let n = tile.edge() as i32;
        let (mut coarse, mut all) = (0.0, 0.0);
        for v in 0..n {
            for u in 0..n {
                let (mut re, mut im) = (0.0, 0.0);
                for y in 0..n {
                    for x in 0..n {
                        let angle = f64::from(u * x + v * y) / f64::from(n) * std::f64::consts::TAU;
                        let value = f64::from(tile.at(x as u32, y as u32)) - 0.5;
                        re += value * angle.cos();
                        im += value * angle.sin();
                    }
                }
                let energy = re * re + im * im;
                let (fu, fv) = (f64::from(u.min(n - u)), f64::from(v.min(n - v)));
                all += energy;
                if fu.hypot(fv) < f64::from(n) / 8.0 && (u, v) != (0, 0) {
                    coarse += energy;
                }
            }
        }
        coarse / all
    }

    #[test]
    fn every_rank_is_there_once() {
        for tile in [NoiseTile::white(3), blue(0)] {
            let mut sorted = tile.values().to_vec();
            sorted.sort_by(f32::total_cmp);
            let n = sorted.len() as f32;
            assert!(sorted.iter().enumerate().all(|(i, v)| *v == i as f32 / n));
        }
        assert_ne!(NoiseTile::white(3), NoiseTile::white(4));
        assert_ne!(blue(1), blue(0));
    }

    #[test]
    fn blue_noise_has_no_coarse_grain() {
        // White noise has its energy everywhere: a disc of radius n/8 is π/64, some 5 %.
        assert!(coarse_share(&NoiseTile::white(0)) > 0.03);
        assert!(coarse_share(&blue(0)) < 0.004);
    }
}
