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

/// The range of greys fits what is drawn.
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
