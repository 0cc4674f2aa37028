//! The hierarchy as a list, for walks without a stack.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use obvhs::bvh2::node::Bvh2Node;

use super::Tracer;

/// A hierarchy in the order of a walk that goes to a node's children after the node itself
/// and to the larger child first. Each inner node says where the walk goes on without its
/// children: a shader needs no stack, whatever the depth.
#[derive(Debug, Clone, Default)]
pub struct Preorder {
    /// The nodes; the walk begins at the first and ends behind the last.
    pub nodes: Vec<PreorderNode>,
    /// The corners of the triangles of the leaves, in the order of the nodes.
    pub triangles: Vec<[Vec3; 3]>,
}

/// A node of a [`Preorder`].
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct PreorderNode {
    /// The least coordinates of its box.
    pub low: Vec3,
    /// Of an inner node, the node after its last descendant. Of a leaf, which has no
    /// descendants, its first triangle.
    pub link: u32,
    /// The greatest coordinates of its box.
    pub high: Vec3,
    /// How many triangles a leaf has; 0 for an inner node.
    pub count: u32,
}

/// A step of the way through the tree.
enum Step {
    /// To the node of this index.
    Enter(usize),
    /// Away from the inner node at this place of the list.
    Leave(usize),
}

impl Tracer {
    /// The hierarchy with those triangles that `keeps`, told their index in
    /// [`Geometry::triangles`](crate::Geometry::triangles), does not leave out. Boxes are
    /// those of all triangles.
    pub fn preorder(&self, mut keeps: impl FnMut(usize) -> bool) -> Preorder {
        let mut list = Preorder::default();
        let mut steps = Vec::new();
        if !self.nodes.is_empty() {
            steps.push(Step::Enter(0));
        }
        while let Some(step) = steps.pop() {
            let index = match step {
                Step::Enter(index) => index,
                Step::Leave(place) => {
                    // A tracer holds fewer nodes than a u32 counts.
                    list.nodes[place].link = list.nodes.len() as u32;
                    continue;
                }
            };
            let node = &self.nodes[index];
            let first = node.first_index as usize;
            let place = list.nodes.len();
            list.nodes.push(PreorderNode {
                low: node.aabb.min.into(),
                link: list.triangles.len() as u32,
                high: node.aabb.max.into(),
                count: 0,
            });
            if node.prim_count == 0 {
                let mut children = [first, first + 1];
                if area(&self.nodes[first]) < area(&self.nodes[first + 1]) {
                    children.swap(0, 1);
                }
                steps.push(Step::Leave(place));
                steps.extend(children.into_iter().rev().map(Step::Enter));
                continue;
            }
            for slot in first..first + node.prim_count as usize {
                if keeps(self.indices[slot] as usize) {
                    list.triangles.push(self.triangles[slot]);
                    list.nodes[place].count += 1;
                }
            }
            if list.nodes[place].count == 0 {
                list.nodes.truncate(place);
            }
        }
        list
    }
}

/// Half of the surface of a node's box.
fn area(node: &Bvh2Node) -> f32 {
    let size = Vec3::from(node.aabb.max - node.aabb.min);
    size.x * size.y + size.y * size.z + size.z * size.x
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;
    use crate::{Geometry, Mesh, Scene};

    fn tracer(count: u32) -> Tracer {
        let mut random = Random::new(5);
        let mut vector = |scale: f32| Vec3::from(random.vector(scale));
        let positions = (0..count).flat_map(|_| {
            let centre = vector(10.0);
            [0; 3].map(|_| centre + vector(1.0))
        });
        let positions: Vec<Vec3> = positions.collect();
        let scene = Scene::from(Mesh {
            positions,
            triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Mesh::default()
        });
        Tracer::new(&Geometry::new(&scene).unwrap())
    }

    /// Checks a subtree and returns the node behind it.
    fn check(list: &Preorder, place: usize, seen: &mut Vec<usize>) -> usize {
        let node = list.nodes[place];
        let is_inside = |at: Vec3| at.cmpge(node.low).all() && at.cmple(node.high).all();
        if node.count > 0 {
            let first = node.link as usize;
            for triangle in first..first + node.count as usize {
                assert!(list.triangles[triangle].into_iter().all(is_inside));
                seen.push(triangle);
            }
            return place + 1;
        }
        let end = node.link as usize;
        let mut child = place + 1;
        while child < end {
            assert!(is_inside(list.nodes[child].low) && is_inside(list.nodes[child].high));
            child = check(list, child, seen);
        }
        assert_eq!(child, end);
        end
    }

    #[test]
    fn each_triangle_is_in_one_leaf_and_links_go_behind_subtrees() {
        for count in [1, 2, 9, 500] {
            let list = tracer(count).preorder(|_| true);
            let mut seen = Vec::new();
            assert_eq!(check(&list, 0, &mut seen), list.nodes.len());
            assert!(seen.into_iter().eq(0..count as usize));
        }
    }

    #[test]
    fn triangles_that_are_left_out_are_in_no_leaf() {
        let tracer = tracer(200);
        let list = tracer.preorder(|index| index % 3 == 0);
        let mut seen = Vec::new();
        assert_eq!(check(&list, 0, &mut seen), list.nodes.len());
        assert!(seen.into_iter().eq(0..67));
        assert!(tracer.preorder(|_| false).triangles.is_empty());
    }
}
