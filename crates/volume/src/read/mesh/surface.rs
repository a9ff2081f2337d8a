//! The surface that a mesh file holds, before it is known in which space it lies.

use crate::error::Error;
use crate::mesh::Mesh;

/// What a reader hands over: numbers as they stand in the file.
pub(super) struct Surface {
    pub mesh: Mesh,
    pub format: &'static str,
    /// The texts in which a space may be named.
    pub remarks: Vec<String>,
    pub notes: Vec<String>,
}

/// Cuts a polygon into triangles that all have its first corner: right for convex ones.
pub(super) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let first = corners.first().copied().unwrap_or(0);
    let edges = corners.get(1..).unwrap_or_default();
    edges.windows(2).map(move |edge| [first, edge[0], edge[1]])
}

/// More vertices than indices can name: no file of less than 48 GiB has them.
pub(super) fn too_many_vertices() -> Error {
    Error::field(
        "number of vertices",
        format!("more than {}", u32::MAX),
        "what a 32-bit index can name",
    )
}

/// Says that polygons were cut, if any have more corners than a quadrangle.
pub(super) fn note_of_polygons(count: usize, notes: &mut Vec<String>) {
    if count > 0 {
        notes.push(format!(
            "{count} polygons of more than four corners were cut into fans, which is right for convex ones"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fans_have_two_triangles_less_than_corners() {
        assert_eq!(fan(&[]).count(), 0);
        assert_eq!(fan(&[1, 2]).count(), 0);
        let triangles: Vec<_> = fan(&[9, 1, 2, 3]).collect();
        assert_eq!(triangles, [[9, 1, 2], [9, 2, 3]]);
    }
}
