//! Presets: scene fragments that fill in what a scene does not say.

use crate::nearest::nearest;
use crate::patient::{is_patient, looks_like_hounsfield};
use crate::problem::Number;
use crate::window::{otsu_threshold, share_above};
use crate::{Headers, LabelHeader, Method, PointsIn, Scene, SegmentChoice, SegmentUse};
use strahl_volume::{Modality, VolumeHeader};

/// Name and purpose of a preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetInfo {
    /// The name that scenes and the command line use.
    pub name: &'static str,
    /// What it is for.
    pub description: &'static str,
    text: &'static str,
}

macro_rules! preset {
    ($name:literal, $description:literal) => {
        PresetInfo {
            name: $name,
            description: $description,
            text: include_str!(concat!("../presets/", $name, ".json")),
        }
    };
}

static PRESETS: [PresetInfo; 16] = [
    preset!(
        "ct-bone",
        "CT: bone and contrast agent, without soft tissue"
    ),
    preset!(
        "ct-soft-tissue",
        "CT: skin and muscle, translucent over bone"
    ),
    preset!(
        "ct-angio",
        "CT with contrast agent: red vessels, ivory bone"
    ),
    preset!("ct-lung", "CT: lungs and airways"),
    preset!("mr", "MR: tissue solid from the noise upwards"),
    preset!("vessels", "angiography without bone: bright vessels"),
    preset!(
        "solid",
        "any volume: solid high values, translucent low values"
    ),
    preset!(
        "grey",
        "any volume: gray, transparent to opaque over the window"
    ),
    preset!(
        "ghost",
        "any volume or its segments: lit surfaces transparent, contours and the inside visible"
    ),
    preset!(
        "context",
        "volumes with labels: solid bones, everything else as a ghost around them"
    ),
    preset!(
        "atlas",
        "volumes with labels: every segment in its color with darker contours, on paper"
    ),
    preset!(
        "anatomy",
        "volumes with labels: solid bones, vessels, organs in a ghost of skin and muscle"
    ),
    preset!(
        "angio-over-bone",
        "volumes with labels: vessels seen through bones, nothing else"
    ),
    preset!("mip", "any volume: largest value of each ray"),
    preset!(
        "minip",
        "any volume: smallest value of each ray, for airways"
    ),
    preset!(
        "x-ray",
        "any volume: mean value of each ray, like an X-ray film"
    ),
];

/// What a person should know who draws this with the preset of `scene`.
pub fn preset_notes(scene: &Scene, headers: &Headers) -> Vec<String> {
    let mut notes = Vec::new();
    let Some(preset) = scene.preset.as_deref().and_then(PresetInfo::find) else {
        return notes;
    };
    let of_preset = preset.scene();
    let function = of_preset.transfer_function.unwrap_or_default();
    let own = scene.transfer_function.clone().unwrap_or_default();
    let in_values = function.points.is_some() && function.points_in != Some(PointsIn::Window);
    if in_values && own.points.is_none() {
        if own.window.is_some() || own.level.is_some() {
            notes.push(format!(
                "the window replaces the points of the preset {}, which count in HU, by a ramp; leave the window out, or choose a preset whose points count in the window, such as solid",
                preset.name
            ));
        } else if let Some(header) = headers.volumes.first()
            && header.metadata.modality != Some(Modality::Ct)
            && !looks_like_hounsfield(header)
        {
            let [low, high] = header.statistics.range;
            notes.push(format!(
                "the preset {} counts in HU, and the values, {} to {}, do not look like HU; solid and vessels fit other values",
                preset.name,
                Number(low),
                Number(high)
            ));
        }
    }
    if let (Some(labels), Some(uses)) = (&headers.labels, &of_preset.segments) {
        notes.extend(note_of_names(preset.name, uses, labels));
    }
    notes
}

/// A note if no segment has a name that the preset looks for.
fn note_of_names(preset: &str, uses: &[SegmentUse], labels: &LabelHeader) -> Option<String> {
    let everything = SegmentChoice::Name("*".to_owned());
    let mut named = uses.iter().filter(|used| used.of != everything).peekable();
    named.peek()?;
    let is_named = named.any(|used| {
        let mut segments = labels.segments();
        segments.any(|(id, label)| used.of.has(id, label))
    });
    (!is_named).then(|| {
        format!(
            "no segment has a name that the preset {preset} looks for, such as skull, rib_left_1, aorta (`strahl presets {preset}` lists them)"
        )
    })
}

/// The built-in presets.
pub fn presets() -> &'static [PresetInfo] {
    &PRESETS
}

impl PresetInfo {
    /// The preset called `name`; `gray` and `grey` are the same word.
    pub fn find(name: &str) -> Option<&'static PresetInfo> {
        let wanted = name.replace("gray", "grey");
        PRESETS.iter().find(|preset| preset.name == wanted)
    }

    /// The name of the preset that was probably meant by `name`, which is none.
    pub fn nearest(name: &str) -> Option<&'static str> {
        nearest(name, PRESETS.iter().map(|preset| preset.name))
    }

    /// The preset as the text of a scene, with comments, ready to be saved and edited.
    pub fn text(&self) -> &'static str {
        self.text
    }

    /// The preset as a scene that says only what the preset decides.
    ///
    /// # Panics
    /// Never: a test parses every preset.
    pub fn scene(&self) -> Scene {
        match Scene::parse(self.name, self.text) {
            Ok(scene) => scene,
            Err(error) => unreachable!("built-in preset: {error}"),
        }
    }

    /// The preset for a scene that names none: after its method, then after the device that made
    /// the volume, then after its values.
    pub fn automatic(method: Option<Method>, header: &VolumeHeader) -> &'static PresetInfo {
        let name = match method {
            Some(Method::Mip) => "mip",
            Some(Method::Minip) => "minip",
            Some(Method::Average) => "x-ray",
            Some(Method::Gmip) => "grey",
            _ => by_volume(header),
        };
        PresetInfo::find(name).unwrap_or(&PRESETS[0])
    }
}

fn by_volume(header: &VolumeHeader) -> &'static str {
    let statistics = &header.statistics;
    match header.metadata.modality {
        Some(Modality::Ct) => "ct-bone",
        Some(Modality::Mr) => "mr",
        Some(Modality::Nuclear | Modality::Ultrasound) => "mr",
        Some(Modality::Microscopy | Modality::Simulation) => "solid",
        None if looks_like_hounsfield(header) => "ct-bone",
        None if is_patient(header) => {
            // Less than a twentieth of the box is bright: vessels from which the rest was taken.
            if share_above(statistics, otsu_threshold(statistics)) < 0.05 {
                "vessels"
            } else {
                "mr"
            }
        }
        None => "solid",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_name_finds_the_preset() {
        for (name, meant) in [
            ("bone", Some("ct-bone")),
            ("Bones", Some("ct-bone")),
            ("soft tissue", Some("ct-soft-tissue")),
            ("lung", Some("ct-lung")),
            ("angio", Some("ct-angio")),
            ("ct-bnoe", Some("ct-bone")),
            ("contxt", Some("context")),
            ("xray", Some("x-ray")),
            ("zebra", None),
        ] {
            assert_eq!(PresetInfo::nearest(name), meant, "{name}");
        }
        assert_eq!(PresetInfo::find("gray"), PresetInfo::find("grey"));
        assert!(PresetInfo::find("gray").is_some());
    }

    /// [`PresetInfo::scene`] relies on it.
    #[test]
    fn every_preset_can_be_read() {
        for preset in presets() {
            let scene = preset.scene();
            assert!(
                scene.method.is_some() && scene.transfer_function.is_some(),
                "{}",
                preset.name
            );
        }
    }
}
