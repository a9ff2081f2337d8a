//! The eight data buses: the voxel that each module delivers for a cell, 0 where the address is not valid.

/// Classified (or cut) voxels as they arrive from the tables on the buses.
#[derive(Clone, Debug)]
pub struct Voxels {
    dims: [i32; 3],
    words: Vec<u16>,
}

impl Voxels {
    /// `words` with x fastest.
    ///
    /// # Panics
    /// If there is not one word per voxel.
    pub fn new(dims: [usize; 3], words: Vec<u16>) -> Voxels {
        assert_eq!(words.len(), dims.iter().product::<usize>());
        Voxels {
            dims: dims.map(|n| n as i32),
            words,
        }
    }

    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims.map(|n| n as usize)
    }

    /// All words, x fastest.
    pub fn words(&self) -> &[u16] {
        &self.words
    }

    /// Whether all eight neighbours of a cell exist.
    #[inline(always)]
    pub fn is_inside(&self, cell: [i32; 3]) -> bool {
        (cell[0] as u32) < (self.dims[0] - 1) as u32
            && (cell[1] as u32) < (self.dims[1] - 1) as u32
            && (cell[2] as u32) < (self.dims[2] - 1) as u32
    }

    /// The word at a voxel, 0 outside.
    #[inline]
    pub fn word(&self, [x, y, z]: [i32; 3]) -> u16 {
        let [nx, ny, nz] = self.dims;
        let is_valid = x >= 0 && y >= 0 && z >= 0 && x < nx && y < ny && z < nz;
        match is_valid {
            true => self.words[x as usize + nx as usize * (y as usize + ny as usize * z as usize)],
            false => 0,
        }
    }

    /// What the modules A … H (bits z, y, x) deliver for the cell at `cell`, whose lowest bits are `lowest`: a module
    /// with bit b on an axis holds the neighbour on the + side where b differs from the lowest bit.
    #[inline(always)]
    pub fn modules(&self, cell: [i32; 3], lowest: [i32; 3]) -> [i32; 8] {
        let [x, y, z] = cell;
        let [lx, ly, lz] = lowest;
        let xs = [x + lx, x + (1 - lx)];
        let ys = [y + ly, y + (1 - ly)];
        let zs = [z + lz, z + (1 - lz)];
        if self.is_inside(cell) {
            let nx = self.dims[0] as usize;
            let plane = nx * self.dims[1] as usize;
            let xs = xs.map(|x| x as usize);
            let ys = ys.map(|y| y as usize * nx);
            let zs = zs.map(|z| z as usize * plane);
            let word = |m: usize| i32::from(self.words[xs[m & 1] + ys[m >> 1 & 1] + zs[m >> 2]]);
            [
                word(0),
                word(1),
                word(2),
                word(3),
                word(4),
                word(5),
                word(6),
                word(7),
            ]
        } else {
            let word = |m: usize| i32::from(self.word([xs[m & 1], ys[m >> 1 & 1], zs[m >> 2]]));
            [
                word(0),
                word(1),
                word(2),
                word(3),
                word(4),
                word(5),
                word(6),
                word(7),
            ]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_module_delivers_the_neighbour_with_its_lowest_bits(
            x in -3i32..7, y in -3i32..6, z in -3i32..5,
        ) {
            let dims = [5, 4, 3];
            let voxels = Voxels::new(dims, (1..=60).collect());
            let lowest = [x & 1, y & 1, z & 1];
            let modules = voxels.modules([x, y, z], lowest);
            for corner in 0..8usize {
                let at = [x + (corner & 1) as i32, y + (corner >> 1 & 1) as i32, z + (corner >> 2) as i32];
                let module = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
                prop_assert_eq!(modules[module as usize], i32::from(voxels.word(at)));
            }
        }
    }
}
