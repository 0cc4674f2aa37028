//! Building the hierarchy.

use std::time::Duration;

use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use crate::SceneError;

/// How far a box may be moved for the builder, as a share of its own size.
const OF_ITSELF: f64 = 1.0 / (1 << 16) as f64;

/// The same as a share of the size of the scene: some steps of an f32.
const OF_ALL: f64 = 1.0 / (1 << 22) as f64;

/// Bytes for each box that the builder of the library takes at most at the same time: five
/// lists of nodes of 48 bytes, two for each box or one, with boxes, those that it is told of,
/// keys to sort by and indices.
const BUILD: usize = 416;

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
/// The builder joins two boxes once each is the best partner of the other. Boxes in a row, or
/// all at the same place, have equally good partners, of which it always takes the last. Only
/// the two at the end would then be joined, the others would have to wait for them, and the
/// time would grow with the square of their number. So it gets boxes that are moved by a
/// trifle, and the hierarchy then gets the true ones.
///
/// The library panics without enough memory, so it is taken and given back before: where there
/// is not enough, the allocator ends the program, as for any vector.
pub fn hierarchy(boxes: &[Aabb], how: BvhBuildParams) -> Bvh2 {
    std::hint::black_box(Vec::<u8>::with_capacity(boxes.len().saturating_mul(BUILD)));
    let mut bvh = build_bvh2(&told_apart(boxes), how, &mut Duration::default());
    for node in &mut bvh.nodes {
        if node.is_leaf() {
            let first = node.first_index as usize;
            let slots = &bvh.primitive_indices[first..first + node.prim_count as usize];
            let own = slots.iter().map(|&index| boxes[index as usize]);
            if let Some(all) = own.reduce(|a, b| a.union(&b)) {
                node.set_aabb(all);
            }
        }
    }
    bvh.refit_all();
    bvh
}

fn box_of(corners: &[Vec3; 3]) -> Aabb {
    let [a, b, c] = corners.map(Vec3A::from);
    Aabb::new(a.min(b).min(c), a.max(b).max(c))
}

/// The boxes with a largest extent of all of 1, each moved a little in a direction that follows
/// from its index and looks random.
fn told_apart(boxes: &[Aabb]) -> Vec<Aabb> {
    let all = boxes.iter().fold(Aabb::empty(), |all, own| all.union(own));
    let origin = wide(all.min);
    let size = (wide(all.max) - origin).max_element();
    let scale = if size > 0.0 { size.recip() } else { 1.0 };
    let moved = |(index, own): (usize, &Aabb)| {
        let [low, high] = [own.min, own.max].map(|corner| (wide(corner) - origin) * scale);
        let most = (OF_ITSELF * (high - low).max_element()).max(OF_ALL);
        let by = most * direction(index as u32);
        Aabb::new(narrow(low + by), narrow(high + by))
    };
    boxes.iter().enumerate().map(moved).collect()
}

fn wide(v: Vec3A) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

fn narrow(v: DVec3) -> Vec3A {
    v.as_vec3().into()
}

/// Three numbers from 0 to 1 that look random.
fn direction(index: u32) -> DVec3 {
    let share = |seed: u32| {
        // The finaliser of the hash function MurmurHash3.
        let mut bits = index.wrapping_mul(3).wrapping_add(seed);
        bits = (bits ^ (bits >> 16)).wrapping_mul(0x85eb_ca6b);
        bits = (bits ^ (bits >> 13)).wrapping_mul(0xc2b2_ae35);
        f64::from(bits ^ (bits >> 16)) / f64::from(u32::MAX)
    };
    DVec3::new(share(0), share(1), share(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many nodes there are on the longest way from the root to a leaf.
    fn depth(bvh: &Bvh2) -> usize {
        let mut deepest = 0;
        let mut open = vec![(0, 1)];
        while let Some((index, depth)) = open.pop() {
            let node = &bvh.nodes[index];
            deepest = deepest.max(depth);
            if !node.is_leaf() {
                let first = node.first_index as usize;
                open.extend([(first, depth + 1), (first + 1, depth + 1)]);
            }
        }
        deepest
    }

    #[test]
    fn triangles_at_one_place_and_in_a_row_do_not_make_a_chain() {
        const MANY: usize = 50_000;
        let at = |x: f32| [Vec3::ZERO, Vec3::X, Vec3::ONE].map(|corner| corner + x * Vec3::X);
        for (what, step) in [("one place", 0.0), ("a row", 2.0), ("a dense row", 0.125)] {
            let triangles: Vec<_> = (0..MANY).map(|i| at(step * i as f32)).collect();
            let deepest = depth(&build(&triangles));
            assert!(deepest < 200, "{what}: {deepest}");
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
