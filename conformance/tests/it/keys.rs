//! Keys that change nothing of a picture are named, and no others: every key, under every method, view, classification,
//! model of light and input of the gradient, drawn with two of its values.

use crate::variants::draw;
use std::collections::BTreeSet;
use strahl_scene::{
    DebugView, Headers, Image, LabelHeader, Method, Scene, ShadingModel, keys_without_effect,
    resolve_with,
};
use strahl_volume::{Control, Datasets, Phantom, Rescale, Volume};

/// How a scene is drawn, whatever the key says that is looked at.
#[derive(Clone, Copy, Debug, Default)]
struct Situation {
    method: Option<Method>,
    debug: Option<DebugView>,
    classify: Option<&'static str>,
    model: Option<ShadingModel>,
    is_of_opacity: bool,
}

impl Situation {
    fn all() -> Vec<Situation> {
        let plain = Situation::default();
        let mut all = Vec::new();
        for method in Method::ALL {
            let by_method = Situation {
                method: Some(method),
                ..plain
            };
            all.push(by_method);
            for classify in ["pre_classified", "gradient_table", "identity"] {
                all.push(Situation {
                    classify: Some(classify),
                    ..by_method
                });
            }
            for model in [ShadingModel::Unlit, ShadingModel::Phong] {
                all.push(Situation {
                    model: Some(model),
                    ..by_method
                });
            }
            all.push(Situation {
                model: Some(ShadingModel::Phong),
                is_of_opacity: true,
                ..by_method
            });
        }
        // What a model of light reads is the same question for all methods that shade.
        for method in [Method::EmissionAbsorption, Method::FirstHit] {
            all.extend(ShadingModel::ALL.map(|model| Situation {
                method: Some(method),
                model: Some(model),
                ..plain
            }));
        }
        all.extend(DebugView::ALL.map(|debug| Situation {
            debug: Some(debug),
            ..plain
        }));
        all
    }

    /// Whether pictures can be equal though the key is read: an extreme value lies where nothing changes around it, and
    /// little has a second layer.
    fn says_little(&self, key: &str) -> bool {
        let is_lit = self.model.is_some_and(ShadingModel::is_lit);
        let is_extreme = matches!(self.method, Some(Method::Mip | Method::Minip));
        let is_peeled = self.method == Some(Method::OpacityPeeling);
        // Their light ends late.
        let is_late = matches!(self.method, Some(Method::Mida | Method::ContextPreserving));
        (is_extreme && is_lit)
            || (is_peeled && self.classify.is_some())
            || (is_late && key == "early_termination")
            // The window says which values are important, and a later one seldom is more so.
            || (self.method == Some(Method::ImportanceAware) && self.classify.is_some())
    }

    /// A scene drawn so, in which the key `top` says `inner`: the inside of an object, or a value.
    fn scene(&self, top: &str, inner: &str) -> Scene {
        let mut keys = vec![r#""size": [10, 9]"#.to_owned()];
        let mut add = |key: &str, own: Option<String>| {
            let parts: Vec<String> = own
                .into_iter()
                .chain((key == top).then(|| inner.to_owned()))
                .collect();
            if !parts.is_empty() {
                keys.push(format!("{key:?}: {{ {} }}", parts.join(", ")));
            }
        };
        let model = self
            .model
            .map(|model| format!(r#""model": "{}""#, model.name()));
        add("shading", model);
        add(
            "gradient",
            self.is_of_opacity.then(|| r#""of": "opacity""#.to_owned()),
        );
        add(
            "functions",
            self.classify.map(|name| {
                let steep = match name {
                    "gradient_table" => r#", "params": { "high_per_mm": 20 }"#,
                    "identity" => r#", "params": { "black": 0, "white": 255 }"#,
                    _ => "",
                };
                format!(r#""classify": {{ "module": "{name}"{steep} }}"#)
            }),
        );
        if let Some(method) = self.method {
            keys.push(format!(r#""method": "{}""#, method.name()));
        }
        if let Some(debug) = self.debug {
            keys.push(format!(r#""debug": "{}""#, debug.name()));
        }
        match top {
            "shading" | "gradient" | "functions" => {}
            "transfer_function" => keys.push(format!("{top:?}: {{ {inner} }}")),
            _ => keys.push(format!("{top:?}: {inner}")),
        }
        let text = format!("{{ {} }}", keys.join(", "));
        Scene::parse("scene", &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }
}

/// Path, key, and two values that differ where anything reads them.
const KEYS: &[(&str, &str, [&str; 2])] = &[
    ("threshold", "threshold", ["90", "160"]),
    ("grey_range", "grey_range", ["[0, 30]", "[0, 300]"]),
    ("early_termination", "early_termination", ["0", "0.9"]),
    (
        "transfer_function.points",
        "transfer_function",
        [
            r##""points": [[20, 0, "#fff"], [200, 0.3, "#f00"]]"##,
            r##""points": [[60, 0, "#0f0"], [90, 0.2, "#00f"]]"##,
        ],
    ),
    (
        "transfer_function.regions",
        "transfer_function",
        [
            r##""regions": [{ "corners": [[40, 0], [200, 0], [200, 90], [40, 90]], "color": "#f00" }]"##,
            r##""regions": [{ "corners": [[20, 5], [90, 5], [90, 60]], "opacity": 0.3 }]"##,
        ],
    ),
    (
        "transfer_function.color_map",
        "transfer_function",
        [r#""color_map": "hot""#, r#""color_map": "viridis""#],
    ),
    (
        "transfer_function.opacity",
        "transfer_function",
        [r#""opacity": [0, 0.2]"#, r#""opacity": [0.1, 0.7]"#],
    ),
    (
        "transfer_function.window",
        "transfer_function",
        [
            r#""level": 100, "window": 60"#,
            r#""level": 100, "window": 190"#,
        ],
    ),
    (
        "transfer_function.level",
        "transfer_function",
        [
            r#""level": 80, "window": 90"#,
            r#""level": 140, "window": 90"#,
        ],
    ),
    (
        "transfer_function.reference_mm",
        "transfer_function",
        [r#""reference_mm": 1"#, r#""reference_mm": 40"#],
    ),
    (
        "transfer_function.reference_voxels",
        "transfer_function",
        [r#""reference_voxels": 0.5"#, r#""reference_voxels": 9"#],
    ),
    (
        "shading.ambient",
        "shading",
        [r#""ambient": 0.1"#, r#""ambient": 0.9"#],
    ),
    (
        "shading.diffuse",
        "shading",
        [r#""diffuse": 0.1"#, r#""diffuse": 0.9"#],
    ),
    (
        "shading.specular",
        "shading",
        [r#""specular": 0"#, r#""specular": 5"#],
    ),
    (
        "shading.shininess",
        "shading",
        [r#""shininess": 1"#, r#""shininess": 90"#],
    ),
    (
        "shading.roughness",
        "shading",
        [r#""roughness": 0.1"#, r#""roughness": 0.9"#],
    ),
    (
        "shading.reflectance",
        "shading",
        [r#""reflectance": 0"#, r#""reflectance": 1"#],
    ),
    (
        "shading.full_per_mm",
        "shading",
        [r#""full_per_mm": 0.01"#, r#""full_per_mm": 90"#],
    ),
    (
        "lights",
        "lights",
        ["[]", r#"[{ "type": "head", "intensity": 3 }]"#],
    ),
    (
        "reconstruct",
        "reconstruct",
        [r#""nearest""#, r#""b-spline""#],
    ),
    (
        "gradient.method",
        "gradient",
        [r#""method": "forward""#, r#""method": "sobel""#],
    ),
    ("step_voxels", "step_voxels", ["0.5", "2.3"]),
    ("step_mm", "step_mm", ["0.7", "3"]),
    ("jitter", "jitter", [r#"{ "seed": 1 }"#, r#"{ "seed": 9 }"#]),
    ("background", "background", [r##""#000""##, r##""#0f0""##]),
    (
        "compositing",
        "compositing",
        [r#""linear""#, r#""display""#],
    ),
];

fn volume() -> Volume {
    let shells = Phantom::Shells.volume([21, 19, 17]).unwrap();
    let (grid, samples, rescale, metadata) = shells.into_parts();
    let rescale = Rescale::new(255.0 * rescale.slope, 255.0 * rescale.intercept);
    Volume::new(grid, samples, rescale, metadata).unwrap()
}

/// The picture, and the keys that are named; nothing where the scene is refused.
fn drawn(volume: &Volume, scene: &Scene) -> Option<(Image, BTreeSet<String>)> {
    let headers = Headers::from(volume.header());
    let plan = resolve_with(scene, &headers).ok()?;
    let named = keys_without_effect(scene, &plan, &headers)
        .into_iter()
        .map(|note| note.key);
    let rendered = strahl_cpu::Renderer::new(volume)
        .render(&plan, &Default::default(), &Control::NONE)
        .unwrap();
    Some((rendered.image, named.collect()))
}

#[test]
fn keys_that_change_nothing_are_named_and_no_others() {
    let volume = volume();
    let (mut compared, mut without) = (0, 0);
    let mut wrong = Vec::new();
    for situation in Situation::all() {
        for (path, top, values) in KEYS {
            let both = values.map(|value| drawn(&volume, &situation.scene(top, value)));
            let [Some((first, named)), Some((second, again))] = both else {
                continue;
            };
            let shows = |image: &Image| image.pixels().iter().any(|pixel| pixel[..3] != [0.0; 3]);
            // What shows nothing says nothing about keys either.
            if !shows(&first) && !shows(&second) {
                continue;
            }
            compared += 1;
            let differ = first.pixels() != second.pixels();
            without += u32::from(!differ);
            // An empty list of lights is what is left of them where nothing is lit.
            for (value, named) in values.iter().zip([named, again]) {
                // A note is wrong wherever it stands; that one is missing shows only where there is something to see.
                let is_missing = !differ && !named.contains(*path) && !situation.says_little(path);
                if (differ && named.contains(*path)) || is_missing {
                    wrong.push(format!(
                        "{path} = {value}, pictures differ: {differ}: {situation:?}"
                    ));
                }
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    assert!(compared > 2000 && without > 500, "{compared}, {without}");
}

/// What goes with another key, or with none at all.
#[test]
fn keys_that_other_keys_overrule_are_named() {
    let volume = volume();
    for (text, expected) in [
        (r#"{ "frames": 4 }"#, &["frames"][..]),
        (r#"{ "frames": 4, "jitter": { "seed": 1 } }"#, &[]),
        (r#"{ "frames": 1 }"#, &[]),
        // It chooses the preset.
        (
            r#"{ "method": "mip", "functions": { "composite": { "module": "mida" } } }"#,
            &[],
        ),
        (
            r#"{ "preset": "grey", "method": "emission-absorption", "functions": { "composite": { "module": "mida" } } }"#,
            &["method"],
        ),
        (
            r#"{ "functions": { "composite": { "module": "mip" }, "gradient": { "module": "sobel" } }, "shading": { "model": "unlit" } }"#,
            &["functions.gradient"],
        ),
        (
            r#"{ "clips": [{ "plane": { "normal": [1, 0, 0], "objects": [] } }] }"#,
            &["clips[0].plane"],
        ),
        (
            r#"{ "objects": [{ "like": "volume", "shading": { "model": "unlit", "shininess": 3 } }], "shading": { "shininess": 4 } }"#,
            &["objects[0].shading.shininess"],
        ),
        (
            r#"{ "objects": [{ "like": "volume", "shading": { "model": "phong" } }], "shading": { "model": "unlit", "shininess": 3 } }"#,
            &["shading.shininess"],
        ),
        ("{}", &[]),
    ] {
        let mut scene = Scene::parse("scene", text).unwrap();
        scene.size = Some([14, 12]);
        let (_, named) = drawn(&volume, &scene).unwrap_or_else(|| panic!("{text}"));
        let expected = expected.iter().map(|key| (*key).to_owned());
        assert_eq!(named, expected.collect(), "{text}");
    }
}

/// A volume with labels, and its headers.
fn anatomy() -> (Datasets, Headers) {
    let dims = [20, 24, 28];
    let volume = Phantom::Anatomy.volume(dims).unwrap();
    let labels = Phantom::Anatomy.labels(dims).unwrap().unwrap();
    let headers = Headers {
        labels: Some(LabelHeader::from(&labels)),
        masks: vec![*volume.grid()],
        ..Headers::from(volume.header())
    };
    let data = Datasets {
        labels: vec![labels],
        masks: vec![volume.clone()],
        ..Datasets::from(&volume)
    };
    (data, headers)
}

/// The picture of segments, and the keys that are named; nothing where the scene is refused.
fn drawn_segments(
    (data, headers): &(Datasets, Headers),
    text: &str,
) -> Option<(Image, BTreeSet<String>)> {
    let mut scene = Scene::parse("scene", text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    scene.size = Some([14, 12]);
    let plan = resolve_with(&scene, headers).ok()?;
    let named = keys_without_effect(&scene, &plan, headers);
    let image = draw(data.clone(), &plan).image;
    Some((image, named.into_iter().map(|note| note.key).collect()))
}

/// Keys that a technique has, too.
const OF_TECHNIQUES: [&str; 3] = ["threshold", "transfer_function", "shading"];

#[test]
fn no_key_that_a_segment_is_drawn_by_is_named() {
    let data = anatomy();
    let (mut differing, mut named_ones) = (0, 0);
    let mut wrong = Vec::new();
    let methods = [
        Method::EmissionAbsorption,
        Method::FirstHit,
        Method::Average,
        Method::Mip,
    ];
    for method in methods {
        for model in ["unlit", "phong"] {
            // Which techniques draw a segment.
            for uses in [
                r#"{ "of": "*", "technique": "a" }"#,
                r#"{ "of": "*", "technique": "scene" }"#,
                r#"{ "of": "*", "technique": "a" }, { "of": 1, "technique": "scene" }"#,
            ] {
                for (path, top, values) in KEYS {
                    for in_technique in [false, true] {
                        if in_technique && !OF_TECHNIQUES.contains(top) {
                            continue;
                        }
                        let model = format!(r#""model": "{model}""#);
                        let with = |top: &str, value: &str, is_here: bool| {
                            let of = |key: &str, own: &str| match is_here && key == top {
                                true => format!(", {key:?}: {{ {own}{value} }}"),
                                false if own.is_empty() => String::new(),
                                false => format!(", {key:?}: {{ {} }}", own.trim_end_matches(", ")),
                            };
                            let inside = ["transfer_function", "gradient", "functions"];
                            match top {
                                "shading" => of("shading", &format!("{model}, ")),
                                _ if inside.contains(&top) => {
                                    of("shading", &format!("{model}, ")) + &of(top, "")
                                }
                                _ if is_here => {
                                    of("shading", &format!("{model}, "))
                                        + &format!(", {top:?}: {value}")
                                }
                                _ => of("shading", &format!("{model}, ")),
                            }
                        };
                        let both = values.map(|value| {
                            let method = method.name();
                            let of_scene = with(top, value, !in_technique);
                            let of_technique = with(top, value, in_technique);
                            let text = format!(
                                r#"{{ "method": "{method}"{of_scene},
                                "techniques": {{ "a": {{ "method": "{method}"{of_technique} }} }},
                                "segments": [{uses}] }}"#
                            );
                            drawn_segments(&data, &text)
                        });
                        let [Some((first, named)), Some((second, again))] = both else {
                            continue;
                        };
                        let differ = first.pixels() != second.pixels();
                        let path = match in_technique {
                            true => format!("techniques.a.{path}"),
                            false => (*path).to_owned(),
                        };
                        differing += u32::from(differ);
                        let top = path.rsplit_once('.').map_or(&*path, |(top, _)| top);
                        let is_named = [&named, &again]
                            .iter()
                            .any(|named| named.contains(&path) || named.contains(top));
                        named_ones += u32::from(is_named);
                        if differ && is_named {
                            wrong.push(format!("{path}: {} {model} {uses}", method.name()));
                        }
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(
        differing > 100 && named_ones > 100,
        "{differing}, {named_ones}"
    );
}

#[test]
fn keys_that_no_segment_is_drawn_by_are_named() {
    let data = anatomy();
    for (text, expected) in [
        (
            r#"{ "segments": [{ "of": "*", "technique": "scene" }] }"#,
            &[][..],
        ),
        (
            r#"{ "composite": "mip", "segments": [{ "of": 1, "show": false }] }"#,
            &[],
        ),
        (r#"{ "method": "opacity-peeling" }"#, &["method"]),
        (
            r#"{ "preset": "mr", "method": "mida" }"#,
            &["preset", "method"],
        ),
        // It sets the background.
        (r#"{ "preset": "mip" }"#, &[]),
        (
            r#"{ "threshold": 90, "method": "first-hit", "preset": "solid", "shading": { "model": "phong" } }"#,
            &["threshold", "shading", "preset", "method"],
        ),
        (
            r#"{ "threshold": 90, "method": "first-hit", "segments": [{ "of": 2, "technique": "scene" }] }"#,
            &[],
        ),
        (
            r#"{ "techniques": { "a": {}, "b": { "method": "mip", "shading": { "shininess": 3 } } }, "segments": [{ "of": "*", "technique": "b" }] }"#,
            &["techniques.a", "techniques.b.shading.shininess"],
        ),
        (
            r#"{ "techniques": { "a": { "shading": { "shininess": 3 } } }, "segments": [{ "of": "*", "technique": "a" }] }"#,
            &[],
        ),
        (
            r#"{ "segments": [{ "of": 1, "importance": 2 }] }"#,
            &["segments[0].importance"],
        ),
        (
            r#"{ "composite": "importance-aware", "segments": [{ "of": 1, "importance": 2 }] }"#,
            &[],
        ),
        (
            r#"{ "techniques": { "a": { "composite": "mip" }, "b": { "segments": [{ "of": 2, "importance": 1 }], "method": "mip" } },
                 "segments": [{ "of": "*", "technique": "b" }] }"#,
            &[
                "techniques.a",
                "techniques.b.method",
                "techniques.b.segments[0].importance",
            ],
        ),
        (
            r#"{ "techniques": { "a": { "composite": "importance-aware", "segments": [{ "of": 2, "importance": 1, "technique": "c" }] },
                                 "c": { "shading": { "shininess": 9 } } },
                 "segments": [{ "of": "*", "technique": "a" }] }"#,
            &[],
        ),
        (
            r#"{ "importance": { "path": "i" }, "segments": [{ "of": 1 }] }"#,
            &["importance"],
        ),
        (
            r#"{ "importance": { "path": "i" }, "composite": "importance-aware" }"#,
            &[],
        ),
        (
            r#"{ "importance": { "path": "i" }, "techniques": { "a": { "method": "importance-aware" } },
                 "segments": [{ "of": 2, "technique": "a" }] }"#,
            &[],
        ),
        (
            r#"{ "functions": { "classify": { "module": "identity" }, "gradient": { "module": "sobel" } } }"#,
            &["functions.classify"],
        ),
    ] {
        let (_, named) = drawn_segments(&data, text).unwrap_or_else(|| panic!("{text}"));
        let expected = expected.iter().map(|key| (*key).to_owned());
        assert_eq!(named, expected.collect(), "{text}");
    }
}

/// Every key of a scene has a value above, or stands here with why no note is ever needed.
#[test]
fn no_key_is_forgotten() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/scene.schema.json");
    let schema: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let keys_of = |value: &serde_json::Value| -> Vec<String> {
        let properties = value["properties"].as_object().unwrap();
        properties.keys().cloned().collect()
    };
    let elsewhere = [
        // Always read.
        "format",
        "volume",
        "transform",
        "objects",
        "camera",
        "clips",
        "size",
        "debug",
        "preset",
        "quality",
        "sampling",
        // Refused where it does not belong.
        "blend",
        "transfer_function.points_in",
        // In the test beside this one.
        "frames",
        "functions",
        "method",
        // In the tests of segments below.
        "techniques",
        "segments",
        "composite",
        "importance",
        // Always read; without them the keys of segments are named where data is loaded.
        "labels",
        // Nothing is said of graphs. Nothing is known of the file before it is written.
        "graph",
        "display",
        // What it chooses is in every situation.
        "shading.model",
        "gradient.of",
        "shading.keep_last_normal",
    ];
    let known: BTreeSet<&str> = KEYS
        .iter()
        .map(|(path, ..)| *path)
        .chain(elsewhere)
        .collect();
    let mut missing = Vec::new();
    for key in keys_of(&schema) {
        let parts = match key.as_str() {
            "transfer_function" => keys_of(&schema["$defs"]["TransferFunction"]),
            "shading" => keys_of(&schema["$defs"]["Shading"]),
            "gradient" => keys_of(&schema["$defs"]["Gradient"]),
            _ => Vec::new(),
        };
        let paths = match parts.is_empty() {
            true => vec![key],
            false => parts.iter().map(|part| format!("{key}.{part}")).collect(),
        };
        missing.extend(
            paths
                .into_iter()
                .filter(|path| !known.contains(path.as_str())),
        );
    }
    assert!(missing.is_empty(), "{missing:?}");
}
