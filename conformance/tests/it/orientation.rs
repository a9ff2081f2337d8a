//! Which way a patient faces in a picture, from the voxels to the pixels.

use glam::{DAffine3, DMat3, DVec3};
use strahl_conformance::renderers;
use strahl_scene::{Camera, Image, Method, Scene, TransferFunction, TransferPoint, View, resolve};
use strahl_scene::{Color, Reconstruct, Shading, ShadingModel};
use strahl_volume::{Grid, Metadata, Modality, Rescale, Samples, Volume};

/// A CT of air, 40³ voxels of 2 mm about (10, −20, 30) mm, with a block of 20 mm of 1000 HU towards `to`
/// and one of 500 HU on the opposite side. `axes` are the directions in which voxels are stored.
fn patient(to: DVec3, axes: DMat3) -> Volume {
    let center = DVec3::new(10.0, -20.0, 30.0);
    let corner = center - axes * DVec3::splat(39.0);
    let world_from_voxel = DAffine3::from_mat3_translation(axes * 2.0, corner);
    let grid = Grid::new([40; 3], world_from_voxel).unwrap();
    let mut samples = Vec::new();
    for z in 0..40 {
        for y in 0..40 {
            for x in 0..40 {
                let voxel = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                let place = world_from_voxel.transform_point3(voxel) - center;
                let near = |middle: DVec3| (place - middle).abs().max_element() < 10.0;
                samples.push(match (near(26.0 * to), near(-26.0 * to)) {
                    (true, _) => 1000i16,
                    (_, true) => 500,
                    _ => -1000,
                });
            }
        }
    }
    let metadata = Metadata {
        modality: Some(Modality::Ct),
        has_length_unit: true,
        ..Metadata::default()
    };
    Volume::new(grid, Samples::I16(samples), Rescale::IDENTITY, metadata).unwrap()
}

/// Voxels stored along R, A, S; as DICOM has them; and turned about.
fn storages() -> [DMat3; 3] {
    let lps = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    let turned = DMat3::from_cols(DVec3::Z, -DVec3::X, DVec3::Y);
    [DMat3::IDENTITY, lps, turned]
}

/// 1000 HU red, 500 HU green, both opaque.
fn pictures(volume: &Volume, view: Option<View>) -> Vec<Image> {
    let point = |value, opacity, color| TransferPoint::new(value, opacity, Color(color));
    let scene = Scene {
        method: Some(Method::EmissionAbsorption),
        transfer_function: Some(TransferFunction {
            points: Some(vec![
                point(200.0, 0.0, [0.0, 1.0, 0.0]),
                point(400.0, 1.0, [0.0, 1.0, 0.0]),
                point(740.0, 1.0, [0.0, 1.0, 0.0]),
                point(760.0, 1.0, [1.0, 0.0, 0.0]),
            ]),
            ..TransferFunction::default()
        }),
        shading: Some(Shading {
            model: Some(ShadingModel::Unlit),
            ..Shading::default()
        }),
        // Between voxels air and 1000 HU would be 500 HU.
        reconstruct: Some(Reconstruct::Nearest),
        camera: view.map(|view| Camera {
            view: Some(view),
            ..Camera::default()
        }),
        size: Some([48, 48]),
        ..Scene::default()
    };
    let plan = resolve(&scene, &volume.header(), None).unwrap();
    let draw = |renderer: strahl_conformance::Renderer| renderer.draw(volume, &plan);
    renderers().into_iter().map(draw).collect()
}

/// Where the pixels of the 1000 HU block lie in the mean, from the middle of the picture (−1 to 1: to the
/// right, upwards), and how many there are.
fn seen(image: &Image) -> (f64, f64, usize) {
    let (mut right, mut up, mut number) = (0.0, 0.0, 0);
    for y in 0..image.height() {
        for x in 0..image.width() {
            let [r, g, ..] = image.pixel(x, y);
            if r > 0.5 && g < 0.5 {
                right += (f64::from(x) + 0.5) / f64::from(image.width()) * 2.0 - 1.0;
                up += 1.0 - (f64::from(y) + 0.5) / f64::from(image.height()) * 2.0;
                number += 1;
            }
        }
    }
    let number_or_1 = f64::from(number.max(1) as u32);
    (right / number_or_1, up / number_or_1, number)
}

const LEFT: DVec3 = DVec3::NEG_X;
const ANTERIOR: DVec3 = DVec3::Y;
const SUPERIOR: DVec3 = DVec3::Z;

#[test]
fn without_a_word_the_patients_left_is_on_the_right_and_the_head_is_up() {
    for axes in storages() {
        for image in pictures(&patient(LEFT, axes), None) {
            let (right, up, number) = seen(&image);
            assert!(number > 30 && right > 0.3 && up.abs() < 0.1, "{right} {up}");
        }
        for image in pictures(&patient(SUPERIOR, axes), None) {
            let (right, up, number) = seen(&image);
            assert!(number > 30 && up > 0.3 && right.abs() < 0.1, "{right} {up}");
        }
        // What is in front hides what is behind.
        for image in pictures(&patient(ANTERIOR, axes), None) {
            assert!(seen(&image).2 > 30);
        }
        for image in pictures(&patient(-ANTERIOR, axes), None) {
            let visible = seen(&image).2;
            assert_eq!(visible, 0, "the back is seen through the front");
        }
    }
}

#[test]
fn every_view_shows_the_side_that_it_is_called_after() {
    // (view, towards the viewer, right of the picture, up)
    let views = [
        (View::Front, ANTERIOR, LEFT, SUPERIOR),
        (View::Back, -ANTERIOR, -LEFT, SUPERIOR),
        (View::Left, LEFT, -ANTERIOR, SUPERIOR),
        (View::Right, -LEFT, ANTERIOR, SUPERIOR),
        (View::Top, SUPERIOR, -LEFT, ANTERIOR),
        (View::Bottom, -SUPERIOR, LEFT, ANTERIOR),
    ];
    for (view, towards, right_side, up_side) in views {
        let see = |to: DVec3| {
            let volume = patient(to, storages()[1]);
            pictures(&volume, Some(view))
                .iter()
                .map(seen)
                .collect::<Vec<_>>()
        };
        let all = |seen: Vec<(f64, f64, usize)>, test: fn(&(f64, f64, usize)) -> bool| {
            assert!(seen.iter().all(test), "{view:?}: {seen:?}");
        };
        all(see(towards), |seen| seen.2 > 30);
        all(see(-towards), |seen| seen.2 == 0);
        all(see(right_side), |seen| seen.2 > 30 && seen.0 > 0.3);
        all(see(up_side), |seen| seen.2 > 30 && seen.1 > 0.3);
    }
}
