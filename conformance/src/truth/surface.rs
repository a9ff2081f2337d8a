//! What a place of the volume looks like: classification and light, written from docs/plan.md.

use super::range::Range;
use glam::DVec3;
use strahl_scene::plan::{Illuminate, Plan, PlanLight, Shade};
use strahl_scene::transfer::TransferTable;

/// Half an ulp of 1 in single precision.
const HALF_ULP: f64 = 0.5 * f32::EPSILON as f64;

/// Linear RGB (not premultiplied) and opacity per reference length.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub color: [Range; 3],
    pub opacity: Range,
}

/// All that the table says of the values in `values`. With `rounded`, what single precision may make
/// of the place in the table and of the interpolation there.
pub fn classify(table: &TransferTable, values: Range, rounded: bool) -> Surface {
    let entries = table.entries();
    let last = (entries.len() - 1) as f64;
    let [d0, d1] = table.domain().map(f64::from);
    let position = |value: f64| ((value - d0) * last / (d1 - d0)).clamp(0.0, last);
    let values = if rounded {
        let size = |v: f64| 2.0 * (v.abs() + d0.abs()) + 6.0 * (v.clamp(d0, d1) - d0);
        values.widened(HALF_ULP * size(values.lo).max(size(values.hi)))
    } else {
        values
    };
    let (first, end) = (position(values.lo), position(values.hi));
    let mut channels = [Range::EMPTY; 4];
    let mut add = |position: f64| {
        let index = (position as usize).min(entries.len() - 2);
        let part = position - index as f64;
        for (c, channel) in channels.iter_mut().enumerate() {
            let (a, b) = (
                f64::from(entries[index][c]),
                f64::from(entries[index + 1][c]),
            );
            let between = Range::exactly(a + part * (b - a));
            // Between equal entries nothing is rounded.
            let doubt = if rounded && a != b {
                4.0 * HALF_ULP * a.abs().max(b.abs())
            } else {
                0.0
            };
            *channel = channel.hull(between.widened(doubt));
        }
    };
    add(first);
    add(end);
    for entry in first.ceil() as usize..=end.floor() as usize {
        add(entry as f64);
    }
    let [r, g, b, a] = channels;
    Surface {
        color: [r, g, b],
        opacity: a.clamped_to_unit(),
    }
}

/// 1 − (1 − a)^exponent.
pub fn opacity_of_length(opacity: Range, exponent: f64, rounded: bool) -> Range {
    let corrected = |a: f64| 1.0 - (1.0 - a).powf(exponent);
    let range = Range {
        lo: corrected(opacity.lo),
        hi: corrected(opacity.hi),
    };
    if rounded {
        range.widened(12.0 * HALF_ULP * range.hi).clamped_to_unit()
    } else {
        range
    }
}

/// How light changes a color c: c·factor + highlight.
#[derive(Clone, Copy, Debug)]
pub struct Lighting {
    pub factor: [Range; 3],
    pub highlight: [Range; 3],
}

impl Lighting {
    pub const UNLIT: Lighting = Lighting {
        factor: [Range { lo: 1.0, hi: 1.0 }; 3],
        highlight: [Range { lo: 0.0, hi: 0.0 }; 3],
    };

    pub fn hull(self, other: Lighting) -> Lighting {
        Lighting {
            factor: std::array::from_fn(|c| self.factor[c].hull(other.factor[c])),
            highlight: std::array::from_fn(|c| self.highlight[c].hull(other.highlight[c])),
        }
    }

    pub fn color(self, surface: [Range; 3]) -> [Range; 3] {
        std::array::from_fn(|c| {
            let (factor, highlight) = (self.factor[c], self.highlight[c]);
            Range {
                lo: surface[c].lo.max(0.0) * factor.lo + highlight.lo,
                hi: surface[c].hi.max(0.0) * factor.hi + highlight.hi,
            }
        })
    }
}

/// Blinn–Phong, and Lambert as Blinn–Phong without a highlight: the models that the truth has.
struct Parts {
    ambient: f32,
    diffuse: f32,
    specular: f32,
    shininess: f32,
}

impl Parts {
    /// `None` if nothing is lit.
    fn of(plan: &Plan) -> Option<Parts> {
        match plan.technique().shade {
            Shade::Lit {
                ambient,
                illuminate:
                    Illuminate::BlinnPhong {
                        diffuse,
                        specular,
                        shininess,
                    },
                ..
            } => Some(Parts {
                ambient,
                diffuse,
                specular,
                shininess,
            }),
            Shade::Lit {
                ambient,
                illuminate: Illuminate::Lambert { diffuse },
                ..
            } => Some(Parts {
                ambient,
                diffuse,
                specular: 0.0,
                shininess: 1.0,
            }),
            _ => None,
        }
    }
}

/// A place on a ray.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// World space, mm.
    pub place_mm: DVec3,
    /// Of the ray, unit length.
    pub direction: DVec3,
}

impl Seen {
    /// Unit vector towards a light, and linear RGB of what arrives from it.
    fn arriving(self, light: &PlanLight) -> (DVec3, [f64; 3]) {
        match *light {
            PlanLight::Directional { to_light, radiance } => (to_light, radiance.map(f64::from)),
            PlanLight::Head { radiance } => (-self.direction, radiance.map(f64::from)),
            PlanLight::Point {
                place_mm,
                reach_mm,
                radiance,
            } => {
                let way = place_mm - self.place_mm;
                let fall = f64::from(reach_mm) / way.length();
                let radiance = radiance.map(|r| f64::from(r) * fall * fall);
                (way.normalize(), radiance)
            }
        }
    }
}

/// The light on a surface seen at a place whose gradient (world space, per mm) is `gradient`, give or take `doubt` in
/// each component.
pub fn illuminate(plan: &Plan, gradient: DVec3, doubt: DVec3, seen: Seen) -> Lighting {
    let Some(Parts { shininess, .. }) = Parts::of(plan) else {
        return Lighting::UNLIT;
    };
    let lit = blinn_phong(plan, gradient, seen);
    if doubt == DVec3::ZERO {
        return lit;
    }
    // Turning by this much changes a highlight by its steepness, √shininess, times it.
    let turn = doubt.length() / gradient.length();
    if gradient == DVec3::ZERO || turn * f64::from(shininess).max(1.0).sqrt() > 0.02 {
        return lit.hull(Lighting::UNLIT).hull(any_normal(plan, seen));
    }
    let mut lighting = lit;
    for corner in 0..8 {
        let sign = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let moved = gradient + doubt * DVec3::new(sign(0), sign(1), sign(2));
        lighting = lighting.hull(blinn_phong(plan, moved, seen));
    }
    // Curvature between the corners, and single precision in what follows: dot products, a power.
    let is_point = |light: &PlanLight| matches!(light, PlanLight::Point { .. });
    // The way to a lamp is a difference of two places far from the origin.
    let single = if plan.lights.iter().any(is_point) {
        8e-6
    } else {
        2e-6
    };
    let slack = turn * turn * f64::from(shininess).max(1.0) + single;
    let power = 1.5 * single * f64::from(shininess).max(1.0);
    let strength = any_normal(plan, seen);
    for c in 0..3 {
        lighting.factor[c] = lighting.factor[c].widened(slack * strength.factor[c].hi);
        lighting.highlight[c] =
            lighting.highlight[c].widened((slack + power) * strength.highlight[c].hi);
    }
    lighting
}

/// Whatever the normal is.
fn any_normal(plan: &Plan, seen: Seen) -> Lighting {
    let Some(Parts {
        ambient,
        diffuse,
        specular,
        ..
    }) = Parts::of(plan)
    else {
        return Lighting::UNLIT;
    };
    let mut lighting = Lighting {
        factor: [Range::exactly(f64::from(ambient)); 3],
        highlight: [Range::exactly(0.0); 3],
    };
    for light in &plan.lights {
        let (_, radiance) = seen.arriving(light);
        for (c, radiance) in radiance.into_iter().enumerate() {
            lighting.factor[c].hi += f64::from(diffuse) * radiance;
            lighting.highlight[c].hi += f64::from(specular) * radiance;
        }
    }
    lighting
}

fn blinn_phong(plan: &Plan, gradient: DVec3, seen: Seen) -> Lighting {
    let Some(Parts {
        ambient,
        diffuse,
        specular,
        shininess,
    }) = Parts::of(plan)
    else {
        return Lighting::UNLIT;
    };
    let Some(normal) = gradient.try_normalize() else {
        return Lighting::UNLIT;
    };
    let view = -seen.direction;
    let normal = if normal.dot(view) < 0.0 {
        -normal
    } else {
        normal
    };
    let mut factor = [f64::from(ambient); 3];
    let mut highlight = [0.0; 3];
    for light in &plan.lights {
        let (to_light, radiance) = seen.arriving(light);
        let cosine = normal.dot(to_light).max(0.0);
        let half = (to_light + view).normalize_or_zero();
        let lobe = normal.dot(half).max(0.0).powf(f64::from(shininess));
        for (c, radiance) in radiance.into_iter().enumerate() {
            factor[c] += f64::from(diffuse) * radiance * cosine;
            if cosine > 0.0 {
                highlight[c] += f64::from(specular) * radiance * lobe;
            }
        }
    }
    Lighting {
        factor: factor.map(Range::exactly),
        highlight: highlight.map(Range::exactly),
    }
}
