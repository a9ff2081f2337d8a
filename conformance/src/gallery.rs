//! One scene per variant of every step of the ray: what `docs/gallery.md` shows, and what the tests draw on
//! both renderers.

use std::borrow::Cow;
use strahl_shader::registry::{FUNCTIONS, Function};

/// A step of the ray, the variant's name (as a file name), and what its scene says beside the size.
pub type Variant = (&'static str, &'static str, Cow<'static, str>);

/// Transparent skin, so that the steps inside are seen.
macro_rules! solid {
    ($more:literal) => {
        concat!(r#""preset": "ct-soft-tissue", "#, $more)
    };
}

/// Variants whose scenes are chosen so that one sees what they do, in the order of the steps.
const CHOSEN: &[(&str, &str, &str)] = &[
    ("quality", "quality-null", r#""quality": "null""#),
    ("quality", "quality-minimum", r#""quality": "minimum""#),
    ("quality", "quality-medium", r#""quality": "medium""#),
    ("quality", "quality-maximum", r#""quality": "maximum""#),
    (
        "clip_ray",
        "plane",
        r#""clips": [{ "plane": { "normal": [0.3, 1, 0.2], "point": [0, 10, 0] } }]"#,
    ),
    (
        "clip_ray",
        "planes",
        r#""clips": [{ "plane": { "normal": [0, 1, 0], "point": [0, 0, 0] } }, { "plane": { "normal": [-1, 0, 0.5], "point": [10, 0, 0] } }]"#,
    ),
    (
        "clip_sample",
        "box",
        r#""clips": [{ "box": { "min": [0.1, 0.3, 0.1], "max": [0.9, 0.9, 0.8], "space": "fraction" } }]"#,
    ),
    (
        "clip_sample",
        "box-outside",
        r#""clips": [{ "box": { "min": [0.5, 0.5, 0.5], "max": [1, 1, 1], "space": "fraction", "keep": "outside" } }]"#,
    ),
    (
        "clip_sample",
        "ellipsoid",
        r#""clips": [{ "ellipsoid": { "min": [0.1, 0.2, 0.1], "max": [0.8, 0.9, 0.9], "space": "fraction" } }]"#,
    ),
    (
        "clip_sample",
        "cylinder-outside",
        r#""clips": [{ "cylinder": { "min": [0.4, 0.5, 0], "max": [0.7, 1, 1], "space": "fraction", "keep": "outside" } }]"#,
    ),
    (
        "jitter",
        "jitter-none",
        r#""step_mm": 8, "preset": "ct-bone""#,
    ),
    (
        "jitter",
        "jitter-hash",
        r#""step_mm": 8, "preset": "ct-bone", "jitter": { "seed": 7 }"#,
    ),
    (
        "jitter",
        "jitter-sine-hash",
        r#""step_mm": 8, "preset": "ct-bone", "jitter": "sine-hash""#,
    ),
    (
        "jitter",
        "jitter-white-tile",
        r#""step_mm": 8, "preset": "ct-bone", "jitter": { "white-tile": 3 }"#,
    ),
    (
        "jitter",
        "jitter-blue-tile",
        r#""step_mm": 8, "preset": "ct-bone", "jitter": { "blue-tile": 3 }"#,
    ),
    (
        "jitter",
        "jitter-accumulated",
        r#""step_mm": 8, "preset": "ct-bone", "jitter": { "blue-tile": 3 }, "frames": 8"#,
    ),
    (
        "fetch",
        "fetch-noise",
        r##""functions": { "fetch": { "module": "noise", "params": { "cell_voxels": 9 } } }, "transfer_function": { "points": [[0.3, 0, "#ff8040"], [0.8, 0.9, "#80c0ff"]] }"##,
    ),
    (
        "fetch",
        "fetch-marschner-lobb",
        r##""functions": { "fetch": { "module": "marschner_lobb" } }, "transfer_function": { "points": [[0.45, 0, "#ff8040"], [0.55, 0.9, "#80c0ff"]] }"##,
    ),
    ("reconstruct", "nearest", r#""reconstruct": "nearest""#),
    ("reconstruct", "trilinear", r#""reconstruct": "trilinear""#),
    ("reconstruct", "b-spline", r#""reconstruct": "b-spline""#),
    (
        "reconstruct",
        "b-spline-interpolating",
        r#""reconstruct": "b-spline-interpolating""#,
    ),
    (
        "reconstruct",
        "catmull-rom",
        r#""reconstruct": "catmull-rom""#,
    ),
    ("classify", "table", r#""preset": "ct-soft-tissue""#),
    (
        "classify",
        "identity",
        r#""functions": { "classify": { "module": "identity", "params": { "black": 0, "white": 1500 } } }"#,
    ),
    (
        "classify",
        "threshold",
        r#""functions": { "classify": { "module": "threshold", "params": { "threshold": 300, "black": -500, "white": 1500 } } }"#,
    ),
    (
        "classify",
        "gradient-table",
        r#""preset": "ct-soft-tissue", "functions": { "classify": { "module": "gradient_table", "params": { "low_per_mm": 5, "high_per_mm": 100 } } }"#,
    ),
    (
        "classify",
        "pre-classified",
        r#""preset": "ct-soft-tissue", "functions": { "classify": { "module": "pre_classified" } }"#,
    ),
    (
        "classify",
        "value-gradient",
        r##""transfer_function": { "regions": [{ "corners": [[150, 0], [3000, 0], [3000, 30], [150, 30]], "opacity": 0.03, "color": "#c64" }, { "corners": [[100, 60], [1500, 60], [1500, 900], [100, 900]], "opacity": 0.5, "color": "#fec" }] }"##,
    ),
    (
        "gradient",
        "forward",
        r#""gradient": { "method": "forward" }"#,
    ),
    (
        "gradient",
        "backward",
        r#""gradient": { "method": "backward" }"#,
    ),
    (
        "gradient",
        "central",
        r#""gradient": { "method": "central" }"#,
    ),
    (
        "gradient",
        "central-9",
        r#""gradient": { "method": "central-9" }"#,
    ),
    ("gradient", "sobel", r#""gradient": { "method": "sobel" }"#),
    (
        "gradient",
        "gradient-b-spline",
        r#""gradient": { "method": "b-spline" }"#,
    ),
    (
        "gradient",
        "gradient-of-opacity",
        r#""gradient": { "of": "opacity" }"#,
    ),
    (
        "light",
        "directional",
        r#""lights": [{ "type": "directional", "azimuth_deg": -50, "elevation_deg": 30 }]"#,
    ),
    (
        "light",
        "point",
        r#""lights": [{ "type": "point", "position": [60, 150, 60], "reach_mm": 160 }]"#,
    ),
    ("light", "head", r#""lights": [{ "type": "head" }]"#),
    (
        "illuminate",
        "lambert",
        r#""shading": { "model": "lambert" }"#,
    ),
    ("illuminate", "phong", r#""shading": { "model": "phong" }"#),
    (
        "illuminate",
        "blinn-phong",
        r#""shading": { "model": "blinn-phong" }"#,
    ),
    (
        "illuminate",
        "blinn-phong-two-sided",
        r#""shading": { "model": "blinn-phong-two-sided" }, "lights": [{ "type": "directional", "azimuth_deg": 200, "elevation_deg": 20 }]"#,
    ),
    (
        "illuminate",
        "cook-torrance",
        r#""shading": { "model": "cook-torrance" }"#,
    ),
    ("shade", "unlit", r#""shading": { "model": "unlit" }"#),
    (
        "shade",
        "keep-last-normal",
        solid!(r#""shading": { "keep_last_normal": true }"#),
    ),
    (
        "shade",
        "gradient-opacity",
        solid!(r#""shading": { "model": "gradient-opacity" }"#),
    ),
    (
        "illustrate",
        "depth-cue",
        solid!(r#""functions": { "illustrate": { "module": "depth_cue" } }"#),
    ),
    (
        "composite",
        "emission-absorption",
        solid!(r#""method": "emission-absorption""#),
    ),
    (
        "composite",
        "back-to-front",
        solid!(r#""functions": { "composite": { "module": "back_to_front" } }"#),
    ),
    ("composite", "mip", r#""method": "mip", "preset": "mip""#),
    (
        "composite",
        "minip",
        r#""method": "minip", "preset": "minip", "clips": [{ "ellipsoid": { "min": [0.25, 0.25, 0.35], "max": [0.75, 0.75, 0.9], "space": "fraction" } }]"#,
    ),
    (
        "composite",
        "average",
        r#""method": "average", "preset": "x-ray""#,
    ),
    ("composite", "gmip", r#""method": "gmip""#),
    ("composite", "mida", r#""method": "mida""#),
    ("composite", "first-hit", r#""method": "first-hit""#),
    (
        "composite",
        "display-space",
        r##""compositing": "display", "background": "#406080""##,
    ),
    ("debug", "debug-entry", r#""debug": "entry""#),
    ("debug", "debug-exit", r#""debug": "exit""#),
    ("debug", "debug-normal", r#""debug": "normal""#),
    ("debug", "debug-gradient-raw", r#""debug": "gradient-raw""#),
    (
        "debug",
        "debug-gradient-magnitude",
        r#""debug": "gradient-magnitude""#,
    ),
    ("debug", "debug-sample-count", r#""debug": "sample-count""#),
    ("debug", "debug-depth", r#""debug": "depth""#),
];

/// Functions that need no picture of their own: every picture that says nothing shows them, or a chosen one with another
/// name; segments, and the last two, need more than a volume.
const SHOWN: [(&str, &str); 8] = [
    ("fetch", "stored"),
    ("gradient_input", "value"),
    ("gradient_input", "opacity"),
    ("gradient_input", "segment"),
    ("shade", "lit"),
    ("shade", "lit_last_normal"),
    ("clip_ray", "depth"),
    ("clip_sample", "mask"),
];

/// All variants: the chosen ones, and a plain scene for every function of the registry that has none of them.
pub fn gallery() -> Vec<Variant> {
    let mut all: Vec<Variant> = CHOSEN
        .iter()
        .map(|&(step, name, keys)| (step, name, keys.into()))
        .collect();
    for function in &FUNCTIONS {
        let is_chosen = CHOSEN
            .iter()
            .any(|(step, name, _)| shows(step, name, function));
        let is_shown = SHOWN.contains(&(function.slot, function.name));
        if is_chosen || is_shown || function.is_way_of.is_some() {
            continue;
        }
        let Some(keys) = plain(function) else {
            continue;
        };
        let behind = all.iter().rposition(|(step, ..)| *step == function.slot);
        let variant = (function.slot, function.word, keys.into());
        all.insert(behind.map_or(all.len(), |i| i + 1), variant);
    }
    all
}

/// Whether the variant `name` of `step` is there for `function`: alone, or with a word before or behind it.
fn shows(step: &str, name: &str, function: &Function) -> bool {
    let is_of_slot = match function.slot {
        "composite" => ["composite", "debug"].contains(&step),
        slot => step == slot,
    };
    let word = function.word;
    let is_named = name == word
        || name.ends_with(&format!("-{word}"))
        || name.starts_with(&format!("{word}-"));
    is_of_slot && is_named
}

/// A scene that draws by `function`; `None` where only a scene of its own could.
fn plain(function: &Function) -> Option<String> {
    let Function { slot, word, .. } = function;
    Some(match *slot {
        "composite" => format!(r#""preset": "ct-soft-tissue", "method": "{word}""#),
        "illuminate" => format!(r#""shading": {{ "model": "{word}" }}"#),
        "reconstruct" => format!(r#""reconstruct": "{word}""#),
        "gradient" => format!(r#""gradient": {{ "method": "{word}" }}"#),
        "fetch" | "classify" | "shade" | "illustrate" | "gradient_input" => {
            format!(r#""functions": {{ "{slot}": {{ "module": "{word}" }} }}"#)
        }
        _ => return None,
    })
}

#[test]
fn every_function_is_shown() {
    let all = gallery();
    for function in FUNCTIONS.iter().filter(|f| f.is_way_of.is_none()) {
        let shown = all
            .iter()
            .any(|(step, name, _)| shows(step, name, function));
        let is_shown = SHOWN.contains(&(function.slot, function.name));
        assert!(shown != is_shown, "{}/{}", function.slot, function.name);
    }
}

/// The text of a variant's scene.
pub fn scene(variant: &Variant, [width, height]: [u32; 2]) -> String {
    format!("{{ \"size\": [{width}, {height}], {} }}", variant.2)
}
