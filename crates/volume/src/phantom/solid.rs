//! Solids with soft edges: signed distances of simple shapes, joined and cut smoothly.
//!
//! A [`Solid`] is a list of shapes, each joined to or cut from what the list has made so far with
//! the polynomial smooth minimum (Quilez, "smooth minimum", 2013), negative inside. [`Solid::pruned`]
//! leaves out the shapes that cannot matter in a box, found by interval arithmetic as in Keeter,
//! "Massively Parallel Rendering of Complex Closed-Form Implicit Surfaces" (2020); what is left
//! gives the same bits everywhere in the box.

use super::number::{Interval, Number};
use glam::{DMat3, DVec3};

/// A point over any kind of number.
pub type Point<N> = [N; 3];

/// A simple shape; lengths in mm.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// An ellipsoid with its axes along the columns of `axes`. Its distance is Quilez' first-order
    /// estimate: exact on the surface, its slope there 1.
    Ellipsoid {
        center: DVec3,
        radii: DVec3,
        axes: Option<DMat3>,
    },
    /// All points nearer to the line from `a` to `b` than a radius that passes smoothly from the one to the other.
    Capsule {
        a: DVec3,
        b: DVec3,
        radius_a: f64,
        radius_b: f64,
    },
    /// A box of the half edges `half` (the rounding included) with its axes along the columns of `axes`.
    Block {
        center: DVec3,
        half: DVec3,
        rounding: f64,
        axes: Option<DMat3>,
    },
    /// A ring around the third column of `axes`.
    Ring {
        center: DVec3,
        radius: f64,
        thickness: f64,
        axes: DMat3,
    },
}

impl Shape {
    /// Signed distance in mm (an estimate with the right sign), negative inside.
    #[inline]
    pub fn distance<N: Number>(&self, p: Point<N>) -> N {
        match *self {
            Shape::Ellipsoid {
                center,
                radii,
                axes,
            } => {
                let q = local(p, center, axes);
                let k0 = length(scaled(q, radii.recip()));
                let k1 = length(scaled(q, (radii * radii).recip()));
                let range = [radii.min_element(), radii.max_element()];
                (k0 - 1.0) * k0.ratio_within(k1, range)
            }
            Shape::Capsule {
                a,
                b,
                radius_a,
                radius_b,
            } => {
                let q = local(p, a, None);
                let line = b - a;
                let h = (dot(q, line) * line.length_squared().recip()).clamp(0.0, 1.0);
                let off = [q[0] - h * line.x, q[1] - h * line.y, q[2] - h * line.z];
                let along = h.squared() * (-h * 2.0 + 3.0);
                length(off) - along * (radius_b - radius_a) - radius_a
            }
            Shape::Block {
                center,
                half,
                rounding,
                axes,
            } => {
                let q = local(p, center, axes);
                let inner = half - rounding;
                let d = [
                    q[0].abs() - inner.x,
                    q[1].abs() - inner.y,
                    q[2].abs() - inner.z,
                ];
                let zero = N::constant(0.0);
                let outside = length(d.map(|d| d.max(zero)));
                let inside = -(-d[0].max(d[1]).max(d[2])).max(zero);
                outside + inside - rounding
            }
            Shape::Ring {
                center,
                radius,
                thickness,
                axes,
            } => {
                let q = local(p, center, Some(axes));
                let off = (q[0].squared() + q[1].squared()).sqrt() - radius;
                (off.squared() + q[2].squared()).sqrt() - thickness
            }
        }
    }
}

fn local<N: Number>(p: Point<N>, origin: DVec3, axes: Option<DMat3>) -> Point<N> {
    let q = [p[0] - origin.x, p[1] - origin.y, p[2] - origin.z];
    match axes {
        None => q,
        Some(m) => [dot(q, m.x_axis), dot(q, m.y_axis), dot(q, m.z_axis)],
    }
}

fn scaled<N: Number>(q: Point<N>, by: DVec3) -> Point<N> {
    [q[0] * by.x, q[1] * by.y, q[2] * by.z]
}

/// q · v.
pub fn dot<N: Number>(q: Point<N>, v: DVec3) -> N {
    q[0] * v.x + q[1] * v.y + q[2] * v.z
}

/// |q|.
pub fn length<N: Number>(q: Point<N>) -> N {
    (q[0].squared() + q[1].squared() + q[2].squared()).sqrt()
}

/// What a step of a [`Solid`] does with its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Joins the shape.
    Join,
    /// Cuts the shape away.
    Cut,
}

/// One step of a [`Solid`].
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// What is joined or cut.
    pub shape: Shape,
    /// Joined or cut.
    pub action: Action,
    /// Width in mm over which edges are rounded.
    pub blend_mm: f64,
    /// Whether the shape is there a second time, mirrored at x = 0.
    pub mirrored: bool,
    /// Whether the next step goes on with the same tube: its pieces make a sharp union first, which is
    /// then joined or cut as one, so that their ends leave no beads.
    pub continues: bool,
}

impl Step {
    /// Distance of the shape or of its mirror image, whichever is nearer. The mirror is smooth:
    /// |x| is rounded within 1 mm, so that surfaces across x = 0 have no crease.
    #[inline]
    fn distance<N: Number>(&self, p: Point<N>, folded: Point<N>) -> N {
        self.shape.distance(if self.mirrored { folded } else { p })
    }
}

fn fold<N: Number>(p: Point<N>) -> Point<N> {
    [(p[0].squared() + 1.0).sqrt(), p[1], p[2]]
}

/// A list of shapes, each joined to or cut from the ones before.
#[derive(Clone, Debug, Default)]
pub struct Solid {
    steps: Vec<Step>,
    far_mm: f64,
}

impl Solid {
    /// A solid of these steps. Its distance is told up to `far_mm` only: far parts then need not be
    /// computed. It must be larger than every blend by what the users of the distance look at.
    pub fn new(steps: Vec<Step>, far_mm: f64) -> Solid {
        Solid { steps, far_mm }
    }

    /// The largest distance told.
    pub fn far_mm(&self) -> f64 {
        self.far_mm
    }

    /// The steps in their order.
    #[cfg(test)]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Signed distance, at most [`Solid::far_mm`].
    #[inline]
    pub fn distance<N: Number>(&self, p: Point<N>) -> N {
        self.distance_from(N::constant(self.far_mm), p)
    }

    /// The same, started from the distance of another solid instead of from nothing.
    #[inline]
    pub fn distance_from<N: Number>(&self, start: N, p: Point<N>) -> N {
        let folded = fold(p);
        let mut distance = start;
        let mut tube = None;
        for step in &self.steps {
            let mut shape = step.distance(p, folded);
            if let Some(tube) = tube {
                shape = shape.min(tube);
            }
            if step.continues {
                tube = Some(shape);
                continue;
            }
            tube = None;
            distance = match step.action {
                Action::Join => distance.smooth_min(shape, step.blend_mm),
                Action::Cut => distance.smooth_max(-shape, step.blend_mm),
            };
        }
        distance
    }

    /// Writes to `into` a solid that has the same distance (the same bits) at every point of the box
    /// `p`, with the steps left out that change nothing there, and gives bounds of the distance. The
    /// start value of [`Solid::distance_from`] must lie in `start`.
    pub fn prune(&self, start: Interval, p: Point<Interval>, into: &mut Solid) -> Interval {
        // Far above the rounding of interval bounds, far below any length that matters.
        const MARGIN: f64 = 1e-6;
        let folded = fold(p);
        into.far_mm = self.far_mm;
        into.steps.clear();
        let mut distance = start;
        // Of the tube that is being gathered: its first step in `into`, and its bounds.
        let mut tube: Option<(usize, Interval)> = None;
        for step in &self.steps {
            let shape = step.distance(p, folded);
            // As a union: with the distance for a join, with its complement for a cut.
            let before = match step.action {
                Action::Join => distance,
                Action::Cut => -distance,
            };
            if shape.lo <= before.hi + step.blend_mm + MARGIN {
                let covers = |d: Interval| shape.hi + step.blend_mm + MARGIN < d.lo;
                let alone = tube.is_none() && !step.continues;
                if alone && step.action == Action::Join && covers(distance) && covers(start) {
                    into.steps.clear();
                }
                tube = Some(match tube {
                    None => (into.steps.len(), shape),
                    Some((first, bounds)) => (first, bounds.min(shape)),
                });
                into.steps.push(Step {
                    continues: true,
                    ..*step
                });
            }
            if step.continues {
                continue;
            }
            if let Some((_, bounds)) = tube.take() {
                let last = into.steps.len() - 1;
                into.steps[last].continues = false;
                let after = before.smooth_min(bounds, step.blend_mm);
                distance = match step.action {
                    Action::Join => after,
                    Action::Cut => -after,
                };
            }
        }
        distance
    }
}
