//! What rays look like, computed ahead of the clocks by as many threads as there are.

use crate::data_path::{DataPath, RayValue};
use crate::frame::Frame;
use crate::rays::Ray;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Tiles that a thread takes at a time.
const TILES: usize = 16;

/// The rays of a tile that hit the volume, with what becomes of each.
pub(crate) type TileValues = Vec<(Ray, RayValue)>;

/// The values of a frame, in the order of tiles.
pub(crate) struct ValuesAhead<'f> {
    frame: &'f Frame,
    path: DataPath<'f>,
    chunks: Vec<OnceLock<Vec<TileValues>>>,
    next: AtomicUsize,
    is_stopped: AtomicBool,
}

impl<'f> ValuesAhead<'f> {
    /// With nothing computed yet.
    pub fn new(frame: &'f Frame) -> ValuesAhead<'f> {
        let chunks = frame.setup.tile_count().div_ceil(TILES);
        ValuesAhead {
            frame,
            path: DataPath::new(frame),
            chunks: (0..chunks).map(|_| OnceLock::new()).collect(),
            next: AtomicUsize::new(0),
            is_stopped: AtomicBool::new(false),
        }
    }

    /// Computes until nothing is left or somebody stops it: what other threads do.
    pub fn work(&self) {
        let _guard = PanicGuard(self);
        loop {
            if self.is_stopped.load(Ordering::Relaxed) || !self.compute_next() {
                break;
            }
        }
    }

    /// Nobody needs more values.
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// The values of a tile. While another thread computes them, this one computes later ones.
    ///
    /// # Panics
    /// If another thread did.
    pub fn tile(&self, tile: usize) -> &TileValues {
        let chunk = &self.chunks[tile / TILES];
        loop {
            if let Some(tiles) = chunk.get() {
                return &tiles[tile % TILES];
            }
            if !self.compute_next() {
                // Everything is taken: the thread that has it is at work, and waits for nobody.
                assert!(
                    !self.is_stopped.load(Ordering::Relaxed),
                    "a thread that computes values has panicked"
                );
                std::thread::yield_now();
            }
        }
    }

    /// Computes the next tiles; whether there were any.
    fn compute_next(&self) -> bool {
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        let Some(chunk) = self.chunks.get(index) else {
            return false;
        };
        let first = index * TILES;
        let setup = &self.frame.setup;
        let values = |tile| {
            let rays = setup.tile(tile).into_iter();
            rays.map(|ray| (ray, self.path.value(&ray))).collect()
        };
        let tiles = first..(first + TILES).min(setup.tile_count());
        let is_first = chunk.set(tiles.map(values).collect()).is_ok();
        debug_assert!(is_first, "a chunk is taken once");
        true
    }
}

/// Lets nobody wait for a thread that has panicked.
struct PanicGuard<'a, 'f>(&'a ValuesAhead<'f>);

impl Drop for PanicGuard<'_, '_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.stop();
        }
    }
}
