//! Labels that are put together from several files: masks, and tables of names.

use strahl_volume::read::{MemoryFiles, ReadOptions, read_file, read_folder};
use strahl_volume::{Label, Samples};

/// Four voxels in a row.
fn image(samples: &str) -> Vec<u8> {
    let header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 1 1\nspace: RAS\n\
        space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n";
    format!("{header}\n{samples}").into()
}

fn files(files: &[(&str, &[u8])]) -> MemoryFiles {
    let file = |&(name, bytes): &(&str, &[u8])| (name.to_owned(), bytes.to_vec());
    files.iter().map(file).collect()
}

fn as_labels() -> ReadOptions {
    ReadOptions {
        as_labels: true,
        ..ReadOptions::default()
    }
}

#[test]
fn masks_in_a_folder_are_labels_in_the_order_of_their_names() {
    let (spleen, liver, heart) = (image("0 1 1 0"), image("0 0 255 255"), image("0 0 0 0"));
    let packed = crate::gzip(&spleen);
    let folder = files(&[
        ("spleen.nrrd.gz", &packed),
        ("liver.nrrd", &liver),
        ("heart.v2.nrrd", &heart),
        ("statistics.json", b"{}"),
    ]);
    let loaded = read_folder("organs", &folder, &ReadOptions::default()).unwrap();
    // The third voxel is in two masks.
    assert_eq!(*loaded.volume.samples(), Samples::U8(vec![0, 3, 3, 2]));
    let names = ["heart.v2", "liver", "spleen"];
    let labels: Vec<Label> = (1..)
        .zip(names)
        .map(|(id, name)| Label::new(id, name))
        .collect();
    assert_eq!(loaded.labels, Some(labels));
    let metadata = loaded.volume.metadata();
    assert_eq!(metadata.format, "3 masks (NRRD)");
    assert_eq!(metadata.name, "organs");
    let overlap = "1 voxels are in several masks; the last mask in alphabetical order is kept";
    let notes: Vec<&str> = loaded.notes.iter().map(String::as_str).collect();
    assert!(notes.contains(&overlap), "{notes:?}");
    assert!(
        notes.contains(&"left out what is no mask: statistics.json"),
        "{notes:?}"
    );
}

#[test]
fn a_folder_of_other_volumes_is_no_segmentation() {
    let (mask, scan, nan) = (image("0 1 1 0"), image("0 1 2.5 0"), image("0 nan 1 0"));
    let larger = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n0 1";
    for (other, expected) in [
        (
            &scan[..],
            "organs: not a volume that can be read: there are 2 volume files: a.nrrd, b.nrrd; name the one to read (only the files of a DICOM series, of a sequence of pictures, and masks are read together; `objects` of a scene draw several volumes); b.nrrd is no mask: it has the values 1 and 2.5",
        ),
        (&nan, "b.nrrd is no mask: it has values that are no numbers"),
        (larger, "organs: the grid of b.nrrd is 2×1×1 voxels"),
    ] {
        let folder = files(&[("a.nrrd", &mask), ("b.nrrd", other)]);
        let message = read_folder("organs", &folder, &as_labels())
            .unwrap_err()
            .to_string();
        assert!(message.contains(expected), "{message}");
    }
    let cut_off = files(&[("a.nrrd", &mask), ("b.nrrd", &mask[..70])]);
    let message = read_folder("organs", &cut_off, &as_labels())
        .unwrap_err()
        .to_string();
    assert!(message.starts_with("b.nrrd: "), "{message}");
    let text = files(&[("a.txt", b"1 liver")]);
    let message = read_folder("organs", &text, &as_labels())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("1 file and no DICOM file or picture"),
        "{message}"
    );
}

#[test]
fn tables_beside_an_image_name_its_labels() {
    let plain = image("0 1 2 0");
    let named: Vec<u8> = String::from_utf8(plain.clone())
        .unwrap()
        .replace(
            "ascii\n",
            "ascii\nSegment0_Name:=own\nSegment0_LabelValue:=1\n",
        )
        .into();
    let table = b"{ \"1\": \"liver\" }";
    let data_set = b"{ \"labels\": { \"background\": 0, \"spleen\": 1 } }";
    let read = |image: &[u8], name: &str, beside: &[(&str, &[u8])], options: &ReadOptions| {
        let folder = files(&[&[(name, image)], beside].concat());
        let loaded = read_file(name, &folder, options).unwrap();
        let names = loaded.labels.map(|labels| {
            let last = labels.into_iter().next_back();
            last.map_or("".into(), |label| label.name)
        });
        (names, loaded.notes.last().cloned().unwrap_or_default())
    };
    let of = |name: &str| (Some(name.to_owned()), String::new());
    let with = |name: &str, table: &str| {
        let note = format!("names and colors of labels are those of {table}");
        (Some(name.to_owned()), note)
    };
    let (image, beside) = (&plain[..], &[("a.json", &table[..])][..]);
    // Only labels have names.
    assert_eq!(
        read(image, "a.nrrd", beside, &ReadOptions::default()).0,
        None
    );
    assert_eq!(
        read(image, "a.nrrd", beside, &as_labels()),
        with("liver", "a.json")
    );
    assert_eq!(
        read(image, "b.nrrd", beside, &as_labels()).0,
        Some("".into())
    );
    // A table of its own goes before the names in a file, that of a data set does not.
    let usual = &ReadOptions::default();
    assert_eq!(read(&named, "a.nrrd", &[], usual), of("own"));
    assert_eq!(
        read(&named, "a.nrrd", beside, usual),
        with("liver", "a.json")
    );
    assert_eq!(
        read(&named, "a.seg.nrrd", beside, usual),
        with("liver", "a.json")
    );
    let of_set: &[(&str, &[u8])] = &[("dataset.json", data_set)];
    assert_eq!(read(&named, "a.nrrd", of_set, usual), of("own"));
    assert_eq!(
        read(image, "a.nrrd", of_set, &as_labels()),
        with("spleen", "dataset.json")
    );
    // What is no table is not mentioned; a broken one is.
    let other: &[(&str, &[u8])] = &[("a.json", b"{ \"EchoTime\": 3.5 }"), ("a.txt", b"2 heart")];
    assert_eq!(
        read(image, "a.nrrd", other, &as_labels()),
        with("heart", "a.txt")
    );
    let broken: &[(&str, &[u8])] = &[("a.csv", b"id,name\n1,a\n1,b")];
    let (names, note) = read(&named, "a.nrrd", broken, usual);
    assert_eq!(names.as_deref(), Some("own"));
    let expected =
        "names and colors of labels in a.csv are not used: line 3: the id is 1, as in line 2";
    assert!(note.starts_with(expected), "{note}");
    // What the caller says goes before everything.
    let said = ReadOptions {
        label_table: Some(vec![Label::new(1, "said")]),
        ..ReadOptions::default()
    };
    assert_eq!(read(&named, "a.nrrd", beside, &said), of("said"));
}
