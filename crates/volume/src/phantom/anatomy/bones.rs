//! Skull, mandible, teeth and cervical spine.

use crate::phantom::modeling::*;
use crate::phantom::solid::Solid;

/// The skull without mandible and teeth, grown from the vault (the start value). The cranial cavity is cut
/// from it afterwards.
pub fn cranium() -> Solid {
    let mut m = Model::default();
    // Base, petrous bones, mastoids, condyles.
    m.join(
        One,
        8.0,
        ellipsoid(at(0.0, 12.0, -6.0), at(28.0, 34.0, 12.0)),
    )
    .join(
        One,
        6.0,
        rod(at(0.0, 8.0, -8.0), 9.0, at(0.0, -8.0, -20.0), 7.0),
    )
    .join(
        Both,
        6.0,
        rod(at(18.0, 4.0, -4.0), 8.0, at(58.0, -14.0, 2.0), 10.0),
    )
    .join_tube(
        Both,
        5.0,
        &[
            [59.0, -14.0, 8.0, 11.0],
            [57.0, -14.0, -12.0, 9.0],
            [53.0, -10.0, -28.0, 5.0],
        ],
    )
    .join(
        Both,
        4.0,
        ellipsoid(at(14.0, -16.0, -26.0), at(6.0, 10.0, 5.0)),
    )
    .join(One, 10.0, ellipsoid(at(0.0, -91.0, 6.0), at(9.0, 5.0, 6.0)))
    .join(
        Both,
        1.0,
        rod(at(48.0, -2.0, -10.0), 2.4, at(43.0, 10.0, -40.0), 1.0),
    );
    // Forehead.
    m.join(
        One,
        12.0,
        ellipsoid(at(0.0, 47.0, 48.0), at(50.0, 41.0, 38.0)),
    );
    // Midface, still solid.
    m.join(
        One,
        8.0,
        ellipsoid(at(0.0, 50.0, 2.0), at(36.0, 32.0, 36.0)),
    )
    .join(
        One,
        8.0,
        ellipsoid(at(0.0, 62.0, -22.0), at(32.0, 22.0, 18.0)),
    )
    .join(
        Both,
        6.0,
        ellipsoid_turned(
            at(43.0, 50.0, 12.0),
            at(7.0, 18.0, 20.0),
            turned(0.0, 0.0, -38.0),
        ),
    )
    // Room for the temporal muscle behind the cheekbone.
    .cut(
        Both,
        5.0,
        ellipsoid(at(65.0, 36.0, 4.0), at(9.5, 20.0, 34.0)),
    )
    .join(
        Both,
        4.0,
        rod(at(14.0, 34.0, -4.0), 5.0, at(16.0, 32.0, -36.0), 4.0),
    );
    // Brow, rim of the orbit, cheekbone and its arch.
    m.join_tube(
        Both,
        9.0,
        &[
            [4.0, 83.0, 31.0, 5.5],
            [18.0, 82.5, 36.0, 5.0],
            [34.0, 77.0, 37.5, 4.5],
            [47.0, 67.5, 33.0, 4.5],
            [53.5, 60.0, 22.0, 4.2],
        ],
    )
    .join_tube(
        Both,
        5.0,
        &[
            [53.5, 60.0, 22.0, 4.0],
            [54.0, 59.0, 10.0, 4.5],
            [52.0, 61.0, -2.0, 6.5],
        ],
    )
    .join_tube(
        Both,
        5.0,
        &[
            [52.0, 62.0, -3.0, 6.0],
            [42.0, 72.0, -5.0, 5.0],
            [28.0, 79.0, -3.0, 4.5],
            [18.0, 82.0, 6.0, 4.0],
            [14.0, 83.0, 20.0, 4.0],
        ],
    )
    .join(
        Both,
        6.0,
        ellipsoid_turned(
            at(49.0, 62.0, -10.0),
            at(9.0, 11.0, 10.0),
            turned(0.0, 0.0, -30.0),
        ),
    )
    .join_tube(
        Both,
        7.0,
        &[
            [46.0, 62.0, -14.0, 7.0],
            [38.0, 60.0, -24.0, 6.5],
            [32.0, 58.0, -34.0, 5.0],
        ],
    )
    .join_tube(
        Both,
        4.0,
        &[
            [54.0, 57.0, -7.0, 5.0],
            [62.0, 44.0, -7.0, 3.6],
            [66.5, 26.0, -5.0, 3.2],
            [66.0, 8.0, -1.0, 3.6],
            [63.0, -4.0, 2.0, 5.0],
        ],
    )
    .join_tube(
        Both,
        3.0,
        &[
            [54.0, 57.0, -3.0, 4.5],
            [62.0, 44.0, -3.0, 3.4],
            [66.5, 26.0, -2.0, 3.0],
            [66.0, 8.0, 1.0, 3.4],
        ],
    );
    // Nasal bones, upper jaw.
    m.join_tube(
        Both,
        5.0,
        &[
            [2.5, 84.0, 27.0, 4.0],
            [3.0, 87.0, 18.0, 3.8],
            [4.0, 92.5, 9.0, 3.2],
            [4.0, 95.5, 4.5, 2.6],
        ],
    )
    .join_tube(
        Both,
        5.0,
        &[
            [0.0, 83.0, -36.0, 5.5],
            [12.0, 80.0, -36.0, 5.5],
            [21.0, 72.0, -36.0, 5.5],
            [26.0, 60.0, -36.0, 5.5],
            [28.0, 46.0, -35.0, 5.5],
        ],
    )
    .join(
        One,
        3.0,
        rod(at(0.0, 82.0, -28.0), 3.0, at(0.0, 90.0, -27.0), 1.5),
    );
    // Hollows: canine fossa, orbits, nose, mouth, foramen magnum, joints of the jaw.
    m.cut(
        Both,
        8.0,
        ellipsoid(at(30.0, 86.0, -18.0), at(8.0, 9.0, 8.0)),
    )
    .cut(
        Both,
        3.0,
        ellipsoid_turned(
            at(34.0, 82.0, 16.0),
            at(19.5, 26.0, 17.0),
            turned(0.0, -12.0, -8.0),
        ),
    )
    .cut(
        Both,
        3.0,
        rod(at(33.0, 76.0, 16.0), 16.0, at(13.0, 38.0, 20.0), 4.0),
    )
    .cut(
        One,
        2.0,
        rod(at(0.0, 97.0, 3.0), 4.5, at(0.0, 92.0, -14.0), 9.0),
    )
    .cut(
        Both,
        2.0,
        rod(at(5.0, 96.0, -18.0), 6.5, at(5.5, 70.0, -18.0), 6.5),
    )
    .cut(
        One,
        4.0,
        block(at(0.0, 52.0, -8.0), at(12.0, 36.0, 20.0), 8.0),
    )
    .cut(
        One,
        5.0,
        ellipsoid(at(0.0, 54.0, -48.0), at(20.0, 27.0, 15.0)),
    )
    .cut(
        One,
        3.0,
        rod(at(0.0, -30.0, -44.0), 15.0, at(0.0, -28.0, 6.0), 14.0),
    )
    .cut(
        Both,
        2.0,
        rod(at(44.0, 8.0, -6.0), 5.5, at(58.0, 9.0, -6.0), 5.5),
    )
    .cut(
        Both,
        1.0,
        rod(at(90.0, -6.0, 0.0), 3.4, at(38.0, -4.0, 0.0), 3.0),
    );
    // Sinuses; the left frontal sinus is the larger one.
    m.cut(
        Both,
        2.0,
        ellipsoid(at(27.0, 58.0, -16.0), at(11.0, 15.0, 13.0)),
    )
    .cut(One, 2.0, ellipsoid(at(9.0, 82.0, 37.0), at(7.0, 3.5, 7.0)))
    .cut(
        One,
        2.0,
        ellipsoid(at(-13.0, 81.0, 39.0), at(11.0, 3.8, 9.0)),
    )
    .cut(Both, 1.0, ball(at(10.0, 68.0, 17.0), 4.5))
    .cut(Both, 1.0, ball(at(10.0, 57.0, 18.0), 4.8))
    .cut(Both, 1.0, ball(at(9.0, 46.0, 17.0), 4.5))
    .cut(Both, 1.5, ellipsoid(at(6.0, 27.0, 5.0), at(7.0, 9.0, 7.5)));
    // Septum (bowed to the left) and conchae.
    m.join_tube(
        One,
        1.0,
        &[
            [0.0, 84.0, -10.0, 1.1],
            [-1.5, 66.0, -10.0, 1.1],
            [0.0, 40.0, -10.0, 1.1],
        ],
    )
    .join(
        One,
        1.0,
        block(at(-1.0, 58.0, -2.0), at(1.1, 28.0, 12.0), 1.0),
    )
    .join(
        One,
        1.0,
        block(at(-1.0, 56.0, -20.0), at(1.1, 26.0, 9.0), 1.0),
    )
    .join(
        Both,
        1.0,
        block_turned(
            at(8.0, 56.0, -16.0),
            at(1.2, 20.0, 5.0),
            1.2,
            turned(0.0, 20.0, 0.0),
        ),
    )
    .join(
        Both,
        1.0,
        block_turned(
            at(7.5, 54.0, -3.0),
            at(1.2, 16.0, 5.0),
            1.2,
            turned(0.0, 20.0, 0.0),
        ),
    );
    m.build()
}

/// The lower jaw.
pub fn mandible() -> Solid {
    let mut m = Model::default();
    m.join_tube(
        Both,
        6.0,
        &[
            [0.0, 75.0, -86.0, 7.5],
            [13.0, 73.0, -86.0, 7.0],
            [26.0, 62.0, -84.0, 6.5],
            [38.0, 42.0, -79.0, 6.0],
            [45.0, 24.0, -72.0, 5.5],
        ],
    )
    .join_tube(
        Both,
        10.0,
        &[
            [0.0, 76.0, -71.0, 5.5],
            [11.0, 74.5, -71.0, 5.5],
            [20.0, 68.0, -70.5, 5.5],
            [27.0, 54.0, -69.5, 5.5],
            [36.0, 36.0, -66.0, 5.0],
        ],
    )
    .join(
        One,
        8.0,
        ellipsoid(at(0.0, 81.0, -89.0), at(10.0, 6.0, 6.0)),
    )
    .join(Both, 7.0, ball(at(12.0, 77.0, -91.0), 5.0))
    // Ramus between its two borders, angle, coronoid process, condyle.
    .join_tube(
        Both,
        5.0,
        &[
            [43.0, 28.0, -74.0, 5.5],
            [46.5, 10.0, -66.0, 5.0],
            [48.5, 4.0, -46.0, 4.6],
            [50.0, 6.0, -26.0, 4.6],
            [51.0, 8.0, -11.0, 4.4],
        ],
    )
    .join_tube(
        Both,
        5.0,
        &[
            [38.0, 38.0, -68.0, 5.5],
            [45.0, 31.0, -50.0, 4.4],
            [49.0, 29.0, -30.0, 3.8],
            [50.5, 31.0, -8.0, 1.8],
        ],
    )
    .join(
        Both,
        4.0,
        ellipsoid_turned(
            at(47.5, 17.0, -44.0),
            at(4.0, 15.0, 24.0),
            turned(4.0, -5.0, 4.0),
        ),
    )
    .join(
        Both,
        3.0,
        rod(at(44.5, 8.0, -8.0), 4.0, at(57.0, 9.0, -8.0), 4.0),
    );
    m.build()
}

/// One tooth: where its neck is, which way its crown grows, and its size.
struct Tooth {
    x: f64,
    y: f64,
    /// Outward direction of the arch, degrees from +y towards +x.
    turn: f64,
    width: f64,
    depth: f64,
    height: f64,
}

/// Mesio-distal width, depth and height of the crown in mm, from the first incisor to the second molar,
/// after the averages in Ash and Nelson, "Wheeler's Dental Anatomy".
const UPPER: [[f64; 3]; 7] = [
    [8.5, 6.6, 10.5],
    [6.7, 6.0, 9.2],
    [7.6, 7.6, 10.2],
    [7.0, 9.0, 8.6],
    [6.8, 9.0, 8.4],
    [10.0, 10.6, 7.6],
    [9.4, 10.6, 7.2],
];
const LOWER: [[f64; 3]; 7] = [
    [5.4, 6.0, 9.0],
    [5.9, 6.2, 9.4],
    [6.9, 7.4, 10.4],
    [7.0, 7.6, 8.6],
    [7.1, 8.0, 8.2],
    [10.8, 10.2, 7.6],
    [10.4, 9.8, 7.2],
];

/// The teeth of one side, set along half an ellipse by their widths.
fn arch(sizes: &[[f64; 3]; 7], radius_x: f64, radius_y: f64, center_y: f64) -> Vec<Tooth> {
    const FINE: usize = 4000;
    let on_arch = |step: usize| {
        let angle = step as f64 / FINE as f64 * std::f64::consts::FRAC_PI_2;
        (
            radius_x * angle.sin(),
            center_y + radius_y * angle.cos(),
            angle,
        )
    };
    let mut teeth = Vec::new();
    let (mut step, mut walked, mut wanted) = (0, 0.0, 0.0);
    for &[width, depth, height] in sizes {
        wanted += width / 2.0;
        while walked < wanted && step < FINE {
            let (a, b) = (on_arch(step), on_arch(step + 1));
            walked += (b.0 - a.0).hypot(b.1 - a.1);
            step += 1;
        }
        wanted += width / 2.0;
        // Past the end of the half ellipse the arch goes straight back.
        let (x, y, angle) = on_arch(step);
        let normal = (angle.sin() / radius_x).atan2(angle.cos() / radius_y);
        teeth.push(Tooth {
            x,
            y: y - (wanted - width / 2.0 - walked).max(0.0),
            turn: normal.to_degrees(),
            width,
            depth,
            height,
        });
    }
    teeth
}

/// z of the plane in which the teeth meet.
pub const OCCLUSAL_Z_MM: f64 = -54.5;

/// Crowns and roots of 28 teeth.
pub fn teeth() -> (Solid, Solid) {
    let (mut crowns, mut roots) = (Model::default(), Model::default());
    let rows = [
        (arch(&UPPER, 26.5, 35.0, 50.0), 1.0),
        (arch(&LOWER, 25.0, 33.0, 49.5), -1.0),
    ];
    for (teeth, up) in rows {
        for (i, t) in teeth.iter().enumerate() {
            let axes = turned(0.0, 0.0, -t.turn);
            let front = i < 3;
            // Upper front teeth reach 1.5 mm over the lower ones.
            let edge = OCCLUSAL_Z_MM + if front && up > 0.0 { -1.5 } else { 0.3 * up };
            let half = at(t.width * 0.5 - 0.1, t.depth * 0.5, t.height * 0.5);
            let center = at(t.x, t.y, edge + up * half.z);
            if front {
                // Wedges: a block at the edge, thicker towards the neck.
                let lip = axes * at(0.0, 1.2, 0.0);
                crowns.join(
                    Both,
                    0.4,
                    block_turned(center + lip, at(half.x, half.y * 0.55, half.z), 1.6, axes),
                );
                crowns.join(
                    Both,
                    2.0,
                    ellipsoid_turned(
                        center + at(0.0, 0.0, up * 2.0),
                        at(half.x * 0.85, half.y, half.z * 0.7),
                        axes,
                    ),
                );
            } else {
                crowns.join(Both, 0.4, block_turned(center, half, 2.4, axes));
                // The groove between the cusps.
                let along = axes * at(half.x + 1.0, 0.0, 0.0);
                let groove = at(t.x, t.y, edge - up * 0.8);
                crowns.cut(Both, 2.0, rod(groove - along, 1.6, groove + along, 1.6));
            }
            let neck = at(t.x, t.y, edge + up * (t.height - 1.0));
            let length = if front { 13.0 } else { 11.0 };
            let splay: &[f64] = if i >= 5 { &[-0.25, 0.25] } else { &[0.0] };
            for &s in splay {
                let from = neck + axes * at(s * t.width, 0.0, 0.0);
                let to = from + axes * at(s * 3.0, -2.0, 0.0) + at(0.0, 0.0, up * length);
                roots.join(
                    Both,
                    1.0,
                    rod(
                        from,
                        t.width.min(t.depth) * if i >= 5 { 0.24 } else { 0.42 },
                        to,
                        1.0,
                    ),
                );
            }
        }
    }
    (crowns.build(), roots.build())
}

/// Center of the body of vertebra C`n` (1 to 7; 8 and 9 are T1 and T2). The column is curved forwards.
pub fn vertebra_at(n: usize) -> glam::DVec3 {
    let z = [
        -34.0, -51.0, -69.0, -86.0, -103.0, -120.0, -138.0, -157.0, -177.0,
    ][n - 1];
    let from_middle: f64 = (z + 92.0) / 60.0;
    at(0.0, 1.0 - 9.0 * from_middle * from_middle, z)
}

/// C1 to T2.
pub fn vertebrae() -> Solid {
    let mut m = Model::default();
    // Atlas: a ring without a body.
    let atlas = vertebra_at(1);
    let (y, z) = (atlas.y, atlas.z);
    m.join_tube(
        Both,
        2.0,
        &[
            [0.0, y + 3.0, z, 4.0],
            [10.0, y, z, 4.0],
            [18.0, y - 8.0, z + 1.0, 6.0],
            [19.0, y - 18.0, z, 5.0],
            [12.0, y - 30.0, z, 3.2],
            [0.0, y - 36.0, z, 3.8],
        ],
    )
    .join(
        Both,
        3.0,
        ellipsoid(at(17.0, y - 9.0, z), at(7.0, 9.0, 7.0)),
    )
    .join(
        Both,
        3.0,
        rod(at(20.0, y - 10.0, z), 4.5, at(37.0, y - 12.0, z - 1.0), 3.2),
    );
    for n in 2..=9 {
        let c = vertebra_at(n);
        let grow = 1.0 + 0.04 * (n as f64 - 4.0);
        let p = |x: f64, y: f64, z: f64| at(x * grow, c.y + y, c.z + z);
        m.join(One, 1.0, block(c, at(11.0 * grow, 8.0 * grow, 6.8), 4.0))
            .join(
                Both,
                3.0,
                rod(p(9.0, -6.0, 0.0), 3.2, p(16.0, -12.0, 0.0), 3.2),
            )
            .join(
                Both,
                3.0,
                block_turned(
                    p(17.0, -14.0, 0.0),
                    at(5.5, 6.0, 7.5),
                    3.5,
                    turned(-25.0, 0.0, 0.0),
                ),
            )
            .join(
                Both,
                3.0,
                rod(p(10.0, -1.0, 0.0), 3.0, p(23.0, -3.0, -2.0), 3.0),
            )
            .join(
                Both,
                2.5,
                rod(p(16.0, -18.0, 0.0), 3.2, p(3.0, -27.0, -3.0), 3.2),
            );
        let (reach, tip) = match n {
            2 => (15.0, 4.2),
            7 => (26.0, 3.6),
            8 | 9 => (28.0, 3.4),
            _ => (11.0, 2.8),
        };
        m.join(
            One,
            3.0,
            rod(
                p(0.0, -27.0, -3.0),
                3.8,
                p(0.0, -27.0 - reach, -8.0 - reach * 0.15),
                tip,
            ),
        );
    }
    let axis = vertebra_at(2);
    m.join(
        One,
        3.0,
        rod(axis, 6.5, at(0.0, vertebra_at(1).y - 6.5, -29.0), 4.2),
    );
    m.build()
}

/// The discs below C2.
pub fn discs() -> Solid {
    let mut m = Model::default();
    for n in 2..=8 {
        let (a, b) = (vertebra_at(n), vertebra_at(n + 1));
        m.join(One, 0.0, ellipsoid((a + b) * 0.5, at(10.8, 8.0, 3.4)));
    }
    m.build()
}

/// Hyoid bone.
pub fn hyoid() -> Solid {
    let mut m = Model::default();
    m.join_tube(
        Both,
        2.0,
        &[
            [0.0, 46.0, -88.0, 3.4],
            [9.0, 44.0, -88.0, 2.8],
            [17.0, 32.0, -85.0, 2.0],
            [20.0, 20.0, -82.0, 1.8],
        ],
    );
    m.build()
}
