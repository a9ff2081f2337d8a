//! The graphics processor beside the processor: the same scenes, the same pictures.
//!
//! Without an adapter the tests say that they are skipped; with `CI=true` that is a failure.

use glam::DVec3;
use std::sync::OnceLock;
use strahl_gpu::{Device, Renderer, no_progress};
use strahl_scene::{Image, Scene, resolve};
use strahl_volume::phantom::Phantom;
use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume};

fn device() -> Option<&'static Device> {
    static DEVICE: OnceLock<Option<Device>> = OnceLock::new();
    let open = || match Device::open(None) {
        Ok(device) => Some(device),
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => panic!("{error}"),
        Err(error) => {
            println!("skipped: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).as_ref()
}

/// What is seen of the difference of two pictures.
struct Difference {
    /// In dB, of 8-bit sRGB-like values; infinite if equal.
    psnr: f64,
    /// Share of the pixels with a channel that is off by more than 8/255.
    far: f64,
    /// The largest difference of a channel.
    most: f64,
}

fn difference(a: &Image, b: &Image) -> Difference {
    let (mut sum, mut far, mut most) = (0.0, 0usize, 0.0f64);
    for (a, b) in a.pixels().iter().zip(b.pixels()) {
        let mut worst = 0.0f64;
        for c in 0..4 {
            // A square root stands for the curve of the screen.
            let seen = |v: f32| f64::from(v.clamp(0.0, 1.0)).sqrt();
            let d = (seen(a[c]) - seen(b[c])).abs();
            sum += d * d;
            worst = worst.max(d);
        }
        far += usize::from(worst > 8.0 / 255.0);
        most = most.max(worst);
    }
    let n = a.pixels().len() as f64;
    Difference {
        psnr: -10.0 * (sum / (4.0 * n)).log10(),
        far: far as f64 / n,
        most,
    }
}

/// Draws on both; `None` without an adapter.
fn both(volume: &Volume, scene: &str) -> Option<(Image, Image)> {
    let device = device()?;
    let plan = resolve(
        &Scene::parse("scene", scene).unwrap(),
        &volume.header(),
        None,
    )
    .unwrap();
    let cpu = strahl_cpu::Renderer::new(volume)
        .render(&plan, &Default::default(), &strahl_cpu::no_progress)
        .unwrap();
    let gpu = Renderer::new(device, volume)
        .unwrap()
        .render(&plan, no_progress)
        .unwrap();
    Some((cpu.image, gpu.image))
}

fn agrees(what: &str, volume: &Volume, scene: &str) {
    let Some((cpu, gpu)) = both(volume, scene) else {
        return;
    };
    let seen = cpu.pixels().iter().filter(|p| p[3] > 0.0).count();
    assert!(seen > cpu.pixels().len() / 20, "{what}: nothing is seen");
    let d = difference(&cpu, &gpu);
    println!(
        "{what}: {:.1} dB, {:.4} far, at most {:.3}",
        d.psnr, d.far, d.most
    );
    // Silhouettes: a sample that lies on the border of the extent or of a surface may fall on
    // either side of it in single precision.
    assert!(
        d.psnr >= 45.0 && d.far < 0.003,
        "{what}: {:.1} dB, {} far",
        d.psnr,
        d.far
    );
}

const SCENES: [(&str, &str); 8] = [
    ("default", r#"{ "size": [96, 80] }"#),
    (
        "unlit",
        r#"{ "size": [96, 80], "shading": { "model": "unlit" } }"#,
    ),
    (
        "mip",
        r#"{ "size": [96, 80], "method": "mip", "preset": "mip" }"#,
    ),
    (
        "minip",
        r#"{ "size": [96, 80], "method": "minip", "preset": "mip" }"#,
    ),
    (
        "average",
        r#"{ "size": [96, 80], "method": "average", "preset": "x-ray" }"#,
    ),
    ("jitter", r#"{ "size": [96, 80], "jitter": { "seed": 7 } }"#),
    (
        "nearest",
        r#"{ "size": [96, 80], "reconstruct": "nearest" }"#,
    ),
    (
        "opaque background",
        r##"{ "size": [96, 80], "background": "#204060" }"##,
    ),
];

#[test]
fn phantoms_look_the_same() {
    for phantom in [
        Phantom::Tree,
        Phantom::MarschnerLobb,
        Phantom::Anatomy,
        Phantom::Fog,
    ] {
        let volume = phantom.volume([40, 36, 44]).unwrap();
        for (name, scene) in SCENES {
            agrees(&format!("{phantom:?} {name}"), &volume, scene);
        }
    }
}

#[test]
fn every_sample_type_looks_the_same() {
    let dims = [20, 24, 28];
    let field = |i: usize| {
        let (x, y, z) = (i % 20, i / 20 % 24, i / 480);
        let r = [
            x as f64 / 9.5 - 1.0,
            y as f64 / 11.5 - 1.0,
            z as f64 / 13.5 - 1.0,
        ];
        100.0 * (1.0 - r.iter().map(|v| v * v).sum::<f64>()).max(0.0)
    };
    let n = dims.iter().product::<usize>();
    let all: [Samples; 8] = [
        Samples::U8((0..n).map(|i| field(i) as u8).collect()),
        Samples::I8((0..n).map(|i| (field(i) - 50.0) as i8).collect()),
        Samples::U16((0..n).map(|i| (600.0 * field(i)) as u16).collect()),
        Samples::I16(
            (0..n)
                .map(|i| (600.0 * field(i) - 30_000.0) as i16)
                .collect(),
        ),
        Samples::U32((0..n).map(|i| (1e4 * field(i)) as u32).collect()),
        Samples::I32((0..n).map(|i| (1e4 * field(i) - 5e5) as i32).collect()),
        Samples::F32((0..n).map(|i| field(i) as f32).collect()),
        Samples::F64((0..n).map(field).collect()),
    ];
    let grid = Grid::centred(dims, DVec3::new(1.0, 0.75, 1.5)).unwrap();
    for samples in all {
        let what = format!("{:?}", samples.sample_type());
        let volume =
            Volume::new(grid, samples, Rescale::new(-2.0, 3.0), Metadata::default()).unwrap();
        for (name, scene) in SCENES {
            agrees(&format!("{what} {name}"), &volume, scene);
        }
    }
}
