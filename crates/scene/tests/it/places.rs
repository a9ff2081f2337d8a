//! What depends on where things lie, and what must not.

use crate::{ct_head, engine};
use glam::DVec3;
use strahl_scene::plan::{Composite, DebugView, Plan, Shade};
use strahl_scene::{Headers, Scene, resolve_with, settled_with};
use strahl_volume::{Grid, VolumeHeader};

fn scene(text: &str) -> Scene {
    Scene::parse("scene", text).unwrap_or_else(|error| panic!("{error}"))
}

fn plan(text: &str, headers: &Headers) -> Plan {
    resolve_with(&scene(text), headers).unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

/// A header with half as many voxels along each axis over the same extent.
fn halved(header: &VolumeHeader) -> VolumeHeader {
    let grid = &header.grid;
    let map = grid.world_from_voxel();
    let scale = glam::DAffine3::from_mat3_translation(
        glam::DMat3::from_diagonal(DVec3::splat(2.0)),
        DVec3::splat(0.5),
    );
    VolumeHeader {
        grid: Grid::new(grid.dims().map(|n| n / 2), map * scale).unwrap(),
        ..header.clone()
    }
}

/// Preset, camera, transfer function, shading and the numbers of the composite are those of the whole volume; the grid is
/// the coarser one.
#[test]
fn a_level_of_detail_changes_nothing_but_detail() {
    for header in [engine(), ct_head()] {
        let whole = Headers::from(header.clone());
        let coarse = Headers {
            coarser: [(0, halved(&header))].into(),
            ..whole.clone()
        };
        for text in [
            "{}",
            r#"{ "method": "gmip" }"#,
            r#"{ "method": "first-hit" }"#,
            r#"{ "debug": "depth" }"#,
            r#"{ "shading": { "model": "gradient-opacity" } }"#,
            r#"{ "clips": [{ "box": { "min": [9, 9, 9], "max": [40, 40, 40], "space": "voxels" } }] }"#,
        ] {
            let [mut a, b] = [plan(text, &whole), plan(text, &coarse)];
            assert_eq!(b.field().grid, halved(&header).grid);
            assert!(!b.field().is_moved);
            assert_eq!(b.lattice.step_mm, 2.0 * a.lattice.step_mm);
            a.field_mut().grid = b.field().grid;
            a.lattice.step_mm = b.lattice.step_mm;
            assert_eq!(format!("{a:?}"), format!("{b:?}"), "{text}");
            let [a, b] = [&whole, &coarse].map(|headers| settled_with(&scene(text), headers));
            assert_eq!(a, b);
        }
    }
}

/// Neither another object nor a transform turns the start view into another.
#[test]
fn the_default_view_is_that_of_the_scenes_own_volume() {
    for (header, forwards) in [(engine(), false), (ct_head(), true)] {
        let alone = Headers::from(header.clone());
        let two = Headers {
            volumes: vec![header.clone(), ct_head()],
            ..alone.clone()
        };
        let expected = plan("{}", &alone).camera.forward;
        assert_eq!(expected.y < -0.999, forwards);
        for (text, headers) in [
            (
                r#"{ "transform": { "translate_mm": [60, 0, 30] } }"#,
                &alone,
            ),
            (r#"{ "transform": { "scale": [2, 2, 2] } }"#, &alone),
            (
                r#"{ "objects": [{ "like": "volume", "transform": { "translate_mm": [60, 0, 30] } }] }"#,
                &alone,
            ),
            (
                r#"{ "objects": [{ "volume": { "path": "other" } }] }"#,
                &two,
            ),
        ] {
            let found = plan(text, headers).camera.forward;
            assert!(found.distance(expected) < 1e-12, "{text}: {found}");
        }
    }
}

/// Whether planes and shapes of layer number `layer` keep a point.
fn keeps(plan: &Plan, layer: usize, point: DVec3) -> bool {
    let mut planes = plan
        .ray_clips
        .iter()
        .filter(|plane| plane.layers >> layer & 1 == 1);
    let mut shapes = plan.sample_clips.iter().filter(|clip| clip.cuts(layer));
    planes.all(|plane| plane.normal.dot(point) + plane.offset_mm >= 0.0)
        && shapes.all(|clip| {
            let unit = clip.unit_from_world.transform_point3(point);
            (unit.abs().max_element() <= 0.5) == clip.keep_inside
        })
}

/// A clip of an object moves with it: what it keeps of voxels does not depend on the object's transform.
#[test]
fn clips_of_an_object_move_with_it() {
    let header = engine();
    let mask = halved(&header).grid;
    for (clip, moves) in [
        (
            r#""box": { "min": [0.1, 0.2, 0.3], "max": [0.5, 0.9, 1], "space": "fraction", "objects": ["b"] }"#,
            true,
        ),
        (
            r#""box": { "min": [0.1, 0.2, 0.3], "max": [0.5, 0.9, 1], "space": "fraction", "frame": "b" }"#,
            true,
        ),
        (
            r#""box": { "min": [0.1, 0.2, 0.3], "max": [0.5, 0.9, 1], "space": "fraction", "frame": "volume", "objects": ["b"] }"#,
            false,
        ),
        (
            r#""box": { "min": [-50, -50, -50], "max": [10, 60, 30], "rotation_deg": [10, 20, 30], "keep": "outside", "frame": "b" }"#,
            true,
        ),
        (
            r#""ellipsoid": { "min": [-50, -50, -50], "max": [10, 60, 30], "objects": ["b"] }"#,
            false,
        ),
        (
            r#""plane": { "normal": [1, 2, -1], "point": [5, 6, 7], "frame": "b" }"#,
            true,
        ),
        (
            r#""plane": { "normal": [1, 2, -1], "distance_mm": 12, "frame": "b" }"#,
            true,
        ),
        (r#""plane": { "normal": [1, 2, -1], "frame": "b" }"#, true),
        (
            r#""plane": { "normal": [1, 2, -1], "objects": ["b"] }"#,
            false,
        ),
        (r#""mask": { "path": "mask", "frame": "b" }"#, true),
        (r#""mask": { "path": "mask", "objects": ["b"] }"#, false),
    ] {
        let headers = Headers {
            masks: vec![mask],
            ..Headers::from(header.clone())
        };
        let with = |transform: &str| {
            let text = format!(
                r#"{{ "objects": [{{ "name": "b", "like": "volume", "transform": {transform} }}], "clips": [{{ {clip} }}] }}"#
            );
            let plan = plan(&text, &headers);
            // A scene with everything said means the same.
            let said = settled_with(&scene(&text), &headers);
            let again = resolve_with(&said, &headers).unwrap();
            assert_eq!(format!("{plan:?}"), format!("{again:?}"), "{text}");
            plan
        };
        let still = with("{}");
        let moved = with(
            r#"{ "translate_mm": [70, -30, 20], "rotate_deg": [20, 0, 50], "scale": [1.5, 1, 1] }"#,
        );
        let mut differ = 0;
        for i in 0..4096u32 {
            let voxel = DVec3::new(
                f64::from(i % 16) * 17.0 + 0.3,
                f64::from(i / 16 % 16) * 17.0 + 0.4,
                f64::from(i / 256) * 8.0 + 0.6,
            );
            let kept = [&still, &moved].map(|plan| {
                let world = plan
                    .field_of(1)
                    .grid
                    .world_from_voxel()
                    .transform_point3(voxel);
                keeps(plan, 1, world)
            });
            differ += u32::from(kept[0] != kept[1]);
        }
        assert_eq!(differ == 0, moves, "{clip}: {differ}");
    }
}

#[test]
fn a_frame_that_is_not_there_is_named() {
    let headers = Headers::from(engine());
    for (clip, what) in [
        (
            r#""plane": { "normal": [1, 0, 0], "frame": "liver" }"#,
            "clips[0].plane.frame is \"liver\"",
        ),
        (
            r#""box": { "min": [0, 0, 0], "max": [1, 1, 1], "space": "voxels", "frame": "group" }"#,
            "clips[0].box.space",
        ),
        (
            r#""box": { "min": [0, 0, 0], "max": [1, 1, 1], "space": "fraction", "frame": "world" }"#,
            "clips[0].box.space",
        ),
    ] {
        let text = format!(r#"{{ "objects": [{{ "name": "group" }}], "clips": [{{ {clip} }}] }}"#);
        let message = resolve_with(&scene(&text), &headers)
            .unwrap_err()
            .to_string();
        assert!(message.contains(what), "{message}");
    }
}

/// The range of grays fits what is drawn.
#[test]
fn grey_ranges_fit_what_is_shown() {
    let headers = Headers::from(engine());
    let white = |text: &str| match plan(text, &headers).technique().composite {
        Composite::Gmip { white_per_mm } => white_per_mm,
        other => panic!("{other:?}"),
    };
    assert_eq!(white(r#"{ "method": "gmip" }"#), 127.5);
    // Half of the opacity per mm, of which there is at most 0.4.
    let of_opacity = r##"{ "method": "gmip", "gradient": { "of": "opacity" }, "transfer_function": { "points": [[10, 0, "#fff"], [99, 0.4, "#fff"], [200, 0.1, "#fff"]] } }"##;
    assert_eq!(white(of_opacity), 0.2);
    let fading = r##"{ "shading": { "model": "gradient-opacity" }, "gradient": { "of": "opacity" }, "transfer_function": { "points": [[10, 0, "#fff"], [99, 0.4, "#fff"]] } }"##;
    let Shade::GradientOpacity { full_per_mm } = plan(fading, &headers).technique().shade else {
        panic!("lit");
    };
    assert_eq!(full_per_mm, 0.1);
    // From the nearest point of the box to its farthest, also along parallel rays.
    for projection in ["perspective", "orthographic"] {
        let text = format!(
            r#"{{ "debug": "depth", "camera": {{ "view": "top", "projection": "{projection}" }} }}"#
        );
        let plan = plan(&text, &headers);
        let Composite::Debug(DebugView::Depth { near_mm, far_mm }) = plan.technique().composite
        else {
            panic!("no depth");
        };
        let (lo, hi) = plan.field().grid.bounds_mm();
        let near = plan.camera.eye_mm.z - hi.z;
        let far = match projection {
            "perspective" => plan.camera.eye_mm.distance(lo),
            _ => plan.camera.eye_mm.z - lo.z,
        };
        assert!((f64::from(near_mm) - near).abs() < 0.02, "{near_mm} {near}");
        assert!((f64::from(far_mm) - far).abs() < 0.02, "{far_mm} {far}");
    }
}
