//! STL (stereolithography), binary and text.
//!
//! | offset | bytes | what                                                             |
//! |--------|-------|------------------------------------------------------------------|
//! | 0      | 80    | text without meaning; 3D Slicer puts `SPACE=LPS` there           |
//! | 80     | 4     | number n of triangles, u32 little endian                         |
//! | 84     | 50 n  | normal and three corners, 12 f32 little endian; two bytes unused |
//!
//! Corners of the same position become one vertex, so that a surface has smooth normals. The normals
//! of the file are left alone: they repeat what the order of the corners says, or are 0.

use super::surface::{Surface, too_many_vertices};
use crate::error::{Error, ErrorKind};
use crate::mesh::Mesh;
use std::collections::HashMap;

const HEADER: usize = 84;
const FACET: usize = 50;

/// Whether a file has exactly the length that its count of triangles asks for. Many programs begin
/// the header of a binary file with `solid`, so this goes before [`is_text`].
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    claimed_length(bytes) == Some(bytes.len() as u64)
}

fn claimed_length(bytes: &[u8]) -> Option<u64> {
    let count = u32::from_le_bytes(*bytes.get(80..)?.first_chunk()?);
    Some(HEADER as u64 + FACET as u64 * u64::from(count))
}

/// Whether a file begins as the text form does, and not like a binary one with such a header.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let begins = start
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && start.get(5).is_none_or(u8::is_ascii_whitespace);
    begins && !start[..start.len().min(512)].contains(&0)
}

pub(super) fn read(bytes: &[u8]) -> Result<Surface, Error> {
    if !is_binary(bytes) && is_text(bytes) {
        return read_text(bytes);
    }
    let claimed = claimed_length(bytes).unwrap_or(HEADER as u64);
    let found = bytes.len() as u64;
    if found < claimed {
        return Err(ErrorKind::Truncated {
            what: "the STL file".into(),
            expected: claimed,
            found,
        }
        .into());
    }
    let mut notes = Vec::new();
    if found > claimed {
        notes.push(format!(
            "{} bytes behind the last triangle were left out",
            found - claimed
        ));
    }
    let mut corners = Corners::default();
    for facet in bytes[HEADER..claimed as usize].chunks_exact(FACET) {
        for corner in facet[12..48].chunks_exact(12) {
            let number = |c: usize| {
                f32::from_le_bytes([corner[c], corner[c + 1], corner[c + 2], corner[c + 3]])
            };
            corners.add([number(0), number(4), number(8)])?;
        }
    }
    Ok(Surface {
        mesh: corners.mesh()?,
        format: "STL",
        remarks: vec![String::from_utf8_lossy(&bytes[..80]).into_owned()],
        notes,
    })
}

/// Lines of words in any case. Several solids in one file are one mesh.
fn read_text(bytes: &[u8]) -> Result<Surface, Error> {
    let mut corners = Corners::default();
    let (mut remarks, mut notes) = (Vec::new(), Vec::new());
    // What must come next: nothing yet, in a solid, in a facet, in its loop with so many corners, behind it.
    #[derive(Clone, Copy, PartialEq)]
    enum At {
        Outside,
        Solid,
        Facet,
        Loop(u32),
        LoopEnd,
    }
    let mut at = At::Outside;
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let mut words = line.split_whitespace();
        let Some(first) = words.next() else {
            continue;
        };
        at = match (at, first.to_ascii_lowercase().as_str()) {
            (At::Outside, "solid") => {
                remarks.push(line.trim().to_owned());
                At::Solid
            }
            (At::Solid, "facet") => At::Facet,
            (At::Solid, "endsolid") => At::Outside,
            (At::Facet, "outer") => At::Loop(0),
            (At::Loop(n), "vertex") if n < 3 => {
                let numbers: Option<Vec<f32>> = words.map(|word| word.parse().ok()).collect();
                let position = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
                corners.add(position.ok_or_else(|| {
                    Error::field(
                        format!("line {}", index + 1),
                        line.trim(),
                        "`vertex` and three numbers",
                    )
                })?)?;
                At::Loop(n + 1)
            }
            (At::Loop(3), "endloop") => At::LoopEnd,
            (At::LoopEnd, "endfacet") => At::Solid,
            (at, _) => {
                return Err(Error::field(
                    format!("line {}", index + 1),
                    line.trim(),
                    match at {
                        At::Outside => "`solid`",
                        At::Solid => "`facet normal` or `endsolid`",
                        At::Facet => "`outer loop`",
                        At::Loop(3) => "`endloop`: STL has triangles only",
                        At::Loop(_) => "`vertex` and three numbers",
                        At::LoopEnd => "`endfacet`",
                    },
                ));
            }
        };
    }
    match at {
        At::Outside => {}
        At::Solid => notes.push("the file ends without `endsolid`; it may be cut off".into()),
        _ => {
            return Err(Error::field(
                "last line",
                "inside a facet",
                "`endsolid`; the file is cut off",
            ));
        }
    }
    Ok(Surface {
        mesh: corners.mesh()?,
        format: "STL",
        remarks,
        notes,
    })
}

/// Corners in the order of the file, and the vertices that they are.
#[derive(Default)]
struct Corners {
    positions: Vec<[f32; 3]>,
    vertex_at: HashMap<[u32; 3], u32>,
    indices: Vec<u32>,
}

impl Corners {
    fn add(&mut self, position: [f32; 3]) -> Result<(), Error> {
        // −0 is where 0 is.
        let position = position.map(|c| c + 0.0);
        let next = u32::try_from(self.positions.len()).map_err(|_| too_many_vertices())?;
        let vertex = *self
            .vertex_at
            .entry(position.map(f32::to_bits))
            .or_insert(next);
        if vertex == next {
            self.positions.push(position);
        }
        self.indices.push(vertex);
        Ok(())
    }

    fn mesh(self) -> Result<Mesh, Error> {
        let triangles = self.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
        Mesh::new(self.positions, triangles.collect(), None)
    }
}
