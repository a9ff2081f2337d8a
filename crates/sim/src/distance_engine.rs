//! Distance coding as a circuit: one voxel per clock through a shift register, and six comparators (document §8.1).
//!
//! A plane of `rows` × `columns` voxels flows through, z after z. The thirteen neighbours that were there before are taps
//! of the register: 1; k − 1, k, k + 1; and the same around (j − 1)k, jk and (j + 1)k. Four of these five groups are the
//! same triple at different delays, so its minimum is made once (two comparators) and delayed; four more comparators join
//! them. Every comparator but the last has a register behind it, and the taps are that much earlier; therefore a row needs
//! at least five columns. The last one joins the voxel just finished, which no register can make earlier.
//!
//! [`chessboard`] codes a whole plane at once: it has a column and a row of its own for what is outside, so that rows do not
//! wrap into each other. [`in_columns`] has a plane of fixed size and codes a volume column by column, as the document does:
//! columns overlap by a margin that is fed and not written, and all finish the first pass before the second begins. Within the
//! margin nothing is missed; beyond it a distance from another column can be, and rows that wrap can make others. Both show
//! only in distances of more than the margin, so these are cut to margin + 1, which is never too far.

use crate::spec::Engine;

/// The largest distance that is told apart: 8 bits.
pub const FARTHEST: u8 = u8::MAX;

/// Two-input comparators of the circuit.
pub const COMPARATORS: usize = 6;

/// Registers behind comparators on the way of a triple.
const REGISTERED: usize = 4;

/// A line of registers with taps.
#[derive(Clone, Debug)]
struct ShiftRegister {
    words: Vec<u8>,
    next: usize,
}

impl ShiftRegister {
    fn new(length: usize) -> ShiftRegister {
        ShiftRegister {
            words: vec![FARTHEST; length.max(1)],
            next: 0,
        }
    }

    /// What went in `delay` clocks ago, 1 being the clock before.
    fn tap(&self, delay: usize) -> u8 {
        let n = self.words.len();
        self.words[(self.next + n - delay) % n]
    }

    fn shift(&mut self, word: u8) {
        self.words[self.next] = word;
        self.next = (self.next + 1) % self.words.len();
    }
}

/// The circuit for one plane size.
#[derive(Clone, Debug)]
pub struct DistanceEngine {
    columns: usize,
    rows: usize,
    output: ShiftRegister,
    /// Registers behind the two comparators of the triple, then the minima of triples, delayed.
    pair: u8,
    /// The third of the triple, one clock later, as the pair is.
    third: u8,
    triples: ShiftRegister,
    joined: [u8; 2],
    all: u8,
    /// Clocks so far.
    pub clocks: u64,
}

impl DistanceEngine {
    /// For planes of `columns` × `rows`, each with one for the outside.
    ///
    /// # Panics
    /// If there are fewer than five columns or two rows.
    pub fn new(columns: usize, rows: usize) -> DistanceEngine {
        assert!(
            columns > REGISTERED && rows >= 2,
            "a plane of {columns} × {rows} is too small"
        );
        DistanceEngine {
            columns,
            rows,
            output: ShiftRegister::new(4),
            pair: FARTHEST,
            third: FARTHEST,
            triples: ShiftRegister::new((rows + 1) * columns),
            joined: [FARTHEST; 2],
            all: FARTHEST,
            clocks: 0,
        }
    }

    /// One clock: `own` is what the voxel has (0 if it is not empty, the farthest or the distance of the first pass), none
    /// for the outside, which a gate behind the last comparator keeps farthest; what it gets.
    pub fn clock(&mut self, own: Option<u8>) -> u8 {
        self.clocks += 1;
        let (j, k) = (self.rows, self.columns);
        // Comparator 6 joins what only this clock knows.
        let nearest = self.all.min(self.output.tap(1));
        let distance = own.map_or(FARTHEST, |own| own.min(nearest.saturating_add(1)));

        // The clock edge, from the last register to the first; a triple around delay c is taken
        // four clocks early, one for each register on its way.
        let triple = |c: usize| self.triples.tap(c - REGISTERED);
        let newest = self.third.min(self.pair);
        let joined = [
            triple(k).min(triple((j - 1) * k)),
            triple(j * k).min(triple((j + 1) * k)),
        ];
        self.all = self.joined[0].min(self.joined[1]);
        self.joined = joined;
        self.triples.shift(newest);
        self.pair = distance.min(self.output.tap(1));
        self.third = self.output.tap(2);
        self.output.shift(distance);
        distance
    }
}

/// Chessboard distances by two passes of the circuit, and the clocks that they take.
pub fn chessboard(dims: [usize; 3], empty: &[bool]) -> (Vec<u8>, u64) {
    let columns = (dims[0] + 1).max(REGISTERED + 1);
    let rows = (dims[1] + 1).max(2);
    let plane = columns * rows;
    let length = plane * dims[2];
    let place = |i: usize| {
        let (x, y, z) = (i % columns, i / columns % rows, i / plane);
        (x < dims[0] && y < dims[1]).then(|| x + dims[0] * (y + dims[1] * z))
    };
    let mut distance = vec![FARTHEST; empty.len()];
    let mut engine = DistanceEngine::new(columns, rows);
    for i in 0..length {
        let at = place(i);
        let word = engine.clock(at.map(|at| if empty[at] { FARTHEST } else { 0 }));
        if let Some(at) = at {
            distance[at] = word;
        }
    }
    let mut clocks = engine.clocks;
    // The second pass is fed backwards, with the registers preset again.
    let mut engine = DistanceEngine::new(columns, rows);
    for i in (0..length).rev() {
        let at = place(i);
        let word = engine.clock(at.map(|at| distance[at]));
        if let Some(at) = at {
            distance[at] = word;
        }
    }
    clocks += engine.clocks;
    (distance, clocks)
}

/// Chessboard distances, at most margin + 1, by a circuit with a plane of fixed size, and the clocks that it takes.
///
/// # Panics
/// If the margins leave nothing of the plane, or it is too small for the circuit.
pub fn in_columns(dims: [usize; 3], empty: &[bool], engine: Engine) -> (Vec<u8>, u64) {
    let [columns, rows, margin] = [engine.columns, engine.rows, engine.margin].map(|n| n as usize);
    let inner = [columns - 2 * margin, rows - 2 * margin];
    let farthest = (margin + 1).min(usize::from(FARTHEST)) as u8;
    let length = columns * rows * dims[2];
    let bases: Vec<[usize; 2]> = (0..dims[1])
        .step_by(inner[1])
        .flat_map(|y| (0..dims[0]).step_by(inner[0]).map(move |x| [x, y]))
        .collect();
    // Where a word of a column lies in the volume, and whether it is written.
    let place = |base: [usize; 2], i: usize| {
        let at = [i % columns, i / columns % rows];
        let [x, y] = [0, 1].map(|axis| (base[axis] + at[axis]).checked_sub(margin));
        let (x, y, z) = (x?, y?, i / (columns * rows));
        let is_written = (0..2).all(|axis| (margin..margin + inner[axis]).contains(&at[axis]));
        (x < dims[0] && y < dims[1]).then(|| (x + dims[0] * (y + dims[1] * z), is_written))
    };
    let mut clocks = 0;
    let mut first = vec![FARTHEST; empty.len()];
    for base in &bases {
        let mut engine = DistanceEngine::new(columns, rows);
        for i in 0..length {
            let at = place(*base, i);
            let word = engine.clock(at.map(|(at, _)| if empty[at] { FARTHEST } else { 0 }));
            if let Some((at, true)) = at {
                first[at] = word.min(farthest);
            }
        }
        clocks += engine.clocks;
    }
    let mut distance = vec![FARTHEST; empty.len()];
    for base in &bases {
        let mut engine = DistanceEngine::new(columns, rows);
        for i in (0..length).rev() {
            let at = place(*base, i);
            let word = engine.clock(at.map(|(at, _)| first[at]));
            if let Some((at, true)) = at {
                distance[at] = word.min(farthest);
            }
        }
        clocks += engine.clocks;
    }
    (distance, clocks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_circuit_finds_what_the_program_finds(
            nx in 1usize..12, ny in 1usize..9, nz in 1usize..9, seed in prop::collection::vec(0u8..25, 401),
        ) {
            let dims = [nx, ny, nz];
            let empty: Vec<bool> = (0..nx * ny * nz).map(|i| seed[(i * 3 + i / 11) % seed.len()] > 0).collect();
            let (got, clocks) = chessboard(dims, &empty);
            prop_assert_eq!(got, crate::distance::chessboard(dims, &empty));
            prop_assert_eq!(clocks as usize, 2 * (nx + 1).max(5) * (ny + 1).max(2) * nz);
        }

        /// Columns of any size: the distances of the program, cut to the margin and one.
        #[test]
        fn columns_are_exact_within_their_margin(
            nx in 1usize..24, ny in 1usize..18, nz in 1usize..7, seed in prop::collection::vec(0u8..60, 401),
            columns in 5u32..14, rows in 3u32..12, margin in 1u32..6,
        ) {
            let margin = margin.min((columns.min(rows) - 1) / 2);
            let dims = [nx, ny, nz];
            let empty: Vec<bool> = (0..nx * ny * nz).map(|i| seed[(i * 3 + i / 11) % seed.len()] > 0).collect();
            let (got, clocks) = in_columns(dims, &empty, Engine { columns, rows, margin, load_ms: 0 });
            let exact = crate::distance::chessboard(dims, &empty);
            let cut: Vec<u8> = exact.iter().map(|d| (*d).min(margin as u8 + 1)).collect();
            prop_assert_eq!(got, cut);
            let bases = nx.div_ceil((columns - 2 * margin) as usize) * ny.div_ceil((rows - 2 * margin) as usize);
            prop_assert_eq!(clocks as usize, 2 * bases * (columns * rows) as usize * nz);
        }
    }
}
