//! A branching tree, like a vessel tree: many thin, connected parts.

use super::number::{Interval, Number};
use super::random::Random;
use super::solid::{Action, Point, Shape, Solid, Step};
use glam::DVec3;
use std::sync::OnceLock;

/// Half the width of the soft edge in mm.
const EDGE_MM: f64 = 0.8;
const GENERATIONS: u32 = 6;

/// 1 inside the branches, 0 outside, a smoothstep of the distance over ±0.8 mm between.
pub fn density<N: Number>(solid: &Solid, p: Point<N>) -> N {
    solid.distance(p).cover(EDGE_MM)
}

/// Writes to `into` the branches that matter in a box; false if there are none.
pub fn prune(bounds: Point<Interval>, into: &mut Solid) -> bool {
    let distance = solid().prune(Interval::constant(solid().far_mm()), bounds, into);
    distance.lo <= EDGE_MM
}

/// The branches: tapering capsules, every branch forking in two for six generations (127 branches), joined with
/// a smooth union of 1 mm. Grown from a fixed seed; radii follow Murray's law (r³ = r₁³ + r₂³).
pub fn solid() -> &'static Solid {
    static SOLID: OnceLock<Solid> = OnceLock::new();
    SOLID.get_or_init(|| {
        let mut steps = Vec::new();
        let root = Branch {
            start: DVec3::new(0.0, 0.0, -46.0),
            direction: DVec3::Z,
            length_mm: 28.0,
            radius_mm: 4.5,
        };
        grow(root, GENERATIONS, &mut Random::new(1994), &mut steps);
        Solid::new(steps, 4.0)
    })
}

struct Branch {
    start: DVec3,
    direction: DVec3,
    length_mm: f64,
    radius_mm: f64,
}

fn grow(branch: Branch, generations: u32, random: &mut Random, steps: &mut Vec<Step>) {
    let end = branch.start + branch.direction * branch.length_mm;
    // The larger child keeps 0.6 of the cross-flow: 0.6 + 0.4 = 1 in cubes of radii.
    let share = random.between(0.4, 0.6);
    steps.push(Step {
        shape: Shape::Capsule {
            a: branch.start,
            b: end,
            radius_a: branch.radius_mm,
            radius_b: branch.radius_mm * 0.85,
        },
        action: Action::Join,
        blend_mm: 1.0,
        mirrored: false,
        continues: false,
    });
    if generations == 0 {
        return;
    }
    let sideways = branch
        .direction
        .cross(random.direction())
        .normalize_or(branch.direction.any_orthonormal_vector());
    for (side, share) in [(sideways, share), (-sideways, 1.0 - share)] {
        let spread = random.between(0.45, 0.85);
        // Thin ends are drawn back to the middle so that the tree stays in its cube.
        let homeward = -end * (end.length() / 45.0).powi(4) * 0.02;
        let direction = (branch.direction + side * spread + homeward).normalize();
        let child = Branch {
            start: end,
            direction,
            length_mm: branch.length_mm * random.between(0.68, 0.8),
            radius_mm: branch.radius_mm * 0.85 * share.cbrt(),
        };
        grow(child, generations - 1, random, steps);
    }
}
