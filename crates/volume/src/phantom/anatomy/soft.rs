//! Muscles, airway, eyes, cartilage, glands.

use super::bones::vertebra_at;
use crate::phantom::modeling::*;
use crate::phantom::solid::Solid;

/// Muscles and other soft tissue of their density.
pub fn muscle() -> Solid {
    let mut m = Model::default();
    // Chewing: temporal (two flat bellies through the arch), masseter, pterygoids.
    m.join(
        Both,
        3.0,
        ellipsoid_turned(
            at(64.0, 22.0, 40.0),
            at(7.0, 38.0, 34.0),
            turned(0.0, 6.0, 8.0),
        ),
    )
    .join(
        Both,
        4.0,
        rod(at(60.0, 34.0, 14.0), 8.0, at(52.0, 30.0, -14.0), 6.0),
    )
    .join(
        Both,
        3.0,
        ellipsoid_turned(
            at(56.0, 24.0, -42.0),
            at(7.5, 15.0, 30.0),
            turned(16.0, 6.0, 6.0),
        ),
    )
    .join(
        Both,
        3.0,
        rod(at(38.0, 24.0, -14.0), 9.0, at(40.0, 16.0, -58.0), 7.0),
    )
    // Around mouth and eyes, and the cheek.
    .join_tube(
        Both,
        3.0,
        &[
            [0.0, 91.0, -46.0, 5.0],
            [14.0, 88.0, -46.0, 5.0],
            [26.0, 82.0, -54.0, 4.5],
            [14.0, 87.0, -65.0, 5.0],
            [0.0, 90.0, -66.0, 5.0],
        ],
    )
    .join_tube(
        Both,
        2.0,
        &[
            [26.0, 82.0, -54.0, 3.0],
            [38.0, 58.0, -48.0, 3.0],
            [42.0, 36.0, -42.0, 3.0],
        ],
    )
    .join_tube(
        Both,
        3.0,
        &[
            [48.0, 68.0, -12.0, 3.0],
            [38.0, 78.0, -34.0, 3.0],
            [26.0, 84.0, -50.0, 3.0],
        ],
    )
    .join(
        One,
        4.0,
        ellipsoid(at(0.0, 80.0, -78.0), at(16.0, 6.0, 9.0)),
    )
    // Tongue and floor of the mouth.
    .join(
        One,
        6.0,
        ellipsoid(at(0.0, 52.0, -54.0), at(20.0, 26.0, 14.0)),
    )
    .join(
        One,
        8.0,
        ellipsoid(at(0.0, 40.0, -72.0), at(20.0, 30.0, 12.0)),
    )
    // Throat: wall of the pharynx, below the jaw, in front of the spine.
    .join(
        One,
        6.0,
        rod(at(0.0, 17.0, -8.0), 17.0, at(0.0, 20.0, -90.0), 17.0),
    )
    .join(
        One,
        6.0,
        rod(at(0.0, 20.0, -90.0), 17.0, at(0.0, 20.0, -190.0), 14.0),
    )
    .join(
        Both,
        4.0,
        rod(at(10.0, 12.0, -40.0), 5.0, at(11.0, 6.0, -190.0), 7.0),
    )
    .join_tube(
        Both,
        4.0,
        &[
            [6.0, 40.0, -92.0, 4.0],
            [9.0, 38.0, -130.0, 5.0],
            [10.0, 34.0, -190.0, 5.0],
        ],
    )
    // Sternocleidomastoid, scalenes.
    .join_tube(
        Both,
        3.0,
        &[
            [57.0, -16.0, -22.0, 7.0],
            [50.0, -2.0, -70.0, 9.5],
            [38.0, 16.0, -120.0, 9.5],
            [18.0, 32.0, -176.0, 7.0],
        ],
    )
    .join(
        Both,
        4.0,
        rod(at(24.0, -6.0, -70.0), 6.0, at(46.0, -6.0, -185.0), 13.0),
    )
    // Back of the neck, two layers, to the occiput.
    .join_tube(
        Both,
        4.0,
        &[
            [16.0, -66.0, -10.0, 11.0],
            [17.0, -50.0, -50.0, 15.0],
            [19.0, -48.0, -100.0, 17.0],
            [24.0, -54.0, -190.0, 19.0],
        ],
    )
    .join_tube(
        Both,
        3.0,
        &[
            [40.0, -40.0, -20.0, 10.0],
            [36.0, -32.0, -60.0, 12.0],
            [38.0, -34.0, -110.0, 13.0],
            [60.0, -46.0, -190.0, 22.0],
        ],
    )
    .join_tube(
        Both,
        3.0,
        &[
            [12.0, -76.0, -10.0, 5.0],
            [14.0, -70.0, -60.0, 5.0],
            [30.0, -70.0, -120.0, 8.0],
            [80.0, -56.0, -195.0, 16.0],
        ],
    );
    m.build()
}

/// Air: nose, sinuses, throat, windpipe, ear canals.
pub fn airway() -> Solid {
    let mut m = Model::default();
    // Nostrils to choanae.
    m.join_tube(
        Both,
        3.0,
        &[
            [6.4, 103.0, -26.0, 2.2],
            [6.0, 100.0, -16.0, 2.6],
            [6.0, 90.0, -12.0, 4.0],
        ],
    )
    .join(
        Both,
        3.0,
        block(at(6.0, 60.0, -11.0), at(4.2, 30.0, 15.5), 3.5),
    )
    .join(
        Both,
        3.0,
        block(at(4.0, 58.0, 4.0), at(2.2, 24.0, 10.0), 2.0),
    )
    // Conchae hang into it.
    .cut(
        Both,
        1.5,
        ellipsoid(at(9.0, 56.0, -16.0), at(4.2, 24.0, 5.0)),
    )
    .cut(
        Both,
        1.5,
        ellipsoid(at(8.5, 54.0, -3.0), at(3.6, 19.0, 4.5)),
    )
    // Nose to throat, throat to windpipe.
    .join_tube(
        One,
        4.0,
        &[
            [0.0, 34.0, -12.0, 8.0],
            [0.0, 22.0, -22.0, 8.0],
            [0.0, 19.0, -50.0, 6.5],
            [0.0, 21.0, -80.0, 7.0],
            [0.0, 24.0, -100.0, 6.0],
            [0.0, 27.0, -112.0, 3.0],
            [0.0, 26.0, -122.0, 7.0],
            [0.0, 22.0, -150.0, 8.0],
            [0.0, 18.0, -195.0, 8.0],
        ],
    )
    .join(
        Both,
        2.0,
        ellipsoid(at(9.0, 20.0, -16.0), at(6.0, 5.0, 6.0)),
    )
    // Between tongue and palate, and behind the lips.
    .join(
        One,
        1.0,
        ellipsoid(at(0.0, 50.0, -38.5), at(16.0, 22.0, 1.6)),
    )
    // Sinuses, 1 mm of lining inside the bone.
    .join(
        Both,
        0.5,
        ellipsoid(at(27.0, 58.0, -16.0), at(10.0, 14.0, 12.0)),
    )
    .join(One, 0.5, ellipsoid(at(9.0, 82.0, 37.0), at(6.4, 2.9, 6.4)))
    .join(
        One,
        0.5,
        ellipsoid(at(-13.0, 81.0, 39.0), at(10.4, 3.2, 8.4)),
    )
    .join(Both, 0.5, ball(at(10.0, 68.0, 17.0), 3.8))
    .join(Both, 0.5, ball(at(10.0, 57.0, 18.0), 4.1))
    .join(Both, 0.5, ball(at(9.0, 46.0, 17.0), 3.8))
    .join(Both, 0.5, ellipsoid(at(6.0, 27.0, 5.0), at(6.0, 8.0, 6.5)))
    // Mastoid cells and ear canals.
    .join(Both, 0.5, ball(at(57.0, -14.0, 4.0), 4.0))
    .join(Both, 0.5, ball(at(58.0, -17.0, -6.0), 3.4))
    .join(Both, 0.5, ball(at(56.0, -10.0, -10.0), 3.0))
    .join(Both, 0.5, ball(at(54.0, -13.0, -18.0), 2.4))
    .join(
        Both,
        0.5,
        rod(at(73.0, -7.0, 0.0), 2.4, at(40.0, -4.0, 0.0), 2.4),
    );
    m.build()
}

/// Center of the right eyeball.
pub const EYE: glam::DVec3 = at(32.0, 74.0, 17.0);

/// Eyeballs.
pub fn eyes() -> Solid {
    let mut m = Model::default();
    m.join(Both, 0.0, ball(EYE, 12.0))
        .join(Both, 2.0, ball(EYE + at(0.0, 5.2, 0.0), 7.6));
    m.build()
}

/// Lenses.
pub fn lenses() -> Solid {
    let mut m = Model::default();
    m.join(
        Both,
        0.0,
        ellipsoid(EYE + at(0.0, 7.0, 0.0), at(4.8, 2.3, 4.8)),
    );
    m.build()
}

/// Optic nerves to the chiasm, and the muscles that turn the eyes.
pub fn optic() -> (Solid, Solid) {
    let (mut nerve, mut muscles) = (Model::default(), Model::default());
    nerve.join_tube(
        Both,
        1.0,
        &[
            [31.0, 62.0, 17.0, 2.2],
            [24.0, 50.0, 19.0, 2.1],
            [13.0, 38.0, 21.0, 2.1],
            [6.0, 28.0, 24.0, 2.2],
            [1.0, 23.0, 25.0, 2.4],
        ],
    );
    for (x, z) in [(11.0, 0.0), (-11.0, 0.0), (0.0, 11.0), (0.0, -11.0)] {
        let belly = at(25.0 + x * 0.75, 60.0, 18.0 + z * 0.8);
        muscles.join_tube(
            Both,
            1.0,
            &[
                [32.0 + x, 74.0, 17.0 + z, 1.2],
                [belly.x, belly.y, belly.z, 2.4],
                [14.0 + x * 0.2, 42.0, 20.0 + z * 0.2, 1.4],
            ],
        );
    }
    (nerve.build(), muscles.build())
}

/// Cartilage of larynx and windpipe.
pub fn cartilage() -> Solid {
    let mut m = Model::default();
    m.join(
        Both,
        2.0,
        block_turned(
            at(10.0, 33.0, -110.0),
            at(1.6, 13.0, 12.0),
            1.4,
            turned(0.0, 0.0, 32.0),
        ),
    )
    .join_tube(
        Both,
        1.0,
        &[
            [0.0, 35.0, -124.0, 2.4],
            [9.0, 31.0, -124.0, 2.4],
            [11.0, 22.0, -123.0, 2.8],
            [0.0, 15.0, -121.0, 3.2],
        ],
    );
    for ring in 0..7 {
        let z = -132.0 - 6.0 * f64::from(ring);
        let y = 22.0 + (z + 150.0) * 0.12;
        m.join_tube(
            Both,
            0.5,
            &[
                [0.0, y + 9.0, z, 1.2],
                [7.0, y + 6.5, z, 1.2],
                [9.6, y, z, 1.2],
                [7.0, y - 6.5, z, 1.0],
            ],
        );
    }
    m.build()
}

/// Thyroid gland, parotid and submandibular glands: (thyroid, salivary).
pub fn glands() -> (Solid, Solid) {
    let (mut thyroid, mut salivary) = (Model::default(), Model::default());
    thyroid
        .join(
            Both,
            4.0,
            ellipsoid_turned(
                at(16.0, 24.0, -134.0),
                at(7.0, 9.0, 20.0),
                turned(0.0, -8.0, 0.0),
            ),
        )
        .join(
            One,
            4.0,
            rod(at(-10.0, 33.0, -140.0), 3.2, at(10.0, 33.0, -140.0), 3.2),
        );
    salivary
        .join(
            Both,
            3.0,
            ellipsoid(at(60.0, 4.0, -34.0), at(9.0, 12.0, 22.0)),
        )
        .join(
            Both,
            3.0,
            ellipsoid(at(34.0, 26.0, -86.0), at(9.0, 14.0, 9.0)),
        );
    (thyroid.build(), salivary.build())
}

/// Spinal canal and cord: (canal, cord).
pub fn cord() -> (Solid, Solid) {
    let line = |radius: f64| {
        let mut points = vec![[0.0, -20.0, 4.0, radius], [0.0, -23.0, -22.0, radius]];
        for n in 2..=9 {
            let c = vertebra_at(n);
            points.push([0.0, c.y - 16.0, c.z, radius]);
        }
        points.push([0.0, vertebra_at(9).y - 18.0, -200.0, radius]);
        let mut m = Model::default();
        m.join_tube(One, 1.0, &points);
        m.build()
    };
    (line(8.0), line(4.6))
}
