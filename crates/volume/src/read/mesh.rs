//! Triangle meshes: STL, OBJ, PLY.
//!
//! None of the three formats says in which space its numbers are. Numbers are taken as they stand, in
//! the RAS millimeters of the volumes, unless the file carries the remark of 3D Slicer (`SPACE=LPS`
//! or `SPACE=RAS` in the header of an STL, in a comment of an OBJ or PLY), or the caller says
//! otherwise. Meshes of ITK and of 3D Slicer are in LPS.
//!
//! | kind         | how it is told apart                                                          |
//! |--------------|-------------------------------------------------------------------------------|
//! | PLY          | begins with the line `ply`                                                    |
//! | STL, binary  | is as long as the number at byte 84 − 4 says, whatever the header begins with |
//! | STL, text    | begins with `solid`                                                           |
//! | OBJ          | text whose first line that is no comment begins with a word of the format     |
//!
//! Where the bytes say nothing, the ending of the name decides.

mod obj;
mod ply;
mod stl;
mod surface;

use super::watched::{Watched, uncancelled};
use super::{Bytes, Files};
use crate::Control;
use crate::error::{Error, ErrorKind};
use crate::memory;
use crate::mesh::Mesh;
use glam::{DAffine3, DVec3};
use surface::Surface;

/// The space that the numbers of a mesh file are in, always millimeters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshSpace {
    /// x to the patient's right, y to the front, z to the head: the world of the volumes.
    Ras,
    /// x to the patient's left, y to the back, z to the head: ITK, DICOM, 3D Slicer's files.
    Lps,
}

/// What a mesh file held.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    /// The surface, in RAS mm.
    pub mesh: Mesh,
    /// The kind of file: `STL`, `OBJ` or `PLY`.
    pub format: &'static str,
    /// What the user should know: the space that was assumed, what was left out.
    pub notes: Vec<String>,
}

/// Reads the mesh file `name` of `files`. `space` goes before what the file says of its space.
///
/// # Errors
/// Whatever is wrong with the file, with its name in front; a file that is no mesh.
pub fn read_mesh(
    name: &str,
    files: &dyn Files,
    space: Option<MeshSpace>,
) -> Result<LoadedMesh, Error> {
    let in_file = |error: Error| error.in_file(name);
    let bytes = files.open(name).map_err(|error| in_file(error.into()))?;
    let bytes = whole(&*bytes).map_err(in_file)?;
    let surface = match kind(&bytes, name).map_err(in_file)? {
        Kind::Stl => stl::read(&bytes),
        Kind::Obj => obj::read(&bytes),
        Kind::Ply => ply::read(&bytes),
    };
    placed(surface.map_err(in_file)?, space).map_err(in_file)
}

/// As [`read_mesh`] under `control`, which is told the share of the bytes that has been read.
///
/// # Errors
/// As [`read_mesh`]; it was cancelled.
pub fn read_mesh_under(
    name: &str,
    files: &dyn Files,
    space: Option<MeshSpace>,
    control: &Control,
) -> Result<LoadedMesh, Error> {
    let read = read_mesh(name, &Watched::new(files, control), space);
    uncancelled(read, control)
}

/// All bytes: unlike samples, none of them stays as it is. The length is that of the file.
fn whole(bytes: &dyn Bytes) -> Result<Vec<u8>, Error> {
    // The corners of a mesh take about as much again.
    bytes.has_room(bytes.len().saturating_mul(2))?;
    let length = usize::try_from(bytes.len()).unwrap_or(usize::MAX);
    let mut all = memory::zeroed(length)?;
    bytes.read_at(0, &mut all)?;
    Ok(all)
}

fn placed(surface: Surface, space: Option<MeshSpace>) -> Result<LoadedMesh, Error> {
    let mut notes = surface.notes;
    let stated = surface.remarks.iter().find_map(|remark| space_in(remark));
    let space = match (space, stated) {
        (Some(space), _) => space,
        (None, Some(Ok(space))) => space,
        (None, Some(Err(other))) => {
            notes.push(format!(
                "SPACE={other} is not known (RAS and LPS are); the mesh is taken as RAS"
            ));
            MeshSpace::Ras
        }
        (None, None) => {
            notes.push(format!(
                "{} does not state its space; the mesh is read as RAS mm",
                surface.format
            ));
            MeshSpace::Ras
        }
    };
    let mesh = match space {
        MeshSpace::Ras => surface.mesh,
        MeshSpace::Lps => {
            let turn = DAffine3::from_scale(DVec3::new(-1.0, -1.0, 1.0));
            surface.mesh.transformed(turn)?
        }
    };
    Ok(LoadedMesh {
        mesh,
        format: surface.format,
        notes,
    })
}

/// The space that a remark names as 3D Slicer does, or the word that stands in its place.
fn space_in(remark: &str) -> Option<Result<MeshSpace, String>> {
    const KEY: &str = "SPACE=";
    let at = remark.find(KEY)?;
    // Not the end of another word.
    if remark[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
        return None;
    }
    let word: String = remark[at + KEY.len()..]
        .chars()
        .take_while(char::is_ascii_alphanumeric)
        .take(16)
        .collect();
    Some(match word.to_ascii_uppercase().as_str() {
        "RAS" => Ok(MeshSpace::Ras),
        "LPS" => Ok(MeshSpace::Lps),
        _ => Err(word),
    })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Stl,
    Obj,
    Ply,
}

fn kind(bytes: &[u8], name: &str) -> Result<Kind, Error> {
    if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        return Ok(Kind::Ply);
    }
    if stl::is_binary(bytes) || stl::is_text(bytes) {
        return Ok(Kind::Stl);
    }
    if obj::is_obj(bytes) {
        return Ok(Kind::Obj);
    }
    let name = name.to_ascii_lowercase();
    let named = [
        (".stl", Kind::Stl),
        (".obj", Kind::Obj),
        (".ply", Kind::Ply),
    ];
    match named.into_iter().find(|(ending, _)| name.ends_with(ending)) {
        Some((_, kind)) => Ok(kind),
        None => Err(ErrorKind::Unsupported {
            feature: format!(
                "a mesh that begins with `{}`",
                String::from_utf8_lossy(&bytes[..bytes.len().min(16)]).escape_debug()
            ),
            instead: "meshes are read from STL, OBJ and PLY files; convert it, or unpack it if it is packed".into(),
        }
        .into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remarks_name_a_space() {
        let space = |remark: &str| space_in(remark);
        assert_eq!(
            space("3D Slicer output. SPACE=LPS"),
            Some(Ok(MeshSpace::Lps))
        );
        assert_eq!(space("SPACE=RAS\0\0"), Some(Ok(MeshSpace::Ras)));
        assert_eq!(space("SPACE=LAS"), Some(Err("LAS".into())));
        for none in ["", "SPACE", "COLORSPACE=LPS", "space", "SPACE LPS"] {
            assert_eq!(space(none), None, "{none}");
        }
    }
}
