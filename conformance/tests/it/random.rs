//! Random volumes and Plans: everything that docs/plan.md allows, in small.
//!
//! From a fixed list of seeds, so that every run of the suite tests the same; with
//! `STRAHL_CONFORMANCE_CASES=20000` it looks further.

use crate::simple;
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot, Vec3Swizzles};
use strahl_conformance::{Renderer, renderers};
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_volume::{Grid, Metadata, Rescale, Sample, SampleType, Samples, Volume};

/// The seeds to test: `usual` many, or as the environment says.
pub fn seeds(usual: u64) -> std::ops::Range<u64> {
    let cases = std::env::var("STRAHL_CONFORMANCE_CASES").ok();
    0..cases.map_or(usual, |n| n.parse().expect("a number of cases"))
}

/// The renderers that draw the scene of a seed.
pub fn renderers_of(seed: u64) -> Vec<Renderer> {
    let mut all = renderers();
    all.retain(|renderer| seed.is_multiple_of(renderer.one_in));
    all
}

/// G. Steele's SplitMix64.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        // Seeds mixed once: neighboring ones would give the same numbers, shifted by one.
        Random(Random(seed).bits())
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// 0 to n − 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Once in `n`.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)))
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector();
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> DMat3 {
        let angles = self.vector() * std::f64::consts::PI;
        DMat3::from_quat(DQuat::from_euler(
            EulerRot::XYZ,
            angles.x,
            angles.y,
            angles.z,
        ))
    }

    /// Oblique, sheared, mirrored, uneven, anywhere.
    fn grid(&mut self) -> Grid {
        let dims = match self.below(8) {
            0 => [1; 3],
            1 => [1, 1 + self.below(12), 1],
            2 => [1 + self.below(20), 1, 1 + self.below(12)],
            _ => std::array::from_fn(|_| 1 + self.below(22)),
        };
        let scale = 10f64.powf(self.between(-3.0, 3.0));
        let spacing = DVec3::from_array(std::array::from_fn(|_| scale * self.between(0.4, 2.5)));
        let mut axes = DMat3::from_diagonal(spacing);
        if !self.once_in(3) {
            let mut shear = DMat3::IDENTITY;
            shear.y_axis.x = self.between(-0.7, 0.7);
            shear.z_axis.x = self.between(-0.7, 0.7);
            shear.z_axis.y = self.between(-0.7, 0.7);
            axes = self.rotation() * shear * axes;
        }
        if self.once_in(3) {
            axes.x_axis = -axes.x_axis;
        }
        let translation = self.vector() * scale * 100.0;
        Grid::new(dims, DAffine3::from_mat3_translation(axes, translation)).unwrap()
    }

    fn samples(&mut self, dims: [usize; 3]) -> Samples {
        let sample_type = self.pick(&SampleType::ALL);
        let (lo, hi) = match sample_type {
            SampleType::U8 => (0.0, 255.0),
            SampleType::I8 => (-128.0, 127.0),
            SampleType::U16 => (0.0, 4095.0),
            SampleType::I16 => (-1024.0, 3071.0),
            SampleType::U32 => (4_294_900_000.0, 4_294_967_295.0),
            SampleType::I32 => (-2e9, 2e9),
            SampleType::F32 | SampleType::F64 => (-1.0, 1.0),
        };
        let broken = !sample_type.is_integer() && self.once_in(2);
        // Noise, blobs in emptiness (so that there is something to skip), a wave.
        let kind = self.below(3);
        let center: [f64; 3] = std::array::from_fn(|a| self.unit() * dims[a] as f64);
        let wave = self.vector();
        let mut values = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let place = DVec3::new(x as f64, y as f64, z as f64);
                    let share = match kind {
                        0 => self.unit(),
                        1 => {
                            let r = place.distance(DVec3::from_array(center));
                            (1.0 - r / 5.0).clamp(0.0, 1.0)
                        }
                        _ => 0.5 + 0.5 * place.dot(wave).sin(),
                    };
                    let value = lo + share * (hi - lo);
                    values.push(if broken && self.once_in(60) {
                        self.pick(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300])
                    } else {
                        value
                    });
                }
            }
        }
        fn stored<T: Sample>(values: Vec<f64>) -> Samples {
            T::wrap(values.into_iter().map(T::from_f64).collect())
        }
        match sample_type {
            SampleType::U8 => stored::<u8>(values),
            SampleType::I8 => stored::<i8>(values),
            SampleType::U16 => stored::<u16>(values),
            SampleType::I16 => stored::<i16>(values),
            SampleType::U32 => stored::<u32>(values),
            SampleType::I32 => stored::<i32>(values),
            SampleType::F32 => stored::<f32>(values),
            SampleType::F64 => stored::<f64>(values),
        }
    }

    /// A small volume of any type on any grid; floats may hold NaN and infinities.
    pub fn volume(&mut self) -> Volume {
        let grid = self.grid();
        let samples = self.samples(grid.dims());
        let rescale = match self.below(3) {
            0 => Rescale::new(self.between(-3.0, 3.0), self.between(-1000.0, 1000.0)),
            _ => Rescale::IDENTITY,
        };
        Volume::new(grid, samples, rescale, Metadata::default()).unwrap()
    }

    fn camera(&mut self, grid: &Grid) -> PlanCamera {
        let (lo, hi) = grid.bounds_mm();
        let size = hi.distance(lo);
        let target = grid.center_mm() + self.vector() * 0.1 * size;
        let axis_aligned = self.once_in(4);
        let forward = if axis_aligned {
            self.pick(&[DVec3::X, -DVec3::Y, DVec3::Z])
        } else {
            self.direction()
        };
        // Sometimes from inside the volume.
        let distance = size * self.pick(&[0.05, 0.8, 1.5, 4.0]);
        let right = forward.cross(if axis_aligned {
            forward.zxy()
        } else {
            self.direction()
        });
        let right = right.normalize();
        let projection = if self.once_in(2) {
            Projection::Perspective {
                tan_half_height: self.between(0.1, 0.4) * size / distance.max(0.5 * size),
            }
        } else {
            Projection::Orthographic {
                half_height_mm: self.between(0.1, 0.35) * size,
            }
        };
        PlanCamera {
            eye_mm: target - forward * distance,
            right,
            up: right.cross(forward).normalize(),
            forward,
            projection,
        }
    }

    /// A table over about the range of the volume: few entries or many, soft or with peaks one entry wide.
    fn table(&mut self, range: [f64; 2], reference_mm: f64) -> TransferTable {
        let width = (range[1] - range[0]).max(1e-6 * range[0].abs()).max(1e-6);
        let lo = range[0] + self.between(-0.3, 0.4) * width;
        let hi = lo + self.between(0.3, 1.2) * width;
        let (lo, hi) = (lo as f32, (hi as f32).max((lo as f32).next_up()));
        let number = self.pick(&[2, 3, 17, 256, 4096]);
        let peaks = self.once_in(2);
        let strength = self.pick(&[0.05, 0.5, 1.0]);
        let mut entries = Vec::new();
        for i in 0..number {
            let share = i as f64 / (number - 1) as f64;
            let opacity = match (peaks, number > 16) {
                (true, true) => f64::from(u8::from(self.once_in(number / 8))),
                (true, false) => f64::from(u8::from(self.once_in(2))),
                (false, _) => (share * 1.5 - 0.5).max(0.0),
            };
            entries.push([
                share as f32,
                (1.0 - share) as f32,
                if peaks { self.unit() as f32 } else { 0.3 },
                (opacity * strength) as f32,
            ]);
        }
        TransferTable::new([lo, hi], reference_mm as f32, entries)
    }

    /// Any rule of sampling that `plan` may have.
    pub fn sampling(&mut self, plan: &Plan) -> Sampling {
        let parts = self.pick(&[1, 2, 3, 8]);
        if matches!(
            plan.technique().composite,
            Composite::Mip | Composite::Minip
        ) && self.once_in(2)
        {
            return Sampling::Refine { parts };
        }
        if !matches!(
            plan.technique().composite,
            Composite::EmissionAbsorption { .. }
        ) {
            return Sampling::Regular;
        }
        let curve = self.pick(&[Curve::Linear, Curve::Cubic]);
        let of_table = plan.technique().classify == Classify::Table && self.once_in(3);
        if of_table && self.once_in(2) {
            return Sampling::ByOpacity {
                share: self.pick(&[0.01, 0.15, 1.0]),
            };
        }
        match self.below(if plan.technique().shade == Shade::Unlit {
            3
        } else {
            2
        }) {
            _ if of_table => Sampling::Integrated,
            0 => Sampling::Refine { parts },
            1 => Sampling::Split { parts, curve },
            _ => Sampling::Adaptive {
                error: self.pick(&[0.001, 0.05, 0.5]),
            },
        }
    }

    /// A clip by any shape somewhere in `grid`; as a mask the volume that is given, which may lie anywhere.
    pub fn sample_clip(&mut self, grid: &Grid, mask: &Volume) -> SampleClip {
        let shapes = [ClipShape::Box, ClipShape::Ellipsoid, ClipShape::Cylinder];
        let (lo, hi) = grid.bounds_mm();
        let placed = |random: &mut Random, size: f64| {
            let edges = DVec3::from_array(std::array::from_fn(|_| random.between(0.2, size)));
            let axes = random.rotation() * DMat3::from_diagonal(edges * hi.distance(lo));
            let center = grid.center_mm() + random.vector() * 0.3 * hi.distance(lo);
            DAffine3::from_mat3_translation(axes, center).inverse()
        };
        let is_mask = self.once_in(2);
        let (shape, unit_from_world) = if is_mask {
            let [lowest, highest] = mask.statistics().range;
            let share = self.pick(&[0.0, 0.2, 0.5, 0.9]);
            let shape = ClipShape::Mask {
                mask: 0,
                threshold: (lowest + (highest - lowest) * share) as f32,
            };
            // Where it is, or with a cell on every cell of the volume, or anywhere.
            let (first, last) = grid.extent_in_voxels();
            let of_volume = DAffine3::from_mat3_translation(
                DMat3::from_diagonal(last - first),
                0.5 * (first + last),
            );
            let fitted = (grid.world_from_voxel() * of_volume).inverse();
            (
                shape,
                if self.once_in(2) {
                    fitted
                } else {
                    placed(self, 1.5)
                },
            )
        } else {
            (self.pick(&shapes), placed(self, 0.8))
        };
        SampleClip {
            shape,
            unit_from_world,
            keep_inside: self.once_in(2),
            layers: ALL_LAYERS,
        }
    }

    fn lights(&mut self, grid: &Grid) -> Vec<PlanLight> {
        let (lo, hi) = grid.bounds_mm();
        let size_mm = hi.distance(lo);
        let radiance = |random: &mut Random| std::array::from_fn(|_| random.unit() as f32);
        let mut lights = Vec::new();
        for _ in 0..self.below(4) {
            lights.push(if self.once_in(3) {
                PlanLight::Head {
                    radiance: radiance(self),
                }
            } else if self.once_in(3) {
                // Outside the volume, and no brighter anywhere in it than its radiance.
                let away_mm = self.between(0.7, 3.0) * size_mm;
                PlanLight::Point {
                    place_mm: grid.center_mm() + away_mm * self.direction(),
                    reach_mm: (away_mm - 0.5 * size_mm) as f32,
                    radiance: radiance(self),
                }
            } else {
                PlanLight::Directional {
                    to_light: self.direction(),
                    radiance: radiance(self),
                }
            });
        }
        lights
    }

    /// Any Plan of `volume`, `size` pixels.
    pub fn plan(&mut self, volume: &Volume, size: [u32; 2]) -> Plan {
        let grid = *volume.grid();
        let range = volume.statistics().range;
        // `resolve` refuses volumes with values as large as 1e300.
        let usual = range.iter().all(|end| end.abs() < 1e15);
        let range = if usual { range } else { [-1.0, 1.0] };
        let inside = self.between(range[0], range[1]);
        let composite = match self.below(8) {
            0 => Composite::Mip,
            1 => Composite::Minip,
            2 => Composite::Average,
            3 | 4 => Composite::FirstHit {
                threshold: inside as f32,
            },
            _ => Composite::EmissionAbsorption {
                stop_at_transmittance: self.pick(&[0.0, 1.0 / 256.0, 0.1]),
            },
        };
        let surface = matches!(
            composite,
            Composite::EmissionAbsorption { .. } | Composite::FirstHit { .. }
        );
        let lit = surface && !self.once_in(3);
        let shade = if lit && self.once_in(4) {
            Shade::Lit {
                ambient: self.unit() as f32,
                illuminate: Illuminate::Lambert {
                    diffuse: self.unit() as f32,
                },
                keep_last_normal: false,
            }
        } else if lit {
            simple::blinn_phong(
                self.unit() as f32,
                self.unit() as f32,
                self.pick(&[0.0, 0.4]),
                self.pick(&[1.0, 10.0, 60.0]),
            )
        } else {
            Shade::Unlit
        };
        let lights = if lit { self.lights(&grid) } else { Vec::new() };
        let (lo, hi) = grid.bounds_mm();
        let size_mm = hi.distance(lo);
        let mut ray_clips = Vec::new();
        let mut sample_clips = Vec::new();
        if self.once_in(5) {
            for _ in 0..1 + self.below(2) {
                let normal = self.direction();
                let through = grid.center_mm() + self.vector() * 0.3 * size_mm;
                ray_clips.push(simple::plane(normal, -normal.dot(through)));
            }
        }
        if self.once_in(5) {
            for _ in 0..1 + self.below(2) {
                let edges = DVec3::from_array(std::array::from_fn(|_| self.between(0.2, 0.6)));
                let axes = self.rotation() * DMat3::from_diagonal(edges * size_mm);
                let center = grid.center_mm() + self.vector() * 0.2 * size_mm;
                sample_clips.push(simple::cut_box(
                    DAffine3::from_mat3_translation(axes, center).inverse(),
                    self.once_in(2),
                ));
            }
        }
        let step_mm = grid.min_spacing_mm() * self.pick(&[0.3, 0.6, 1.0, 1.7, 4.0]);
        let reference_mm = step_mm * self.pick(&[0.2, 1.0, 2.0, 10.0]);
        let camera = self.camera(&grid);
        let jitter = match self.below(2) {
            0 => Jitter::Center,
            _ => Jitter::Hash(self.below(1 << 32) as u32),
        };
        let reconstruct = self.pick(&[
            Reconstruct::Trilinear,
            Reconstruct::Trilinear,
            Reconstruct::Trilinear,
            Reconstruct::Nearest,
            Reconstruct::BSpline,
            Reconstruct::CatmullRom,
        ]);
        let table = self.table(range, reference_mm);
        let background = self.pick(&[[0.0; 4], [0.1, 0.2, 0.3, 1.0], [0.05, 0.0, 0.1, 0.5]]);
        let mut plan = Plan {
            width: size[0],
            height: size[1],
            lattice: Lattice {
                step_mm,
                jitter,
                frames: 1,
            },
            lights,
            ray_clips,
            sample_clips,
            background,
            ..simple::plan(volume, camera, table)
        };
        plan.field_mut().reconstruct = reconstruct;
        let technique = plan.technique_mut();
        (technique.shade, technique.composite) = (shade, composite);
        plan
    }
}
