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

/// 2^64 over the golden ratio: the upper half of a product with it depends on all bits.
const MIX: u64 = 0x9E37_79B9_7F4A_7C15;

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
    let Some(groups) = Groups::of(boxes) else {
        return build_bvh2(boxes, how, &mut Duration::default());
    };
    let mut bvh = build_bvh2(&groups.each, how, &mut Duration::default());
    // Where the boxes of each slot begin.
    let mut begins = vec![0];
    let mut indices = Vec::with_capacity(boxes.len());
    for &group in &bvh.primitive_indices {
        indices.extend(groups.members(group as usize));
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

/// Boxes, and which of a longer list have each.
struct Groups {
    each: Vec<Aabb>,
    /// The places in that list, group by group.
    members: Vec<u32>,
    /// Where each group begins in it, and where the last one ends.
    begins: Vec<u32>,
}

impl Groups {
    /// `None` if no box occurs often.
    fn of(boxes: &[Aabb]) -> Option<Self> {
        // Few boxes share a slot; one that occurs often has a slot with many.
        let slots = (boxes.len() / 4).next_power_of_two();
        let slot_of = |own: &Aabb| {
            let mix = |hash: u64, bits| (hash ^ u64::from(bits)).wrapping_mul(MIX);
            (bits(own).into_iter().fold(0, mix) >> 32) as usize & (slots - 1)
        };
        let mut in_slot = vec![0_u8; slots];
        for own in boxes {
            let count = &mut in_slot[slot_of(own)];
            *count = count.saturating_add(1);
        }
        let full = |own: &Aabb| usize::from(in_slot[slot_of(own)]) > OFTEN;
        if !boxes.iter().any(full) {
            return None;
        }

        let mut places: HashMap<[u32; 6], u32> = HashMap::new();
        let mut each = Vec::new();
        let group_of: Vec<u32> = boxes
            .iter()
            .map(|own| {
                let next = each.len() as u32;
                let group = if full(own) {
                    *places.entry(bits(own)).or_insert(next)
                } else {
                    next
                };
                if group == next {
                    each.push(*own);
                }
                group
            })
            .collect();

        // Sorted by counting.
        let mut begins = vec![0; each.len() + 1];
        for &group in &group_of {
            begins[group as usize + 1] += 1;
        }
        for group in 0..each.len() {
            begins[group + 1] += begins[group];
        }
        let mut ends = begins.clone();
        let mut members = vec![0; boxes.len()];
        for (index, &group) in group_of.iter().enumerate() {
            let end = &mut ends[group as usize];
            members[*end as usize] = index as u32;
            *end += 1;
        }
        Some(Self {
            each,
            members,
            begins,
        })
    }

    /// The places of the boxes that equal this one of `each`.
    fn members(&self, group: usize) -> &[u32] {
        &self.members[self.begins[group] as usize..self.begins[group + 1] as usize]
    }
}

fn bits(own: &Aabb) -> [u32; 6] {
    let [low, high] = [own.min, own.max].map(|corner| corner.to_array().map(f32::to_bits));
    [low[0], low[1], low[2], high[0], high[1], high[2]]
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
