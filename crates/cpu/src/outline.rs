//! Where in the picture the volumes lie. Rays of other pixels need not be aimed.

use glam::{DMat3, DVec3};
use strahl_scene::plan::{Plan, PlanCamera, Projection};

/// Pixels around the outline that count as inside. Rounding moves a corner by far less.
const MARGIN: f64 = 1.0;

/// How much of a pixel rounding may move a corner.
const MOST_ROUNDING: f64 = 1e-3;

/// The convex outline of all volumes of a Plan, in columns and rows of the picture.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Pixels with `x`, `y` where one of them has a·x + b·y + c > 0 lie outside.
    edges: Vec<[f64; 3]>,
}

impl Outline {
    /// `None` where every pixel may show something: in front of meshes, or if a volume reaches behind the eye.
    pub fn of(plan: &Plan) -> Option<Outline> {
        if !plan.meshes.is_empty() {
            return None;
        }
        let mut corners = Vec::new();
        for field in plan.drawn_fields() {
            for corner in field.grid.corners_mm() {
                corners.push(pixel(plan, corner)?);
            }
        }
        let hull = hull(corners);
        if hull.len() < 3 {
            return None;
        }
        let next = hull.iter().cycle().skip(1);
        let sides = hull.iter().zip(next).map(|([x, y], [to_x, to_y])| {
            // The hull goes against the clock, so that its outside is on the right.
            let (a, b) = (to_y - y, x - to_x);
            [a, b, -(a * x + b * y) - MARGIN * a.hypot(b)]
        });
        let most = |pick: fn(&[f64; 2]) -> f64| hull.iter().map(pick).fold(f64::MIN, f64::max);
        let faces = [
            [-1.0, 0.0, -most(|p| -p[0]) - MARGIN],
            [1.0, 0.0, -most(|p| p[0]) - MARGIN],
            [0.0, -1.0, -most(|p| -p[1]) - MARGIN],
            [0.0, 1.0, -most(|p| p[1]) - MARGIN],
        ];
        let edges: Vec<_> = faces.into_iter().chain(sides).collect();
        let is_finite = edges.iter().flatten().all(|number| number.is_finite());
        is_finite.then_some(Outline { edges })
    }

    /// Whether no pixel from `first` to `last`, columns and rows, sees a volume.
    pub fn misses(&self, first: [u32; 2], last: [u32; 2]) -> bool {
        let [x0, y0] = first.map(f64::from);
        let [x1, y1] = last.map(f64::from);
        self.edges.iter().any(|[a, b, c]| {
            let nearest = a * if *a > 0.0 { x0 } else { x1 } + b * if *b > 0.0 { y0 } else { y1 };
            nearest + c > 0.0
        })
    }
}

/// Where the picture shows a point, in columns and rows; `None` if it is not in front of the eye, or rounding counts.
fn pixel(plan: &Plan, point_mm: DVec3) -> Option<[f64; 2]> {
    let PlanCamera {
        eye_mm,
        right,
        up,
        forward,
        projection,
    } = plan.camera;
    let [across, upward, depth_mm] = DMat3::from_cols(right, up, forward)
        .inverse()
        .mul_vec3(point_mm - eye_mm)
        .to_array();
    let half_height_mm = match projection {
        Projection::Perspective { tan_half_height } => depth_mm * tan_half_height,
        Projection::Orthographic { half_height_mm } => half_height_mm,
    };
    let (width, height) = (f64::from(plan.width), f64::from(plan.height));
    let pixel_mm = 2.0 * half_height_mm / height;
    let rounding_mm = 1e-12 * (eye_mm.length() + point_mm.length());
    // Also false for numbers that are not finite.
    let is_exact = rounding_mm < MOST_ROUNDING * pixel_mm;
    let aspect = width / height;
    is_exact.then(|| {
        [
            (across / (half_height_mm * aspect) + 1.0) / 2.0 * width - 0.5,
            (1.0 - upward / half_height_mm) / 2.0 * height - 0.5,
        ]
    })
}

/// The corners of the convex hull, against the clock (x to the right, y upward): A. M. Andrew, Another efficient
/// algorithm for convex hulls in two dimensions (1979).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && turn(a, b, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut all = chain(&mut points.iter().copied());
    all.extend(chain(&mut points.iter().rev().copied()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use strahl_scene::{Scene, resolve};
    use strahl_volume::Phantom;

    fn plan(camera: &str) -> Plan {
        let volume = Phantom::Tree.volume([8, 12, 10]).unwrap();
        let scene = format!(r#"{{ "size": [61, 47], "camera": {{ {camera} }} }}"#);
        let scene = Scene::parse("scene", &scene).unwrap();
        resolve(&scene, &volume.header(), None).unwrap()
    }

    /// Whether the ray of a pixel meets the box of the volume, in double precision.
    fn meets(plan: &Plan, x: u32, y: u32) -> bool {
        let ray = plan.camera.ray(x, y, plan.width, plan.height);
        let grid = &plan.field().grid;
        let (lo, hi) = grid.extent_in_voxels();
        let to_voxel = grid.voxel_from_world();
        let (start, along) = (
            to_voxel.transform_point3(ray.origin_mm),
            to_voxel.transform_vector3(ray.direction),
        );
        let (mut first, mut last) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let [a, b] = [lo, hi].map(|end| (end[axis] - start[axis]) / along[axis]);
            (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
        }
        first < last
    }

    #[test]
    fn pixels_outside_see_no_volume_and_most_of_the_others_do() {
        for projection in ["perspective", "orthographic"] {
            for (azimuth, elevation, zoom) in [(0, 0, 1.0), (31, 17, 1.0), (75, -60, 2.5)] {
                let plan = plan(&format!(
                    r#""projection": "{projection}", "azimuth_deg": {azimuth}, "elevation_deg": {elevation}, "zoom": {zoom}"#
                ));
                let outline = Outline::of(&plan).unwrap();
                let (mut inside, mut seen) = (0, 0);
                for (x, y) in (0..plan.height).flat_map(|y| (0..plan.width).map(move |x| (x, y))) {
                    let meets = meets(&plan, x, y);
                    let misses = outline.misses([x, y], [x, y]);
                    assert!(!(meets && misses), "{projection} {azimuth}: {x}, {y}");
                    inside += u32::from(!misses);
                    seen += u32::from(meets);
                }
                // The margin is a pixel on all sides.
                assert!(
                    seen > 200 && inside < seen + 2 * (61 + 47),
                    "{inside} {seen}"
                );
            }
        }
    }

    #[test]
    fn a_block_is_outside_if_all_its_pixels_are() {
        let plan = plan(r#""azimuth_deg": 31, "elevation_deg": 17, "zoom": 0.6"#);
        let outline = Outline::of(&plan).unwrap();
        let mut outside = 0;
        for (x, y) in (0..40)
            .step_by(8)
            .flat_map(|y| (0..56).step_by(8).map(move |x| (x, y)))
        {
            let block = outline.misses([x, y], [x + 7, y + 3]);
            let pixels = (y..y + 4).flat_map(|y| (x..x + 8).map(move |x| [x, y]));
            let all = pixels.map(|pixel| outline.misses(pixel, pixel));
            assert!(!block || all.into_iter().all(|pixel| pixel), "{x}, {y}");
            outside += u32::from(block);
        }
        assert!(outside > 10, "{outside}");
    }

    #[test]
    fn inside_a_volume_every_pixel_is_aimed() {
        assert!(Outline::of(&plan(r#""zoom": 50"#)).is_some_and(|o| !o.misses([0, 0], [0, 0])));
        let mut inside = plan("");
        inside.camera.eye_mm = inside.field().grid.center_mm();
        assert!(Outline::of(&inside).is_none());
        inside.camera.eye_mm.x = f64::NAN;
        assert!(Outline::of(&inside).is_none());
    }
}
