//! What lies in the cranial cavity.

use crate::phantom::modeling::*;
use crate::phantom::number::Number;
use crate::phantom::solid::{Point, Solid};

/// Lateral, third and fourth ventricles.
pub fn ventricles() -> Solid {
    let mut m = Model::default();
    m.join_tube(
        Both,
        3.0,
        &[
            [6.0, 34.0, 52.0, 3.5],
            [7.0, 22.0, 58.0, 4.5],
            [9.0, 0.0, 63.0, 4.5],
            [15.0, -22.0, 60.0, 5.5],
            [22.0, -36.0, 50.0, 6.5],
            [28.0, -28.0, 34.0, 4.0],
            [32.0, -8.0, 22.0, 3.0],
        ],
    )
    .join(
        Both,
        2.0,
        rod(at(22.0, -38.0, 48.0), 4.5, at(17.0, -58.0, 46.0), 2.0),
    )
    .join(One, 1.0, block(at(0.0, 4.0, 40.0), at(2.0, 13.0, 9.0), 1.8))
    .join(
        One,
        2.0,
        ellipsoid(at(0.0, -22.0, 12.0), at(7.0, 4.0, 10.0)),
    );
    m.build()
}

/// Thalamus, caudate and lentiform nuclei.
pub fn nuclei() -> Solid {
    let mut m = Model::default();
    m.join(
        Both,
        1.0,
        ellipsoid_turned(
            at(11.0, -4.0, 46.0),
            at(7.5, 14.0, 9.0),
            turned(0.0, 0.0, 18.0),
        ),
    )
    .join(
        Both,
        1.0,
        ellipsoid_turned(
            at(24.0, 12.0, 44.0),
            at(7.0, 17.0, 10.0),
            turned(0.0, 0.0, 14.0),
        ),
    )
    .join_tube(
        Both,
        1.0,
        &[
            [13.0, 28.0, 50.0, 5.0],
            [15.0, 16.0, 57.0, 4.0],
            [18.0, -6.0, 62.0, 2.5],
        ],
    );
    m.build()
}

/// Cerebellum.
pub fn cerebellum() -> Solid {
    let mut m = Model::default();
    m.join(
        Both,
        6.0,
        ellipsoid(at(22.0, -50.0, 6.0), at(24.0, 27.0, 22.0)),
    )
    .join(
        One,
        6.0,
        ellipsoid(at(0.0, -48.0, 8.0), at(11.0, 24.0, 21.0)),
    );
    m.build()
}

/// Midbrain, pons, medulla.
pub fn brainstem() -> Solid {
    let mut m = Model::default();
    m.join(
        One,
        4.0,
        rod(at(0.0, -6.0, 34.0), 11.0, at(0.0, -8.0, 20.0), 11.0),
    )
    .join(
        One,
        6.0,
        ellipsoid(at(0.0, -8.0, 8.0), at(15.0, 12.0, 13.0)),
    )
    .join(
        One,
        4.0,
        rod(at(0.0, -14.0, -4.0), 8.5, at(0.0, -22.0, -26.0), 5.5),
    )
    .join(
        Both,
        5.0,
        rod(at(8.0, -16.0, 8.0), 7.0, at(20.0, -36.0, 8.0), 7.0),
    );
    m.build()
}

/// Distance in mm to the folds between the convolutions: sheets about 1.6 mm thick along a warped gyroid,
/// whose wavelength of 26 mm gives convolutions some 11 mm wide. Negative in the folds.
pub fn folds<N: Number>(p: Point<N>) -> N {
    const WAVE_PER_MM: f64 = std::f64::consts::TAU / 30.0;
    // Mirror images are alike but not the same: the folds of both sides are shifted against each other.
    let [x, y, z] = [p[0] + 3.0, p[1], p[2]];
    let warp = [
        x + (y * 0.09 + z * 0.05).sin() * 4.0,
        y + (z * 0.08 - x * 0.06).sin() * 4.5,
        z + (x * 0.07 + y * 0.05 + 1.0).sin() * 4.0,
    ];
    let [a, b, c] = warp.map(|w| w * WAVE_PER_MM);
    let gyroid = a.sin() * b.cos() + b.sin() * c.cos() + c.sin() * a.cos();
    // The slope of the gyroid on its zero surface is about 1.5 per radian.
    let sheet = (gyroid.squared() + 0.01).sqrt() - 0.1;
    sheet * (1.0 / (1.5 * WAVE_PER_MM)) - 0.6
}

/// Distance to the leaves of the cerebellum's surface, 3.5 mm apart. Negative in the fissures.
pub fn leaves<N: Number>(p: Point<N>) -> N {
    let wave = (p[2] * 1.8 + (p[1] * 0.05).sin() * 4.0 + p[0].squared() * 0.004).sin();
    wave * 0.9 + 0.55
}
