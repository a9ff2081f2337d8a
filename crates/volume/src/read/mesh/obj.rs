//! Wavefront OBJ: the polygons of a scene; groups, materials and texture coordinates are left aside.
//!
//! | line           | what                                                                       |
//! |----------------|----------------------------------------------------------------------------|
//! | `v x y z …`    | a position; a weight or a color behind it is left out                     |
//! | `vn x y z`     | a normal                                                                   |
//! | `f a b c …`    | a polygon; a corner is `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or backwards from −1 |
//! | `# …`          | a comment; 3D Slicer puts `SPACE=LPS` there                                |
//! | `…\`           | goes on in the next line                                                   |

use super::surface::{Surface, fan, note_of_polygons, too_many_vertices};
use crate::error::Error;
use crate::mesh::Mesh;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Words that a line may begin with and that change nothing in a surface of polygons.
const LEFT_ASIDE: [&str; 14] = [
    "vt", "vp", "g", "o", "s", "mg", "mtllib", "usemtl", "usemap", "maplib", "lod", "bevel",
    "c_interp", "d_interp",
];

/// Where `SPACE=` may stand: a comment among the first lines.
const REMARKS: usize = 32;

/// Whether the first line that says anything begins as those of an OBJ do.
pub(super) fn is_obj(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1 << 16)];
    for line in head.split(|&byte| byte == b'\n') {
        let Ok(line) = std::str::from_utf8(line) else {
            return false;
        };
        match line.split_whitespace().next() {
            None => {}
            Some(word) if word.starts_with('#') => {}
            Some(word) => return matches!(word, "v" | "vn" | "f") || LEFT_ASIDE.contains(&word),
        }
    }
    false
}

pub(super) fn read(bytes: &[u8]) -> Result<Surface, Error> {
    let mut reader = Reader::default();
    let mut lines = bytes.split(|&byte| byte == b'\n').enumerate();
    while let Some((index, line)) = lines.next() {
        let mut line = String::from_utf8_lossy(line);
        while let Some(shorter) = line.trim_end().strip_suffix('\\') {
            let Some((_, next)) = lines.next() else { break };
            // Appended, not copied: a file may consist of one such line.
            let length = shorter.len();
            let whole = line.to_mut();
            whole.truncate(length);
            whole.push(' ');
            whole.push_str(&String::from_utf8_lossy(next));
        }
        reader.line(index + 1, line.trim())?;
    }
    reader.surface()
}

#[derive(Default)]
struct Reader {
    file_positions: Vec<[f32; 3]>,
    file_normals: Vec<[f32; 3]>,
    /// The vertex of a position and normal of the file, each from 0.
    vertex_of: HashMap<(usize, Option<usize>), u32>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Corners of one polygon, kept for its memory.
    corners: Vec<u32>,
    corners_without_normal: usize,
    polygons: usize,
    not_surfaces: usize,
    remarks: Vec<String>,
}

impl Reader {
    fn line(&mut self, number: usize, line: &str) -> Result<(), Error> {
        if let Some(comment) = line.strip_prefix('#') {
            if self.remarks.len() < REMARKS {
                self.remarks.push(comment.chars().take(1024).collect());
            }
            return Ok(());
        }
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        let Some(key) = words.next() else {
            return Ok(());
        };
        match key {
            "v" => self.file_positions.push(three(number, line)?),
            "vn" => self.file_normals.push(three(number, line)?),
            "f" | "fo" => self.face(number, line)?,
            "p" | "l" | "curv" | "curv2" | "surf" => self.not_surfaces += 1,
            _ if LEFT_ASIDE.contains(&key) || is_free_form(key) => {}
            _ => {
                return Err(Error::field(
                    format!("line {number}"),
                    shortened(line),
                    "a line that begins with `v`, `vn`, `f` or another word of OBJ",
                ));
            }
        }
        Ok(())
    }

    fn face(&mut self, number: usize, line: &str) -> Result<(), Error> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for corner in line.split_whitespace().skip(1) {
            corners.push(self.vertex(number, corner)?);
        }
        if corners.len() < 3 {
            return Err(Error::field(
                format!("line {number}"),
                shortened(line),
                "a face of at least three corners",
            ));
        }
        self.polygons += usize::from(corners.len() > 4);
        self.triangles.extend(fan(&corners));
        self.corners = corners;
        Ok(())
    }

    fn vertex(&mut self, number: usize, corner: &str) -> Result<u32, Error> {
        let wrong = |what: &str, count: usize| {
            Error::field(
                format!("{what} of a corner in line {number}"),
                shortened(corner),
                format!("1 to {count}, or -1 to -{count}: what stands above it in the file"),
            )
        };
        let mut parts = corner.split('/');
        let (position, _texture, normal) = (parts.next(), parts.next(), parts.next());
        let positions = self.file_positions.len();
        let position = position
            .and_then(|text| index(text, positions))
            .ok_or_else(|| wrong("position", positions))?;
        let normals = self.file_normals.len();
        let normal = match normal.filter(|text| !text.is_empty()) {
            None => None,
            Some(text) => Some(index(text, normals).ok_or_else(|| wrong("normal", normals))?),
        };
        if parts.next().is_some() {
            return Err(Error::field(
                format!("corner in line {number}"),
                shortened(corner),
                "v, v/vt, v//vn or v/vt/vn",
            ));
        }
        self.corners_without_normal += usize::from(normal.is_none());
        let next = u32::try_from(self.positions.len()).map_err(|_| too_many_vertices())?;
        Ok(match self.vertex_of.entry((position, normal)) {
            Entry::Occupied(vertex) => *vertex.get(),
            Entry::Vacant(vertex) => {
                self.positions.push(self.file_positions[position]);
                let normal = normal.map(|normal| self.file_normals[normal]);
                self.normals.push(normal.unwrap_or_default());
                *vertex.insert(next)
            }
        })
    }

    fn surface(self) -> Result<Surface, Error> {
        let mut notes = Vec::new();
        note_of_polygons(self.polygons, &mut notes);
        if self.not_surfaces > 0 {
            notes.push(format!(
                "{} points, lines and free-form pieces were left out",
                self.not_surfaces
            ));
        }
        let all_have_normals = self.corners_without_normal == 0;
        if !all_have_normals && !self.file_normals.is_empty() {
            notes.push(format!(
                "{} corners have no normal; those of the file were left out",
                self.corners_without_normal
            ));
        }
        let normals = (all_have_normals && !self.triangles.is_empty()).then_some(self.normals);
        Ok(Surface {
            mesh: Mesh::new(self.positions, self.triangles, normals)?,
            format: "OBJ",
            remarks: self.remarks,
            notes,
        })
    }
}

/// From 1, or backwards from the last, to from 0.
fn index(text: &str, count: usize) -> Option<usize> {
    let number: i64 = text.parse().ok()?;
    let index = match number {
        1.. => usize::try_from(number - 1).ok()?,
        0 => return None,
        _ => count.checked_sub(usize::try_from(number.unsigned_abs()).ok()?)?,
    };
    (index < count).then_some(index)
}

fn three(number: usize, line: &str) -> Result<[f32; 3], Error> {
    let mut numbers = line
        .split_whitespace()
        .skip(1)
        .map(|word| word.parse().ok());
    let mut next = || numbers.next().flatten();
    match (next(), next(), next()) {
        (Some(x), Some(y), Some(z)) => Ok([x, y, z]),
        _ => Err(Error::field(
            format!("line {number}"),
            shortened(line),
            "three numbers",
        )),
    }
}

/// Words of curves and surfaces, whose pieces are counted as left out.
fn is_free_form(key: &str) -> bool {
    matches!(
        key,
        "cstype"
            | "deg"
            | "bmat"
            | "step"
            | "parm"
            | "trim"
            | "hole"
            | "scrv"
            | "sp"
            | "end"
            | "con"
            | "bsp"
            | "bzp"
            | "cdc"
            | "cdp"
            | "res"
            | "ctech"
            | "stech"
            | "shadow_obj"
            | "trace_obj"
    )
}

fn shortened(line: &str) -> String {
    line.trim().chars().take(80).collect()
}
