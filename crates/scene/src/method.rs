//! What becomes of the samples of a ray.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the samples of a ray become a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Light and opacity add up along the ray, front to back.
    EmissionAbsorption,
    /// The largest value of the ray (maximum intensity projection).
    Mip,
    /// The smallest value of the ray.
    Minip,
    /// The mean value of the ray, as an X-ray film.
    Average,
    /// The largest gradient magnitude of the ray.
    Gmip,
    /// Maximum intensity difference accumulation: larger values shine through what lies before them.
    Mida,
    /// The first place where the value reaches `threshold`, as a solid surface.
    FirstHit,
}

impl Method {
    /// Every method.
    pub const ALL: [Method; 7] = [
        Method::EmissionAbsorption,
        Method::Mip,
        Method::Minip,
        Method::Average,
        Method::Gmip,
        Method::Mida,
        Method::FirstHit,
    ];

    /// The name used in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::EmissionAbsorption => "emission-absorption",
            Method::Mip => "mip",
            Method::Minip => "minip",
            Method::Average => "average",
            Method::Gmip => "gmip",
            Method::Mida => "mida",
            Method::FirstHit => "first-hit",
        }
    }

    /// Whether one number per ray makes the pixel; without a word about shading it is unlit then.
    pub fn is_projection(self) -> bool {
        matches!(
            self,
            Method::Mip | Method::Minip | Method::Average | Method::Gmip
        )
    }
}

impl std::str::FromStr for Method {
    type Err = String;

    fn from_str(name: &str) -> Result<Method, String> {
        Method::ALL
            .into_iter()
            .find(|method| method.name() == name)
            .ok_or_else(|| {
                let names = Method::ALL.map(Method::name).join(", ");
                format!("{name:?} is not a method; known are {names}")
            })
    }
}
