//! Building the hierarchy.

use std::collections::HashMap;

use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;

use crate::SceneError;

/// The builder gets each box once if there is one that occurs more often than this.
const OFTEN: usize = 64;

/// Bytes for each box that the builder of the library takes at most at the same time: five
/// lists of nodes of 48 bytes, two for each box or one, with boxes, keys to sort by and
/// indices; and what tells boxes that occur often.
const BUILD: usize = 480;

/// How many times as deep a tree may become while its nodes are moved: the test's becomes 1.4
/// times as deep. Stacks have room for a depth of 192 in any case.
const GROWTH: usize = 8;

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
        return of_different(boxes, how);
    };
    let mut bvh = of_different(&groups.each, how);
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

/// The hierarchy of boxes of which none occurs often.
///
/// These are the steps of the library's own `build_bvh2`, which forgets that a tree whose nodes
/// were moved may have become deeper: the next search for a better place may then find its stack
/// full, and panics.
fn of_different(boxes: &[Aabb], how: BvhBuildParams) -> Bvh2 {
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        how.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        how.sort_precision,
        how.search_depth_threshold,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    make_room(&mut bvh);
    optimizer.run(&mut bvh, how.reinsertion_batch_ratio, None);
    let most = how.max_prims_per_leaf.clamp(1, 255);
    collapse(&mut bvh, most, how.collapse_traversal_cost);
    make_room(&mut bvh);
    let ratio = how.reinsertion_batch_ratio * how.post_collapse_reinsertion_batch_ratio_multiplier;
    optimizer.run(&mut bvh, ratio, None);
    bvh
}

/// Lets the stacks of the library have room for a tree several times as deep as this one.
fn make_room(bvh: &mut Bvh2) {
    let mut depth = 0;
    let mut nodes = vec![(0, 1)];
    while let Some((index, level)) = nodes.pop() {
        depth = depth.max(level);
        if let Some(node) = bvh.nodes.get(index).filter(|node| !node.is_leaf()) {
            let child = node.first_index as usize;
            nodes.extend([(child, level + 1), (child + 1, level + 1)]);
        }
    }
    // The library takes twice this number of places.
    bvh.max_depth = bvh.max_depth.max(GROWTH * depth / 2);
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

    /// No tree of boxes around boxes is shallow, and this one becomes deeper once it is built.
    #[test]
    fn boxes_around_boxes_have_a_hierarchy_however_deep_it_is() {
        for growth in [1.005_f32, 1.012, 1.3] {
            let high = |i: i32| {
                let height = match i % 3 {
                    0 => 1.0,
                    _ => growth.powi(i % 400),
                };
                Vec3A::new(1.0, height, 1.0 + 0.5 * (i / 7) as f32)
            };
            let boxes: Vec<_> = (0..571).map(|i| Aabb::new(Vec3A::ZERO, high(i))).collect();
            for how in [BvhBuildParams::fast_build(), BvhBuildParams::medium_build()] {
                let mut indices = hierarchy(&boxes, how).primitive_indices;
                indices.sort_unstable();
                assert_eq!(indices, Vec::from_iter(0..571));
            }
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
