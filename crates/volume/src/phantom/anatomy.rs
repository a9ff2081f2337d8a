//! A stylised head and neck in Hounsfield units.
//!
//! Every tissue is a solid with a soft edge (`docs/phantoms.md` lists them). [`Anatomy::paint`] lays them
//! over one another in a fixed order; a painter turns that into a value, a value with gradient, or a label.
//!
//! Coordinates: RAS mm, the origin midway between the ear canals, the Frankfurt plane (ear canals and
//! lower rims of the orbits) at z = 0. Patient's left is −x: there hangs the earring, and there
//! is the aneurysm.

mod bones;
mod brain;
mod head;
mod soft;
mod vessels;

use super::number::{Interval, Number, Single};
use super::solid::{Point, Solid};
use glam::DVec3;
use std::sync::OnceLock;

/// The box that is sampled: smallest and largest corner.
pub const EXTENT_MM: (DVec3, DVec3) = (
    DVec3::new(-96.0, -112.0, -168.0),
    DVec3::new(96.0, 128.0, 136.0),
);

/// A tissue. The number is the label id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Tissue {
    Air = 0,
    Skin,
    Fat,
    Muscle,
    Skull,
    Mandible,
    Teeth,
    Vertebrae,
    Discs,
    Fluid,
    Ventricles,
    GreyMatter,
    WhiteMatter,
    Nuclei,
    Cerebellum,
    Brainstem,
    Eyes,
    Lenses,
    OpticNerves,
    Arteries,
    Aneurysm,
    Veins,
    Airway,
    Cartilage,
    Thyroid,
    SalivaryGlands,
    Earring,
}

/// Name and color (sRGB) of a tissue.
pub struct TissueFacts {
    /// The tissue.
    pub tissue: Tissue,
    /// The name of its label.
    pub name: &'static str,
    /// sRGB bytes.
    pub color: [u8; 3],
}

const fn facts(tissue: Tissue, name: &'static str, color: [u8; 3]) -> TissueFacts {
    TissueFacts {
        tissue,
        name,
        color,
    }
}

/// Every tissue, in the order of the ids.
pub const TISSUES: [TissueFacts; 27] = [
    facts(Tissue::Air, "air", [0, 0, 0]),
    facts(Tissue::Skin, "skin", [224, 172, 140]),
    facts(Tissue::Fat, "fat", [242, 214, 120]),
    facts(Tissue::Muscle, "muscle", [168, 60, 52]),
    facts(Tissue::Skull, "skull", [236, 226, 200]),
    facts(Tissue::Mandible, "mandible", [222, 206, 170]),
    facts(Tissue::Teeth, "teeth", [250, 250, 244]),
    facts(Tissue::Vertebrae, "vertebrae", [216, 204, 160]),
    facts(Tissue::Discs, "intervertebral discs", [140, 190, 200]),
    facts(Tissue::Fluid, "cerebrospinal fluid", [80, 140, 220]),
    facts(Tissue::Ventricles, "ventricles", [40, 90, 200]),
    facts(Tissue::GreyMatter, "grey matter", [190, 150, 150]),
    facts(Tissue::WhiteMatter, "white matter", [240, 226, 220]),
    facts(Tissue::Nuclei, "deep grey nuclei", [170, 110, 140]),
    facts(Tissue::Cerebellum, "cerebellum", [200, 140, 110]),
    facts(
        Tissue::Brainstem,
        "brainstem and spinal cord",
        [210, 180, 120],
    ),
    facts(Tissue::Eyes, "eyes", [230, 236, 245]),
    facts(Tissue::Lenses, "lenses", [120, 200, 230]),
    facts(Tissue::OpticNerves, "optic nerves", [240, 220, 90]),
    facts(Tissue::Arteries, "arteries", [220, 30, 30]),
    facts(Tissue::Aneurysm, "aneurysm", [255, 110, 0]),
    facts(Tissue::Veins, "veins", [50, 70, 190]),
    facts(Tissue::Airway, "airway and sinuses", [150, 220, 240]),
    facts(Tissue::Cartilage, "cartilage", [150, 200, 170]),
    facts(Tissue::Thyroid, "thyroid gland", [190, 80, 120]),
    facts(Tissue::SalivaryGlands, "salivary glands", [220, 160, 90]),
    facts(Tissue::Earring, "earring", [255, 205, 60]),
];

/// What comes of laying tissues over one another at a point.
pub trait Painter<N> {
    /// Lays `tissue` of this value over what is there, opaque where `cover` is 1.
    fn lay(&mut self, tissue: Tissue, hu: f64, cover: N);
}

/// Paints values in HU.
pub struct Hounsfield<N>(pub N);

impl<N: Number> Painter<N> for Hounsfield<N> {
    #[inline(always)]
    fn lay(&mut self, _: Tissue, hu: f64, cover: N) {
        self.0 = self.0.covered_by(hu, cover);
    }
}

/// Paints label ids: the topmost tissue that covers at least half.
pub struct LabelId(pub Tissue);

impl Painter<f64> for LabelId {
    fn lay(&mut self, tissue: Tissue, _: f64, cover: f64) {
        if cover >= 0.5 {
            self.0 = tissue;
        }
    }
}

/// The value at a point in HU.
#[inline]
pub fn hounsfield<N: Single>(head: &Anatomy, p: Point<N>) -> N {
    let mut painter = Hounsfield(N::constant(-1000.0));
    head.paint(p, &mut painter);
    painter.0
}

/// The tissue at a point.
pub fn tissue(head: &Anatomy, p: Point<f64>) -> Tissue {
    let mut painter = LabelId(Tissue::Air);
    head.paint(p, &mut painter);
    painter.0
}

macro_rules! solids {
    ($($name:ident),* $(,)?) => {
        /// Indices of the solids in [`Anatomy`].
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        #[derive(Clone, Copy, PartialEq)]
        enum Part { $($name),* }
        impl Part {
            const ALL: [Part; PARTS] = [$(Part::$name),*];
        }
        const PARTS: usize = [$(Part::$name),*].len();
    };
}

solids!(
    Cavity,
    Skin,
    Cranium,
    Mandible,
    Crowns,
    Roots,
    Vertebrae,
    Discs,
    Hyoid,
    Muscle,
    Airway,
    Eyes,
    Lenses,
    OpticNerves,
    EyeMuscles,
    Cartilage,
    Thyroid,
    Salivary,
    Canal,
    Cord,
    Arteries,
    Aneurysm,
    Veins,
    Earring,
    Ventricles,
    Nuclei,
    Cerebellum,
    Brainstem,
);

impl Part {
    /// Whether the fluid of the cranial cavity is laid over it.
    fn is_below_cavity(self) -> bool {
        use Part::*;
        matches!(
            self,
            Muscle
                | Salivary
                | Thyroid
                | Cartilage
                | EyeMuscles
                | OpticNerves
                | Eyes
                | Lenses
                | Discs
                | Cranium
                | Hyoid
                | Mandible
                | Vertebrae
                | Canal
                | Cord
        )
    }
}

/// The solids of the head, all of them or those that matter in a box.
#[derive(Clone)]
pub struct Anatomy {
    solids: [Solid; PARTS],
    /// Solids that cover nothing are left out.
    present: [bool; PARTS],
    /// Nothing of skin and outer air is in the box.
    deep: bool,
}

/// Thickness of skull and scalp around the cranial cavity.
const SKULL_MM: f64 = 6.0;
const SCALP_MM: f64 = 5.5;
/// Thickness of the skin.
const DERMIS_MM: f64 = 2.2;
/// Half the width of soft edges, like the blur of a scanner; thinner for what is thin.
const EDGE_MM: f64 = 1.4;
const FINE_EDGE_MM: f64 = 0.9;

impl Anatomy {
    /// The whole head.
    pub fn whole() -> &'static Anatomy {
        static WHOLE: OnceLock<Anatomy> = OnceLock::new();
        WHOLE.get_or_init(|| {
            let cavity = head::cavity();
            let on_wall = |p: DVec3, depth: f64| {
                let middle = DVec3::new(0.0, -5.0, 45.0);
                let outward = (p - middle).normalize();
                let (mut near, mut far) = (0.0, 150.0);
                for _ in 0..40 {
                    let half = 0.5 * (near + far);
                    let at = (middle + outward * half).to_array();
                    if cavity.distance(at) < -depth {
                        near = half;
                    } else {
                        far = half;
                    }
                }
                middle + outward * near
            };
            let (crowns, roots) = bones::teeth();
            let (optic_nerves, eye_muscles) = soft::optic();
            let (thyroid, salivary) = soft::glands();
            let (canal, cord) = soft::cord();
            let veins = vessels::veins(on_wall);
            let mut solids: [Solid; PARTS] = Default::default();
            for (part, solid) in [
                (Part::Cavity, cavity),
                (Part::Skin, head::skin()),
                (Part::Cranium, bones::cranium()),
                (Part::Mandible, bones::mandible()),
                (Part::Crowns, crowns),
                (Part::Roots, roots),
                (Part::Vertebrae, bones::vertebrae()),
                (Part::Discs, bones::discs()),
                (Part::Hyoid, bones::hyoid()),
                (Part::Muscle, soft::muscle()),
                (Part::Airway, soft::airway()),
                (Part::Eyes, soft::eyes()),
                (Part::Lenses, soft::lenses()),
                (Part::OpticNerves, optic_nerves),
                (Part::EyeMuscles, eye_muscles),
                (Part::Cartilage, soft::cartilage()),
                (Part::Thyroid, thyroid),
                (Part::Salivary, salivary),
                (Part::Canal, canal),
                (Part::Cord, cord),
                (Part::Arteries, vessels::arteries()),
                (Part::Aneurysm, vessels::aneurysm()),
                (Part::Veins, veins),
                (Part::Earring, vessels::earring(head::EARRING)),
                (Part::Ventricles, brain::ventricles()),
                (Part::Nuclei, brain::nuclei()),
                (Part::Cerebellum, brain::cerebellum()),
                (Part::Brainstem, brain::brainstem()),
            ] {
                solids[part as usize] = solid;
            }
            Anatomy {
                solids,
                present: [true; PARTS],
                deep: false,
            }
        })
    }

    /// Nothing yet: for [`Anatomy::prune`] to write to.
    pub fn scratch() -> Anatomy {
        Anatomy {
            solids: Default::default(),
            present: [false; PARTS],
            deep: false,
        }
    }

    /// Writes to `into` the parts that matter in the box `p`: painting with them gives the same bits at every
    /// point of the box. False if there is nothing but air.
    pub fn prune(&self, p: Point<Interval>, into: &mut Anatomy) -> bool {
        const MARGIN: f64 = 1e-6;
        let pruned = |part: Part, start: Option<Interval>, into: &mut Anatomy| {
            let part = part as usize;
            let start = start.unwrap_or(Interval::constant(self.solids[part].far_mm()));
            let distance = self.solids[part].prune(start, p, &mut into.solids[part]);
            // A solid that stays farther away than its soft edge covers nothing.
            into.present[part] = self.present[part] && distance.lo <= EDGE_MM + MARGIN;
            distance
        };
        let cavity = pruned(Part::Cavity, None, into);
        let skin = pruned(Part::Skin, Some(cavity - (SKULL_MM + SCALP_MM)), into);
        pruned(Part::Earring, None, into);
        let in_body = into.present[Part::Skin as usize];
        // Deep in the cavity its fluid covers all that is laid below it.
        let in_cavity = cavity.hi < -EDGE_MM - MARGIN;
        for part in Part::ALL {
            match part {
                Part::Cavity | Part::Skin | Part::Earring => {}
                _ if !in_body || in_cavity && part.is_below_cavity() => {
                    into.present[part as usize] = false;
                }
                Part::Cranium => {
                    pruned(part, Some(cavity - SKULL_MM), into);
                }
                _ => {
                    pruned(part, None, into);
                }
            }
        }
        into.deep = skin.hi < -(DERMIS_MM + EDGE_MM + MARGIN);
        into.present[Part::Skin as usize] || into.present[Part::Earring as usize]
    }

    #[inline]
    fn distance<N: Number>(&self, part: Part, p: Point<N>) -> N {
        self.solids[part as usize].distance(p)
    }

    /// Lays the tissues at `p` over one another, the deepest last said first.
    pub fn paint<N: Single>(&self, p: Point<N>, painter: &mut impl Painter<N>) {
        let present = |part: Part| self.present[part as usize];
        let cavity = self.distance(Part::Cavity, p);
        if present(Part::Skin) {
            let skin = (!self.deep).then(|| {
                let scalp = cavity - (SKULL_MM + SCALP_MM);
                self.solids[Part::Skin as usize].distance_from(scalp, p)
            });
            // What would be covered wholly in the end is not computed.
            let in_air = skin.is_some_and(|skin| skin.value() >= EDGE_MM);
            if !in_air {
                if cavity.value() > -EDGE_MM {
                    painter.lay(Tissue::Fat, -90.0, N::constant(1.0));
                    self.paint_soft_tissue(p, painter);
                    self.paint_bones(p, cavity, painter);
                }
                if cavity.value() < EDGE_MM {
                    self.paint_cranial_cavity(p, cavity, painter);
                }
                self.paint_inlays(p, painter);
                if present(Part::Airway) {
                    let airway = self.distance(Part::Airway, p);
                    painter.lay(Tissue::Airway, -1000.0, airway.cover(EDGE_MM));
                }
            }
            if let Some(skin) = skin {
                let dermis = (-skin - DERMIS_MM).cover(EDGE_MM);
                painter.lay(Tissue::Skin, 45.0, dermis);
                painter.lay(Tissue::Air, -1000.0, (-skin).cover(EDGE_MM));
            }
        }
        if present(Part::Earring) {
            let ring = self.distance(Part::Earring, p);
            painter.lay(Tissue::Earring, 2900.0, ring.cover(FINE_EDGE_MM));
        }
    }

    fn paint_soft_tissue<N: Number>(&self, p: Point<N>, painter: &mut impl Painter<N>) {
        for (part, tissue, hu, edge) in [
            (Part::Muscle, Tissue::Muscle, 55.0, EDGE_MM),
            (Part::Salivary, Tissue::SalivaryGlands, 20.0, EDGE_MM),
            (Part::Thyroid, Tissue::Thyroid, 150.0, EDGE_MM),
            (Part::Cartilage, Tissue::Cartilage, 130.0, FINE_EDGE_MM),
            (Part::EyeMuscles, Tissue::Muscle, 55.0, FINE_EDGE_MM),
            (Part::OpticNerves, Tissue::OpticNerves, 35.0, FINE_EDGE_MM),
        ] {
            if self.present[part as usize] {
                painter.lay(tissue, hu, self.distance(part, p).cover(edge));
            }
        }
        if self.present[Part::Eyes as usize] {
            let eye = self.distance(Part::Eyes, p);
            painter.lay(Tissue::Eyes, 60.0, eye.cover(FINE_EDGE_MM));
            painter.lay(Tissue::Eyes, 12.0, (eye + 1.6).cover(FINE_EDGE_MM));
            if self.present[Part::Lenses as usize] {
                let lens = self.distance(Part::Lenses, p);
                painter.lay(Tissue::Lenses, 85.0, lens.cover(FINE_EDGE_MM));
            }
        }
        if self.present[Part::Discs as usize] {
            let disc = self.distance(Part::Discs, p);
            painter.lay(Tissue::Discs, 90.0, disc.cover(EDGE_MM));
        }
    }

    fn paint_bones<N: Number>(&self, p: Point<N>, cavity: N, painter: &mut impl Painter<N>) {
        if self.present[Part::Cranium as usize] {
            let grown = self.solids[Part::Cranium as usize].distance_from(cavity - SKULL_MM, p);
            let bone = grown.smooth_max(-cavity, 1.5);
            painter.lay(Tissue::Skull, 1300.0, bone.cover(EDGE_MM));
            // Diploë between the tables, marrow in thick bones.
            painter.lay(Tissue::Skull, 600.0, (bone + 2.2).cover(FINE_EDGE_MM));
        }
        for (part, tissue, cortical, spongy, shell) in [
            (Part::Hyoid, Tissue::Skull, 700.0, 400.0, 1.5),
            (Part::Mandible, Tissue::Mandible, 1450.0, 650.0, 2.6),
            (Part::Vertebrae, Tissue::Vertebrae, 850.0, 430.0, 1.5),
        ] {
            if self.present[part as usize] {
                let bone = self.distance(part, p);
                painter.lay(tissue, cortical, bone.cover(FINE_EDGE_MM));
                painter.lay(tissue, spongy, (bone + shell).cover(FINE_EDGE_MM));
            }
        }
        if self.present[Part::Canal as usize] {
            let canal = self.distance(Part::Canal, p);
            painter.lay(Tissue::Fluid, 5.0, canal.cover(EDGE_MM));
        }
        if self.present[Part::Cord as usize] {
            let cord = self.distance(Part::Cord, p);
            painter.lay(Tissue::Brainstem, 32.0, cord.cover(EDGE_MM));
        }
    }

    fn paint_cranial_cavity<N: Number>(
        &self,
        p: Point<N>,
        cavity: N,
        painter: &mut impl Painter<N>,
    ) {
        let inside = cavity.cover(EDGE_MM);
        painter.lay(Tissue::Fluid, 5.0, inside);
        // Below here everything is 2 mm inside the cavity.
        let room = cavity + 2.5;
        let in_room = |d: N| d.smooth_max(room, 1.0);
        let cerebellum_part = self.distance(Part::Cerebellum, p);
        let stem = self.distance(Part::Brainstem, p);
        // The cerebrum fills the cavity above tentorium and brainstem, parted by the fissure in the
        // middle except where the corpus callosum joins the halves.
        let [y, z] = [(p[1] - 2.0) * (1.0 / 42.0), (p[2] - 46.0) * (1.0 / 27.0)];
        let callosum = ((y.squared() + z.squared()).sqrt() - 1.0) * 27.0;
        let fissure = ((p[0].squared() + 0.5).sqrt() - 1.5).smooth_max(-callosum, 2.0);
        let tentorium = cerebellum_part.smooth_min(stem, 2.0) - 3.0;
        let hull = room.smooth_max(-tentorium, 3.0).smooth_max(-fissure, 2.0);
        let folds = brain::folds(p).smooth_max(-hull - 17.0, 4.0);
        let cerebrum = hull.smooth_max(-folds, 1.5);
        painter.lay(Tissue::GreyMatter, 39.0, cerebrum.cover(FINE_EDGE_MM));
        painter.lay(Tissue::WhiteMatter, 28.0, (cerebrum + 3.4).cover(EDGE_MM));
        for (part, tissue, hu) in [
            (Part::Nuclei, Tissue::Nuclei, 41.0),
            (Part::Ventricles, Tissue::Ventricles, 5.0),
        ] {
            if self.present[part as usize] {
                painter.lay(tissue, hu, in_room(self.distance(part, p)).cover(EDGE_MM));
            }
        }
        if self.present[Part::Cerebellum as usize] {
            let leaves = brain::leaves(p).smooth_max(-cerebellum_part - 5.0, 1.0);
            let d = in_room(cerebellum_part).smooth_max(-leaves, 0.6);
            painter.lay(Tissue::Cerebellum, 38.0, d.cover(FINE_EDGE_MM));
            painter.lay(Tissue::Cerebellum, 30.0, (d + 5.0).cover(EDGE_MM));
        }
        if self.present[Part::Brainstem as usize] {
            painter.lay(
                Tissue::Brainstem,
                32.0,
                stem.smooth_max(cavity + 0.5, 1.0).cover(EDGE_MM),
            );
        }
    }

    fn paint_inlays<N: Number>(&self, p: Point<N>, painter: &mut impl Painter<N>) {
        if self.present[Part::Roots as usize] {
            let root = self.distance(Part::Roots, p);
            painter.lay(Tissue::Teeth, 1600.0, root.cover(FINE_EDGE_MM));
        }
        if self.present[Part::Crowns as usize] {
            let crown = self.distance(Part::Crowns, p);
            painter.lay(Tissue::Teeth, 2500.0, crown.cover(FINE_EDGE_MM));
            painter.lay(Tissue::Teeth, 1800.0, (crown + 1.8).cover(FINE_EDGE_MM));
        }
        for (part, tissue, hu) in [
            (Part::Veins, Tissue::Veins, 170.0),
            (Part::Arteries, Tissue::Arteries, 290.0),
            (Part::Aneurysm, Tissue::Aneurysm, 290.0),
        ] {
            if self.present[part as usize] {
                painter.lay(tissue, hu, self.distance(part, p).cover(FINE_EDGE_MM));
            }
        }
    }
}
