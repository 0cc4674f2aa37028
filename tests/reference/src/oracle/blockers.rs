//! The triangles near a planar region, by a bounding volume hierarchy.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use scene::trace::hierarchy;

use super::span::Dark;
use super::visibility::Region;

/// A hierarchy of boxes around triangles.
pub(super) struct Tree {
    bvh: Bvh2,
    /// The size of the coordinates, to which rounding is relative.
    scale: f64,
}

impl std::fmt::Debug for Tree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tree")
            .field("nodes", &self.bvh.nodes.len())
            .finish_non_exhaustive()
    }
}

impl Tree {
    pub(super) fn new(triangles: &[[DVec3; 3]]) -> Self {
        let boxes: Vec<_> = triangles.iter().map(enclose).collect();
        let scale = triangles.iter().flatten().fold(0.0_f64, |scale, corner| {
            scale.max(corner.abs().max_element())
        });
        Self {
            bvh: hierarchy(&boxes, BvhBuildParams::fast_build()),
            scale,
        }
    }

    /// Calls `visit` with the index of every triangle whose box may meet the
    /// region, those near the light first, until it returns true. Boxes that
    /// are all in the `dark` are skipped.
    pub(super) fn search(
        &self,
        region: &Region,
        dark: &mut Dark,
        mut visit: impl FnMut(&mut Dark, usize) -> bool,
    ) {
        let origin = region.origin();
        let slack = 1e-12 * (self.scale + origin.abs().max_element());
        let tests: Vec<Test> = region
            .half_spaces()
            .iter()
            .map(|half| Test {
                normal: half.normal,
                spread: half.normal.abs(),
                limit: half.limit + half.normal.dot(origin) + slack + 1e-12 * half.limit.abs(),
            })
            .collect();
        let extent = |index: usize| {
            let bounds = self.bvh.nodes[index].aabb();
            let (low, high) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
            (0.5 * (low + high), 0.5 * (high - low))
        };
        let mut stack = vec![0_usize];
        while let Some(index) = stack.pop() {
            let (centre, half) = extent(index);
            if tests.iter().any(|test| test.misses(centre, half)) {
                continue;
            }
            if let Some(shadow) = region.shadow_of_box(centre, half)
                && dark.contains(shadow)
            {
                continue;
            }
            let node = &self.bvh.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                for slot in first..first + node.prim_count as usize {
                    if visit(dark, self.bvh.primitive_indices[slot] as usize) {
                        return;
                    }
                }
            } else {
                // What is nearer to the light has the larger shadow.
                let depth = |child: usize| region.depth(extent(child).0);
                let second = first + 1;
                if depth(first) < depth(second) {
                    stack.extend([second, first]);
                } else {
                    stack.extend([first, second]);
                }
            }
        }
    }
}

/// The smallest box of f32 coordinates around a triangle.
fn enclose([a, b, c]: &[DVec3; 3]) -> Aabb {
    let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
    let down = |x: f64| {
        let near = x as f32;
        if f64::from(near) > x {
            near.next_down()
        } else {
            near
        }
    };
    let up = |x: f64| {
        let near = x as f32;
        if f64::from(near) < x {
            near.next_up()
        } else {
            near
        }
    };
    Aabb::new(
        Vec3A::from_array(low.to_array().map(down)),
        Vec3A::from_array(high.to_array().map(up)),
    )
}

/// A half-space and what a box needs to be compared with it.
struct Test {
    normal: DVec3,
    spread: DVec3,
    limit: f64,
}

impl Test {
    /// True if the box lies outside as a whole.
    fn misses(&self, centre: DVec3, half: DVec3) -> bool {
        self.normal.dot(centre) - self.spread.dot(half) > self.limit
    }
}
