//! Which points of a ray are looked at: every lattice point, more of them, or fewer.

use crate::plan;
use crate::problem::{Checker, Within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where along a ray samples are taken. All rules except `regular` need the method
/// `emission-absorption` and a single volume; `refine` also works with `mip` and `minip`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Sampling {
    /// The rule; default `regular`, or `adaptive` if `error` is set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rule: Option<SamplingRule>,
    /// `refine`, `split` and `split-cubic`: parts of a step, 1 to 64; default 8 for `refine`, else 10.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<u32>,
    /// `adaptive`: the largest difference from the regular picture in any channel (0 to 1,
    /// linear light), 0 to 0.5; default 0.01.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// `by-opacity`: the largest contribution to a pixel, 0 to 1, of a sample that stands for
    /// two or four lattice points; default 0.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
}

/// A rule of sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SamplingRule {
    /// One sample at every lattice point.
    Regular,
    /// Subdivides a step if the transfer function shows something between the values at its
    /// ends. With `mip` and `minip`: searches around the largest or smallest value of each ray.
    Refine,
    /// Subdivides the same steps, with values interpolated linearly instead of read from the
    /// volume.
    Split,
    /// Subdivides the same steps, with values on a cubic through four lattice points.
    SplitCubic,
    /// Integrates the transfer function between the values at the ends of each step
    /// (pre-integration).
    Integrated,
    /// Fewer samples where the transfer function hardly changes.
    Adaptive,
    /// Fewer samples where they contribute little to the pixel.
    ByOpacity,
}

impl SamplingRule {
    /// Every rule.
    pub const ALL: [SamplingRule; 7] = [
        SamplingRule::Regular,
        SamplingRule::Refine,
        SamplingRule::Split,
        SamplingRule::SplitCubic,
        SamplingRule::Integrated,
        SamplingRule::Adaptive,
        SamplingRule::ByOpacity,
    ];

    /// The name used in scenes.
    pub fn name(self) -> &'static str {
        match self {
            SamplingRule::Regular => "regular",
            SamplingRule::Refine => "refine",
            SamplingRule::Split => "split",
            SamplingRule::SplitCubic => "split-cubic",
            SamplingRule::Integrated => "integrated",
            SamplingRule::Adaptive => "adaptive",
            SamplingRule::ByOpacity => "by-opacity",
        }
    }

    /// Parts of a step unless a scene says otherwise; `None` where a step is not divided.
    fn default_parts(self) -> Option<u32> {
        match self {
            SamplingRule::Regular
            | SamplingRule::Integrated
            | SamplingRule::Adaptive
            | SamplingRule::ByOpacity => None,
            SamplingRule::Refine => Some(8),
            // More change nothing that can be seen with smooth transfer functions.
            SamplingRule::Split | SamplingRule::SplitCubic => Some(10),
        }
    }
}

/// [`Sampling`] with a number for everything, also for what the rule does not ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledSampling {
    pub rule: SamplingRule,
    pub parts: u32,
    pub error: f64,
    pub share: f64,
}

impl Sampling {
    /// The sampling that this means; keys that its rule does not have are problems.
    pub(crate) fn settled(self, checker: &mut Checker) -> SettledSampling {
        let rule = self.rule.unwrap_or(match self.error {
            Some(_) => SamplingRule::Adaptive,
            None => SamplingRule::Regular,
        });
        for (given, fits, key, allowed) in [
            (
                self.parts.is_some(),
                rule.default_parts().is_some(),
                "parts",
                "refine, split and split-cubic divide a step",
            ),
            (
                self.error.is_some(),
                rule == SamplingRule::Adaptive,
                "error",
                "it belongs to adaptive",
            ),
            (
                self.share.is_some(),
                rule == SamplingRule::ByOpacity,
                "share",
                "it belongs to by-opacity",
            ),
        ] {
            if given && !fits {
                checker.add(
                    format!("sampling.{key}"),
                    format!("given for rule {:?}", rule.name()),
                    &format!("nothing: {allowed}"),
                );
            }
        }
        SettledSampling {
            rule,
            parts: match rule.default_parts() {
                Some(parts) => self.parts.unwrap_or(parts),
                None => 1,
            },
            error: match rule {
                SamplingRule::Adaptive => self.error.unwrap_or(0.01),
                _ => 0.0,
            },
            share: match rule {
                SamplingRule::ByOpacity => self.share.unwrap_or(0.2),
                _ => 0.0,
            },
        }
    }
}

impl SettledSampling {
    /// As a scene says it.
    pub fn scene(self) -> Sampling {
        let rule = self.rule;
        Sampling {
            rule: Some(rule),
            parts: rule.default_parts().map(|_| self.parts),
            error: (rule == SamplingRule::Adaptive).then_some(self.error),
            share: (rule == SamplingRule::ByOpacity).then_some(self.share),
        }
    }

    /// With every number checked.
    pub fn plan(self, checker: &mut Checker) -> plan::Sampling {
        let SettledSampling {
            rule,
            parts,
            error,
            share,
        } = self;
        if !(1..=64).contains(&parts) {
            checker.add("sampling.parts", parts, "1 to 64");
        }
        checker.number("sampling.error", error, Within::Closed(0.0, 0.5));
        checker.number("sampling.share", share, Within::Closed(0.0, 1.0));
        match rule {
            SamplingRule::Regular => plan::Sampling::Regular,
            SamplingRule::Refine => plan::Sampling::Refine { parts },
            SamplingRule::Split => plan::Sampling::Split {
                parts,
                curve: plan::Curve::Linear,
            },
            SamplingRule::SplitCubic => plan::Sampling::Split {
                parts,
                curve: plan::Curve::Cubic,
            },
            SamplingRule::Integrated => plan::Sampling::Integrated,
            // What must not differ at all is the regular picture.
            SamplingRule::Adaptive if error as f32 == 0.0 => plan::Sampling::Regular,
            SamplingRule::Adaptive => plan::Sampling::Adaptive {
                error: error as f32,
            },
            // What may make up nothing is no sample: every lattice point has its own.
            SamplingRule::ByOpacity if share as f32 == 0.0 => plan::Sampling::Regular,
            SamplingRule::ByOpacity => plan::Sampling::ByOpacity {
                share: share as f32,
            },
        }
    }
}

/// What a rule cannot be combined with.
pub(crate) fn check_together(plan: &plan::Plan, checker: &mut Checker) {
    use plan::{Classify, Composite, Illustrate, Sampling, Shade};
    if plan.sampling == Sampling::Regular {
        return;
    }
    let mut refuse = |what: &str, allowed: &str| {
        let allowed = format!("\"regular\", or {allowed}");
        let rule = format!("{:?} {what}", plan.sampling.name());
        checker.add("sampling.rule", rule, &allowed);
    };
    let projects = matches!(
        plan.technique().composite,
        Composite::Mip | Composite::Minip
    );
    let refines = matches!(plan.sampling, Sampling::Refine { .. });
    let adds = matches!(
        plan.technique().composite,
        Composite::EmissionAbsorption { .. }
    );
    if !(adds || projects && refines) {
        refuse(
            "with a method that looks at lattice points",
            "method emission-absorption, or rule \"refine\" with mip or minip",
        );
    }
    if plan.layers.len() > 1 {
        refuse("with several volumes", "one volume");
    }
    if !plan.modules.is_empty() {
        refuse("with functions of your own", "functions of the library");
    }
    let by_value = matches!(
        plan.technique().classify,
        Classify::Table | Classify::Identity { .. } | Classify::Threshold { .. }
    );
    match plan.sampling {
        Sampling::Regular => {}
        Sampling::Refine { .. } => {
            if adds && plan.technique().classify == Classify::PreClassified {
                refuse(
                    "with voxels that are classified before they are interpolated",
                    "classification by the value of the sample",
                );
            }
        }
        Sampling::Split { .. } => {
            if !by_value {
                refuse(
                    "with a classification that needs more than the value",
                    "classification by the value, or rule \"refine\"",
                );
            }
        }
        Sampling::Integrated | Sampling::ByOpacity { .. } => {
            if plan.technique().classify != Classify::Table {
                refuse(
                    "with a classification that is no table of values",
                    "a transfer function of the value, or rule \"refine\"",
                );
            }
        }
        Sampling::Adaptive { .. } => {
            if plan.technique().classify != Classify::Table {
                refuse(
                    "with a classification that is no table of values",
                    "a transfer function of the value",
                );
            }
            if plan.technique().shade != Shade::Unlit {
                refuse(
                    "with shading: its light changes with the gradient, which nothing bounds",
                    "shading \"unlit\"",
                );
            }
            if plan.technique().illustrate != Illustrate::Plain {
                refuse(
                    "with a function for the slot illustrate: its color changes with the place, which nothing bounds",
                    "no such function",
                );
            }
        }
    }
}
