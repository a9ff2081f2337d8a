//! Shading by a reflectance map: direction of the gradient → face, two angles → table → bilinear interpolation
//! (document §6.7). Widths of fraction, divider and arctan are not in the document; here they are `widths.norm`.

use crate::fixed_point::{integer_sqrt, lerp};
use crate::spec::{Light, Look, Widths};
use glam::DVec3;
use std::f64::consts::FRAC_PI_4;

/// The table of a frame, and what leads into it.
#[derive(Clone, Debug)]
pub struct ReflectanceMap {
    norm: u32,
    index: u32,
    /// arctan(n / 2^norm), 2^(norm − 1) for 45°.
    arctan: Vec<u16>,
    /// Six faces of 2^index · 2^index cells; each word holds the four supports of a cell.
    cells: Vec<[u16; 4]>,
    /// What a sample without gradient reflects: unlit.
    flat: u32,
}

/// Where a gradient points: cell of the map and the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Direction {
    /// Axis of the largest component · 2, + 1 if it is negative.
    pub face: usize,
    /// Two angles from −45° (0) to 45° (2^norm − 1).
    pub angle: [u32; 2],
}

impl ReflectanceMap {
    /// For the lights of `look` and a view direction, all in voxel axes.
    pub fn new(
        look: &Look,
        norm: u32,
        index: u32,
        intensity: u32,
        axes: &ViewAxes,
    ) -> ReflectanceMap {
        let side = 1usize << index;
        let top = f64::from((1u32 << intensity) - 1);
        let support = |face: usize, c1: usize, c2: usize| {
            let tangent = |c: usize| ((2.0 * c as f64 / side as f64 - 1.0) * FRAC_PI_4).tan();
            let gradient = direction(face, tangent(c1), tangent(c2));
            (phong(look, axes, -gradient).clamp(0.0, 1.0) * top).round() as u16
        };
        let mut cells = Vec::with_capacity(6 * side * side);
        for face in 0..6 {
            for c2 in 0..side {
                for c1 in 0..side {
                    cells.push([
                        support(face, c1, c2),
                        support(face, c1 + 1, c2),
                        support(face, c1, c2 + 1),
                        support(face, c1 + 1, c2 + 1),
                    ]);
                }
            }
        }
        ReflectanceMap {
            norm,
            index,
            arctan: arctan(norm),
            cells,
            flat: (1 << intensity) - 1,
        }
    }

    /// A table as it was written: four supports of 8 bits a word, int0 lowest.
    pub(crate) fn of_words(widths: &Widths, words: &[u32]) -> ReflectanceMap {
        ReflectanceMap {
            norm: widths.norm,
            index: widths.reflectance_index,
            arctan: arctan(widths.norm),
            cells: words
                .iter()
                .map(|word| word.to_le_bytes().map(u16::from))
                .collect(),
            flat: (1 << widths.intensity) - 1,
        }
    }

    /// The table as it is written.
    pub(crate) fn to_words(&self) -> Vec<u32> {
        let word = |cell: &[u16; 4]| u32::from_le_bytes(cell.map(|support| support as u8));
        self.cells.iter().map(word).collect()
    }

    /// Bytes of the table, four per cell and 8 bits of intensity.
    pub fn words(&self) -> usize {
        self.cells.len()
    }

    /// Face and angles of a gradient; none if it is 0.
    #[inline(always)]
    pub fn direction(&self, gradient: [i32; 3]) -> Option<Direction> {
        let size = gradient.map(i32::unsigned_abs);
        let largest = size[0].max(size[1]).max(size[2]);
        if largest == 0 {
            return None;
        }
        // Without branches, which would be as unpredictable as surfaces are.
        let axis = usize::from(size[0] < largest) * (1 + usize::from(size[1] < largest));
        // A circuit shifts out common leading zeros and divides; the quotient is the same. Operands have less than 26 bits
        // and the quotient at most 15, so that a division in double precision never rounds up to the next whole number.
        let divisor = f64::from(largest);
        let scale = f64::from(1u32 << self.norm);
        let one = 1u32 << self.norm;
        let angle = |component: i32| {
            let norm = (f64::from(component.unsigned_abs()) * scale / divisor) as usize;
            let angle = i32::from(self.arctan[norm]);
            let turned = if component < 0 { -angle } else { angle };
            ((one / 2) as i32 + turned).min(one as i32 - 1) as u32
        };
        Some(Direction {
            face: 2 * axis + usize::from(gradient[axis] < 0),
            angle: [
                angle(gradient[(axis + 1) % 3]),
                angle(gradient[(axis + 2) % 3]),
            ],
        })
    }

    /// The light that a surface with this gradient reflects.
    #[inline(always)]
    pub fn reflect(&self, gradient: [i32; 3]) -> u32 {
        let Some(Direction { face, angle }) = self.direction(gradient) else {
            return self.flat;
        };
        let below = self.norm - self.index;
        let cell = |angle: u32| (angle >> below) as usize;
        let rest = |angle: u32| (angle & ((1 << below) - 1)) as i32;
        let at = (face << self.index | cell(angle[1])) << self.index | cell(angle[0]);
        let [a, b, c, d] = self.cells[at].map(i32::from);
        if below == 0 {
            return a as u32;
        }
        let low = lerp(a, b, rest(angle[0]), below);
        let high = lerp(c, d, rest(angle[0]), below);
        lerp(low, high, rest(angle[1]), below) as u32
    }
}

/// arctan(n / 2^norm), 2^(norm − 1) for 45°.
fn arctan(norm: u32) -> Vec<u16> {
    let one = 1u32 << norm;
    let half = f64::from(one / 2);
    (0..=one)
        .map(|n| ((f64::from(n) / f64::from(one)).atan() / FRAC_PI_4 * half).round() as u16)
        .collect()
}

/// The length of a gradient with `guard` fraction bits times `gain`: `data` bits, saturated.
#[inline]
pub fn length(gradient: [i32; 3], guard: u32, data: u32, gain: u32) -> u32 {
    let squared: u64 = gradient
        .iter()
        .map(|&g| (i64::from(g) * i64::from(g)) as u64)
        .sum();
    let length = (integer_sqrt(squared) * u64::from(gain)) >> guard;
    length.min((1 << data) - 1) as u32
}

/// The axes of a view in voxels: unit vectors to the right, into the picture, and up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewAxes {
    /// To the right.
    pub right: DVec3,
    /// Into the picture.
    pub forward: DVec3,
    /// Up.
    pub up: DVec3,
}

impl ViewAxes {
    /// The direction towards a light, in voxel axes.
    fn towards(&self, light: &Light) -> DVec3 {
        let [x, y, z] = light.direction;
        (self.right * x + self.forward * y + self.up * z).normalize()
    }
}

/// The vector of a face with these tangents, normalised.
fn direction(face: usize, t1: f64, t2: f64) -> DVec3 {
    let axis = face / 2;
    let mut v = [0.0; 3];
    v[axis] = if face % 2 == 1 { -1.0 } else { 1.0 };
    v[(axis + 1) % 3] = t1;
    v[(axis + 2) % 3] = t2;
    DVec3::from_array(v).normalize()
}

/// Phong's model for one view direction and parallel lights; `normal` points out of the material.
pub fn phong(look: &Look, axes: &ViewAxes, normal: DVec3) -> f64 {
    let [ambient, diffuse, specular] = look.phong;
    let to_eye = -axes.forward;
    let mut sum = ambient;
    for light in &look.lights {
        let to_light = axes.towards(light);
        let cosine = normal.dot(to_light);
        if cosine > 0.0 {
            let reflected = 2.0 * cosine * normal - to_light;
            let highlight = reflected.dot(to_eye).max(0.0).powf(look.shininess);
            sum += light.intensity * (diffuse * cosine + specular * highlight);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn axes() -> ViewAxes {
        ViewAxes {
            right: DVec3::X,
            forward: DVec3::Y,
            up: DVec3::Z,
        }
    }

    #[test]
    fn the_documents_map_has_one_and_a_half_kilobytes() {
        let map = ReflectanceMap::new(&Look::default(), 8, 3, 8, &axes());
        assert_eq!(map.words() * 4, 1536);
        assert_eq!(map.reflect([0; 3]), 255);
    }

    proptest! {
        /// Angles against arctan of real numbers; the fourth decimal would need more bits.
        #[test]
        fn directions_are_those_of_real_numbers(g in prop::array::uniform3(-255i32..256)) {
            let map = ReflectanceMap::new(&Look::default(), 8, 3, 8, &axes());
            prop_assume!(g != [0; 3]);
            let Direction { face, angle } = map.direction(g).unwrap();
            let axis = face / 2;
            let size = g.map(|c| f64::from(c).abs());
            prop_assert!(size.iter().all(|s| *s <= size[axis]));
            prop_assert_eq!(face % 2 == 1, g[axis] < 0);
            for (i, angle) in angle.into_iter().enumerate() {
                let exact = (f64::from(g[(axis + 1 + i) % 3]) / size[axis]).atan() / FRAC_PI_4;
                let got = (f64::from(angle) - 128.0) / 128.0;
                prop_assert!((got - exact).abs() <= 2.0 / 128.0, "{} for {}", got, exact);
            }
        }

        /// The whole unit against Phong's formula: how far apart is a matter of the number of supports.
        #[test]
        fn light_is_that_of_the_formula(g in prop::array::uniform3(-4000i32..4001)) {
            let look = Look { shininess: 4.0, ..Look::default() };
            let length = DVec3::from_array(g.map(f64::from)).length();
            prop_assume!(length > 100.0);
            let exact = phong(&look, &axes(), -DVec3::from_array(g.map(f64::from)) / length).min(1.0) * 255.0;
            for (index, norm, bound) in [(3, 8, 14.0), (4, 8, 8.0), (6, 12, 3.0)] {
                let map = ReflectanceMap::new(&look, norm, index, 8, &axes());
                let got = f64::from(map.reflect(g));
                prop_assert!((got - exact).abs() <= bound, "{} bits: {} for {}", index, got, exact);
            }
        }

        #[test]
        fn lengths_are_those_of_real_numbers(g in prop::array::uniform3(-255i32..256)) {
            let exact = DVec3::from_array(g.map(f64::from)).length();
            let got = f64::from(length(g, 0, 8, 1));
            prop_assert!((got - exact.min(255.0)).abs() <= 1.0);
        }
    }
}
