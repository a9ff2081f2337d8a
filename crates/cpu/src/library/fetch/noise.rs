use super::shape::Shape;
use super::voxels::Fetch;
use crate::lanes::{F32s, I32s, each, lanes};
use crate::levels::Level;

/// Value noise: random numbers on a lattice, joined by cubics without overshoot (3t² − 2t³), each octave
/// of half the size and half the strength; 0 to 1.
pub struct Noise {
    pub shape: Shape,
    pub cell_voxels: f32,
    pub octaves: u32,
    pub seed: u32,
}

impl Noise {
    fn at(&self, voxel: [usize; 3]) -> f32 {
        let (mut sum, mut strength, mut total, mut cell) = (0.0, 1.0, 0.0, self.cell_voxels);
        for octave in 0..self.octaves {
            sum += strength
                * octave_at(
                    voxel.map(|v| v as f32 / cell),
                    self.seed.wrapping_add(octave),
                );
            total += strength;
            strength *= 0.5;
            cell *= 0.5;
        }
        sum / total
    }
}

fn octave_at(place: [f32; 3], seed: u32) -> f32 {
    let corner = place.map(f32::floor);
    let smooth = [0, 1, 2].map(|axis: usize| {
        let t = place[axis] - corner[axis];
        t * t * (3.0 - 2.0 * t)
    });
    let number = |dx: u32, dy: u32, dz: u32| {
        let [x, y, z] =
            [(0, dx), (1, dy), (2, dz)].map(|(a, d): (usize, u32)| corner[a] as u32 + d);
        random(x, y, z, seed)
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |dy, dz| mix(number(0, dy, dz), number(1, dy, dz), smooth[0]);
    let plane = |dz| mix(row(0, dz), row(1, dz), smooth[1]);
    mix(plane(0), plane(1), smooth[2])
}

/// A number in [0, 1) for a place on the lattice: C. Wellons' `lowbias32` of its coordinates.
fn random(x: u32, y: u32, z: u32, seed: u32) -> f32 {
    let mut h = x.wrapping_mul(0x9E37_79B1)
        ^ y.wrapping_mul(0x85EB_CA77)
        ^ z.wrapping_mul(0x27D4_EB2F)
        ^ seed.wrapping_mul(0xC2B2_AE3D);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7FEB_352D);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846C_A68B);
    h ^= h >> 16;
    (h >> 8) as f32 / 16_777_216.0
}

impl<S: Level> Fetch<S> for Noise {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Lane by lane.
    #[inline(never)]
    unsafe fn fetch(&self, voxel: [I32s<S>; 3]) -> F32s<S> {
        F32s::from_array(lanes(|i| {
            self.at(each!(voxel, |axis| axis.lane(i) as usize))
        }))
    }
}
