//! Which parts of a mesh enclose something.

use std::collections::HashMap;

use glam::Vec3;

use super::Watertightness;

/// Parts of a mesh that hang together.
#[derive(Debug)]
pub(crate) struct Components {
    /// Whether each triangle belongs to a part that is closed.
    pub(crate) closed: Vec<bool>,
    pub(crate) watertightness: Watertightness,
}

/// Disjoint sets of vertices.
#[derive(Debug)]
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn find(&mut self, mut item: u32) -> u32 {
        while self.parent[item as usize] != item {
            // Halving the path keeps it short.
            let above = self.parent[self.parent[item as usize] as usize];
            self.parent[item as usize] = above;
            item = above;
        }
        item
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

/// Bits that are equal where coordinates are: there are two zeros.
fn key(position: &Vec3) -> [u32; 3] {
    (*position + Vec3::ZERO).to_array().map(f32::to_bits)
}

impl Components {
    /// Vertices at the same position count as one. A part is closed if all of
    /// its edges have as many triangles on one side as on the other, and none of
    /// its triangles has holes.
    pub(crate) fn new(
        positions: &[Vec3],
        indices: &[[u32; 3]],
        has_holes: impl Fn(usize) -> bool,
    ) -> Self {
        let mut at = HashMap::with_capacity(positions.len());
        let same: Vec<u32> = (0..)
            .zip(positions)
            .map(|(vertex, position)| *at.entry(key(position)).or_insert(vertex))
            .collect();
        drop(at);
        let mut sets = Sets {
            parent: (0..positions.len() as u32).collect(),
        };
        // Edges in one direction, and which way the triangle runs.
        let mut edges: Vec<(u32, u32, i32)> = Vec::with_capacity(3 * indices.len());
        for corners in indices {
            let [a, b, c] = corners.map(|corner| same[corner as usize]);
            sets.join(a, b);
            sets.join(a, c);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if from != to {
                    edges.push((from.min(to), from.max(to), if from < to { 1 } else { -1 }));
                }
            }
        }
        edges.sort_unstable();
        let mut open = vec![false; positions.len()];
        let mut watertightness = Watertightness::default();
        for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if edge.iter().map(|edge| edge.2).sum::<i32>() != 0 {
                watertightness.open_edges += 1;
                open[sets.find(edge[0].0) as usize] = true;
            }
        }
        drop(edges);
        for (triangle, corners) in indices.iter().enumerate() {
            if has_holes(triangle) {
                open[sets.find(same[corners[0] as usize]) as usize] = true;
            }
        }

        // Six times the volume, from a corner of the part so that no digits
        // are lost to its distance from the origin.
        let mut volume = vec![0.0_f64; positions.len()];
        let mut used = vec![false; positions.len()];
        for corners in indices {
            let part = sets.find(same[corners[0] as usize]) as usize;
            let origin = positions[part].as_dvec3();
            let [a, b, c] = corners.map(|corner| positions[corner as usize].as_dvec3() - origin);
            volume[part] += a.cross(b).dot(c);
            used[part] = true;
        }
        for part in (0..positions.len()).filter(|&part| used[part]) {
            watertightness.parts += 1;
            if open[part] {
                watertightness.open_parts += 1;
            } else if volume[part] < 0.0 {
                watertightness.inverted_parts += 1;
                open[part] = true;
            }
        }
        let closed = (indices.iter())
            .map(|corners| !open[sets.find(same[corners[0] as usize]) as usize])
            .collect();
        Self {
            closed,
            watertightness,
        }
    }
}
