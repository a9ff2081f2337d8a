//! Arteries and veins filled with contrast medium, and the aneurysm that marks the left side.

use crate::phantom::modeling::*;
use crate::phantom::solid::Solid;
use glam::DVec3;

/// Arteries of both sides. `ACom` and the basilar artery join them to the circle of Willis.
pub fn arteries() -> Solid {
    let mut m = Model::default();
    // Common and internal carotid with its siphon.
    m.join_tube(
        Both,
        1.5,
        &[
            [20.0, 4.0, -195.0, 4.0],
            [23.0, 8.0, -140.0, 4.0],
            [27.0, 10.0, -96.0, 4.8],
            [30.0, 4.0, -80.0, 3.6],
            [29.0, 4.0, -50.0, 2.7],
            [27.0, 8.0, -22.0, 2.7],
            [23.0, 12.0, -9.0, 2.7],
            [16.0, 15.0, -2.0, 2.6],
            [14.5, 24.0, 3.0, 2.6],
            [14.5, 32.0, 9.0, 2.5],
            [13.0, 29.0, 16.0, 2.4],
            [12.0, 25.0, 22.0, 2.3],
        ],
    )
    // Middle cerebral, two branches in the fissure.
    .join_tube(
        Both,
        1.0,
        &[
            [12.0, 25.0, 22.0, 2.1],
            [24.0, 30.0, 22.0, 2.0],
            [36.0, 26.0, 26.0, 1.8],
            [45.0, 14.0, 34.0, 1.6],
            [50.0, -4.0, 46.0, 1.4],
            [52.0, -22.0, 54.0, 1.2],
            [48.0, -42.0, 58.0, 1.0],
        ],
    )
    .join_tube(
        Both,
        1.0,
        &[
            [36.0, 26.0, 26.0, 1.6],
            [46.0, 26.0, 40.0, 1.4],
            [50.0, 20.0, 56.0, 1.2],
            [47.0, 10.0, 74.0, 1.0],
        ],
    )
    // Anterior cerebral and the communicating artery.
    .join_tube(
        Both,
        1.0,
        &[
            [12.0, 25.0, 22.0, 1.8],
            [4.0, 34.0, 27.0, 1.7],
            [2.5, 44.0, 40.0, 1.6],
            [2.5, 45.0, 58.0, 1.5],
            [2.5, 30.0, 70.0, 1.4],
            [2.5, 6.0, 76.0, 1.2],
            [2.5, -20.0, 76.0, 1.0],
        ],
    )
    .join(
        One,
        1.0,
        rod(at(-4.0, 34.0, 27.0), 1.2, at(4.0, 34.0, 27.0), 1.2),
    )
    // Vertebral, basilar, posterior cerebral, posterior communicating.
    .join_tube(
        Both,
        1.0,
        &[
            [19.0, 0.0, -195.0, 2.0],
            [17.0, -3.0, -138.0, 2.0],
            [17.5, -1.0, -103.0, 2.0],
            [17.5, -2.0, -69.0, 2.0],
            [21.0, -8.0, -48.0, 2.0],
            [26.0, -18.0, -34.0, 2.0],
            [15.0, -32.0, -27.0, 2.0],
            [8.0, -22.0, -16.0, 2.0],
            [1.0, -4.0, -6.0, 2.1],
        ],
    )
    .join_tube(
        One,
        1.0,
        &[
            [0.0, -4.0, -6.0, 2.3],
            [0.0, 4.0, 6.0, 2.2],
            [0.0, 9.0, 17.0, 2.0],
        ],
    )
    .join_tube(
        Both,
        1.0,
        &[
            [0.5, 9.0, 17.0, 1.8],
            [9.0, 8.0, 19.0, 1.7],
            [19.0, -6.0, 20.0, 1.6],
            [22.0, -22.0, 25.0, 1.4],
            [17.0, -44.0, 32.0, 1.2],
            [12.0, -64.0, 36.0, 1.0],
        ],
    )
    .join_tube(
        Both,
        1.0,
        &[
            [12.0, 24.0, 20.0, 1.1],
            [10.0, 15.0, 19.0, 1.1],
            [9.0, 8.0, 19.0, 1.1],
        ],
    )
    // External carotid: superficial temporal, facial.
    .join_tube(
        Both,
        1.0,
        &[
            [28.0, 12.0, -94.0, 3.0],
            [38.0, 10.0, -72.0, 2.6],
            [50.0, 2.0, -44.0, 2.3],
            [62.0, 2.0, -18.0, 2.0],
            [70.0, 6.0, 6.0, 1.8],
            [73.0, 10.0, 26.0, 1.6],
            [71.5, 22.0, 46.0, 1.5],
            [66.0, 34.0, 66.0, 1.3],
        ],
    )
    .join_tube(
        Both,
        1.0,
        &[
            [72.0, 11.0, 30.0, 1.3],
            [74.0, -4.0, 52.0, 1.3],
            [69.0, -20.0, 78.0, 1.2],
        ],
    )
    .join_tube(
        Both,
        1.0,
        &[
            [36.0, 11.0, -76.0, 2.0],
            [46.0, 30.0, -86.0, 1.8],
            [48.0, 44.0, -78.0, 1.7],
            [38.0, 70.0, -56.0, 1.5],
            [24.0, 86.0, -38.0, 1.4],
            [18.0, 90.0, -14.0, 1.2],
            [15.0, 88.0, 8.0, 1.0],
        ],
    );
    m.build()
}

/// Center of the aneurysm at the fork of the left middle cerebral artery.
pub const ANEURYSM: DVec3 = at(-38.0, 29.0, 23.0);

/// The aneurysm, on the left only.
pub fn aneurysm() -> Solid {
    let mut m = Model::default();
    m.join(One, 0.0, ball(ANEURYSM, 5.0));
    m.join(One, 1.5, ball(ANEURYSM + at(1.5, -2.5, 3.0), 2.8));
    m.build()
}

/// Veins and sinuses. `on_wall(p, depth)` moves a point along its ray from the middle of the brain to
/// `depth` mm inside the wall of the cranial cavity.
pub fn veins(on_wall: impl Fn(DVec3, f64) -> DVec3) -> Solid {
    let mut m = Model::default();
    let along = |points: &[(f64, f64, f64, f64)]| -> Vec<[f64; 4]> {
        points
            .iter()
            .map(|&(x, y, z, r)| {
                let p = on_wall(at(x, y, z), r * 0.7);
                [p.x, p.y, p.z, r]
            })
            .collect()
    };
    m.join_tube(
        One,
        1.0,
        &along(&[
            (0.0, 76.0, 50.0, 1.4),
            (0.0, 68.0, 80.0, 2.2),
            (0.0, 36.0, 104.0, 2.8),
            (0.0, -5.0, 112.0, 3.2),
            (0.0, -45.0, 103.0, 3.6),
            (0.0, -76.0, 76.0, 4.0),
            (0.0, -86.0, 40.0, 4.2),
            (0.0, -84.0, 14.0, 4.4),
        ]),
    )
    .join_tube(
        Both,
        1.0,
        &along(&[
            (0.5, -84.0, 14.0, 4.2),
            (24.0, -76.0, 13.0, 4.2),
            (42.0, -58.0, 12.0, 4.2),
            (50.0, -40.0, 8.0, 4.2),
        ]),
    );
    let sigmoid = on_wall(at(50.0, -40.0, 8.0), 3.0);
    m.join_tube(
        Both,
        1.0,
        &[
            [sigmoid.x, sigmoid.y, sigmoid.z, 4.2],
            [47.0, -26.0, -8.0, 4.4],
            [40.0, -12.0, -16.0, 4.4],
            [37.0, -4.0, -26.0, 4.6],
            [40.0, 0.0, -60.0, 5.0],
            [38.0, 10.0, -100.0, 5.6],
            [32.0, 14.0, -140.0, 6.0],
            [27.0, 12.0, -195.0, 6.4],
        ],
    );
    let confluence = on_wall(at(0.0, -84.0, 14.0), 3.0);
    m.join_tube(
        One,
        1.0,
        &[
            [0.0, -18.0, 50.0, 1.4],
            [0.0, -32.0, 50.0, 1.8],
            [0.0, -56.0, 34.0, 2.2],
            [confluence.x, confluence.y, confluence.z, 3.0],
        ],
    );
    m.build()
}

/// The ring in the lobe of the left ear.
pub fn earring(center: DVec3) -> Solid {
    let shape = crate::phantom::solid::Shape::Ring {
        center,
        radius: 6.0,
        thickness: 1.4,
        axes: turned(0.0, 90.0, 45.0),
    };
    let mut m = Model::default();
    m.join(One, 0.0, shape);
    m.build()
}
