//! Meshes: one tetrahedron in every form of the three formats, and every way in which a file can lie.

use glam::{DVec3, Vec3};
use strahl_volume::read::MemoryFiles;
use strahl_volume::read::mesh::{LoadedMesh, MeshSpace, read_mesh};
use strahl_volume::{Error, ErrorKind};

fn read_as(name: &str, bytes: &[u8], space: Option<MeshSpace>) -> Result<LoadedMesh, Error> {
    let files = MemoryFiles::from([(name.to_owned(), bytes.to_vec())]);
    read_mesh(name, &files, space)
}

fn read(name: &str, bytes: impl AsRef<[u8]>) -> LoadedMesh {
    read_as(name, bytes.as_ref(), None).unwrap_or_else(|error| panic!("{error}"))
}

fn message(name: &str, bytes: impl AsRef<[u8]>) -> String {
    match read_as(name, bytes.as_ref(), None) {
        Ok(loaded) => panic!("{name} was read: {:?}", loaded.mesh),
        Err(error) => error.to_string(),
    }
}

fn seed(path: &str) -> Vec<u8> {
    let seeds = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/");
    std::fs::read(format!("{seeds}{path}")).unwrap()
}

/// Six times the volume inside, by the divergence theorem; above 0 if fronts are outside.
fn six_volumes(loaded: &LoadedMesh) -> f32 {
    let corner = |c: u32| Vec3::from_array(loaded.mesh.positions()[c as usize]);
    let triangles = loaded.mesh.triangles().iter();
    triangles
        .map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))))
        .sum()
}

/// The same tetrahedron of 10 mm; where the file says LPS, it lies to the right and back.
#[test]
fn every_form_gives_the_same_tetrahedron() {
    for (path, format, is_lps) in [
        ("stl/binary", "STL", true),
        ("stl/binary-solid", "STL", false),
        ("stl/text", "STL", false),
        ("obj/plain", "OBJ", true),
        ("ply/text", "PLY", true),
        ("ply/little", "PLY", true),
        ("ply/big-normals", "PLY", false),
    ] {
        // Without an ending: the bytes say what it is.
        let loaded = read("mesh", seed(path));
        assert_eq!(loaded.format, format, "{path}");
        assert_eq!(loaded.mesh.positions().len(), 4, "{path}");
        assert_eq!(loaded.mesh.triangles().len(), 4, "{path}");
        assert_eq!(six_volumes(&loaded), 1000.0, "{path}");
        let (lo, hi) = loaded.mesh.bounds_mm();
        if is_lps {
            assert_eq!((lo.x, hi.y, hi.z), (-10.0, 0.0, 10.0), "{path}");
            assert_eq!(loaded.notes, [""; 0], "{path}");
        } else {
            assert_eq!((lo, hi), (DVec3::ZERO, DVec3::splat(10.0)), "{path}");
            assert!(
                loaded.notes[0].contains("read as RAS mm"),
                "{:?}",
                loaded.notes
            );
        }
    }
}

#[test]
fn what_is_said_goes_before_what_the_file_says() {
    for path in ["stl/binary", "obj/plain", "ply/text"] {
        let ras = read_as("mesh", &seed(path), Some(MeshSpace::Ras)).unwrap();
        assert_eq!(ras.mesh.bounds_mm().1, DVec3::splat(10.0), "{path}");
    }
    let lps = read_as("mesh", &seed("stl/text"), Some(MeshSpace::Lps)).unwrap();
    assert_eq!(lps.mesh.bounds_mm().0, DVec3::new(-10.0, -10.0, 0.0));
    assert!(lps.notes.is_empty());
    let other = String::from_utf8(seed("obj/plain")).unwrap();
    let other = read("mesh", other.replace("LPS", "LAS"));
    assert!(other.notes[0].contains("SPACE=LAS"), "{:?}", other.notes);
}

/// The normal of a face in LPS turns with it.
#[test]
fn stated_normals_come_along() {
    let loaded = read("mesh", seed("ply/big-normals"));
    assert_eq!(loaded.mesh.normals().unwrap(), [[0.0, 0.0, 1.0]; 4]);
    let text = "# SPACE=LPS\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 3 4 0\nf 1//1 2//1 3//1\n";
    let loaded = read("mesh", text);
    let normal = Vec3::from_array(loaded.mesh.normals().unwrap()[2]);
    assert!(
        normal.distance(Vec3::new(-0.6, -0.8, 0.0)) < 1e-6,
        "{normal}"
    );
}

#[test]
fn several_solids_are_one_mesh() {
    let loaded = read("mesh", seed("stl/two-solids"));
    assert_eq!(loaded.mesh.triangles().len(), 8);
    assert_eq!(loaded.mesh.positions().len(), 4);
    let upper = String::from_utf8(seed("stl/text")).unwrap().to_uppercase();
    assert_eq!(
        read("mesh", upper.replace('\n', "\r\n"))
            .mesh
            .triangles()
            .len(),
        4
    );
    let whole = String::from_utf8(seed("stl/text")).unwrap();
    let cut = read("mesh", whole.replace("endsolid tetrahedron\n", ""));
    assert!(cut.notes[0].contains("cut off"), "{:?}", cut.notes);
}

/// Positions with two normals become two vertices; corners count from both ends; lines go on.
#[test]
fn corners_of_obj_are_what_they_say() {
    let loaded = read("mesh", seed("obj/normals"));
    assert_eq!(loaded.mesh.triangles(), [[0, 1, 2], [3, 4, 5], [3, 5, 6]],);
    let positions = loaded.mesh.positions();
    assert_eq!(positions[0], positions[3]);
    assert_eq!(positions[6], [0.0, 0.0, 10.0]);
    assert_eq!(loaded.mesh.normals().unwrap()[3], [1.0, 0.0, 0.0]);
    let pentagon = read("mesh", seed("obj/pentagon"));
    assert_eq!(pentagon.mesh.triangles(), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    assert!(
        pentagon.notes[0].contains("1 polygons"),
        "{:?}",
        pentagon.notes
    );
    assert!(
        pentagon.notes[1].contains("left out"),
        "{:?}",
        pentagon.notes
    );
    let mixed = read("mesh", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2 3\n");
    assert!(mixed.mesh.normals().is_none());
    assert!(
        mixed.notes[0].contains("2 corners have no normal"),
        "{:?}",
        mixed.notes
    );
}

#[test]
fn other_elements_of_ply_are_left_out_with_a_note() {
    let loaded = read("mesh", seed("ply/other-element"));
    assert_eq!(loaded.mesh.triangles().len(), 2 + 1 + 1 + 3);
    assert!(
        loaded.notes.iter().any(|note| note.contains("`edge`")),
        "{:?}",
        loaded.notes
    );
}

/// A header's claim must not be believed: each of these would take gigabytes.
#[test]
fn claims_beyond_the_file_are_refused() {
    let mut stl = seed("stl/binary");
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = read_as("mesh.stl", &stl, None).unwrap_err();
    let ErrorKind::Truncated {
        expected, found, ..
    } = error.kind()
    else {
        panic!("{error}");
    };
    assert_eq!((*expected, *found), (84 + 50 * u64::from(u32::MAX), 284));
    let text = String::from_utf8(seed("ply/text")).unwrap();
    for count in ["400000000", "18446744073709551615"] {
        for element in ["vertex", "face"] {
            let lie = text.replace(
                &format!("element {element} 4"),
                &format!("element {element} {count}"),
            );
            assert_ne!(lie, text);
            let found = message("mesh", lie);
            assert!(found.contains("cut off"), "{found}");
        }
    }
    let empty = text.replace("element face", "element nothing 4000000000\nelement face");
    let found = message("mesh", empty);
    assert!(
        found.contains("number of properties of PLY element `nothing` is 0"),
        "{found}"
    );
    let mut list = seed("ply/little");
    let at = list.len() - 13;
    list[at] = 255;
    let found = message("mesh", list);
    assert!(found.contains("PLY file is not readable"), "{found}");
}

#[test]
fn damage_is_named() {
    let cut = &seed("stl/binary")[..200];
    assert!(message("mesh.stl", cut).starts_with("mesh.stl: the STL file is cut off"));
    let found = message("mesh.stl", b"solid");
    assert!(found.contains("number of triangles is 0"), "{found}");
    let text = String::from_utf8(seed("stl/text")).unwrap();
    let found = message("mesh", text.replacen("vertex 0 10 0", "vertex 0 10", 1));
    assert_eq!(
        found,
        "mesh: line 5 is vertex 0 10; allowed: `vertex` and three numbers"
    );
    let found = message(
        "mesh",
        text.replacen("  endloop\n", "   vertex 1 1 1\n  endloop\n", 1),
    );
    assert!(found.contains("triangles only"), "{found}");
    let found = message("mesh", text.replacen("vertex 0 0 0", "vertex nan 0 0", 1));
    assert!(found.contains("position 0 is [NaN"), "{found}");

    let obj = |faces: &str| message("mesh", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}"));
    assert_eq!(
        obj("f 1 2 4"),
        "mesh: position of a corner in line 4 is 4; allowed: 1 to 3, or -1 to -3: what stands above it in the file"
    );
    for wrong in [
        "f 0 1 2",
        "f -4 1 2",
        "f 1 2 x",
        "f 1/1/1 2 3",
        "f 9223372036854775808 1 2",
        "f -9223372036854775808 1 2",
        "f 1 2",
        "f 1/1/1/1 2 3",
        "v 1 2",
        "hello",
    ] {
        let found = obj(wrong);
        assert!(found.contains("line 4"), "{found}");
    }

    let ply = String::from_utf8(seed("ply/text")).unwrap();
    let swap = |from: &str, to: &str| {
        let changed = ply.replacen(from, to, 1);
        assert_ne!(changed, ply);
        message("mesh", changed)
    };
    assert!(swap("3 0 2 1", "3 0 2 -1").contains("corner of a PLY face is -1"));
    assert!(swap("3 0 2 1", "3 0 2 4").contains("corner of triangle 0 is 4"));
    assert!(swap("property float x", "property float w").contains("property `x`"));
    assert!(swap("property float y", "property float x").contains("each name once"));
    assert!(swap("element face", "element vertex").contains("each name once"));
    assert!(swap("element vertex", "element point").contains("PLY element `vertex` is missing"));
    assert!(swap("end_header", "end").contains("PLY file is not readable"));
    assert!(swap("list uchar int", "list uchar float").contains("PLY file is not readable"));
}

#[test]
fn what_is_no_mesh_is_refused() {
    let found = message("mesh.glb", b"glTF\x02\0\0\0");
    assert!(found.contains("STL, OBJ and PLY"), "{found}");
    assert!(message("mesh", b"").contains("STL, OBJ and PLY"));
    assert!(message("empty.stl", b"").contains("cut off"));
    assert!(message("empty.obj", b"").contains("number of triangles is 0"));
    assert!(message("empty.ply", b"").contains("PLY file"));
}
