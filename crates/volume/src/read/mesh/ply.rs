//! PLY (polygon file format of Stanford), text and binary, through the crate `ply-rs-bw`.
//!
//! Of element `vertex` the properties x, y, z and nx, ny, nz are taken, of element `face` the list
//! `vertex_indices` or `vertex_index`. The crate takes a header at its word; so the least number of
//! bytes that the elements can take is compared with the file first, and faces come in portions.

use super::surface::{Surface, fan, note_of_polygons};
use crate::error::{Error, ErrorKind};
use crate::mesh::Mesh;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};
use std::io::Cursor;

/// How many elements are taken from the crate at once: it makes a vector for every face.
const PORTION: usize = 4096;

pub(super) fn read(bytes: &[u8]) -> Result<Surface, Error> {
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Unused>::new()
        .read_header(&mut reader)
        .map_err(not_ply)?;
    let data_offset = reader.get_ref().position() as usize;
    check_names(&header, &bytes[..data_offset])?;
    check_length(&header, bytes.len() - data_offset)?;
    let mut notes = Vec::new();
    let (mut vertices, mut triangles) = (Vec::<Vertex>::new(), Vec::new());
    let (mut has_vertices, mut polygons, mut without_area) = (false, 0, 0);
    for element in header.elements.values() {
        let mut left = element.count;
        if element.name == "vertex" {
            properties(element, ["x", "y", "z"])?;
            has_vertices = true;
        }
        while left > 0 {
            let portion = ElementDef {
                count: left.min(PORTION),
                ..element.clone()
            };
            left -= portion.count;
            match element.name.as_str() {
                "vertex" => vertices.extend(portion_of(&mut reader, &portion, &header)?),
                "face" => {
                    for face in portion_of::<Face>(&mut reader, &portion, &header)? {
                        polygons += usize::from(face.corners.len() > 4);
                        without_area += usize::from(face.corners.len() < 3);
                        triangles.extend(fan(&face.corners));
                        if let Some(wrong) = face.wrong {
                            return Err(Error::field("corner of a PLY face", wrong, CORNER));
                        }
                    }
                }
                _ => drop(portion_of::<Unused>(&mut reader, &portion, &header)?),
            }
        }
    }
    if !has_vertices {
        return Err(ErrorKind::Missing {
            field: "PLY element `vertex`".into(),
            allowed: "a mesh has vertices with the properties x, y and z".into(),
        }
        .into());
    }
    note_of_polygons(polygons, &mut notes);
    if without_area > 0 {
        notes.push(format!(
            "{without_area} faces of fewer than three corners were left out"
        ));
    }
    let others = |name: &&String| !["vertex", "face"].contains(&name.as_str());
    for other in header.elements.keys().filter(others) {
        notes.push(format!("PLY element `{other}` was left out"));
    }
    let with_normals = header
        .elements
        .get("vertex")
        .is_some_and(|vertex| properties(vertex, ["nx", "ny", "nz"]).is_ok());
    let normals = with_normals.then(|| vertices.iter().map(|v| v.normal).collect());
    let remarks = header.comments.iter().chain(&header.obj_infos);
    Ok(Surface {
        mesh: Mesh::new(
            vertices.into_iter().map(|v| v.position).collect(),
            triangles,
            normals,
        )?,
        format: "PLY",
        remarks: remarks.cloned().collect(),
        notes,
    })
}

const CORNER: &str = "whole numbers from 0";

fn portion_of<E: PropertyAccess>(
    reader: &mut Reader<Cursor<&[u8]>>,
    portion: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, Error> {
    let parser = Parser::<E>::new();
    parser
        .read_payload_for_element(reader, portion, header)
        .map_err(not_ply)
}

/// The crate keeps the last of two things with one name, and would read the others as if they were
/// not there.
fn check_names(header: &Header, text: &[u8]) -> Result<(), Error> {
    let lines = |word: &[u8]| {
        let lines = text.split(|&byte| byte == b'\n' || byte == b'\r');
        lines.filter(|line| line.starts_with(word)).count()
    };
    let elements = header.elements.len();
    let properties: usize = header.elements.values().map(|e| e.properties.len()).sum();
    if lines(b"element") != elements || lines(b"property") != properties {
        return Err(Error::field(
            "PLY header",
            "with two elements, or two properties of one element, of the same name",
            "each name once",
        ));
    }
    Ok(())
}

/// Compares the least number of bytes that the elements can take with those that are there.
fn check_length(header: &Header, found: usize) -> Result<(), Error> {
    let is_text = header.encoding == Encoding::Ascii;
    let mut expected = 0u64;
    for element in header.elements.values() {
        let properties = element.properties.values();
        let least: u64 = properties
            .map(|property| match &property.data_type {
                // A digit, and a space or the end of the line.
                _ if is_text => 2,
                PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size(scalar),
            })
            .sum();
        if least == 0 && element.count > 0 {
            return Err(Error::field(
                format!(
                    "number of properties of PLY element `{}`",
                    element.name.escape_debug()
                ),
                0,
                "at least 1",
            ));
        }
        expected = least
            .checked_mul(element.count as u64)
            .and_then(|bytes| expected.checked_add(bytes))
            .unwrap_or(u64::MAX);
    }
    // The last line of a text may have no end.
    let found = found as u64 + u64::from(is_text);
    if found < expected {
        return Err(ErrorKind::Truncated {
            what: "the PLY data".into(),
            expected,
            found,
        }
        .into());
    }
    Ok(())
}

fn size(scalar: &ScalarType) -> u64 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Whether an element has all three properties as numbers.
fn properties(element: &ElementDef, names: [&str; 3]) -> Result<(), Error> {
    let is_number = |name: &str| {
        let property = element.properties.get(name);
        property.is_some_and(|p| matches!(p.data_type, PropertyType::Scalar(_)))
    };
    match names.into_iter().find(|name| !is_number(name)) {
        None => Ok(()),
        Some(name) => Err(ErrorKind::Missing {
            field: format!("property `{name}` of PLY element `vertex`"),
            allowed: "a vertex has the properties x, y and z, numbers each".into(),
        }
        .into()),
    }
}

fn not_ply(error: ParseError) -> Error {
    let words = error.to_string();
    let words: Vec<&str> = words.split_whitespace().take(40).collect();
    let words: String = words.join(" ").chars().take(300).collect();
    Error::field(
        "PLY file",
        format!("not readable ({words})"),
        "what its header declares",
    )
}

#[derive(Default)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Vertex {
        Vertex::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" => &mut self.normal[0],
            "ny" => &mut self.normal[1],
            "nz" => &mut self.normal[2],
            _ => return PropertyAccessResult::Ignored,
        };
        match value.to_f32_lossy() {
            Some(number) => *place = number,
            None => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

#[derive(Default)]
struct Face {
    corners: Vec<u32>,
    /// A corner that is no index.
    wrong: Option<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Face {
        Face::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        match value {
            Property::ListChar(list) => self.take(list),
            Property::ListUChar(list) => self.take(list),
            Property::ListShort(list) => self.take(list),
            Property::ListUShort(list) => self.take(list),
            Property::ListInt(list) => self.take(list),
            Property::ListUInt(list) => self.corners = list,
            _ => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

impl Face {
    fn take<T: Into<i64>>(&mut self, list: Vec<T>) {
        for corner in list {
            let corner = corner.into();
            match u32::try_from(corner) {
                Ok(corner) => self.corners.push(corner),
                Err(_) => self.wrong = Some(corner),
            }
        }
    }
}

/// What is read over.
struct Unused;

impl PropertyAccess for Unused {
    fn new() -> Unused {
        Unused
    }

    fn set_property(&mut self, _: &str, _: Property) -> PropertyAccessResult {
        PropertyAccessResult::Ignored
    }
}
