//! Times pictures of segments, and of rules that look into what is hidden, beside plain pictures of the same volume.
//!
//!     cargo run --release -p strahl --example time_segments -- \
//!         [data=FOLDER] [frames=9] [threads=2] [size=512] [case=brain]
//!
//! The pictures of a case are drawn in turns through one session, so that a ratio is not of two moments. One line of JSON
//! per picture: the median of its milliseconds, and that over the median of the first picture of its case.

use std::error::Error;
use std::path::Path;
use std::time::Instant;
use strahl::{Control, Scene, Session};

/// Name, the keys of all pictures of the case, and the name and further keys of each.
type Case = (&'static str, &'static str, Vec<(&'static str, String)>);

fn main() -> Result<(), Box<dyn Error>> {
    let argument = |name: &str| {
        let prefix = format!("{name}=");
        std::env::args().find_map(|a| a.strip_prefix(&prefix).map(str::to_owned))
    };
    let number =
        |name: &str, default: usize| argument(name).map_or(Ok(default), |text| text.parse());
    let (frames, size) = (number("frames", 9)?, number("size", 512)?);
    let folder = argument("data").unwrap_or_else(|| "../shared/data".to_owned());
    let pool = rayon::ThreadPoolBuilder::new();
    let pool = pool.num_threads(number("threads", 2)?).build()?;
    for (name, common, pictures) in cases() {
        if argument("case").is_some_and(|only| only != name) {
            continue;
        }
        let common = common.replace("DATA", &folder);
        let scene = |own: &str| {
            let text = format!(r#"{{ "size": [{size}, {size}], {common} {own} }}"#);
            Scene::parse(name, &text.replace("DATA", &folder))
        };
        let scenes: Vec<_> = pictures
            .iter()
            .map(|(_, own)| scene(own))
            .collect::<Result<_, _>>()?;
        let path = scenes[0].volume.as_ref().and_then(|v| v.path.as_deref());
        if path.is_some_and(|path| !Path::new(path).exists()) {
            eprintln!("{name}: skipped, there is no {}", path.unwrap_or_default());
            continue;
        }
        let session = Session::new();
        let mut milliseconds = vec![Vec::new(); scenes.len()];
        for frame in 0..=frames {
            for (scene, of_scene) in scenes.iter().zip(&mut milliseconds) {
                let start = Instant::now();
                pool.install(|| session.draw(scene, &Control::NONE))?;
                // The first picture also makes what is kept.
                if frame > 0 {
                    of_scene.push(1e3 * start.elapsed().as_secs_f64());
                }
            }
        }
        let medians = milliseconds.iter_mut().map(|of_scene| median(of_scene));
        let medians: Vec<f64> = medians.collect();
        for ((picture, _), median) in pictures.iter().zip(&medians) {
            let ratio = median / medians[0];
            println!(
                r#"{{"case":"{name}","picture":"{picture}","ms":{median:.1},"ratio":{ratio:.2}}}"#
            );
        }
    }
    Ok(())
}

fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn cases() -> Vec<Case> {
    let plain = || ("one technique", String::new());
    let all_by_scene =
        r#""segments": [{ "of": "*", "technique": "scene" }, { "of": 0, "technique": "scene" }],"#;
    let ten: String = (0..10).map(ramp).collect();
    let of_ten: String = (0..210)
        .map(|id| format!(r#"{{ "of": {id}, "technique": "t{}" }},"#, id % 10))
        .collect();
    let anatomy = r#""volume": { "phantom": "anatomy" },"#;
    let brain_labels = r#""labels": { "path": "DATA/brain-labels.nii.gz" },"#;
    // With labels another gradient is the default. All pictures of a case have one, so that its cost is not compared.
    let engine = r##""volume": { "path": "DATA/engine.nii.gz" }, "gradient": { "method": "central" },
        "transfer_function": { "points": [[60, 0, "#fff4e4"], [255, 0.8, "#fff4e4"]] },"##;
    let other = r##""techniques": { "red": { "transfer_function": { "points": [[60, 0, "#f43"], [255, 0.8, "#f43"]] } } },
        "segments": [{ "of": "*", "technique": "scene" }, { "of": 2, "technique": "red" }],"##;
    let layers = r#""labels": { "layers": [0, 150] },"#;
    vec![
        (
            "engine",
            engine,
            vec![
                plain(),
                (
                    "two segments, one technique",
                    format!("{all_by_scene} {layers}"),
                ),
                ("two segments, two techniques", format!("{other} {layers}")),
            ],
        ),
        (
            "anatomy",
            r#""volume": { "phantom": "anatomy" }, "gradient": { "method": "central" },"#,
            vec![plain(), ("27 segments", all_by_scene.to_owned())],
        ),
        (
            "brain",
            r#""volume": { "path": "DATA/brain-t1.nii.gz" }, "preset": "mr", "gradient": { "method": "central" },"#,
            vec![
                plain(),
                (
                    "207 segments, one technique",
                    format!("{all_by_scene} {brain_labels}"),
                ),
                (
                    "207 segments, 10 techniques",
                    format!(r#""techniques": {{ {ten} }}, "segments": [{of_ten}], {brain_labels}"#),
                ),
            ],
        ),
        (
            "rules on engine",
            r#""volume": { "path": "DATA/engine.nii.gz" },"#,
            rules(),
        ),
        (
            "rules on head-cta",
            r#""volume": { "path": "DATA/head-cta.nii.gz" }, "preset": "ct-angio","#,
            rules(),
        ),
        ("rules on anatomy", anatomy, rules()),
    ]
}

/// A technique with the opacities of the preset `mr`, and colors of its own.
fn ramp(number: usize) -> String {
    let colors = ["#3a2a26", "#7a5a4c", "#c49a80", "#e8ccb0", "#fff4e4"];
    let color = |i: usize| colors[(i + number) % 5];
    let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(color);
    format!(
        r#""t{number}": {{ "transfer_function": {{ "points_in": "window", "points": [
            [0.0, 0.0, "{a}"], [0.15, 0.02, "{b}"], [0.4, 0.25, "{c}"], [0.7, 0.5, "{d}"], [1.0, 0.8, "{e}"]
        ] }} }},"#
    )
}

/// Emission and absorption, then the rules of the table of the source (S1, table 4.1).
fn rules() -> Vec<(&'static str, String)> {
    let measure = |measure: usize| {
        format!(
            r#""functions": {{ "composite": {{ "module": "importance_aware", "params": {{ "measure": {measure} }} }} }},"#
        )
    };
    vec![
        ("emission-absorption", String::new()),
        (
            "context-preserving",
            r#""method": "context-preserving","#.to_owned(),
        ),
        ("importance by gradient", measure(0)),
        ("importance by silhouette", measure(1)),
        ("importance by light", measure(2)),
        ("importance by value", measure(3)),
        ("importance by layers", measure(4)),
    ]
}
