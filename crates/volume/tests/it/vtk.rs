//! Images of VTK, legacy and XML, in every encoding.

use crate::{message, read};
use glam::{DAffine3, DMat3, DVec3};
use std::io::Write;
use strahl_volume::Samples;

const NUMBERS: [i16; 6] = [-3, 300, 0, 1, 2, 258];

fn big() -> Vec<u8> {
    NUMBERS.iter().flat_map(|n| n.to_be_bytes()).collect()
}

fn little() -> Vec<u8> {
    NUMBERS.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn place() -> DAffine3 {
    DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::new(-0.5, -2.0, 3.0)),
        DVec3::new(-10.0, 20.0, 30.0),
    )
}

fn legacy(coding: &str, rest: &str, data: &[u8]) -> Vec<u8> {
    let head = format!(
        "# vtk DataFile Version 3.0\nmade up\n{coding}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 1\nORIGIN 10 -20 30\nSPACING 0.5 2 3\n{rest}"
    );
    [head.as_bytes(), data].concat()
}

#[test]
fn structured_points_are_read_from_text_and_bytes() {
    let scalars = "POINT_DATA 6\nSCALARS density short 1\nLOOKUP_TABLE default\n";
    let field = "POINT_DATA 6\nFIELD FieldData 1\ndensity 1 6 short\n";
    let text = b"-3 300\n0 1 2 258\n";
    for file in [
        legacy("BINARY", scalars, &big()),
        legacy("BINARY", field, &big()),
        legacy(
            "BINARY",
            scalars,
            &[big(), b"\nMETADATA\n".to_vec()].concat(),
        ),
        legacy("ASCII", scalars, text),
        legacy("ASCII", "POINT_DATA 6\nSCALARS density short\n", text),
    ] {
        let loaded = read(&[("v.vtk", &file)]).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::I16(NUMBERS.to_vec()));
        assert_eq!(loaded.volume.grid().dims(), [2, 3, 1]);
        assert_eq!(loaded.volume.grid().world_from_voxel(), place());
    }
    // Cells lie between the points.
    let cells = "CELL_DATA 2\nSCALARS density short\nLOOKUP_TABLE default\n";
    let loaded = read(&[("v.vtk", &legacy("BINARY", cells, &big()[..4]))]).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [1, 2, 1]);
    let first = loaded.volume.grid().world_from_voxel().translation;
    assert_eq!(first, DVec3::new(-10.25, 19.0, 30.0));
}

#[test]
fn other_data_of_vtk_is_named() {
    for (file, part) in [
        (
            legacy("BINARY", "POINT_DATA 6\nSCALARS d short 3\n", &big()),
            "3 numbers per voxel",
        ),
        (
            legacy("BINARY", "POINT_DATA 6\nVECTORS d short\n", &big()),
            "3 numbers per voxel",
        ),
        (
            legacy("BINARY", "POINT_DATA 5\nSCALARS d short\n", &big()),
            "6, for",
        ),
        (
            legacy("BINARY", "POINT_DATA 6\nSCALARS d bit\n", &big()),
            "`bit`",
        ),
        (
            legacy("BINARY", "POINT_DATA 6\nSCALARS d double\n", &big()),
            "cut off",
        ),
        (legacy("HEX", "", &[]), "ASCII or BINARY"),
        (legacy("ASCII", "", &[]), "SCALARS is missing"),
        (
            b"# vtk DataFile Version 2.0\nx\nASCII\nDATASET POLYDATA\n".to_vec(),
            "POLYDATA",
        ),
    ] {
        let message = message(&[("v.vtk", &file)]);
        assert!(message.contains(part), "{part}: {message}");
    }
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for part in bytes.chunks(3) {
        let bits = part.iter().fold(0u32, |n, b| n << 8 | u32::from(*b)) << (8 * (3 - part.len()));
        for i in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * i) & 63) as usize] as char;
            text.push(if i <= part.len() { letter } else { '=' });
        }
    }
    text
}

fn zlib(data: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(data).unwrap();
    packer.finish().unwrap()
}

/// The header and data of an array: plain, or packed in two blocks of 8 and 4 bytes.
fn parts(data: &[u8], packed: bool, word: usize, is_big: bool) -> (Vec<u8>, Vec<u8>) {
    let number = |n: usize| match is_big {
        true => (n as u64).to_be_bytes()[8 - word..].to_vec(),
        false => (n as u64).to_le_bytes()[..word].to_vec(),
    };
    if !packed {
        return (number(data.len()), data.to_vec());
    }
    let blocks = [zlib(&data[..8]), zlib(&data[8..])];
    let header = [2, 8, data.len() - 8, blocks[0].len(), blocks[1].len()].map(number);
    (header.concat(), blocks.concat())
}

fn xml(attributes: &str, array: &str, inside: &str, appended: &[u8]) -> Vec<u8> {
    let head = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" {attributes}>\n\
         <ImageData WholeExtent=\"0 1 0 2 0 0\" Origin=\"10 -20 30\" Spacing=\"0.5 2 3\">\n\
         <Piece Extent=\"0 1 0 2 0 0\">\n<PointData Scalars=\"density\">\n\
         <DataArray type=\"Int16\" Name=\"density\" {array}>{inside}</DataArray>\n\
         </PointData>\n<CellData></CellData>\n</Piece>\n</ImageData>\n"
    );
    [head.as_bytes(), appended, b"\n</VTKFile>\n"].concat()
}

#[test]
fn every_encoding_of_xml_says_the_same() {
    let mut files = vec![xml("", "format=\"ascii\"", "\n -3 300 0\n1 2 258 ", b"")];
    for is_big in [false, true] {
        for word in [4, 8] {
            for packed in [false, true] {
                let data = if is_big { big() } else { little() };
                let (header, data) = parts(&data, packed, word, is_big);
                let attributes = format!(
                    "byte_order=\"{}\" header_type=\"{}\"{}",
                    if is_big { "BigEndian" } else { "LittleEndian" },
                    if word == 8 { "UInt64" } else { "UInt32" },
                    if packed {
                        " compressor=\"vtkZLibDataCompressor\""
                    } else {
                        ""
                    }
                );
                // VTK writes the header of packed data as a text of its own.
                let text = match packed {
                    true => base64(&header) + &base64(&data),
                    false => base64(&[header.clone(), data.clone()].concat()),
                };
                files.push(xml(
                    &attributes,
                    "format=\"binary\"",
                    &format!("\n {text}\n"),
                    b"",
                ));
                let offset = "format=\"appended\" offset=\"3\"";
                let raw = [
                    b"<AppendedData encoding=\"raw\">\n _xyz",
                    &header[..],
                    &data,
                    b"</AppendedData>",
                ];
                files.push(xml(&attributes, offset, "", &raw.concat()));
                let text = format!("<AppendedData encoding=\"base64\">_xyz{text}</AppendedData>");
                files.push(xml(&attributes, offset, "", text.as_bytes()));
            }
        }
    }
    for file in files {
        let loaded = read(&[("v.vti", &file)]).unwrap();
        let shown = String::from_utf8_lossy(&file);
        assert_eq!(
            *loaded.volume.samples(),
            Samples::I16(NUMBERS.to_vec()),
            "{shown}"
        );
        assert_eq!(loaded.volume.grid().dims(), [2, 3, 1]);
        assert_eq!(loaded.volume.grid().world_from_voxel(), place());
    }
}

#[test]
fn xml_places_images_by_extent_and_direction() {
    let file = xml("", "format=\"ascii\"", "1 2 3 4 5 6", b"");
    let text = String::from_utf8(file).unwrap();
    let moved = text
        .replace("0 1 0 2 0 0", "2 3 1 3 4 4")
        .replace("Spacing=", "Direction=\"0 -1 0 1 0 0 0 0 1\" Spacing=");
    let loaded = read(&[("v.vti", moved.as_bytes())]).unwrap();
    // LPS: x runs along y, y against x; the first point is 2, 1 and 4 steps away.
    let expected = DAffine3::from_cols(
        DVec3::new(0.0, -0.5, 0.0),
        DVec3::new(2.0, 0.0, 0.0),
        DVec3::new(0.0, 0.0, 3.0),
        DVec3::new(-10.0 + 2.0, 20.0 - 1.0, 30.0 + 12.0),
    );
    assert_eq!(loaded.volume.grid().world_from_voxel(), expected);
    for (from, to, part) in [
        ("type=\"ImageData\"", "type=\"PolyData\"", "PolyData"),
        ("1 2 3 4 5 6", "1 2 3", "cut off"),
        ("1 2 3 4 5 6", "1 2 3 4 5 70000", "70000"),
        ("WholeExtent=\"0 1", "WholeExtent=\"1 0", "Extent is"),
        (
            "Name=\"density\"",
            "NumberOfComponents=\"3\"",
            "3 numbers per voxel",
        ),
        (
            "format=\"ascii\"",
            "format=\"appended\"",
            "AppendedData is missing",
        ),
        ("<ImageData ", "<Image ", "ImageData is missing"),
    ] {
        let message = message(&[("v.vti", text.replace(from, to).as_bytes())]);
        assert!(message.contains(part), "{part}: {message}");
    }
}
