//! Importance that is data: a volume that says how important each place is.

use crate::Headers;
use crate::clip::unit_from_world;
use crate::plan::{Composite, MOST_MASKS, Plan, PlanImportance};
use crate::problem::{Checker, Within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_shader::registry::Function;

/// A volume that says how important each place is, from 0 to 1; nothing beyond its extent is important.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ImportanceSource {
    /// File with the volume, on a grid of its own, relative to the folder of the scene file. It moves with the volume
    /// that is drawn.
    pub path: String,
    /// The values whose share is 0 and 1; default 0 and 1. Values are interpolated linearly between voxel centers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// The importance of a place whose share is 1, 0 to 50; default 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
}

/// The measure of `importance-aware` that reads such a volume.
pub(crate) const BY_VOLUME: u32 = 5;

impl ImportanceSource {
    /// What 1 is worth.
    pub(crate) fn gain(&self) -> f64 {
        let default =
            || Function::find("composite", "importance_aware").map(|f| f.default_of("gain"));
        self.gain.or_else(default).unwrap_or(1.0)
    }

    /// `mask` is its number among the masks of the data; `plan` has its fields.
    pub(crate) fn plan(
        &self,
        mask: usize,
        plan: &Plan,
        headers: &Headers,
        checker: &mut Checker,
    ) -> Option<PlanImportance> {
        let [low, high] = self.range.unwrap_or([0.0, 1.0]);
        let large = Within::Closed(-1e30, 1e30);
        checker.number("importance.range[0]", low, large);
        checker.number("importance.range[1]", high, large);
        if low as f32 == high as f32 {
            let range = format!("{:?}", [low, high]);
            checker.add("importance.range", range, "two different numbers");
        }
        let gain = self.gain();
        checker.number("importance.gain", gain, Within::Closed(0.0, 50.0));
        if mask >= MOST_MASKS {
            let allowed =
                format!("at most {MOST_MASKS} masks in one picture, of which `importance` is one");
            checker.add("importance", format!("mask number {}", mask + 1), &allowed);
            return None;
        }
        let Some(grid) = headers.masks.get(mask) else {
            let there = format!("{:?}, which is not loaded", self.path);
            checker.add(
                "importance.path",
                there,
                "a volume that is loaded with the scene",
            );
            return None;
        };
        let own = &headers.drawn(0).grid;
        let back = own.world_from_voxel() * plan.field().grid.voxel_from_world();
        let unit = unit_from_world(grid);
        Some(PlanImportance {
            mask,
            unit_from_world: match plan.field().is_moved {
                true => unit * back,
                false => unit,
            },
            low: low as f32,
            high: high as f32,
            gain_of_runs: gain as f32,
        })
    }
}

impl Plan {
    /// Whether anything of it asks for importance by place.
    pub(crate) fn reads_importance(&self) -> bool {
        let is_read = |composite: Composite| {
            matches!(
                composite,
                Composite::ImportanceAware {
                    measure: BY_VOLUME,
                    ..
                }
            )
        };
        self.weighs_runs() || self.drawn_techniques().any(|t| is_read(t.composite))
    }

    /// Importance by place, where a technique asks for it and there is none.
    pub(crate) fn check_importance(&self, checker: &mut Checker) {
        if self.importance.is_none() && self.reads_importance() && !self.weighs_runs() {
            checker.add(
                "functions.composite.params.measure",
                BY_VOLUME,
                "0 to 4; 5 needs the key `importance`",
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, resolve_with};
    use strahl_volume::Phantom;

    /// The importance of the Plan, and the measure and the gain of its rule; or what is wrong.
    fn planned(text: &str) -> Result<(Option<PlanImportance>, Composite), String> {
        let volume = Phantom::Tree.volume([8, 9, 10]).unwrap();
        let headers = Headers {
            masks: vec![*volume.grid()],
            ..Headers::from(volume.header())
        };
        let scene = Scene::parse("scene", text).unwrap();
        let again = serde_json::to_string(&scene).unwrap();
        assert_eq!(Scene::parse("scene", &again).unwrap(), scene);
        let plan = resolve_with(&scene, &headers).map_err(|problems| problems.to_string())?;
        Ok((plan.importance, plan.technique().composite))
    }

    #[test]
    fn the_method_reads_the_volume_that_there_is() {
        let text = r#"{ "method": "importance-aware", "importance": { "path": "i", "range": [2, 9], "gain": 4 } }"#;
        let (importance, composite) = planned(text).unwrap();
        let importance = importance.unwrap();
        assert_eq!((importance.low, importance.high), (2.0, 9.0));
        assert_eq!((importance.mask, importance.gain_of_runs), (0, 4.0));
        assert!(matches!(
            composite,
            Composite::ImportanceAware {
                measure: BY_VOLUME,
                gain: 4.0,
                ..
            }
        ));
        let (none, composite) = planned(r#"{ "method": "importance-aware" }"#).unwrap();
        assert!(none.is_none());
        assert!(matches!(
            composite,
            Composite::ImportanceAware { measure: 0, .. }
        ));
    }

    #[test]
    fn every_mistake_is_named() {
        for (text, expected) in [
            (
                r#"{ "importance": { "path": "i", "range": [1, 1] } }"#,
                "importance.range is [1.0, 1.0]; allowed: two different numbers",
            ),
            (
                r#"{ "importance": { "path": "i", "gain": 51 } }"#,
                "importance.gain is 51; allowed: 0 to 50",
            ),
            (
                r#"{ "clips": [{ "mask": { "path": "m" } }], "importance": { "path": "i" } }"#,
                "importance.path is \"i\", which is not loaded",
            ),
            (
                r#"{ "functions": { "composite": { "module": "importance-aware", "params": { "measure": 5 } } } }"#,
                "functions.composite.params.measure is 5; allowed: 0 to 4",
            ),
        ] {
            let found = planned(text).unwrap_err();
            assert!(found.contains(expected), "{text}: {found}");
        }
    }
}
