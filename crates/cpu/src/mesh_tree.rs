//! The tree of boxes over the triangles of a mesh, in which rays look for the first that they meet.

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::triangle::Triangle;
use std::time::Duration;

/// Smaller meshes are clustered from below by the crate obvhs (PLOC, D. Meister and J. Bittner, 2018). Of larger ones
/// this may take a time that grows with the square of their number, where neighbors do not agree which of them are
/// nearest: strips, triangles that lie in the same place.
const LARGE: usize = 4096;

/// Triangles that are not parted any more.
const LEAF: usize = 4;

/// Planes at which a box is parted, and one more.
const BINS: usize = 16;

/// Below so many nodes in one another, halves are made by number, so that no mesh makes a deep tree.
const DEEPEST: usize = 48;

/// A tree over `triangles`; rays look at those that its `primitive_indices` name.
pub fn tree(triangles: &[Triangle]) -> Bvh2 {
    match triangles.len() < LARGE {
        true => {
            let parameters = BvhBuildParams::medium_build();
            build_bvh2_from_tris(triangles, parameters, &mut Duration::default())
        }
        false => parted(triangles),
    }
}

/// Parts boxes from above where the surfaces of both parts, times the number of triangles in them, are least (J. D.
/// MacDonald and K. S. Booth 1990, in bins as by I. Wald 2007).
fn parted(triangles: &[Triangle]) -> Bvh2 {
    let mut indices = seen(triangles);
    let mut boxes: Vec<Aabb> = Vec::with_capacity(triangles.len());
    boxes.extend(triangles.iter().map(Triangle::aabb));
    let mut tree = Bvh2::default();
    tree.nodes.push(Bvh2Node::new(Aabb::empty(), 0, 0));
    let mut open = vec![(0, 0..indices.len(), 0)];
    while let Some((node, range, depth)) = open.pop() {
        let part = &mut indices[range.clone()];
        let around = part
            .iter()
            .fold(Aabb::empty(), |around, &i| around.union(&boxes[i as usize]));
        if part.len() <= LEAF {
            let (number, first) = (part.len() as u32, range.start as u32);
            tree.nodes[node] = Bvh2Node::new(around, number, first);
            continue;
        }
        let number = match depth < DEEPEST {
            true => partition(part, &boxes),
            false => part.len() / 2,
        };
        let middle = range.start + number;
        let children = tree.nodes.len();
        tree.nodes[node] = Bvh2Node::new(around, 0, children as u32);
        tree.nodes.extend([Bvh2Node::new(around, 0, 0); 2]);
        open.push((children, range.start..middle, depth + 1));
        open.push((children + 1, middle..range.end, depth + 1));
    }
    tree.primitive_indices = indices;
    tree
}

/// The triangles that have an area, each of equal ones once.
fn seen(triangles: &[Triangle]) -> Vec<u32> {
    let key = |index: &u32| {
        let triangle = &triangles[*index as usize];
        [triangle.v0, triangle.v1, triangle.v2].map(|v| v.to_array().map(f32::to_bits))
    };
    let has_area = |index: &u32| {
        let Triangle { v0, v1, v2 } = triangles[*index as usize];
        (v1 - v0).cross(v2 - v0) != Vec3A::ZERO
    };
    let mut indices: Vec<u32> = (0..triangles.len() as u32).filter(has_area).collect();
    indices.sort_by_cached_key(key);
    indices.dedup_by_key(|index| key(index));
    if indices.is_empty() && !triangles.is_empty() {
        indices.push(0);
    }
    indices
}

/// Orders `part` so that what is to be on one side comes first, and gives its number: at least one, and not all.
fn partition(part: &mut [u32], boxes: &[Aabb]) -> usize {
    let middle = |i: u32| boxes[i as usize].min + boxes[i as usize].max;
    let (low, high) = part
        .iter()
        .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), &i| {
            (low.min(middle(i)), high.max(middle(i)))
        });
    let size = high - low;
    let axis = (0..3).fold(
        0,
        |best, axis| if size[axis] > size[best] { axis } else { best },
    );
    let scale = BINS as f32 / size[axis];
    if !scale.is_finite() {
        return part.len() / 2;
    }
    let bin = |i: u32| (((middle(i)[axis] - low[axis]) * scale) as usize).min(BINS - 1);
    let mut bins = [(0usize, Aabb::empty()); BINS];
    for &i in part.iter() {
        let (number, around) = &mut bins[bin(i)];
        *number += 1;
        *around = around.union(&boxes[i as usize]);
    }
    let cost_of = |bins: &[(usize, Aabb)]| {
        let all = bins.iter().filter(|(number, _)| *number > 0);
        let (number, around) = all.fold((0, Aabb::empty()), |(sum, around), (number, of_bin)| {
            (sum + number, around.union(of_bin))
        });
        (number > 0).then(|| number as f32 * around.half_area())
    };
    let mut best = (f32::INFINITY, 0);
    for at in 1..BINS {
        let (left, right) = bins.split_at(at);
        if let (Some(left), Some(right)) = (cost_of(left), cost_of(right))
            && left + right < best.0
        {
            best = (left + right, at);
        }
    }
    if best.1 == 0 {
        return part.len() / 2;
    }
    let mut number = 0;
    for i in 0..part.len() {
        if bin(part[i]) < best.1 {
            part.swap(i, number);
            number += 1;
        }
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f32; 3]; 3]) -> Triangle {
        let [v0, v1, v2] = corners.map(Vec3A::from_array);
        Triangle { v0, v1, v2 }
    }

    /// Depth, and how often each triangle is named.
    fn walked(tree: &Bvh2, number: usize) -> (usize, Vec<usize>) {
        let (mut deepest, mut named) = (0, vec![0; number]);
        let mut open = vec![(0, 0)];
        while let Some((node, depth)) = open.pop() {
            let node = &tree.nodes[node];
            deepest = deepest.max(depth);
            let first = node.first_index as usize;
            match node.prim_count as usize {
                0 => open.extend([(first, depth + 1), (first + 1, depth + 1)]),
                number => tree.primitive_indices[first..first + number]
                    .iter()
                    .for_each(|i| named[*i as usize] += 1),
            }
        }
        (deepest, named)
    }

    /// With neighbors that do not agree, a builder from below would need minutes for each.
    #[test]
    fn no_mesh_takes_long_or_makes_a_deep_tree() {
        const NUMBER: usize = 200_000;
        let strip = |i: usize| {
            let x = i as f32;
            triangle([[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]])
        };
        let shrinking = |i: usize| {
            let size = 1.0 - i as f32 / NUMBER as f32;
            let x = i as f32;
            triangle([[x, 0.0, 0.0], [x + size, 0.0, 0.0], [x, size, size]])
        };
        // All in one box.
        let crossing = |i: usize| {
            let y = i as f32 / NUMBER as f32;
            triangle([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.5, y, 0.5]])
        };
        // Far out, the smallest have no area in single precision.
        for mesh in [strip, shrinking, crossing] {
            let triangles: Vec<_> = (0..NUMBER).map(mesh).collect();
            let (depth, named) = walked(&tree(&triangles), NUMBER);
            assert!(depth < 80, "{depth}");
            assert!(named.iter().filter(|number| **number == 1).count() >= NUMBER - 2000);
            assert!(named.iter().all(|number| *number <= 1));
        }
    }

    #[test]
    fn equal_triangles_are_met_once_and_those_without_an_area_not_at_all() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let flat = triangle([corners[0], corners[1], corners[0]]);
        let mut triangles = vec![triangle(corners); 50_000];
        triangles.extend(vec![flat; 50_000]);
        let (_, named) = walked(&tree(&triangles), triangles.len());
        assert_eq!(named.iter().sum::<usize>(), 1);
        let (_, named) = walked(&tree(&vec![flat; 50_000]), 50_000);
        assert_eq!(named.iter().sum::<usize>(), 1);
    }
}
