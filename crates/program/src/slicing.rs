//! View-aligned slicing: planes across the view that are blended one after the other, as an alternative to
//! walking along rays.
//!
//! Slice n is the plane of all points that lie n steps in front of the eye (or of the picture's plane, if the
//! projection is orthographic), measured along the view axis. A program computes what each pixel sees of a
//! slice; how that joins what is there already is the [`Blend`], which fixed-function hardware does on a
//! GPU, and [`Blend::blended`] elsewhere.

use strahl_scene::plan::{Field, Plan, Projection};

/// Slices in one picture.
pub const MOST_SLICES: u32 = 65_536;

/// In which order slices are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// The nearest first.
    #[default]
    FrontToBack,
    /// The farthest first.
    BackToFront,
}

/// How a graph's slices become a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slicing {
    /// Which slice comes first.
    pub order: Order,
    /// How a slice joins those before it.
    pub blend: Blend,
    /// What is there before the first slice: premultiplied color, opacity.
    pub start: [f32; 4],
}

/// How what is drawn (the source) joins what is there (the destination): the blend state of the graphics
/// interface. In the end the destination counts as premultiplied color and opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Blend {
    /// Of red, green and blue.
    pub color: BlendPart,
    /// Of the opacity.
    pub opacity: BlendPart,
}

/// `operation(source · source factor, destination · destination factor)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BlendPart {
    /// What the source is multiplied by.
    pub source: Factor,
    /// What the destination is multiplied by.
    pub destination: Factor,
    /// What is done with both.
    pub operation: Operation,
}

/// What one side of a blend is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Factor {
    /// 0.
    Zero,
    /// 1.
    One,
    /// The source, channel by channel.
    Source,
    /// 1 − the source.
    OneMinusSource,
    /// The source's opacity.
    SourceOpacity,
    /// 1 − the source's opacity.
    OneMinusSourceOpacity,
    /// The destination, channel by channel.
    Destination,
    /// 1 − the destination.
    OneMinusDestination,
    /// The destination's opacity.
    DestinationOpacity,
    /// 1 − the destination's opacity.
    OneMinusDestinationOpacity,
}

/// What is done with source and destination after their factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// Source + destination.
    Add,
    /// Source − destination.
    Subtract,
    /// Destination − source.
    ReverseSubtract,
    /// The smaller; factors have to be 1.
    Smaller,
    /// The larger; factors have to be 1.
    Larger,
}

impl Blend {
    /// A slice behind those before it: premultiplied colors, nearest first.
    pub const FRONT_TO_BACK: Blend = Blend::both(
        Factor::OneMinusDestinationOpacity,
        Factor::One,
        Operation::Add,
    );
    /// A slice in front of those before it: premultiplied colors, farthest first.
    pub const BACK_TO_FRONT: Blend =
        Blend::both(Factor::One, Factor::OneMinusSourceOpacity, Operation::Add);
    /// The larger of each channel.
    pub const LARGER: Blend = Blend::both(Factor::One, Factor::One, Operation::Larger);
    /// The smaller of each channel.
    pub const SMALLER: Blend = Blend::both(Factor::One, Factor::One, Operation::Smaller);
    /// The sum.
    pub const ADD: Blend = Blend::both(Factor::One, Factor::One, Operation::Add);

    const fn both(source: Factor, destination: Factor, operation: Operation) -> Blend {
        let part = BlendPart {
            source,
            destination,
            operation,
        };
        Blend {
            color: part,
            opacity: part,
        }
    }

    /// The only order in which it makes sense, if there is one: who hides what comes later by what is there
    /// draws the nearest first, who hides what is there by what comes draws it last.
    pub fn order(&self) -> Option<Order> {
        match (self.color.source, self.color.destination) {
            (Factor::OneMinusDestinationOpacity, _) => Some(Order::FrontToBack),
            (_, Factor::OneMinusSourceOpacity) => Some(Order::BackToFront),
            _ => None,
        }
    }

    /// Why no hardware blends so, or why no slice would be seen.
    ///
    /// # Errors
    /// The part, `color` or `opacity`, and what would be right.
    pub fn check(&self) -> Result<(), (&'static str, &'static str)> {
        for (name, part) in [("color", self.color), ("opacity", self.opacity)] {
            let takes_none = matches!(part.operation, Operation::Smaller | Operation::Larger);
            if takes_none && (part.source, part.destination) != (Factor::One, Factor::One) {
                return Err((
                    name,
                    "`smaller` and `larger` take no factors; leave `source` and `destination` at `one`",
                ));
            }
        }
        if self.color.source == Factor::Zero
            && !matches!(
                self.color.destination,
                Factor::Source
                    | Factor::OneMinusSource
                    | Factor::SourceOpacity
                    | Factor::OneMinusSourceOpacity
            )
        {
            return Err((
                "color",
                "no slice would be seen: the source is multiplied by zero; `one` would keep premultiplied colors as they are",
            ));
        }
        Ok(())
    }

    /// What is there after `source` was drawn over `destination`.
    pub fn blended(&self, source: [f32; 4], destination: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|channel| {
            let part = if channel < 3 {
                self.color
            } else {
                self.opacity
            };
            let (s, d) = (source[channel], destination[channel]);
            let factor = |factor| match factor {
                Factor::Zero => 0.0,
                Factor::One => 1.0,
                Factor::Source => s,
                Factor::OneMinusSource => 1.0 - s,
                Factor::SourceOpacity => source[3],
                Factor::OneMinusSourceOpacity => 1.0 - source[3],
                Factor::Destination => d,
                Factor::OneMinusDestination => 1.0 - d,
                Factor::DestinationOpacity => destination[3],
                Factor::OneMinusDestinationOpacity => 1.0 - destination[3],
            };
            let (s, d) = (s * factor(part.source), d * factor(part.destination));
            match part.operation {
                Operation::Add => s + d,
                Operation::Subtract => s - d,
                Operation::ReverseSubtract => d - s,
                Operation::Smaller => s.min(d),
                Operation::Larger => s.max(d),
            }
        })
    }
}

/// Why a Plan is not drawn by slices.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SlicingError {
    /// Opaque geometry would have to cut each slice.
    #[error(
        "slices are not drawn among meshes; leave `meshes` out of the scene, or draw by a graph with a loop along the ray"
    )]
    Meshes,
    /// No slice knows whether it is the first that is seen.
    #[error(
        "slices have no depth; ask for none, or draw by a graph with a loop along the ray and the root `depth_mm`"
    )]
    Depth,
    /// More slices than anybody waits for.
    #[error(
        "the volume is {slices} slices deep at a step of {step_mm} mm; at most {MOST_SLICES} are drawn: make the step larger (`step_mm` or `step_voxels`)"
    )]
    TooMany {
        /// How many it would be.
        slices: f64,
        /// Their distance.
        step_mm: f64,
    },
}

/// The slices that can meet the objects of a Plan: numbers of planes, one step apart from the eye on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slices {
    /// The one that is drawn first.
    pub first: i32,
    /// How many are drawn.
    pub count: u32,
    /// From one to the next: 1 or −1.
    pub direction: i32,
}

impl Slices {
    /// The slices of `plan`, in this order.
    ///
    /// # Errors
    /// The Plan asks for what slices cannot do.
    pub fn of(plan: &Plan, order: Order) -> Result<Slices, SlicingError> {
        if !plan.meshes.is_empty() {
            return Err(SlicingError::Meshes);
        }
        if plan.with_depth {
            return Err(SlicingError::Depth);
        }
        let depths = plan.drawn_fields().flat_map(|field| depths(plan, field));
        let (near, far) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), depth| {
            (near.min(depth), far.max(depth))
        });
        let step_mm = plan.lattice.step_mm;
        // One more on each side makes up for rounding: what lies outside is not drawn anyway. Rays begin at the
        // eye, and so do slices; in perspective the plane of the eye itself is a point.
        let nearest = match plan.camera.projection {
            Projection::Perspective { .. } => 1.0,
            Projection::Orthographic { .. } => 0.0,
        };
        let first = ((near / step_mm).floor() - 1.0).max(nearest);
        let last = (far / step_mm).ceil() + 1.0;
        let count = (last - first + 1.0).max(0.0);
        if count > f64::from(MOST_SLICES) {
            return Err(SlicingError::TooMany {
                slices: count,
                step_mm,
            });
        }
        // Numbers of slices are whole numbers of single precision.
        if last.abs() > f64::from(1 << 24) {
            return Err(SlicingError::TooMany {
                slices: last,
                step_mm,
            });
        }
        let (first, count) = (first as i32, count as u32);
        Ok(match order {
            Order::FrontToBack => Slices {
                first,
                count,
                direction: 1,
            },
            Order::BackToFront => Slices {
                first: first + (count.max(1) - 1) as i32,
                count,
                direction: -1,
            },
        })
    }
}

/// How far in front of the eye the corners of a field's sampled extent lie.
fn depths(plan: &Plan, field: &Field) -> [f64; 8] {
    let world_from_voxel = field.grid.world_from_voxel();
    let dims = field.grid.dims();
    std::array::from_fn(|corner| {
        let end = |axis: usize| match corner >> axis & 1 {
            0 => -0.5,
            _ => dims[axis] as f64 - 0.5,
        };
        let place = world_from_voxel.transform_point3([end(0), end(1), end(2)].into());
        (place - plan.camera.eye_mm).dot(plan.camera.forward)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl_scene::{Scene, resolve};
    use strahl_volume::Phantom;

    fn plan(camera: &str) -> Plan {
        let volume = Phantom::Tree.volume([8, 8, 8]).unwrap();
        let text = format!(r#"{{ "camera": {camera}, "step_voxels": 0.5 }}"#);
        resolve(
            &Scene::parse("test", &text).unwrap(),
            &volume.header(),
            None,
        )
        .unwrap()
    }

    #[test]
    fn both_orders_blend_to_the_same() {
        let samples = [[0.3, 0.1, 0.0, 0.4], [0.0, 0.2, 0.1, 0.2], [0.5; 4]];
        let mut front = [0.0; 4];
        let mut back = [0.0; 4];
        for (near, far) in samples.iter().zip(samples.iter().rev()) {
            front = Blend::FRONT_TO_BACK.blended(*near, front);
            back = Blend::BACK_TO_FRONT.blended(*far, back);
        }
        for (f, b) in front.iter().zip(back) {
            assert!((f - b).abs() < 1e-6, "{front:?} {back:?}");
        }
        // 1 − 0.6 · 0.8 · 0.5.
        assert!((front[3] - 0.76).abs() < 1e-6, "{front:?}");
    }

    #[test]
    fn a_blend_says_its_order() {
        assert_eq!(Blend::FRONT_TO_BACK.order(), Some(Order::FrontToBack));
        assert_eq!(Blend::BACK_TO_FRONT.order(), Some(Order::BackToFront));
        assert_eq!(Blend::LARGER.order(), None);
        assert_eq!(
            Blend::LARGER.blended([0.1, 0.5, 0.2, 1.0], [0.3, 0.2, 0.2, 0.4]),
            [0.3, 0.5, 0.2, 1.0]
        );
        assert!(Blend::FRONT_TO_BACK.check().is_ok() && Blend::SMALLER.check().is_ok());
        let mut wrong = Blend::LARGER;
        wrong.opacity.source = Factor::SourceOpacity;
        assert_eq!(wrong.check().unwrap_err().0, "opacity");
        let mut nothing = Blend::ADD;
        nothing.color.source = Factor::Zero;
        assert_eq!(nothing.check().unwrap_err().0, "color");
    }

    /// Every plane that meets the volume is there, in either order.
    #[test]
    fn slices_cover_the_objects() {
        for camera in [
            r#"{ "projection": "orthographic", "azimuth_deg": 30, "elevation_deg": 20 }"#,
            r#"{ "azimuth_deg": 130 }"#,
        ] {
            let plan = plan(camera);
            let forth = Slices::of(&plan, Order::FrontToBack).unwrap();
            let back = Slices::of(&plan, Order::BackToFront).unwrap();
            assert_eq!(forth.count, back.count);
            assert_eq!(
                back.first + back.direction * (back.count as i32 - 1),
                forth.first
            );
            let step_mm = plan.lattice.step_mm;
            let last = f64::from(forth.first + forth.count as i32 - 1) * step_mm;
            for depth in depths(&plan, plan.field()) {
                assert!(f64::from(forth.first) * step_mm <= depth && depth <= last);
            }
            assert!(forth.count < 60, "{forth:?}");
        }
    }

    #[test]
    fn too_many_slices_are_refused() {
        let mut plan = plan("{}");
        plan.lattice.step_mm = 1e-9;
        let error = Slices::of(&plan, Order::FrontToBack).unwrap_err();
        assert!(error.to_string().contains("step_mm"), "{error}");
        plan.lattice.step_mm = 1.0;
        plan.with_depth = true;
        assert_eq!(
            Slices::of(&plan, Order::FrontToBack),
            Err(SlicingError::Depth)
        );
    }
}
