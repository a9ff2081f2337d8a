//! Phantoms: fields with exact value and gradient everywhere, sampled at any resolution.
//!
//! ```
//! use strahl_volume::phantom::Phantom;
//! let shells = Phantom::from_name("shells").unwrap();
//! let volume = shells.volume([32, 32, 32])?;
//! let center = volume.grid().world_from_voxel().transform_point3(glam::DVec3::new(16.0, 16.0, 3.0));
//! // What is stored is the field at the voxel's center, to half a step of the stored type.
//! assert!((volume.value(16, 16, 3) - shells.value(center)).abs() <= 0.5 / 255.0);
//! # Ok::<(), strahl_volume::Error>(())
//! ```
//!
//! Formulas, parameters and sources: `docs/phantoms.md`.

mod analytic;
mod anatomy;
mod blocks;
mod modeling;
mod number;
mod random;
mod solid;
mod tree;

use crate::{
    Control, Error, Grid, Label, LabelVolume, Metadata, Modality, Rescale, Sample, Samples, Volume,
};
use anatomy::Anatomy;
use glam::{DAffine3, DMat3, DVec3};
use number::Dual;
use solid::Solid;

/// A field in world space (RAS mm) whose value and gradient are known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Phantom {
    /// Marschner and Lobb's test signal (f_M = 6, α = 0.25), 0 to 1.
    MarschnerLobb,
    /// Four nested shells with soft edges, 0 to 1.
    Shells,
    /// Twelve shells thinner than a voxel of the default grid, 0 to 1.
    ThinShells,
    /// Thin fog, 0 to below 0.1.
    Fog,
    /// A branching tree of soft-edged tubes, 0 to 1.
    Tree,
    /// |ψ|² of the 3d z² state of hydrogen, 0 to 1.
    Hydrogen,
    /// 100 + x + 2y + 4z.
    Ramp,
    /// A stylised head and neck in Hounsfield units, -1000 to 2900. The patient's left ear wears a ring.
    Anatomy,
}

impl Phantom {
    /// Every phantom.
    pub const ALL: [Phantom; 8] = [
        Phantom::MarschnerLobb,
        Phantom::Shells,
        Phantom::ThinShells,
        Phantom::Fog,
        Phantom::Tree,
        Phantom::Hydrogen,
        Phantom::Ramp,
        Phantom::Anatomy,
    ];

    /// The name of every phantom, in the order of [`Phantom::ALL`].
    pub const NAMES: [&str; Self::ALL.len()] = {
        let mut names = [""; Self::ALL.len()];
        let mut i = 0;
        while i < names.len() {
            names[i] = Self::ALL[i].name();
            i += 1;
        }
        names
    };

    /// The phantom called `name`, one of [`Phantom::NAMES`].
    pub fn from_name(name: &str) -> Option<Phantom> {
        Phantom::ALL.into_iter().find(|p| p.name() == name)
    }

    /// The name used on the command line and in scenes.
    pub const fn name(self) -> &'static str {
        match self {
            Phantom::MarschnerLobb => "marschner-lobb",
            Phantom::Shells => "shells",
            Phantom::ThinShells => "thin-shells",
            Phantom::Fog => "fog",
            Phantom::Tree => "tree",
            Phantom::Hydrogen => "hydrogen",
            Phantom::Ramp => "ramp",
            Phantom::Anatomy => "anatomy",
        }
    }

    /// One line for lists.
    pub const fn about(self) -> &'static str {
        match self {
            Phantom::MarschnerLobb => "Marschner and Lobb's test signal for reconstruction filters",
            Phantom::Shells => "four nested shells with soft edges",
            Phantom::ThinShells => "twelve shells thinner than a voxel",
            Phantom::Fog => "fog of very low opacity",
            Phantom::Tree => "a branching tree of tubes",
            Phantom::Hydrogen => "the 3d z² state of a hydrogen atom",
            Phantom::Ramp => "a linear ramp, different along each axis",
            Phantom::Anatomy => "a stylised head and neck as in a CT angiogram, with labels",
        }
    }

    /// The value at a point of the world. Defined everywhere, also outside [`Phantom::extent_mm`].
    pub fn value(&self, p_mm: DVec3) -> f64 {
        let p = p_mm.to_array();
        match self {
            Phantom::MarschnerLobb => analytic::marschner_lobb(p),
            Phantom::Shells => analytic::shells(p),
            Phantom::ThinShells => analytic::thin_shells(p),
            Phantom::Fog => analytic::fog(p),
            Phantom::Tree => tree::density(tree::solid(), p),
            Phantom::Hydrogen => analytic::hydrogen(p),
            Phantom::Ramp => analytic::ramp(p),
            Phantom::Anatomy => anatomy::hounsfield(Anatomy::whole(), p),
        }
    }

    /// The exact gradient per mm, by forward-mode differentiation of the same formula. Where the field has a
    /// kink (at single points and creases) it is that of one side.
    pub fn gradient(&self, p_mm: DVec3) -> DVec3 {
        let p = Dual::coordinates(p_mm);
        match self {
            Phantom::MarschnerLobb => analytic::marschner_lobb(p),
            Phantom::Shells => analytic::shells(p),
            Phantom::ThinShells => analytic::thin_shells(p),
            Phantom::Fog => analytic::fog(p),
            Phantom::Tree => tree::density(tree::solid(), p),
            Phantom::Hydrogen => analytic::hydrogen(p),
            Phantom::Ramp => analytic::ramp(p),
            Phantom::Anatomy => anatomy::hounsfield(Anatomy::whole(), p),
        }
        .gradient
    }

    /// The box that [`Phantom::volume`] samples: smallest and largest corner in mm.
    pub fn extent_mm(&self) -> (DVec3, DVec3) {
        let half = DVec3::splat(analytic::HALF_EDGE_MM);
        match self {
            Phantom::Anatomy => anatomy::EXTENT_MM,
            _ => (-half, half),
        }
    }

    /// The number of voxels (x, y, z) that shows the phantom well; cubic voxels.
    pub fn default_dims(&self) -> [usize; 3] {
        match self {
            Phantom::MarschnerLobb => [64; 3],
            Phantom::Ramp => [32; 3],
            // 1 mm.
            Phantom::Anatomy => [192, 240, 304],
            _ => [128; 3],
        }
    }

    /// The number of voxels for which the longest edge has `edge` voxels and voxels are as near to
    /// cubes as whole numbers allow.
    pub fn dims_for_edge(&self, edge: usize) -> [usize; 3] {
        let (lo, hi) = self.extent_mm();
        let size = hi - lo;
        let per_mm = edge as f64 / size.max_element();
        size.to_array()
            .map(|length| ((length * per_mm).round() as usize).max(1))
    }

    /// Where [`Phantom::volume`] puts its voxels: `dims` voxels that fill [`Phantom::extent_mm`],
    /// voxel axes along R, A, S.
    ///
    /// # Errors
    /// Dimensions as in [`Grid::new`].
    pub fn grid(&self, dims: [usize; 3]) -> Result<Grid, Error> {
        let (lo, hi) = self.extent_mm();
        let spacing_mm = (hi - lo) / DVec3::from_array(dims.map(|n| n.max(1) as f64));
        Grid::new(
            dims,
            DAffine3::from_mat3_translation(
                DMat3::from_diagonal(spacing_mm),
                lo + 0.5 * spacing_mm,
            ),
        )
    }

    /// The field at the centers of `dims` voxels that fill [`Phantom::extent_mm`], rounded to the
    /// nearest number of the stored type: i16 HU for `anatomy`, f32 for `marschner-lobb` and `ramp`,
    /// u16 with slope 1/65535 for `fog`, u8 with slope 1/255 for the others. The same bytes at any number of
    /// threads.
    ///
    /// # Errors
    /// Dimensions as in [`Grid::new`], or no memory for the samples.
    pub fn volume(&self, dims: [usize; 3]) -> Result<Volume, Error> {
        self.volume_under(dims, &Control::NONE)
    }

    /// The same under `control`, with its values counted.
    ///
    /// # Errors
    /// As [`Phantom::volume`]; it was cancelled.
    pub fn volume_under(&self, dims: [usize; 3], control: &Control) -> Result<Volume, Error> {
        let grid = self.grid(dims)?;
        let sample_bytes = match self {
            Phantom::MarschnerLobb | Phantom::Ramp => 4,
            Phantom::Fog | Phantom::Anatomy => 2,
            _ => 1,
        };
        control.has_room(sample_bytes * grid.voxel_count() as u64)?;
        let rescale = match self {
            Phantom::MarschnerLobb | Phantom::Ramp | Phantom::Anatomy => Rescale::IDENTITY,
            Phantom::Fog => Rescale::new(1.0 / 65535.0, 0.0),
            _ => Rescale::new(1.0 / 255.0, 0.0),
        };
        let samples = match self {
            Phantom::MarschnerLobb | Phantom::Ramp => {
                self.sample::<f32>(&grid, rescale, control)?
            }
            Phantom::Fog => self.sample::<u16>(&grid, rescale, control)?,
            Phantom::Anatomy => i16::wrap(blocks::fill(
                &grid,
                i16::from_f64(-1000.0),
                Anatomy::scratch,
                |bounds, head| Anatomy::whole().prune(bounds, head),
                |p, head| i16::from_f64(anatomy::hounsfield(head, p)),
                control,
            )?),
            Phantom::Tree => u8::wrap(blocks::fill(
                &grid,
                0,
                Solid::default,
                tree::prune,
                |p, branches| u8::from_f64(rescale.stored(tree::density(branches, p))),
                control,
            )?),
            _ => self.sample::<u8>(&grid, rescale, control)?,
        };
        let is_anatomy = *self == Phantom::Anatomy;
        let metadata = Metadata {
            name: self.name().to_owned(),
            format: "phantom".to_owned(),
            modality: Some(if is_anatomy {
                Modality::Ct
            } else {
                Modality::Simulation
            }),
            value_unit: is_anatomy.then(|| "HU".to_owned()),
            has_length_unit: true,
            time_points: 1,
            ..Metadata::default()
        };
        let volume = Volume::new(grid, samples, rescale, metadata)?;
        volume.statistics_under(control)?;
        Ok(volume)
    }

    /// The object that each voxel center lies in (u8), with names and colors; none for phantoms without
    /// parts, which are all but `anatomy`.
    ///
    /// # Errors
    /// As [`Phantom::volume`].
    pub fn labels(&self, dims: [usize; 3]) -> Result<Option<LabelVolume>, Error> {
        let grid = self.grid(dims)?;
        if *self != Phantom::Anatomy {
            return Ok(None);
        }
        let ids = blocks::fill(
            &grid,
            0u8,
            Anatomy::scratch,
            |bounds, head| Anatomy::whole().prune(bounds, head),
            |p, head| anatomy::tissue(head, p) as u8,
            &Control::NONE,
        )?;
        let labels = anatomy::TISSUES
            .iter()
            .map(|facts| Label {
                color: Some(facts.color.map(|c| f32::from(c) / 255.0)),
                ..Label::new(facts.tissue as u32, facts.name)
            })
            .collect();
        let volume = Volume::new(
            grid,
            Samples::U8(ids),
            Rescale::IDENTITY,
            Metadata::default(),
        )?;
        LabelVolume::from_volume(volume, labels).map(Some)
    }

    fn sample<T: Sample>(
        &self,
        grid: &Grid,
        rescale: Rescale,
        control: &Control,
    ) -> Result<Samples, Error> {
        let samples = blocks::fill(
            grid,
            T::from_f64(0.0),
            || (),
            |_, _| true,
            |p, _| T::from_f64(rescale.stored(self.value(DVec3::from_array(p)))),
            control,
        )?;
        Ok(T::wrap(samples))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    fn random_points(phantom: Phantom, count: usize) -> impl Iterator<Item = DVec3> {
        let (lo, hi) = phantom.extent_mm();
        let mut random = Random::new(7);
        std::iter::repeat_with(move || {
            DVec3::new(
                random.between(lo.x, hi.x),
                random.between(lo.y, hi.y),
                random.between(lo.z, hi.z),
            )
        })
        .take(count)
    }

    /// Largest value times the steepness of the soft edges, in which errors of gradients are counted.
    fn scale(phantom: Phantom) -> f64 {
        match phantom {
            Phantom::Ramp => 100.0,
            Phantom::Anatomy => 4000.0,
            _ => 1.0,
        }
    }

    /// Central differences of step h miss the derivative by h²/6 of the third derivative (thin shells: 90 per mm³, 1.5e-9),
    /// by rounding, 1e-16 · f / h = 1e-11, and where the second derivative jumps by J between the points, at the ends of a
    /// smoothstep, by h/4 · J, with J up to 6 / (2 · 0.9 mm)²: 5e-6.
    #[test]
    fn gradients_match_central_differences() {
        const H: f64 = 1e-5;
        for phantom in Phantom::ALL {
            let scale = scale(phantom);
            let (mut creases, mut steep, mut count) = (0, 0, 0);
            for p in random_points(phantom, 3000) {
                let gradient = phantom.gradient(p);
                let here = phantom.value(p);
                for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                    count += 1;
                    let after = phantom.value(p + axis * H) - here;
                    let before = here - phantom.value(p - axis * H);
                    // A second difference above the largest second derivative is a crease between the points.
                    if (after - before).abs() > 20.0 * scale * H * H {
                        creases += 1;
                        continue;
                    }
                    let central = (after + before) / (2.0 * H);
                    let error = (central - gradient.dot(axis)).abs();
                    assert!(error < 1e-5 * scale, "{phantom:?} at {p}: {error}");
                    steep += i32::from(gradient.dot(axis).abs() > 1e-4 * scale);
                }
            }
            assert!(creases * 200 <= count, "{phantom:?}: {creases} creases");
            assert!(steep > 30, "{phantom:?}: the points miss the field");
        }
    }

    #[test]
    fn known_values() {
        let at = |p: Phantom, x, y, z| p.value(DVec3::new(x, y, z));
        // ρ_r(0) = cos(12π) = 1, sin 0 = 0: (1 + 0.25 · 2) / 2.5.
        assert!((at(Phantom::MarschnerLobb, 0.0, 0.0, 0.0) - 0.6).abs() < 1e-12);
        // z = 1: sin(π/2) = 1; r = 1: ρ_r = cos(12π cos(π/2)) = 1: 0.5 / 2.5.
        assert!((at(Phantom::MarschnerLobb, 0.0, 50.0, 50.0) - 0.2).abs() < 1e-12);
        assert_eq!(at(Phantom::Shells, 0.0, 44.0, 0.0), 0.25);
        assert_eq!(at(Phantom::Shells, 11.0, 0.0, 0.0), 1.0);
        assert_eq!(at(Phantom::Shells, 0.0, 0.0, 0.0), 0.0);
        assert!((at(Phantom::Shells, 0.0, 0.0, -47.0) - 0.125).abs() < 1e-12);
        assert!((at(Phantom::ThinShells, 0.0, 0.0, 24.0) - 1.0).abs() < 1e-12);
        assert!(at(Phantom::ThinShells, 0.0, 0.0, 26.0) < 1e-12);
        assert_eq!(at(Phantom::Tree, 0.0, 0.0, -40.0), 1.0);
        assert_eq!(at(Phantom::Tree, 40.0, 0.0, -40.0), 0.0);
        assert!((at(Phantom::Hydrogen, 0.0, 0.0, 15.0) - 1.0).abs() < 1e-12);
        assert_eq!(at(Phantom::Hydrogen, 0.0, 0.0, 0.0), 0.0);
        // The cone on which 3 cos²θ = 1 holds no electron.
        assert!(at(Phantom::Hydrogen, 10.0, 10.0, 10.0) < 1e-12);
        assert_eq!(at(Phantom::Ramp, 1.0, 1.0, 1.0), 107.0);
    }

    #[test]
    fn values_stay_in_range() {
        for phantom in Phantom::ALL {
            let [lo, hi] = match phantom {
                Phantom::Ramp => [-250.0, 450.0],
                Phantom::Fog => [0.0, 0.1],
                Phantom::Anatomy => [-1000.0, 2900.0],
                _ => [0.0, 1.0],
            };
            for p in random_points(phantom, 20_000) {
                let value = phantom.value(p);
                // Mixing rounds.
                assert!(
                    value >= lo - 1e-9 && value <= hi + 1e-9,
                    "{phantom:?} at {p}: {value}"
                );
            }
        }
    }

    #[test]
    fn a_volume_holds_the_field_at_its_voxel_centers() {
        for phantom in Phantom::ALL {
            let volume = phantom.volume([9, 12, 7]).unwrap();
            let (lo, hi) = phantom.extent_mm();
            let (grid_lo, grid_hi) = volume.grid().bounds_mm();
            assert!(lo.distance(grid_lo) < 1e-9 && hi.distance(grid_hi) < 1e-9);
            let half_step = match volume.sample_type() {
                crate::SampleType::I16 => 0.5,
                crate::SampleType::F32 => 450.0 * f64::from(f32::EPSILON),
                _ => 0.5 * volume.rescale().slope,
            } + 1e-12;
            for (x, y, z) in [(0, 0, 0), (8, 11, 6), (4, 6, 3), (3, 2, 5)] {
                let voxel = DVec3::new(x as f64, y as f64, z as f64);
                let p = volume.grid().world_from_voxel().transform_point3(voxel);
                let error = (volume.value(x, y, z) - phantom.value(p)).abs();
                assert!(error <= half_step, "{phantom:?} {error}");
            }
        }
    }

    #[test]
    fn names_lead_back() {
        for (phantom, name) in Phantom::ALL.into_iter().zip(Phantom::NAMES) {
            assert_eq!(Phantom::from_name(name), Some(phantom));
        }
        assert_eq!(Phantom::from_name("engine"), None);
    }

    #[test]
    fn impossible_dimensions_are_errors() {
        assert!(Phantom::Ramp.volume([0, 1, 1]).is_err());
        assert!(Phantom::Ramp.volume([1 << 20, 1 << 20, 1 << 20]).is_err());
    }

    /// Every voxel of a volume is what `value` says there: leaving parts out per block changes nothing.
    #[test]
    fn pruned_blocks_have_the_same_bits() {
        let mut random = Random::new(3);
        let (mut head, mut branches) = (Anatomy::scratch(), Solid::default());
        let mut empty = 0;
        for _ in 0..1500 {
            let (lo, hi) = anatomy::EXTENT_MM;
            let at = |random: &mut Random| {
                DVec3::new(
                    random.between(lo.x, hi.x),
                    random.between(lo.y, hi.y),
                    random.between(lo.z, hi.z),
                )
            };
            let corner = at(&mut random);
            let edge = random.between(1.0, 16.0);
            let bounds = corner
                .to_array()
                .map(|c| number::Interval::new(c, c + edge));
            let head_there = Anatomy::whole().prune(bounds, &mut head);
            let branches_there = tree::prune(bounds, &mut branches);
            empty += i32::from(!head_there);
            for _ in 0..12 {
                let p = corner + edge * DVec3::new(random.unit(), random.unit(), random.unit());
                let whole = Phantom::Anatomy.value(p);
                let part = if head_there {
                    anatomy::hounsfield(&head, p.to_array())
                } else {
                    -1000.0
                };
                assert_eq!(whole.to_bits(), part.to_bits(), "{p} in {bounds:?}");
                let whole = Phantom::Tree.value(p);
                let part = if branches_there {
                    tree::density(&branches, p.to_array())
                } else {
                    0.0
                };
                assert_eq!(whole.to_bits(), part.to_bits(), "{p} in {bounds:?}");
            }
        }
        assert!((100..1000).contains(&empty), "{empty} boxes are empty");
    }

    /// Points in the middle of tissues have their values and labels, on the right side of the patient.
    #[test]
    fn tissues_are_where_they_belong() {
        use anatomy::Tissue::*;
        for (x, y, z, tissue, hu) in [
            (0.0, 125.0, 60.0, Air, -1000.0),
            (-95.0, -110.0, -167.0, Air, -1000.0),
            (32.0, 72.0, 17.0, Eyes, 12.0),
            (-32.0, 81.0, 17.0, Lenses, 85.0),
            (0.0, 19.0, -50.0, Airway, -1000.0),
            (27.0, 58.0, -16.0, Airway, -1000.0),
            (10.0, 0.0, 63.0, Ventricles, 5.0),
            (0.0, 50.0, -60.0, Muscle, 55.0),
            // The aneurysm and the earring are on the left only, that is at negative x.
            (-38.0, 29.0, 23.0, Aneurysm, 290.0),
            (-73.0, -4.5, -31.5, Earring, 2900.0),
            (73.0, -4.5, -31.5, Air, -1000.0),
        ] {
            let p = DVec3::new(x, y, z);
            assert_eq!(
                anatomy::tissue(Anatomy::whole(), p.to_array()),
                tissue,
                "{p}"
            );
            assert_eq!(Phantom::Anatomy.value(p), hu, "{p}");
        }
        let mirrored = anatomy::tissue(Anatomy::whole(), [38.0, 29.0, 23.0]);
        assert_ne!(mirrored, Aneurysm);
    }

    #[test]
    fn labels_name_every_tissue_once_and_show_each() {
        let labels = Phantom::Anatomy.labels([96, 120, 152]).unwrap().unwrap();
        let crate::LabelIds::U8(ids) = labels.ids() else {
            panic!("u8 ids")
        };
        for (i, (label, facts)) in labels.labels().iter().zip(&anatomy::TISSUES).enumerate() {
            assert_eq!(label.id as usize, i);
            assert_eq!(facts.tissue as usize, i);
            let count = ids.iter().filter(|&&id| u32::from(id) == label.id).count();
            assert!(count > 0, "{} is nowhere", label.name);
        }
        assert!(Phantom::Shells.labels([4, 4, 4]).unwrap().is_none());
    }

    /// What a label volume calls a tissue has that tissue's values: most voxels of a label lie within the
    /// range that it is known by, the rest on its soft edge.
    #[test]
    fn labels_and_values_agree() {
        let dims = [96, 120, 152];
        let volume = Phantom::Anatomy.volume(dims).unwrap();
        let labels = Phantom::Anatomy.labels(dims).unwrap().unwrap();
        assert_eq!(volume.grid(), labels.grid());
        let mut names: Vec<_> = labels.labels().iter().map(|l| l.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), anatomy::TISSUES.len(), "a name is there twice");
        for (name, [lo, hi]) in [
            ("air", [-1000.0, -400.0]),
            ("fat", [-110.0, 0.0]),
            ("muscle", [20.0, 80.0]),
            ("skull", [300.0, 1310.0]),
            ("mandible", [300.0, 1460.0]),
            ("teeth", [900.0, 2510.0]),
            ("cerebrospinal fluid", [0.0, 25.0]),
            ("grey matter", [20.0, 45.0]),
            ("white matter", [25.0, 36.0]),
            ("arteries", [150.0, 300.0]),
            ("veins", [90.0, 180.0]),
            ("airway and sinuses", [-1010.0, -400.0]),
        ] {
            let id = labels.labels().iter().find(|l| l.name == name).unwrap().id;
            let (mut within, mut count) = (0u32, 0u32);
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        if labels.id(x, y, z) == id {
                            count += 1;
                            within += u32::from((lo..=hi).contains(&volume.value(x, y, z)));
                        }
                    }
                }
            }
            let share = f64::from(within) / f64::from(count);
            assert!(count > 20 && share > 0.8, "{name}: {share:.3} of {count}");
        }
    }

    /// The markers by which left can be told from right.
    #[test]
    fn earring_and_aneurysm_are_on_the_left() {
        let labels = Phantom::Anatomy.labels([96, 120, 152]).unwrap().unwrap();
        let [nx, ny, nz] = labels.grid().dims();
        for tissue in [anatomy::Tissue::Earring, anatomy::Tissue::Aneurysm] {
            let mut count = 0;
            for (x, y, z) in (0..nz)
                .flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (x, y, z))))
                .filter(|&(x, y, z)| labels.id(x, y, z) == tissue as u32)
            {
                let voxel = DVec3::new(x as f64, y as f64, z as f64);
                let p = labels.grid().world_from_voxel().transform_point3(voxel);
                // RAS: the patient's left is at negative x.
                assert!(p.x < 0.0, "{tissue:?} at {p}");
                count += 1;
            }
            assert!(count > 0, "{tissue:?} is nowhere");
        }
    }

    /// Nothing of the head reaches the border of the volume.
    #[test]
    fn the_head_has_air_around_it() {
        let volume = Phantom::Anatomy.volume([48, 60, 76]).unwrap();
        let [nx, ny, nz] = volume.grid().dims();
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    if [x, y, z].contains(&0) || x == nx - 1 || y == ny - 1 || z == nz - 1 {
                        assert_eq!(volume.value(x, y, z), -1000.0, "({x}, {y}, {z})");
                    }
                }
            }
        }
    }

    #[test]
    fn the_tree_stays_in_its_cube() {
        for step in tree::solid().steps() {
            let solid::Shape::Capsule { a, b, radius_a, .. } = step.shape else {
                panic!("the tree is made of capsules")
            };
            let reach = a.abs().max(b.abs()).max_element() + radius_a;
            assert!(reach < 51.0, "{a} to {b}");
        }
    }
}
