//! What goes beyond the document's machine, each as a switch of the Spec.

use crate::{draw, jaw_spec, small_jaw, volume_of};
use proptest::prelude::*;
use strahl_sim::deformation::Deformation;
use strahl_sim::polygons::Fragment;
use strahl_sim::spec::{
    Axis, Bend, Leaping, Merge, PlacedVolume, Polygons, Projection, Shape, Spec, Widths,
};
use strahl_sim::study::psnr_db;
use strahl_sim::{Error, Frame, NoObserver, Run, Subject, VolumeStore, no_progress, run};
use strahl_volume::Mesh;

fn drawn(spec: &Spec, subject: &Subject) -> Result<Run, Error> {
    strahl_sim::draw(spec, subject, &mut NoObserver, &no_progress)
}

fn alone(spec: &Spec, volume: &VolumeStore) -> Run {
    drawn(spec, &Subject::of(volume)).unwrap()
}

/// Field, value and what would be right.
fn refused(spec: &Spec, subject: &Subject, words: &[&str]) {
    let message = drawn(spec, subject).unwrap_err().to_string();
    for word in words {
        assert!(message.contains(word), "{word}: {message}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A volume cut into parts, on a board each: every sample is read by one of them, and the picture is that of the whole,
    /// but for the rounding of words where parts meet.
    #[test]
    fn boards_draw_the_parts_of_a_volume(
        seed in prop::collection::vec(0u8..90, 97), boards in 2u32..6, cut in 0usize..3,
        turn in -180.0f64..180.0, tilt in -80.0f64..80.0, is_perspective in any::<bool>(),
    ) {
        let volume = volume_of([12, 20, 9], (0..12 * 20 * 9).map(|i| seed[(i * 37 + i / 3) % 97]).collect());
        let mut spec = Spec { widths: Widths::wide(), ..Spec::default() };
        spec.look.opacity = vec![[0.0, 0.0], [255.0, 0.2]];
        spec.optimisation.termination_threshold = 0.0;
        spec.view.rotate_z_deg = turn;
        spec.view.rotate_x_deg = tilt;
        if is_perspective {
            spec.view.projection = Projection::Perspective { angle_deg: 50.0 };
        }
        let together = alone(&spec, &volume);
        spec.merge = Merge { boards, cut: [Axis::X, Axis::Y, Axis::Z][cut], ..Merge::default() };
        let apart = alone(&spec, &volume);
        prop_assert_eq!(apart.counters.samples, together.counters.samples);
        prop_assert_eq!(apart.clocks_of_part.len(), boards as usize);
        prop_assert_eq!(Some(&apart.counters.clocks), apart.clocks_of_part.iter().max());
        let psnr = psnr_db(&apart.picture, &together.picture);
        prop_assert!(psnr > 70.0, "{} dB", psnr);
    }
}

/// Two volumes one behind the other draw what one volume with both of them in it draws.
#[test]
fn volumes_lie_where_they_are_placed() {
    let value = |i: usize| ((i * 37 + i / 3) % 90) as u8;
    let (dims, far_dims) = ([12, 10, 9], [7, 6, 5]);
    let near = volume_of(dims, (0..12 * 10 * 9).map(value).collect());
    let far = volume_of(far_dims, (0..7 * 6 * 5).map(|i| value(i + 5)).collect());
    // Two empty layers between them, which interpolation needs and leaps over.
    let mut whole = vec![0; 12 * 18 * 9];
    for z in 0..9 {
        for y in 0..18 {
            for x in 0..12 {
                let at: Option<u8> = if y < 10 {
                    Some(value(x + 12 * (y + 10 * z)))
                } else if (3..10).contains(&x) && y >= 12 && (2..7).contains(&z) {
                    Some(value(x - 3 + 7 * (y - 12 + 6 * (z - 2)) + 5))
                } else {
                    None
                };
                whole[x + 12 * (y + 18 * z)] = at.unwrap_or(0);
            }
        }
    }
    let mut spec = Spec {
        widths: Widths::wide(),
        ..Spec::default()
    };
    spec.look.opacity = vec![[0.0, 0.0], [255.0, 0.2]];
    spec.optimisation.termination_threshold = 0.0;
    spec.look.background = 0.1;
    let expected = alone(&spec, &volume_of([12, 18, 9], whole));
    let at = [3, 12, 2];
    let placed = |at| PlacedVolume {
        path: "far".to_owned(),
        at,
        opacity: Vec::new(),
    };
    spec.merge.volumes = vec![placed(at)];
    let subject = Subject {
        volume: &near,
        others: vec![far],
        mesh: None,
    };
    let merged = drawn(&spec, &subject).unwrap();
    assert_eq!(merged.size, expected.size);
    // The one volume also interpolates between its parts and the air around them, which a volume of its own does not have.
    let psnr = psnr_db(&merged.picture, &expected.picture);
    assert!(psnr > 35.0, "{psnr} dB");
    // Half of the rays go through both; the merge costs two more bytes per pixel and volume.
    assert_eq!(merged.counters.rays, 12 * 9 + 7 * 5);
    spec.merge.volumes[0].opacity = vec![[0.0, 0.0]];
    let hidden = drawn(&spec, &subject).unwrap();
    let near_alone = alone(
        &Spec {
            merge: Merge::default(),
            ..spec.clone()
        },
        &near,
    );
    for (a, b) in hidden.picture.iter().zip(&near_alone.picture) {
        assert!((a - b).abs() < 0.001);
    }

    spec.merge.volumes = vec![placed([3, 9, 2])];
    refused(
        &spec,
        &subject,
        &["merge.volumes.at is [3, 9, 2]", "overlaps"],
    );
    spec.merge.volumes = vec![placed(at), placed([40, 0, 0])];
    refused(&spec, &subject, &["merge.volumes is 2", "1 of them"]);
    spec.merge.volumes = vec![placed(at)];
    spec.memory.rows = 1;
    refused(
        &spec,
        &subject,
        &["memory.rows is 1", "2 rows in every bank"],
    );
}

#[test]
fn boards_work_at_the_same_time_and_share_their_buses() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    let one = alone(&spec, &volume).counters.clocks;
    spec.merge.boards = 4;
    spec.merge.cut = Axis::Z;
    let four = alone(&spec, &volume);
    // Cut along z each board has a quarter of the picture.
    assert!(four.counters.clocks < one / 2);
    assert!(four.clocks_of_part.iter().sum::<u64>() < one * 5 / 4);
    spec.host.is_waited_for = true;
    spec.host.bus_mb_per_s = 40.0;
    let shared = alone(&spec, &volume).counters.clocks;
    spec.merge.buses = 4;
    let own = alone(&spec, &volume).counters.clocks;
    assert!(
        own < shared,
        "{own} clocks with four buses, {shared} with one"
    );
    spec.merge.buses = 5;
    refused(
        &spec,
        &Subject::of(&volume),
        &["merge.buses is 5", "merge.boards 4"],
    );
    spec.merge.boards = 64;
    refused(
        &spec,
        &Subject::of(&volume),
        &["merge.boards is 64", "63 cells"],
    );
}

/// Slabs draw the picture of one piece with fewer reads: near the eye their rays are not denser than voxels.
#[test]
fn slabs_read_less_for_the_same_picture() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.look.background = 0.3;
    spec.view.projection = Projection::Perspective { angle_deg: 90.0 };
    let one = alone(&spec, &volume);
    spec.view.slabs = 2;
    let two = alone(&spec, &volume);
    spec.view.slabs = 4;
    let four = alone(&spec, &volume);
    // The last slab has the density of the picture; one piece is as dense as suits a cube.
    assert_eq!(
        (one.size, two.size, four.size),
        ([384, 192], [382, 191], [382, 191])
    );
    assert!(two.counters.reads < one.counters.reads && four.counters.reads < two.counters.reads);
    assert_eq!(four.clocks_of_part.len(), 4);
    assert_eq!(
        four.counters.clocks,
        four.clocks_of_part.iter().sum::<u64>()
    );
    assert!((four.counters.reads as f64) < 0.7 * one.counters.reads as f64);
    let psnr = psnr_db(&two.picture, &four.picture);
    assert!(psnr > 25.0, "{psnr} dB");
    // Whatever the slabs, nothing is read where the slabs before are opaque.
    assert!(four.clocks_of_part[3] < 9 * four.clocks_of_part[0]);
    let subject = Subject::of(&volume);
    spec.view.slabs = 0;
    refused(&spec, &subject, &["view.slabs is 0", "1 to 64"]);
    spec.view.slabs = 4;
    spec.merge.boards = 2;
    refused(&spec, &subject, &["view.slabs is 4", "set it to 1"]);
    spec.merge.boards = 1;
    spec.view.projection = Projection::Parallel;
    refused(&spec, &subject, &["view.slabs is 4", "perspective"]);
}

#[test]
fn fragments_hide_what_is_behind_them_and_nothing_before() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.optimisation.termination_threshold = 0.0;
    let frame = Frame::new(&spec, &volume).unwrap();
    let pixels = frame.setup.pixel_count();
    let without = draw(&spec, &volume);
    let with = |plane, opacity| {
        let fragment = Fragment {
            plane,
            opacity,
            intensity: [255; 3],
        };
        let frame = frame
            .clone()
            .with_fragments(vec![Some(fragment); pixels])
            .unwrap();
        run(&frame, &mut NoObserver, &no_progress).unwrap()
    };
    // Before everything: white, and rays end at their first sample.
    let before = with(0, 255);
    assert!(before.picture.iter().all(|p| *p > 0.99));
    assert!(before.counters.reads < without.counters.reads / 4);
    // Behind everything: like a white background.
    let behind = with(1000, 255);
    let mut white = spec.clone();
    white.look.background = 1.0;
    let expected = draw(&white, &volume);
    assert!(psnr_db(&behind.picture, &expected.picture) > 60.0);
    // In the middle: the volume cut there, before white.
    let middle = with(64, 255);
    let cut: Vec<u16> = volume
        .words
        .iter()
        .enumerate()
        .map(|(i, w)| if i / 128 % 128 < 64 { *w } else { 0 })
        .collect();
    let front = VolumeStore {
        words: cut,
        ..volume.clone()
    };
    let expected = draw(&white, &front);
    // The sample before the cut interpolates towards what was cut away: its gradient differs.
    assert!(psnr_db(&middle.picture, &expected.picture) > 25.0);
    // A clear one changes nothing.
    assert!(with(64, 0).picture == without.picture);
}

/// A plane of the Spec is the fragment that it makes in every pixel; a mesh that lies in it too.
#[test]
fn surfaces_of_the_spec_are_their_fragments() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.look.phong = [1.0, 0.0, 0.0];
    let frame = Frame::new(&spec, &volume).unwrap();
    let fragment = Fragment {
        plane: 50,
        opacity: 128,
        intensity: [204; 3],
    };
    let pixels = frame.setup.pixel_count();
    let by_hand = frame.with_fragments(vec![Some(fragment); pixels]).unwrap();
    let expected = run(&by_hand, &mut NoObserver, &no_progress).unwrap();
    spec.polygons = Polygons {
        shape: Shape::Plane {
            point: [0.0, 50.0, 0.0],
            normal: [0.0, -2.0, 0.0],
        },
        opacity: 0.5,
        color: [0.8; 3],
    };
    let plane = alone(&spec, &volume);
    assert_eq!(
        (&plane.picture, plane.counters),
        (&expected.picture, expected.counters)
    );

    // Two triangles in the millimetres of the volume.
    let corner = |x: f64, z: f64| {
        let world = volume
            .voxel_from_world
            .inverse()
            .transform_point3(glam::DVec3::new(x, 50.0, z));
        world.as_vec3().to_array()
    };
    let corners = vec![
        corner(-9.0, -9.0),
        corner(400.0, -9.0),
        corner(-9.0, 400.0),
        corner(140.0, 90.0),
    ];
    let mesh = Mesh::new(corners, vec![[0, 1, 2], [1, 2, 3]], None).unwrap();
    spec.polygons.shape = Shape::File {
        path: "plane.stl".to_owned(),
    };
    let subject = Subject {
        mesh: Some(mesh),
        ..Subject::of(&volume)
    };
    let mesh = drawn(&spec, &subject).unwrap();
    assert_eq!(mesh.picture, expected.picture);
    refused(
        &spec,
        &Subject::of(&volume),
        &["polygons.shape.file.path is plane.stl"],
    );
    spec.merge.boards = 2;
    refused(&spec, &subject, &["polygons.shape", "merge.boards to 1"]);
    spec.merge.boards = 1;
    spec.polygons.shape = Shape::Sphere {
        centre: [0.0; 3],
        radius: -1.0,
    };
    refused(
        &spec,
        &subject,
        &["polygons.shape.sphere.radius is -1", "above 0"],
    );
}

/// A ball in the picture, drawn in slabs as well as in one piece; outside the rays the host shows it.
#[test]
fn a_ball_is_seen_whole() {
    let volume = volume_of([64; 3], vec![0; 64 * 64 * 64]);
    let mut spec = Spec::default();
    spec.look.phong = [1.0, 0.0, 0.0];
    spec.view.projection = Projection::Perspective { angle_deg: 60.0 };
    spec.view.rotate_z_deg = 30.0;
    spec.polygons.shape = Shape::Sphere {
        centre: [31.5; 3],
        radius: 37.0,
    };
    let share = |run: &Run| {
        assert!(run.picture.iter().all(|p| *p == 0.0 || *p > 0.99));
        run.picture.iter().sum::<f32>() / run.picture.len() as f32
    };
    let one = share(&alone(&spec, &volume));
    spec.view.slabs = 3;
    let three = share(&alone(&spec, &volume));
    assert!(
        one > 0.3 && (three / one - 1.0).abs() < 0.03,
        "{one} {three}"
    );
}

#[test]
fn bent_rays_see_what_lies_beside_them() {
    let volume = small_jaw();
    let mut spec = jaw_spec();
    spec.optimisation.leaping = Leaping::Off;
    let frame = Frame::new(&spec, &volume).unwrap();
    let pixels = frame.setup.pixel_count();
    let bent = |right: i16| {
        let deformation = Deformation::Table {
            planes: 1,
            offsets: vec![[right, 0]; pixels],
        };
        run(
            &frame.clone().with_deformation(deformation).unwrap(),
            &mut NoObserver,
            &no_progress,
        )
        .unwrap()
    };
    let straight = draw(&spec, &volume);
    assert!(bent(0).picture == straight.picture);
    // Two voxels to the right: the picture moves two pixels to the left.
    let moved = bent(512);
    for y in 0..64 {
        for x in 0..120 {
            assert_eq!(
                moved.picture[y * 128 + x],
                straight.picture[y * 128 + x + 2]
            );
        }
    }
    let message = Frame::new(&jaw_spec(), &volume)
        .unwrap()
        .with_deformation(Deformation::Table {
            planes: 1,
            offsets: vec![[0, 0]; pixels],
        })
        .unwrap_err()
        .to_string();
    assert!(message.contains("optimisation.leaping"), "{message}");
}

/// A bar along the view direction, up at the front: twisted by a quarter turn over its length it lies at the back. A lens
/// makes a ball larger by what it says.
#[test]
fn bends_of_the_spec_turn_and_enlarge() {
    let dims = [41, 41, 41];
    let bar = |x: usize, y: usize, z: usize| y == 40 && z == 20 && (20..35).contains(&x);
    let ball = |x: usize, y: usize, z: usize| {
        [x, y, z]
            .iter()
            .map(|c| c.abs_diff(20).pow(2))
            .sum::<usize>()
            < 64
    };
    let volume = |is_inside: &dyn Fn(usize, usize, usize) -> bool| {
        let voxels = (0..41usize.pow(3)).map(|i| {
            let inside = is_inside(i % 41, i / 41 % 41, i / 1681);
            if inside { 255 } else { 0 }
        });
        volume_of(dims, voxels.collect())
    };
    let mut spec = Spec::default();
    spec.look.opacity = vec![[0.0, 0.0], [255.0, 1.0]];
    spec.look.shading = strahl_sim::spec::Shading::Unlit;
    spec.look.gradient_weighting = false;
    spec.optimisation.leaping = Leaping::Off;
    let bars = volume(&bar);
    let straight = alone(&spec, &bars);
    // Rows of a picture go from the top: a quarter turn counter-clockwise of the samples turns the picture clockwise.
    spec.bend = Bend::Twist {
        deg_per_plane: 90.0 / 40.0,
    };
    let turned = alone(&spec, &bars);
    let at = |run: &Run, x: usize, z: usize| run.picture[(40 - z) * 41 + x];
    for i in 0..41 {
        for j in 0..41 {
            // Sample (u, v) of the back plane is taken at (−v, u).
            let expected = at(&straight, 40 - j, i);
            assert!((at(&turned, i, j) - expected).abs() < 0.02, "{i} {j}");
        }
    }
    assert_eq!(turned.counters.reads, straight.counters.reads);
    assert_eq!(
        turned.counters.host_bytes - straight.counters.host_bytes,
        // 36 tiles of 64 rays with 41 offsets of 4 bytes.
        36 * 64 * 41 * 4
    );

    let balls = volume(&ball);
    let area = |spec: &Spec| alone(spec, &balls).picture.iter().sum::<f32>();
    spec.bend = Bend::None;
    let before = area(&spec);
    spec.bend = Bend::Lens {
        strength: 0.5,
        radius: 400.0,
    };
    let factor = area(&spec) / before;
    assert!(
        (3.7..4.4).contains(&factor),
        "twice as wide and high: {factor}"
    );

    let subject = Subject::of(&balls);
    spec.bend = Bend::Twist {
        deg_per_plane: 91.0,
    };
    refused(
        &spec,
        &subject,
        &["bend.twist.deg_per_plane is 91", "-90 to 90"],
    );
    spec.bend = Bend::Lens {
        strength: 0.9,
        radius: 2000.0,
    };
    refused(&spec, &subject, &["bend.lens.radius is 2000", "127"]);
    spec.bend = Bend::Twist { deg_per_plane: 1.0 };
    spec.optimisation.leaping = Leaping::Safe;
    refused(&spec, &subject, &["optimisation.leaping is safe", "off"]);
}
