use crate::{ct_head, engine, header_at};
use glam::DVec3;
use strahl_scene::plan::{Plan, PlanCamera, Projection as PlanProjection};
use strahl_scene::{Camera, Projection, Scene, View, resolve};
use strahl_volume::VolumeHeader;

fn plan(camera: Camera, size: [u32; 2], header: &VolumeHeader) -> Plan {
    let scene = Scene {
        camera: Some(camera),
        size: Some(size),
        ..Scene::default()
    };
    resolve(&scene, header, None).unwrap()
}

/// Column and row (0 to 1 from the left top) where a world point appears.
fn seen_at(camera: &PlanCamera, point: DVec3, aspect: f64) -> [f64; 2] {
    let from_eye = point - camera.eye_mm;
    let half_height = match camera.projection {
        PlanProjection::Perspective { tan_half_height } => {
            from_eye.dot(camera.forward) * tan_half_height
        }
        PlanProjection::Orthographic { half_height_mm } => half_height_mm,
    };
    [
        0.5 + 0.5 * from_eye.dot(camera.right) / (half_height * aspect),
        0.5 - 0.5 * from_eye.dot(camera.up) / half_height,
    ]
}

fn close(a: DVec3, b: [f64; 3], tolerance: f64) {
    let b = DVec3::from_array(b);
    assert!(a.distance(b) < tolerance, "{a} is not {b}");
}

#[test]
fn orbit_is_vtks() {
    // By hand for the engine: bounds of the voxel centers 255×255×127, so the sphere's radius is
    // √(255² + 255² + 127²)/2 = 191.1668 and the distance 191.1668 / sin 15° = 738.6118. From the
    // center (0.5, 0.5, −0.5) along (cos 20° sin 30°, sin 20°, cos 20° cos 30°).
    let camera = Camera {
        view: Some(View::Top),
        elevation_deg: Some(20.0),
        azimuth_deg: Some(30.0),
        zoom: Some(1.4),
        ..Camera::default()
    };
    let plan = plan(camera, [512, 512], &engine());
    let PlanProjection::Perspective { tan_half_height } = plan.camera.projection else {
        panic!("not perspective");
    };
    assert!((tan_half_height - (15f64 / 1.4).to_radians().tan()).abs() < 1e-12);
    let (elevation, azimuth) = (20f64.to_radians(), 30f64.to_radians());
    let distance = 0.5 * f64::sqrt(146_179.0) / 15f64.to_radians().sin();
    let eye = [
        0.5 + distance * elevation.cos() * azimuth.sin(),
        0.5 + distance * elevation.sin(),
        -0.5 + distance * elevation.cos() * azimuth.cos(),
    ];
    close(plan.camera.eye_mm, eye, 1e-9);
    // VTK 9.7.2, asked for the same volume at the origin (center 127.5, 127.5, 63.5), says:
    let vtk = DVec3::new(474.53404936687457, 380.12012849282047, 664.580605459793);
    let moved = vtk - DVec3::new(127.0, 127.0, 64.0);
    close(plan.camera.eye_mm, moved.to_array(), 1e-9);
    // The view-up axis stays y, made perpendicular to the view.
    assert!(plan.camera.right.y.abs() < 1e-12);
    close(
        plan.camera.right,
        [azimuth.cos(), 0.0, -azimuth.sin()],
        1e-12,
    );
    assert!((plan.camera.up.y - elevation.cos()).abs() < 1e-12);
}

#[test]
fn azimuths_add_up() {
    let at = |azimuth| {
        let camera = Camera {
            view: Some(View::Front),
            elevation_deg: Some(15.0),
            azimuth_deg: Some(azimuth),
            ..Camera::default()
        };
        plan(camera, [64, 64], &engine()).camera.eye_mm
    };
    close(at(0.0), at(360.0).to_array(), 1e-9);
    let center = engine().grid.center_mm();
    let turned = glam::DQuat::from_rotation_z(40f64.to_radians()) * (at(10.0) - center) + center;
    close(at(50.0), turned.to_array(), 1e-9);
}

#[test]
fn patient_left_is_on_the_right_from_the_front() {
    let header = ct_head();
    let plan = plan(Camera::default(), [300, 200], &header);
    let center = header.grid.center_mm();
    let at = |offset: DVec3| seen_at(&plan.camera, center + offset, 1.5);
    // RAS: the patient's left is −x, the head +z, the face +y.
    assert!(at(DVec3::new(-50.0, 0.0, 0.0))[0] > 0.6);
    assert!(at(DVec3::new(50.0, 0.0, 0.0))[0] < 0.4);
    assert!(at(DVec3::new(0.0, 0.0, 50.0))[1] < 0.4);
    assert!(plan.camera.eye_mm.y > center.y + 100.0);
}

#[test]
fn views_are_seen_from_their_side() {
    let header = ct_head();
    let center = header.grid.center_mm();
    // Side of the eye, direction of the picture's right edge, of its top.
    for (view, eye, right, up) in [
        (View::Front, DVec3::Y, -DVec3::X, DVec3::Z),
        (View::Back, -DVec3::Y, DVec3::X, DVec3::Z),
        (View::Left, -DVec3::X, -DVec3::Y, DVec3::Z),
        (View::Right, DVec3::X, DVec3::Y, DVec3::Z),
        (View::Top, DVec3::Z, DVec3::X, DVec3::Y),
        (View::Bottom, -DVec3::Z, -DVec3::X, DVec3::Y),
    ] {
        let camera = Camera {
            view: Some(view),
            ..Camera::default()
        };
        let camera = plan(camera, [64, 64], &header).camera;
        close((camera.eye_mm - center).normalize(), eye.to_array(), 1e-9);
        close(camera.right, right.to_array(), 1e-9);
        close(camera.up, up.to_array(), 1e-9);
        assert_eq!(view.name().parse(), Ok(view));
    }
}

/// The depths that context-preserving rendering counts from: those of all places in the box, and no more.
#[test]
fn depths_are_those_of_the_nearest_and_the_farthest_place() {
    let header = ct_head();
    let (low, high) = header.grid.bounds_mm();
    for projection in [Projection::Perspective, Projection::Orthographic] {
        for (azimuth_deg, zoom) in [(0.0, 1.0), (35.0, 1.0), (200.0, 3.0)] {
            let camera = Camera {
                projection: Some(projection),
                azimuth_deg: Some(azimuth_deg),
                zoom: Some(zoom),
                ..Camera::default()
            };
            let camera = plan(camera, [64, 64], &header).camera;
            let [near, far] = camera.depths_mm(&header.grid);
            let (mut least, mut most) = (f64::INFINITY, 0.0f64);
            for i in 0..31 * 31 * 31 {
                let share =
                    DVec3::new((i % 31) as f64, (i / 31 % 31) as f64, (i / 961) as f64) / 30.0;
                let way = low + share * (high - low) - camera.eye_mm;
                let depth = match projection {
                    Projection::Perspective => way.length(),
                    Projection::Orthographic => way.dot(camera.forward),
                };
                (least, most) = (least.min(depth), most.max(depth));
            }
            assert!((far - most).abs() < 1e-6, "{far} {most}");
            // The nearest place of a face lies between two of these.
            assert!(near <= least + 1e-6 && near > least - 1.0, "{near} {least}");
        }
    }
}

#[test]
fn nothing_is_cut_off_without_a_zoom() {
    for header in [
        engine(),
        ct_head(),
        header_at([1, 1, 1], DVec3::ZERO),
        header_at([2, 300, 1], DVec3::splat(90.0)),
    ] {
        for size in [[640, 480], [200, 900], [100, 100]] {
            for projection in [Projection::Perspective, Projection::Orthographic] {
                let camera = Camera {
                    projection: Some(projection),
                    ..Camera::default()
                };
                let plan = plan(camera, size, &header);
                let aspect = f64::from(size[0]) / f64::from(size[1]);
                let mut reach: f64 = 0.0;
                for corner in header.grid.corners_mm() {
                    for place in seen_at(&plan.camera, corner, aspect) {
                        reach = reach.max((place - 0.5).abs() * 2.0);
                    }
                }
                // Fills the picture, but for a margin.
                assert!((0.94..=0.965).contains(&reach), "{reach} {size:?}");
            }
        }
    }
}

#[test]
fn a_tall_picture_still_holds_the_sphere() {
    let camera = Camera {
        zoom: Some(1.0),
        view: Some(View::Top),
        ..Camera::default()
    };
    let distance = |size| {
        let plan = plan(camera, size, &engine());
        plan.camera.eye_mm.distance(engine().grid.center_mm())
    };
    let radius = 0.5 * f64::sqrt(146_179.0);
    // vtkRenderer::ResetCamera: half the horizontal angle is atan(tan 15° · aspect).
    let half_angle = (15f64.to_radians().tan() * 0.5).atan();
    assert!((distance([100, 200]) - radius / half_angle.sin()).abs() < 1e-9);
    // VTK 9.7.2 in a window of 200×400 pixels:
    assert!((distance([200, 400]) - 1439.6373050176364).abs() < 1e-9);
    assert_eq!(distance([200, 100]), distance([100, 100]));
}

#[test]
fn a_free_camera_looks_where_it_is_told() {
    let camera = Camera {
        position: Some([100.0, 200.0, 300.0]),
        focus: Some([1.0, 2.0, 3.0]),
        up: Some([0.0, 0.0, 5.0]),
        view_angle_deg: Some(60.0),
        ..Camera::default()
    };
    let camera = plan(camera, [64, 64], &engine()).camera;
    assert_eq!(camera.eye_mm, DVec3::new(100.0, 200.0, 300.0));
    let middle = seen_at(&camera, DVec3::new(1.0, 2.0, 3.0), 1.0);
    assert!((middle[0] - 0.5).abs() < 1e-12 && (middle[1] - 0.5).abs() < 1e-12);
    close(
        camera.right.cross(camera.up),
        (-camera.forward).to_array(),
        1e-12,
    );
    assert_eq!(
        camera.projection,
        PlanProjection::Perspective {
            tan_half_height: 30f64.to_radians().tan()
        }
    );
}

#[test]
fn a_zoom_of_an_orthographic_camera_divides_its_height() {
    let camera = Camera {
        projection: Some(Projection::Orthographic),
        height_mm: Some(100.0),
        zoom: Some(2.5),
        ..Camera::default()
    };
    assert_eq!(
        plan(camera, [64, 64], &engine()).camera.projection,
        PlanProjection::Orthographic {
            half_height_mm: 20.0
        }
    );
}

/// Straight above: what comes up from the horizon is up in the picture, as it is just before.
#[test]
fn an_orbit_reaches_its_poles() {
    for view in View::ALL {
        for (pole, before) in [(90.0, 89.8), (-90.0, -89.8)] {
            let at = |elevation| {
                let camera = Camera {
                    view: Some(view),
                    elevation_deg: Some(elevation),
                    azimuth_deg: Some(25.0),
                    ..Camera::default()
                };
                plan(camera, [64, 64], &engine()).camera
            };
            let (found, near) = (at(pole), at(before));
            close(found.up, near.up.to_array(), 0.01);
            close(found.right, near.right.to_array(), 0.01);
            assert!(found.forward.dot(near.forward) > 0.9999);
        }
    }
}
