//! Words in which the shapes of the anatomy phantom are written down.

use super::solid::{Action, Shape, Solid, Step};
use glam::{DMat3, DVec3};

/// A point in mm.
pub const fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Axes turned about x, then y, then z, by degrees.
pub fn turned(x: f64, y: f64, z: f64) -> DMat3 {
    DMat3::from_rotation_z(z.to_radians())
        * DMat3::from_rotation_y(y.to_radians())
        * DMat3::from_rotation_x(x.to_radians())
}

/// An ellipsoid along the world's axes.
pub fn ellipsoid(center: DVec3, radii: DVec3) -> Shape {
    Shape::Ellipsoid {
        center,
        radii,
        axes: None,
    }
}

/// An ellipsoid along turned axes.
pub fn ellipsoid_turned(center: DVec3, radii: DVec3, axes: DMat3) -> Shape {
    Shape::Ellipsoid {
        center,
        radii,
        axes: Some(axes),
    }
}

/// A ball.
pub fn ball(center: DVec3, radius: f64) -> Shape {
    Shape::Capsule {
        a: center,
        b: center + DVec3::Z * 1e-3,
        radius_a: radius,
        radius_b: radius,
    }
}

/// A rod with round ends.
pub fn rod(a: DVec3, radius_a: f64, b: DVec3, radius_b: f64) -> Shape {
    Shape::Capsule {
        a,
        b,
        radius_a,
        radius_b,
    }
}

/// A box with rounded edges.
pub fn block(center: DVec3, half: DVec3, rounding: f64) -> Shape {
    Shape::Block {
        center,
        half,
        rounding,
        axes: None,
    }
}

/// A box with rounded edges along turned axes.
pub fn block_turned(center: DVec3, half: DVec3, rounding: f64, axes: DMat3) -> Shape {
    Shape::Block {
        center,
        half,
        rounding,
        axes: Some(axes),
    }
}

/// One side or both.
#[derive(Clone, Copy, PartialEq)]
pub enum Side {
    /// Where it is written.
    One,
    /// There, and mirrored at x = 0.
    Both,
}
pub use Side::{Both, One};

/// Collects the steps of a solid.
#[derive(Default)]
pub struct Model {
    steps: Vec<Step>,
}

impl Model {
    fn step(&mut self, shape: Shape, action: Action, side: Side, blend_mm: f64) -> &mut Model {
        self.steps.push(Step {
            shape,
            action,
            blend_mm,
            mirrored: side == Both,
            continues: false,
        });
        self
    }

    /// Joins a shape, its edge filled over `blend_mm`.
    pub fn join(&mut self, side: Side, blend_mm: f64, shape: Shape) -> &mut Model {
        self.step(shape, Action::Join, side, blend_mm)
    }

    /// Cuts a shape away.
    pub fn cut(&mut self, side: Side, blend_mm: f64, shape: Shape) -> &mut Model {
        self.step(shape, Action::Cut, side, blend_mm)
    }

    /// Joins a smooth tube through points [x, y, z, radius] in mm.
    pub fn join_tube(&mut self, side: Side, blend_mm: f64, points: &[[f64; 4]]) -> &mut Model {
        self.tube(points, Action::Join, side, blend_mm)
    }

    /// Cuts a smooth tube through points [x, y, z, radius] in mm.
    pub fn cut_tube(&mut self, side: Side, blend_mm: f64, points: &[[f64; 4]]) -> &mut Model {
        self.tube(points, Action::Cut, side, blend_mm)
    }

    fn tube(
        &mut self,
        points: &[[f64; 4]],
        action: Action,
        side: Side,
        blend_mm: f64,
    ) -> &mut Model {
        for rod in tube(points) {
            self.step(rod, action, side, blend_mm);
            self.steps.last_mut().expect("just pushed").continues = true;
        }
        self.steps.last_mut().expect("two points or more").continues = false;
        self
    }

    /// The solid. Its distance is right up to 4 mm from the surface: that is more than any soft edge.
    pub fn build(&mut self) -> Solid {
        let blend = self.steps.iter().map(|s| s.blend_mm).fold(0.0, f64::max);
        self.build_up_to(4.0 + 1.25 * blend)
    }

    /// The solid, its distance told up to `far_mm`.
    pub fn build_up_to(&mut self, far_mm: f64) -> Solid {
        Solid::new(std::mem::take(&mut self.steps), far_mm)
    }
}

/// Rods along the Catmull–Rom spline through `points` (x, y, z, radius), three per span.
fn tube(points: &[[f64; 4]]) -> Vec<Shape> {
    const PIECES: usize = 3;
    let point = |i: isize| points[i.clamp(0, points.len() as isize - 1) as usize];
    let mut fine = vec![points[0]];
    for span in 0..points.len() as isize - 1 {
        let [p0, p1, p2, p3] = [-1, 0, 1, 2].map(|k| point(span + k));
        for piece in 1..=PIECES {
            let t = piece as f64 / PIECES as f64;
            fine.push(std::array::from_fn(|c| {
                let (a, b, c, d) = (p0[c], p1[c], p2[c], p3[c]);
                b + 0.5
                    * t
                    * ((c - a)
                        + t * ((2.0 * a - 5.0 * b + 4.0 * c - d) + t * (3.0 * (b - c) + d - a)))
            }));
        }
    }
    fine.windows(2)
        .map(|ends| {
            let [a, b] = [ends[0], ends[1]];
            rod(at(a[0], a[1], a[2]), a[3], at(b[0], b[1], b[2]), b[3])
        })
        .collect()
}
