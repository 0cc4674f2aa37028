//! Building the hierarchy.

use std::collections::HashMap;
use std::time::Duration;

use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use crate::SceneError;

/// The builder gets each box once if there is one that occurs more often than this.
const OFTEN: usize = 64;

/// Bytes for each box that the builder of the library takes at most at the same time: five
/// lists of nodes of 48 bytes, two for each box or one, with boxes, keys to sort by and
/// indices; and what tells boxes that occur often.
const BUILD: usize = 480;

/// Whether there is memory to build the hierarchy of so many boxes.
pub(super) fn reserve(what: &'static str, boxes: usize) -> Result<(), SceneError> {
    let bytes = boxes.saturating_mul(BUILD);
    let mut room: Vec<u8> = Vec::new();
    let reserved = room.try_reserve_exact(bytes);
    // A vector that nobody sees need not be allocated.
    std::hint::black_box(&room);
    reserved.map_err(|_| SceneError::OutOfMemory {
        what,
        bytes: bytes as u64,
    })
}

/// Builds the hierarchy of these triangles.
pub(super) fn build(triangles: &[[Vec3; 3]]) -> Bvh2 {
    let boxes: Vec<Aabb> = triangles.iter().map(box_of).collect();
    hierarchy(&boxes, BvhBuildParams::medium_build())
}

/// Builds a hierarchy of boxes.
///
/// The builder joins two boxes once each is the best partner of the other. Boxes at the same
/// place have equally good partners, of which it always takes the last. Only the two at the end
/// would then be joined, the others would have to wait for them, and the time would grow with
/// the square of their number. So a box that occurs often is built once, and its leaf gets all
/// that have it.
///
/// The library panics without enough memory, so it is taken and given back before: where there
/// is not enough, the allocator ends the program, as for any vector.
pub fn hierarchy(boxes: &[Aabb], how: BvhBuildParams) -> Bvh2 {
    std::hint::black_box(Vec::<u8>::with_capacity(boxes.len().saturating_mul(BUILD)));
    let mut places: HashMap<[u32; 6], usize> = HashMap::new();
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for (index, own) in boxes.iter().enumerate() {
        let [low, high] = [own.min, own.max].map(|corner| corner.to_array().map(f32::to_bits));
        let key = [low[0], low[1], low[2], high[0], high[1], high[2]];
        let place = *places.entry(key).or_insert(groups.len());
        if place == groups.len() {
            groups.push(Vec::new());
        }
        groups[place].push(index as u32);
    }
    if groups.iter().all(|group| group.len() <= OFTEN) {
        return build_bvh2(boxes, how, &mut Duration::default());
    }
    let each: Vec<Aabb> = groups
        .iter()
        .map(|group| boxes[group[0] as usize])
        .collect();
    let mut bvh = build_bvh2(&each, how, &mut Duration::default());
    // Where the boxes of each slot begin.
    let mut begins = vec![0];
    let mut indices = Vec::with_capacity(boxes.len());
    for &place in &bvh.primitive_indices {
        indices.extend(&groups[place as usize]);
        begins.push(indices.len() as u32);
    }
    for node in bvh.nodes.iter_mut().filter(|node| node.is_leaf()) {
        let (first, end) = (node.first_index, node.first_index + node.prim_count);
        node.first_index = begins[first as usize];
        node.prim_count = begins[end as usize] - node.first_index;
    }
    bvh.primitive_indices = indices;
    bvh
}

fn box_of(corners: &[Vec3; 3]) -> Aabb {
    let [a, b, c] = corners.map(Vec3A::from);
    Aabb::new(a.min(b).min(c), a.max(b).max(c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_at_one_place_are_in_leaves_once_each() {
        const MANY: u32 = 100_000;
        let at = |x: f32| [Vec3::ZERO, Vec3::X, Vec3::ONE].map(|corner| corner + x * Vec3::X);
        // All at one place, at three places, and with others around.
        for places in [1, 3, 500] {
            let place = |i: u32| if i.is_multiple_of(2) { 0 } else { i % places };
            let triangles: Vec<_> = (0..MANY).map(|i| at(place(i) as f32)).collect();
            let bvh = build(&triangles);
            let mut met = vec![0; MANY as usize];
            for node in bvh.nodes.iter().filter(|node| node.is_leaf()) {
                let first = node.first_index as usize;
                for &index in &bvh.primitive_indices[first..first + node.prim_count as usize] {
                    met[index as usize] += 1;
                    let own = box_of(&triangles[index as usize]);
                    assert_eq!(node.aabb().union(&own), *node.aabb());
                }
            }
            assert!(met.iter().all(|times| *times == 1), "{places}");
        }
    }

    #[test]
    fn triangles_for_which_there_is_no_memory_are_an_error() {
        assert_eq!(reserve("a test", 1000), Ok(()));
        let error = reserve("a test", usize::MAX / 1000).unwrap_err();
        assert!(matches!(error, SceneError::OutOfMemory { .. }), "{error}");
        assert!(
            error
                .to_string()
                .starts_with("there is no memory for a test")
        );
    }

    #[test]
    fn boxes_are_those_of_the_triangles() {
        let at = |x: f32| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + x * Vec3::ONE);
        for offsets in [vec![], vec![3.0], vec![0.0; 30], vec![1e6, -1e-3, 7.0, 7.0]] {
            let triangles: Vec<_> = offsets.iter().map(|x| at(*x)).collect();
            let bvh = build(&triangles);
            for node in bvh.nodes.iter().filter(|node| node.is_leaf()) {
                let first = node.first_index as usize;
                let slots = &bvh.primitive_indices[first..first + node.prim_count as usize];
                let own = slots
                    .iter()
                    .map(|&index| box_of(&triangles[index as usize]));
                assert_eq!(own.reduce(|a, b| a.union(&b)), Some(*node.aabb()));
            }
            let all = triangles.iter().map(box_of).reduce(|a, b| a.union(&b));
            assert_eq!(bvh.nodes.first().map(|root| *root.aabb()), all);
        }
    }
}
