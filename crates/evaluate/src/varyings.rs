//! What the fragment stage is given: where its pixel lies, and what the vertex stage has said, between the
//! corners of the triangle.

use crate::code::{BLOCK, Code, LANES, Lanes};
use crate::error::Error;
use crate::machine::{Component, Machine};
use naga::{Binding, BuiltIn, Interpolation, ScalarKind};

/// Corners of the triangle that covers what is drawn.
const CORNERS: usize = 3;

/// Where each scalar of the fragment stage comes from, for every instance that is drawn.
#[derive(Debug)]
pub struct Inputs {
    sources: Vec<Source>,
    triangles: Vec<Triangle>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// A part of the pixel's place.
    Place(usize),
    /// A scalar of the vertex stage, and how it gets here.
    Varying(usize, Interpolation),
}

/// What the vertex stage gives for one instance.
#[derive(Clone, Debug, Default)]
struct Triangle {
    /// In pixels of what is drawn, from its upper left end, and the number that perspective divides by.
    places: [[f64; 3]; CORNERS],
    /// The bits of each scalar at the corners.
    bits: Vec<[u32; CORNERS]>,
}

impl Inputs {
    /// What fragment entry point `entry` gets over `size` pixels in each of so many instances.
    pub fn of(
        machine: &Machine,
        entry: &str,
        instances: u32,
        size: [u32; 2],
    ) -> Result<Inputs, Error> {
        let inputs = machine.inputs(entry)?;
        let is_place =
            |c: &Component| matches!(c.binding, Some(Binding::BuiltIn(BuiltIn::Position { .. })));
        if inputs.iter().all(is_place) {
            return Ok(Inputs {
                sources: (0..inputs.len()).map(Source::Place).collect(),
                triangles: Vec::new(),
            });
        }
        let not_covered = |what: String, function: &str| Error::NotCovered {
            what,
            function: function.to_owned(),
        };
        let lanes = CORNERS * instances as usize;
        let mut arguments = Vec::new();
        for input in machine.inputs("vertex")? {
            let number = match input.binding {
                Some(Binding::BuiltIn(BuiltIn::VertexIndex)) => |lane: usize| lane % CORNERS,
                Some(Binding::BuiltIn(BuiltIn::InstanceIndex)) => |lane: usize| lane / CORNERS,
                _ => {
                    return Err(not_covered(
                        format!("input {} of vertices", input.name),
                        "vertex",
                    ));
                }
            };
            arguments.push(
                (0..lanes)
                    .map(|lane| number(lane) as u32)
                    .collect::<Vec<_>>(),
            );
        }
        let arguments: Vec<_> = arguments.iter().map(Vec::as_slice).collect();
        let results = machine.call("vertex", lanes, &arguments)?;
        let outputs = machine.outputs("vertex")?;
        let place: Vec<usize> = (0..outputs.len())
            .filter(|i| is_place(&outputs[*i]))
            .collect();
        let [x, y, _, w] = place[..] else {
            return Err(not_covered("vertex without a place".into(), "vertex"));
        };
        let mut sources = Vec::new();
        let mut scalars: Vec<usize> = Vec::new();
        for input in &inputs {
            let Some(Binding::Location {
                location,
                interpolation,
                ..
            }) = &input.binding
            else {
                if is_place(input) {
                    sources.push(Source::Place(input.part as usize));
                    continue;
                }
                return Err(not_covered(
                    format!("input {} of pixels", input.name),
                    entry,
                ));
            };
            let same = |output: &Component| {
                matches!(&output.binding, Some(Binding::Location { location: l, .. }) if l == location)
                    && output.part == input.part
            };
            let Some(scalar) = outputs.iter().position(same) else {
                let what = format!(
                    "input {} of pixels without an output of vertices",
                    input.name
                );
                return Err(not_covered(what, entry));
            };
            let how = match input.kind {
                ScalarKind::Float => interpolation.unwrap_or(Interpolation::Perspective),
                _ => Interpolation::Flat,
            };
            if !matches!(
                how,
                Interpolation::Perspective | Interpolation::Linear | Interpolation::Flat
            ) {
                return Err(not_covered(format!("interpolation {how:?}"), entry));
            }
            sources.push(Source::Varying(scalars.len(), how));
            scalars.push(scalar);
        }
        let [width, height] = size.map(f64::from);
        let triangles = (0..instances as usize).map(|instance| {
            let corner =
                |scalar: usize, corner: usize| results.scalars[scalar][CORNERS * instance + corner];
            Triangle {
                places: std::array::from_fn(|c| {
                    let [x, y, w] = [x, y, w].map(|s| f64::from(f32::from_bits(corner(s, c))));
                    [(x / w + 1.0) / 2.0 * width, (1.0 - y / w) / 2.0 * height, w]
                }),
                bits: (scalars.iter())
                    .map(|scalar| std::array::from_fn(|c| corner(*scalar, c)))
                    .collect(),
            }
        });
        Ok(Inputs {
            triangles: triangles.collect(),
            sources,
        })
    }

    /// Puts the inputs of a block of pixels in one instance where `code` expects them.
    pub fn set(
        &self,
        instance: usize,
        [left, top]: [usize; 2],
        code: &Code,
        registers: &mut [Lanes],
    ) {
        let place = |lane: usize| {
            let (x, y) = (lane % BLOCK, lane / BLOCK);
            [(left + x) as f32 + 0.5, (top + y) as f32 + 0.5, 0.0, 1.0]
        };
        let triangle = self.triangles.get(instance);
        let shares: Option<[[f64; CORNERS]; LANES]> = triangle.map(|triangle| {
            std::array::from_fn(|lane| {
                let [x, y, ..] = place(lane);
                triangle.shares([f64::from(x), f64::from(y)])
            })
        });
        for (register, source) in code.inputs.iter().zip(&self.sources) {
            let register = &mut registers[*register as usize];
            match (source, triangle, &shares) {
                (Source::Place(part), ..) => {
                    *register = Lanes(std::array::from_fn(|lane| place(lane)[*part].to_bits()));
                }
                (Source::Varying(scalar, how), Some(triangle), Some(shares)) => {
                    let bits = triangle.bits[*scalar];
                    *register = Lanes(std::array::from_fn(|lane| {
                        triangle.between(bits, *how, &shares[lane])
                    }));
                }
                _ => {}
            }
        }
    }
}

impl Triangle {
    /// How much each corner counts at a place of the picture.
    fn shares(&self, [x, y]: [f64; 2]) -> [f64; CORNERS] {
        let [a, b, c] = self.places;
        let area = |p: [f64; 3], q: [f64; 3], [x, y]: [f64; 2]| {
            (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
        };
        let all = area(a, b, [c[0], c[1]]);
        [(b, c), (c, a), (a, b)].map(|(p, q)| area(p, q, [x, y]) / all)
    }

    fn between(&self, bits: [u32; CORNERS], how: Interpolation, shares: &[f64; CORNERS]) -> u32 {
        let values = bits.map(|bits| f64::from(f32::from_bits(bits)));
        let value = match how {
            Interpolation::Perspective => {
                let (mut sum, mut weights) = (0.0, 0.0);
                for ((share, place), value) in shares.iter().zip(&self.places).zip(values) {
                    sum += share / place[2] * value;
                    weights += share / place[2];
                }
                sum / weights
            }
            Interpolation::Linear => shares.iter().zip(values).map(|(s, v)| s * v).sum(),
            // The first corner's, whatever it is.
            _ => return bits[0],
        };
        (value as f32).to_bits()
    }
}
