//! The cranial cavity and the skin around everything.

use crate::phantom::modeling::*;
use crate::phantom::solid::Solid;

/// Inside of the skull, where the brain lies. Skull and scalp are grown around it.
pub fn cavity() -> Solid {
    let mut m = Model::default();
    m.join(
        One,
        0.0,
        ellipsoid(at(0.0, -6.0, 58.0), at(62.0, 80.0, 56.0)),
    )
    .join(
        One,
        16.0,
        ellipsoid(at(0.0, 36.0, 58.0), at(51.0, 42.0, 42.0)),
    )
    .join(
        Both,
        14.0,
        ellipsoid(at(27.0, -34.0, 66.0), at(37.0, 38.0, 36.0)),
    )
    // Occipital lobes and the fossa of the cerebellum.
    .join(
        One,
        14.0,
        ellipsoid(at(0.0, -50.0, 12.0), at(47.0, 34.0, 32.0)),
    )
    // Above orbits and nose the cavity ends at the floor of the anterior fossa.
    .cut(
        One,
        10.0,
        block(at(0.0, 84.0, -8.0), at(90.0, 48.0, 42.0), 6.0),
    )
    // Temporal lobes.
    .join(
        Both,
        8.0,
        ellipsoid(at(38.0, 9.0, 16.0), at(19.0, 27.0, 21.0)),
    )
    // Body of the sphenoid, clivus and the ridges of the petrous bones rise into it.
    .cut(
        One,
        8.0,
        rod(at(0.0, 40.0, 0.0), 15.0, at(0.0, 2.0, -4.0), 13.0),
    )
    .cut(
        Both,
        6.0,
        rod(at(16.0, 2.0, -4.0), 8.0, at(60.0, -20.0, 2.0), 9.0),
    );
    m.build_up_to(30.0)
}

/// Where the ring hangs: below the lobe of the left ear.
pub const EARRING: glam::DVec3 = at(-73.0, -4.5, -25.5);

/// The skin, grown from the scalp (the start value).
pub fn skin() -> Solid {
    let mut m = Model::default();
    // Neck and shoulders first, so that jaw and chin stand out from them.
    m.join(
        One,
        22.0,
        rod(at(0.0, -24.0, -46.0), 46.0, at(0.0, -18.0, -122.0), 48.0),
    )
    .join(
        One,
        26.0,
        ellipsoid(at(0.0, -22.0, -182.0), at(92.0, 60.0, 46.0)),
    )
    .join_tube(
        Both,
        10.0,
        &[
            [54.0, -18.0, -34.0, 10.0],
            [42.0, 4.0, -90.0, 11.0],
            [14.0, 33.0, -162.0, 9.0],
        ],
    )
    .join(
        One,
        12.0,
        ellipsoid(at(0.0, 31.0, -112.0), at(12.0, 13.0, 17.0)),
    );
    // The masses of the face.
    m.join(
        One,
        16.0,
        ellipsoid(at(0.0, 50.0, 48.0), at(55.0, 44.0, 42.0)),
    )
    .join(
        One,
        16.0,
        ellipsoid(at(0.0, 38.0, -6.0), at(63.0, 48.0, 46.0)),
    )
    .join(
        Both,
        22.0,
        ellipsoid(at(42.0, 58.0, -8.0), at(19.0, 20.0, 17.0)),
    )
    .join(
        One,
        18.0,
        ellipsoid(at(0.0, 44.0, -56.0), at(48.0, 43.0, 40.0)),
    )
    .join(
        Both,
        16.0,
        ellipsoid(at(44.0, 16.0, -54.0), at(12.0, 20.0, 24.0)),
    )
    .join(
        One,
        14.0,
        ellipsoid(at(0.0, 80.0, -87.0), at(19.0, 16.0, 13.0)),
    )
    .join(
        One,
        14.0,
        ellipsoid(at(0.0, 80.0, -52.0), at(29.0, 18.5, 24.0)),
    );
    // Brows and eyes: sockets, then closed lids over the eyeballs.
    m.join_tube(
        Both,
        12.0,
        &[
            [6.0, 87.0, 32.0, 7.0],
            [22.0, 87.0, 37.0, 7.0],
            [38.0, 80.0, 37.0, 7.0],
            [51.0, 68.0, 30.0, 7.0],
        ],
    )
    .cut(
        Both,
        12.0,
        ellipsoid(at(31.0, 99.0, 15.0), at(17.0, 14.0, 12.0)),
    )
    .join(
        Both,
        5.0,
        ellipsoid_turned(
            at(32.5, 73.0, 16.5),
            at(17.0, 15.0, 13.5),
            turned(0.0, 0.0, -10.0),
        ),
    )
    .cut_tube(
        Both,
        1.6,
        &[
            [19.0, 83.5, 14.0, 0.8],
            [25.0, 87.4, 11.5, 1.0],
            [32.0, 88.6, 10.2, 1.0],
            [40.0, 85.6, 11.2, 1.0],
            [47.5, 79.0, 14.5, 0.8],
        ],
    )
    .cut_tube(
        Both,
        3.0,
        &[
            [20.0, 84.0, 21.0, 0.9],
            [26.0, 87.0, 25.0, 1.0],
            [34.0, 86.5, 26.0, 1.0],
            [42.0, 83.0, 23.5, 1.0],
            [49.0, 76.0, 17.5, 0.8],
        ],
    );
    // Nose.
    m.join_tube(
        One,
        10.0,
        &[
            [0.0, 86.0, 28.0, 6.5],
            [0.0, 91.0, 17.0, 5.8],
            [0.0, 100.0, 4.0, 6.0],
            [0.0, 107.5, -8.0, 6.6],
            [0.0, 110.0, -14.0, 7.0],
        ],
    )
    .join(
        One,
        5.0,
        ellipsoid(at(0.0, 110.5, -15.5), at(8.5, 8.0, 7.5)),
    )
    .join(
        Both,
        5.0,
        ellipsoid_turned(
            at(10.5, 101.5, -19.0),
            at(6.0, 9.0, 6.8),
            turned(0.0, 0.0, 22.0),
        ),
    )
    .join(
        Both,
        10.0,
        rod(at(7.0, 90.0, 4.0), 4.5, at(10.0, 95.0, -12.0), 5.5),
    )
    .join(
        One,
        4.0,
        rod(at(0.0, 107.0, -21.0), 3.4, at(0.0, 96.0, -27.0), 4.5),
    )
    .cut(
        Both,
        2.0,
        rod(at(6.5, 104.0, -30.0), 3.3, at(6.0, 100.0, -15.0), 2.4),
    );
    // Mouth.
    m.join_tube(
        Both,
        5.0,
        &[
            [0.0, 94.5, -49.5, 4.6],
            [5.5, 95.5, -48.6, 4.7],
            [14.0, 91.5, -50.5, 4.2],
            [25.0, 83.0, -54.0, 2.6],
        ],
    )
    .join_tube(
        Both,
        5.0,
        &[
            [0.0, 94.0, -60.0, 5.4],
            [8.0, 93.5, -59.6, 5.2],
            [16.0, 89.5, -57.8, 4.2],
            [25.0, 83.0, -55.0, 2.6],
        ],
    )
    .cut_tube(
        Both,
        2.5,
        &[
            [0.0, 100.3, -55.0, 1.2],
            [7.0, 100.3, -54.2, 1.2],
            [15.0, 95.9, -54.6, 1.2],
            [27.0, 86.6, -55.2, 1.0],
        ],
    )
    .cut(
        One,
        9.0,
        ellipsoid(at(0.0, 103.0, -71.5), at(17.0, 9.0, 5.0)),
    )
    .cut(
        One,
        4.0,
        rod(at(0.0, 101.5, -33.0), 2.4, at(0.0, 103.6, -44.0), 3.0),
    )
    .cut_tube(
        Both,
        9.0,
        &[
            [17.0, 97.0, -22.0, 2.0],
            [24.0, 94.5, -34.0, 2.4],
            [31.0, 88.0, -48.0, 2.0],
        ],
    );
    // Ears: a tilted shell with a rolled rim, hollow in the middle.
    let ear = turned(12.0, 0.0, 22.0);
    let in_ear = |x: f64, y: f64, z: f64| at(76.0, -14.0, 8.0) + ear * at(x, y, z);
    m.join(
        Both,
        5.0,
        ellipsoid_turned(in_ear(0.0, 0.0, 0.0), at(4.5, 16.0, 28.0), ear),
    );
    m.cut(
        Both,
        3.0,
        ellipsoid_turned(in_ear(7.0, 0.0, 4.0), at(6.5, 12.5, 22.0), ear),
    );
    let rim: Vec<[f64; 4]> = [
        (1.0, 9.0, 2.0, 1.8),
        (2.5, 13.5, 12.0, 2.4),
        (3.0, 9.0, 24.0, 2.6),
        (3.0, -3.0, 28.5, 2.6),
        (3.0, -13.0, 20.0, 2.6),
        (3.0, -16.0, 6.0, 2.5),
        (3.0, -12.5, -9.0, 2.5),
        (2.5, -5.0, -19.0, 3.0),
    ]
    .map(|(x, y, z, r)| {
        let p = in_ear(x, y, z);
        [p.x, p.y, p.z, r]
    })
    .to_vec();
    let antihelix: Vec<[f64; 4]> = [
        (3.0, -1.0, 20.0, 1.8),
        (3.5, -8.0, 10.0, 2.2),
        (3.5, -7.5, -2.0, 2.2),
        (3.0, -2.0, -11.0, 2.4),
    ]
    .map(|(x, y, z, r)| {
        let p = in_ear(x, y, z);
        [p.x, p.y, p.z, r]
    })
    .to_vec();
    m.join_tube(Both, 1.5, &rim)
        .join_tube(Both, 2.0, &antihelix)
        .join(
            Both,
            3.0,
            ellipsoid_turned(in_ear(1.5, 4.0, -24.0), at(3.5, 7.0, 8.0), ear),
        )
        .join(
            Both,
            3.0,
            ellipsoid_turned(in_ear(2.0, 9.5, -4.0), at(3.5, 3.5, 6.5), ear),
        )
        .cut(
            Both,
            2.0,
            rod(in_ear(6.0, 3.0, -4.0), 4.5, in_ear(-8.0, 5.0, -6.0), 3.0),
        );
    // A bust: it ends above the floor of the volume, rounded.
    m.cut(
        One,
        8.0,
        block(at(0.0, 0.0, -260.0), at(300.0, 300.0, 98.0), 1.0),
    );
    m.build()
}
