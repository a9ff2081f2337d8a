//! What was typed, checked: each function turns a group of [`crate::flags`] into values that the
//! library takes.

use crate::flags::{
    BackendName, Component, DrawFlags, LimitFlags, MemoryFlags, PictureFlags, ReadFlags,
};
use anyhow::{Context, Result, anyhow, bail};
use std::str::FromStr;
use strahl::scene::plan::MOST_EDGE_PIXELS;
use strahl::scene::{
    AllBut, BoxClip, BoxSpace, Endian, Jitter, LabelSource, OfGroup, PlaneClip, PointsIn, Quality,
    Reconstruct, SegmentChoice, SegmentUse, Shading, ShadingModel, ToneMap, ValueLayer,
    ValueLayers, VolumeSource,
};
use strahl::volume::SampleType;
use strahl::volume::read::ReadOptions;
use strahl::{
    Backend, Background, Budget, Camera, Clip, Color, ColorMap, Method, Projection, Scene,
    SceneFile, TransferFunction, View,
};

/// How to read a volume: what was typed, put over what a scene says.
pub fn read_over(flags: &ReadFlags, source: VolumeSource) -> Result<VolumeSource> {
    let dims = flags.dims.as_deref().map(dims).transpose()?;
    if let Some(name) = &flags.sample_type
        && SampleType::from_name(name).is_none()
    {
        let names = SampleType::ALL.map(SampleType::name).join(", ");
        bail!("--type is {name}; known are {names}");
    }
    let spacing_mm = flags.spacing.as_deref().map(|text| {
        let wanted = "one or three lengths in mm, such as 0.5 or 0.4,0.4,1.5";
        let spacing = match numbers::<f64, 1>("--spacing", text, wanted) {
            Ok([all]) => [all; 3],
            Err(_) => numbers::<f64, 3>("--spacing", text, wanted)?,
        };
        if !spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
            bail!("--spacing is {text}; every length has to be above 0");
        }
        Ok(spacing)
    });
    Ok(VolumeSource {
        path: source.path,
        phantom: source.phantom,
        dims: dims.or(source.dims),
        level: flags.level_of_detail.or(source.level),
        time: flags.time.or(source.time),
        component: match flags.component {
            Some(Component::One(component)) => Some(component),
            Some(Component::Luminance) => None,
            None => source.component,
        },
        series: flags.series.clone().or(source.series),
        allow_gaps: flags.allow_gaps.then_some(true).or(source.allow_gaps),
        sample_type: flags.sample_type.clone().or(source.sample_type),
        spacing_mm: spacing_mm.transpose()?.or(source.spacing_mm),
        endian: match flags.endian.as_deref() {
            Some("big") => Some(Endian::Big),
            Some(_) => Some(Endian::Little),
            None => source.endian,
        },
        header_bytes: flags.header_bytes.or(source.header_bytes),
    })
}

/// The options for reading a volume that no scene speaks of.
pub fn read_options(flags: &ReadFlags) -> Result<ReadOptions> {
    let source = VolumeSource {
        path: Some(String::new()),
        ..VolumeSource::default()
    };
    Ok(read_over(flags, source)?.read_options()?)
}

/// `--dims`.
pub fn dims(text: &str) -> Result<[usize; 3]> {
    let dims = numbers("--dims", text, "three whole numbers, such as 256,256,128")?;
    if dims.contains(&0) {
        bail!("--dims is {text}; every dimension has to be at least 1");
    }
    Ok(dims)
}

/// Puts what was typed over `scene`.
pub fn draw_over(flags: &DrawFlags, scene: &mut Scene) -> Result<()> {
    look_over(flags, scene)?;
    if let Some(path) = &flags.graph {
        scene.graph = match SceneFile::open(path)? {
            Some(SceneFile { scene, .. }) if scene.graph.is_some() => scene.graph,
            _ => bail!(
                "--graph {}: no graph, and no scene that has one",
                path.display()
            ),
        };
    }
    let camera = scene.camera.take().unwrap_or_default();
    let camera = camera_over(flags, camera)?;
    scene.camera = (camera != Camera::default()).then_some(camera);
    clips_over(flags, scene)?;
    segments_over(flags, scene)?;
    if let Some(text) = &flags.size {
        let size = numbers::<u32, 2>("--size", text, "width and height, such as 1920x1080")?;
        if !size
            .iter()
            .all(|pixels| (1..=MOST_EDGE_PIXELS).contains(pixels))
        {
            bail!("--size is {text}; width and height have to be 1 to {MOST_EDGE_PIXELS}");
        }
        scene.size = Some(size);
    }
    for (flag, step) in [("--step", flags.step), ("--step-voxels", flags.step_voxels)] {
        if let Some(step) = step
            && (step.is_nan() || step <= 0.0)
        {
            bail!("{flag} is {step}; it has to be above 0");
        }
    }
    if flags.step.is_some() || flags.step_voxels.is_some() {
        (scene.step_mm, scene.step_voxels) = (flags.step, flags.step_voxels);
    }
    scene.jitter = flags.jitter.map(Jitter::Seed).or(scene.jitter);
    scene.reconstruct = match flags.reconstruct.as_deref() {
        Some("nearest") => Some(Reconstruct::Nearest),
        Some("b-spline") => Some(Reconstruct::BSpline),
        Some("b-spline-interpolating") => Some(Reconstruct::BSplineInterpolating),
        Some("catmull-rom") => Some(Reconstruct::CatmullRom),
        Some(_) => Some(Reconstruct::Trilinear),
        None => scene.reconstruct,
    };
    scene.frames = flags.frames.or(scene.frames);
    if let Some(name) = &flags.quality {
        scene.quality = Some(match name.as_str() {
            "null" => Quality::Null,
            "minimum" => Quality::Minimum,
            "maximum" => Quality::Maximum,
            _ => Quality::Medium,
        });
    }
    if let Some(name) = &flags.debug {
        scene.debug = name.parse().ok();
    }
    Ok(())
}

fn look_over(flags: &DrawFlags, scene: &mut Scene) -> Result<()> {
    if let Some(preset) = &flags.preset {
        // What a preset decides is the preset's again; scenes out of pictures say all of it.
        *scene = Scene {
            preset: Some(preset.clone()),
            method: None,
            threshold: None,
            transfer_function: None,
            shading: None,
            lights: None,
            background: None,
            display: None,
            early_termination: None,
            ..std::mem::take(scene)
        };
    }
    if let Some(method) = parsed::<Method>("--method", &flags.method)? {
        scene.method = Some(method);
        if method.is_projection() {
            // A projection has no surface that the scene's light could fall on.
            (scene.shading, scene.lights) = (None, None);
        }
    }
    scene.threshold = flags.threshold.or(scene.threshold);
    let mut function = scene.transfer_function.take().unwrap_or_default();
    if flags.window.is_some() || flags.level.is_some() {
        // A window replaces points that count in values, as it does with a preset's.
        if function.points_in != Some(PointsIn::Window) {
            (function.points, function.points_in) = (None, None);
        }
        function.window = flags.window.or(function.window);
        function.level = flags.level.or(function.level);
    }
    if let Some(map) = parsed::<ColorMap>("--color-map", &flags.color_map)? {
        function.color_map = Some(map);
        let points = function.points.iter_mut().flatten();
        points.for_each(|point| point.color = None);
    }
    if let Some(text) = &flags.opacity {
        let wanted = "one opacity or two, for the low and the high end, each 0 to 1";
        function.opacity = Some(match numbers::<f64, 1>("--opacity", text, wanted) {
            Ok([both]) => [both; 2],
            Err(_) => numbers::<f64, 2>("--opacity", text, wanted)?,
        });
        let points = function.points.iter_mut().flatten();
        points.for_each(|point| point.opacity = None);
    }
    scene.transfer_function = (function != TransferFunction::default()).then_some(function);
    match flags.shade.as_deref() {
        Some("unlit") => {
            scene.shading = Some(Shading {
                model: Some(ShadingModel::Unlit),
                ..Shading::default()
            });
            scene.lights = None;
        }
        Some(name) => {
            let model = name.parse().ok();
            scene.shading.get_or_insert_default().model = model;
        }
        None => {}
    }
    if flags.transparent {
        scene.background = Some(Background::Transparent);
    }
    if let Some(background) = parsed::<Background>("--background", &flags.background)? {
        scene.background = Some(background);
    }
    if let Some(exposure) = flags.exposure {
        scene.display.get_or_insert_default().exposure = Some(exposure);
    }
    if let Some(tone_map) = parsed::<ToneMap>("--tone-map", &flags.tone_map)? {
        let display = scene.display.get_or_insert_default();
        if display.tone_map != Some(tone_map) {
            // The scene's white point was said for another curve.
            display.white_point = None;
        }
        display.tone_map = Some(tone_map);
    }
    if let Some(white_point) = flags.white_point {
        scene.display.get_or_insert_default().white_point = Some(white_point);
    }
    if let Some(gamma) = flags.gamma {
        scene.display.get_or_insert_default().gamma = Some(gamma);
    }
    if let Some(fxaa) = flags.fxaa.as_deref() {
        scene.display.get_or_insert_default().fxaa = Some(fxaa == "on");
    }
    Ok(())
}

fn camera_over(flags: &DrawFlags, scene: Camera) -> Result<Camera> {
    let mut camera = scene;
    if let Some(view) = parsed::<View>("--view", &flags.view)? {
        // A new orbit; what is kept does not say from where.
        camera = Camera {
            view: Some(view),
            projection: scene.projection,
            focus: scene.focus,
            view_angle_deg: scene.view_angle_deg,
            height_mm: scene.height_mm,
            ..Camera::default()
        };
    }
    if flags.azimuth.is_some() || flags.elevation.is_some() {
        (camera.position, camera.up) = (None, None);
        camera.azimuth_deg = flags.azimuth.or(camera.azimuth_deg);
        camera.elevation_deg = flags.elevation.or(camera.elevation_deg);
    }
    if let Some(text) = &flags.position {
        camera.position = Some(numbers("--position", text, POINT)?);
        (camera.view, camera.azimuth_deg, camera.elevation_deg) = (None, None, None);
    }
    if let Some(text) = &flags.focus {
        camera.focus = Some(numbers("--focus", text, POINT)?);
    }
    if let Some(name) = &flags.projection {
        let projection = match name.as_str() {
            "orthographic" => Projection::Orthographic,
            _ => Projection::Perspective,
        };
        if camera.projection.unwrap_or(Projection::Perspective) != projection {
            // Each projection has its own measure of how much is seen.
            (camera.view_angle_deg, camera.height_mm) = (None, None);
        }
        camera.projection = Some(projection);
    }
    camera.zoom = flags.zoom.or(camera.zoom);
    Ok(camera)
}

const POINT: &str = "three numbers in RAS mm, such as 10,-20,35.5";

/// How opaque the runs of segments are that stand around highlighted ones, and their color.
const GLIMPSE: (f64, Color) = (0.07, Color([0.62, 0.66, 0.7]));

/// The segments that are asked for; they count more than those of the scene.
fn segments_over(flags: &DrawFlags, scene: &mut Scene) -> Result<()> {
    if let Some(labels) = &flags.labels {
        let path = labels.to_string_lossy().into_owned();
        scene.labels = Some(LabelSource::file(path));
    }
    if let Some(layers) = &flags.layers {
        scene.labels = Some(LabelSource {
            layers: Some(value_layers(layers)?),
            ..LabelSource::default()
        });
    }
    let any = || SegmentChoice::Name("*".to_owned());
    let of = |texts: &[String]| {
        let choice = |text: &String| match text.parse() {
            Ok(id) => SegmentChoice::Id(id),
            Err(_) => match text.strip_prefix("group:") {
                Some(group) => SegmentChoice::Group(OfGroup {
                    group: group.to_owned(),
                }),
                None => SegmentChoice::Name(text.clone()),
            },
        };
        SegmentChoice::List(texts.iter().map(choice).collect())
    };
    let used = |of, show, opacity| SegmentUse {
        of,
        technique: None,
        show,
        color: None,
        opacity,
        importance: None,
    };
    let mut uses = Vec::new();
    if !flags.only.is_empty() {
        uses.push(used(any(), Some(false), None));
        uses.push(used(of(&flags.only), Some(true), None));
    }
    if !flags.highlight.is_empty() {
        let (opacity, color) = GLIMPSE;
        let not = vec![of(&flags.highlight)];
        uses.push(SegmentUse {
            color: Some(color),
            ..used(SegmentChoice::But(AllBut { not }), None, Some(opacity))
        });
        uses.push(used(of(&flags.highlight), Some(true), Some(1.0)));
    }
    for (texts, show) in [(&flags.show, true), (&flags.hide, false)] {
        if !texts.is_empty() {
            uses.push(used(of(texts), Some(show), None));
        }
    }
    if !uses.is_empty() {
        scene.segments.get_or_insert_default().extend(uses);
    }
    Ok(())
}

/// `4` is as many equal layers, `100,300` are two that begin at these values; one alone is `100,`.
fn value_layers(text: &str) -> Result<ValueLayers> {
    if let Ok(count) = text.trim().parse() {
        return Ok(ValueLayers::Count(count));
    }
    let values = text.strip_suffix(',').unwrap_or(text).split(',');
    let values: std::result::Result<Vec<f64>, _> = values.map(|t| t.trim().parse()).collect();
    match values {
        Ok(values) => Ok(ValueLayers::From(
            values.into_iter().map(ValueLayer::Value).collect(),
        )),
        Err(_) => bail!(
            "--layers is {text:?}; allowed: a number of equal layers, such as 4, or the values at which layers begin, such as 100,300"
        ),
    }
}

fn clips_over(flags: &DrawFlags, scene: &mut Scene) -> Result<()> {
    let mut clips = Vec::new();
    for text in &flags.clip_plane {
        let wanted = "a normal and, if wanted, a distance in mm, such as 0,0,1 or 0,0,1,-20";
        let plane = match numbers::<f64, 3>("--clip-plane", text, wanted) {
            Ok(normal) => PlaneClip {
                normal,
                ..PlaneClip::default()
            },
            Err(_) => {
                let [x, y, z, distance_mm] = numbers("--clip-plane", text, wanted)?;
                PlaneClip {
                    normal: [x, y, z],
                    distance_mm: Some(distance_mm),
                    ..PlaneClip::default()
                }
            }
        };
        clips.push(Clip::Plane(plane));
    }
    for text in &flags.clip_box {
        let wanted = "two corners, such as -40,-50,0,40,50,90";
        let [x0, y0, z0, x1, y1, z1] = numbers::<f64, 6>("--clip-box", text, wanted)?;
        clips.push(Clip::Box(BoxClip {
            min: [x0.min(x1), y0.min(y1), z0.min(z1)],
            max: [x0.max(x1), y0.max(y1), z0.max(z1)],
            space: match flags.clip_space.as_deref() {
                Some("voxels") => Some(BoxSpace::Voxels),
                Some("fraction") => Some(BoxSpace::Fraction),
                _ => None,
            },
            ..BoxClip::default()
        }));
    }
    if !clips.is_empty() {
        scene.clips.get_or_insert_default().extend(clips);
    }
    Ok(())
}

/// A name or color that the library reads.
fn parsed<T: FromStr<Err = String>>(flag: &str, text: &Option<String>) -> Result<Option<T>> {
    let value = text.as_deref().map(str::parse::<T>).transpose();
    value.map_err(|why| anyhow!("{flag}: {why}"))
}

/// Exactly `N` numbers with `,`, `x`, `×` or `:` between.
fn numbers<T: FromStr, const N: usize>(flag: &str, text: &str, wanted: &str) -> Result<[T; N]> {
    let parts: Vec<T> = text
        .split([',', 'x', 'X', '×', ':'])
        .map(|part| part.trim().parse().ok())
        .collect::<Option<_>>()
        .with_context(|| format!("{flag} is {text}; it has to be {wanted}"))?;
    match parts.try_into() {
        Ok(parts) => Ok(parts),
        Err(_) => bail!("{flag} is {text}; it has to be {wanted}"),
    }
}

/// How much memory reading may take: what `--max-memory` says, or what the system has.
pub fn memory(flags: &MemoryFlags) -> Result<u64> {
    match &flags.max_memory {
        Some(text) => memory_bytes(text),
        None => Ok(Budget::of_machine().memory_bytes),
    }
}

fn memory_bytes(text: &str) -> Result<u64> {
    bytes(text).with_context(|| {
        format!("--max-memory is {text}; it has to be a number of bytes, such as 500M or 8G")
    })
}

/// How much a picture may take.
pub fn budget(flags: &LimitFlags) -> Result<Budget> {
    if flags.force {
        return Ok(Budget::UNLIMITED);
    }
    let mut budget = Budget::of_machine();
    if let Some(text) = &flags.max_memory {
        budget.memory_bytes = memory_bytes(text)?;
    }
    if let Some(seconds) = flags.max_time {
        if !(seconds > 0.0 && seconds.is_finite()) {
            bail!("--max-time is {seconds}; it has to be a number of seconds above 0");
        }
        budget.seconds = seconds;
    }
    Ok(budget)
}

/// A whole number of bytes, or of as many thousands, millions … as its last letter says (1024 each).
fn bytes(text: &str) -> Option<u64> {
    let upper = text.trim().to_ascii_uppercase();
    let text = upper.strip_suffix('B').unwrap_or(&upper);
    let unit = text.chars().last().and_then(|last| "KMGT".find(last));
    let (number, shift) = match unit {
        Some(place) => (&text[..text.len() - 1], 10 * (1 + place)),
        None => (text, 0),
    };
    number.trim().parse::<u64>().ok()?.checked_mul(1 << shift)
}

/// Which renderer draws.
pub fn backend(flags: &PictureFlags) -> Result<Backend> {
    Ok(match (flags.backend, &flags.adapter) {
        (BackendName::Auto, None) => Backend::Auto,
        (BackendName::Cpu, None) => Backend::Cpu,
        (BackendName::Gpu, adapter) => Backend::Gpu {
            adapter: adapter.clone(),
        },
        (_, Some(adapter)) => {
            bail!("--adapter is {adapter}, which needs --backend gpu")
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_taken_with_the_usual_letters() {
        for (text, number) in [
            ("17", 17),
            ("3k", 3 << 10),
            ("500M", 500 << 20),
            ("8 GB", 8 << 30),
            ("1T", 1 << 40),
        ] {
            assert_eq!(bytes(text), Some(number), "{text}");
        }
        for text in ["", "M", "-1", "1.5G", "99999999T", "1X"] {
            assert_eq!(bytes(text), None, "{text}");
        }
    }

    #[test]
    fn numbers_are_taken_with_the_usual_separators() {
        for text in ["256,128,64", "256x128x64", "256X128×64", " 256, 128, 64"] {
            let found = numbers::<usize, 3>("--dims", text, "").unwrap();
            assert_eq!(found, [256, 128, 64], "{text}");
        }
        for text in ["256", "256,128", "1,2,3,4", "a,b,c", "", "1,,3", "-1,2,3"] {
            assert!(numbers::<usize, 3>("--dims", text, "").is_err(), "{text}");
        }
    }

    #[test]
    fn wrong_reading_flags_say_what_would_be_right() {
        let message = |flags: ReadFlags| read_options(&flags).unwrap_err().to_string();
        let text = |text: &str| Some(text.to_owned());
        let found = message(ReadFlags {
            dims: text("256,0,3"),
            ..Default::default()
        });
        assert_eq!(
            found,
            "--dims is 256,0,3; every dimension has to be at least 1"
        );
        let found = message(ReadFlags {
            sample_type: text("u12"),
            ..Default::default()
        });
        assert_eq!(
            found,
            "--type is u12; known are u8, i8, u16, i16, u32, i32, f32, f64"
        );
        let found = message(ReadFlags {
            spacing: text("0.5,0,1"),
            ..Default::default()
        });
        assert_eq!(
            found,
            "--spacing is 0.5,0,1; every length has to be above 0"
        );
    }

    #[test]
    fn one_spacing_counts_for_all_axes() {
        let flags = ReadFlags {
            spacing: Some("0.5".into()),
            endian: Some("big".into()),
            ..Default::default()
        };
        let options = read_options(&flags).unwrap();
        assert_eq!(options.spacing_mm, Some([0.5; 3]));
        assert!(options.raw.big_endian);
    }
}
