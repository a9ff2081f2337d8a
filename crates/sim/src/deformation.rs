//! Bent rays (document §8.7): every sample is moved across its ray, by a table or a formula.

use crate::Error;
use crate::rays::RaySetup;
use crate::spec::Bend;

/// Offsets of every sample across its ray, to the right and up, in 1/256 voxels, 2 bytes each.
#[derive(Clone, Debug, PartialEq)]
pub enum Deformation {
    /// Pixel after pixel (rows from the bottom).
    Table {
        /// Offsets per ray; beyond them the last counts.
        planes: u32,
        /// `planes` of each pixel.
        offsets: Vec<[i16; 2]>,
    },
    /// What the host would load by a formula.
    Formula {
        /// Offsets per ray.
        planes: u32,
        /// The formula.
        bend: Bend,
    },
}

impl Deformation {
    /// By the formula of a Spec; none for straight rays.
    ///
    /// # Errors
    /// If an offset does not fit its word.
    pub fn of_bend(bend: Bend, setup: &RaySetup) -> Result<Option<Deformation>, Error> {
        let planes = setup.plane_count();
        let corner = setup.lateral(0, planes - 1);
        let reach = corner[0].hypot(corner[1]);
        let (field, value, farthest) = match bend {
            Bend::None => return Ok(None),
            Bend::Twist { deg_per_plane } => {
                let angle = (deg_per_plane.abs() * f64::from(planes)).min(180.0);
                let chord = 2.0 * reach * (0.5 * angle.to_radians()).sin();
                ("bend.twist.deg_per_plane", deg_per_plane, chord)
            }
            // Where 1 − 5 (r / radius)² is 0.
            Bend::Lens { strength, radius } => (
                "bend.lens.radius",
                radius,
                strength * radius * 0.64 / 5.0f64.sqrt(),
            ),
        };
        if farthest > 127.9 {
            let problem =
                format!("samples would move {farthest:.0} voxels; a word holds at most 127");
            return Err(Error::field(field, value, problem));
        }
        Ok(Some(Deformation::Formula { planes, bend }))
    }

    /// Offsets per ray.
    pub fn planes(&self) -> u32 {
        match self {
            Deformation::Table { planes, .. } | Deformation::Formula { planes, .. } => *planes,
        }
    }

    /// The offset of a sample.
    pub fn offset(&self, setup: &RaySetup, pixel: u32, plane: u32) -> [i16; 2] {
        let plane = plane.min(self.planes().saturating_sub(1));
        match self {
            Deformation::Table { planes, offsets } => {
                let index = pixel as usize * *planes as usize + plane as usize;
                offsets.get(index).copied().unwrap_or_default()
            }
            Deformation::Formula { bend, .. } => {
                let [u, v] = setup.lateral(pixel, plane);
                let [du, dv] = match *bend {
                    Bend::None => [0.0; 2],
                    Bend::Twist { deg_per_plane } => {
                        let (sin, cos) = (deg_per_plane * f64::from(plane)).to_radians().sin_cos();
                        [u * cos - v * sin - u, u * sin + v * cos - v]
                    }
                    Bend::Lens { strength, radius } => {
                        let part = (1.0 - (u * u + v * v) / (radius * radius)).max(0.0);
                        [u, v].map(|c| -strength * part * part * c)
                    }
                };
                [du, dv].map(|c| (c * 256.0).round() as i16)
            }
        }
    }
}
