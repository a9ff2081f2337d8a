//! Colour and reflection by material (document §8.4): a table behind interpolation, and two reflectance maps, one for
//! diffuse light and one for highlights.

use crate::fixed_point::{scaled, whole};
use crate::spec::{Look, Material};
use crate::stages::shade::{ReflectanceMap, ViewAxes};

/// A row of the table: words of `widths.intensity` bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Row {
    color: [u32; 3],
    ambient: u32,
    diffuse: u32,
    specular: u32,
}

/// The table and the maps of a frame.
#[derive(Clone, Debug)]
pub struct Materials {
    rows: Vec<Row>,
    diffuse: ReflectanceMap,
    specular: ReflectanceMap,
    intensity: u32,
}

impl Materials {
    /// For words of `data` bits over `range`; none if the look names no materials.
    pub fn new(
        look: &Look,
        data: u32,
        range: [f64; 2],
        norm: u32,
        index: u32,
        intensity: u32,
        axes: &ViewAxes,
    ) -> Option<Materials> {
        if look.materials.is_empty() {
            return None;
        }
        let top = f64::from((1u32 << intensity) - 1);
        let words = f64::from((1u32 << data) - 1);
        let word = |share: f64| (share * top).round() as u32;
        let rows = (0..1u32 << data)
            .map(|entry| {
                let value = range[0] + (range[1] - range[0]) * f64::from(entry) / words;
                let m = between(&look.materials, value);
                Row {
                    color: m.color.map(word),
                    ambient: word(m.ambient),
                    diffuse: word(m.diffuse),
                    specular: word(m.specular),
                }
            })
            .collect();
        let map = |phong| {
            let look = Look {
                phong,
                ..look.clone()
            };
            ReflectanceMap::new(&look, norm, index, intensity, axes)
        };
        Some(Materials {
            rows,
            diffuse: map([0.0, 1.0, 0.0]),
            specular: map([0.0, 0.0, 1.0]),
            intensity,
        })
    }

    /// The light of a sample: C = ka + kd · Id · colour + ks · Is, saturated.
    pub fn reflect(&self, word: u16, gradient: [i32; 3]) -> [u32; 3] {
        let bits = self.intensity;
        let row = &self.rows[word as usize];
        let times = |a: u32, b: u32| scaled(a, whole(b, bits), bits);
        let diffuse = times(self.diffuse.reflect(gradient), row.diffuse);
        // Without a direction there is no highlight.
        let specular = match gradient {
            [0, 0, 0] => 0,
            _ => times(self.specular.reflect(gradient), row.specular),
        };
        row.color
            .map(|c| (row.ambient + times(diffuse, c) + specular).min((1 << bits) - 1))
    }
}

/// The material of a value: linear between those around it.
fn between(materials: &[Material], value: f64) -> Material {
    let next = materials.partition_point(|m| m.value <= value);
    let (a, b) = match next {
        0 => return materials[0],
        n if n == materials.len() => return materials[n - 1],
        n => (materials[n - 1], materials[n]),
    };
    let t = (value - a.value) / (b.value - a.value);
    let mix = |a: f64, b: f64| a + (b - a) * t;
    Material {
        value,
        color: std::array::from_fn(|i| mix(a.color[i], b.color[i])),
        ambient: mix(a.ambient, b.ambient),
        diffuse: mix(a.diffuse, b.diffuse),
        specular: mix(a.specular, b.specular),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::shade::phong;
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        /// Against the formula in real numbers.
        #[test]
        fn light_is_that_of_the_formula(g in prop::array::uniform3(-4000i32..4001), word in 0u16..256) {
            let length = DVec3::from_array(g.map(f64::from)).length();
            prop_assume!(length > 100.0);
            let material = |value, color| Material { value, color, ambient: 0.1, diffuse: 0.6, specular: 0.3 };
            let look = Look {
                materials: vec![material(0.0, [1.0, 0.2, 0.0]), material(255.0, [0.0, 0.4, 1.0])],
                shininess: 4.0,
                ..Look::default()
            };
            let axes = ViewAxes { right: DVec3::X, forward: DVec3::Y, up: DVec3::Z };
            let unit = Materials::new(&look, 8, [0.0, 255.0], 12, 6, 8, &axes).unwrap();
            let normal = -DVec3::from_array(g.map(f64::from)) / length;
            let light = |phong_shares| phong(&Look { phong: phong_shares, ..look.clone() }, &axes, normal).min(1.0);
            let (id, is) = (light([0.0, 1.0, 0.0]), light([0.0, 0.0, 1.0]));
            let t = f64::from(word) / 255.0;
            let got = unit.reflect(word, g);
            for (i, (a, b)) in [(1.0, 0.0), (0.2, 0.4), (0.0, 1.0)].into_iter().enumerate() {
                let exact = 255.0 * (0.1 + 0.6 * id * (a + (b - a) * t) + 0.3 * is).min(1.0);
                prop_assert!((f64::from(got[i]) - exact).abs() < 5.0, "{:?} for {}", got, exact);
            }
        }
    }
}
