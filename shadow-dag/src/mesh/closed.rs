//! Which parts of a mesh enclose something.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;
use gpu_backend::Cpu;

use super::Watertightness;
use super::cull::Extents;
use super::sorted::{PARTS, Parts};
use super::weld::first_at;

/// Parts of a mesh that hang together.
#[derive(Debug)]
pub(crate) struct Components {
    /// Whether each triangle belongs to a part that is closed.
    pub(crate) closed: Vec<bool>,
    pub(super) extents: Extents,
    pub(crate) watertightness: Watertightness,
}

/// Disjoint sets of vertices, that many threads can join at once.
///
/// Every member but one of a set names a smaller one, so the smallest stands
/// for it, whatever was joined first. Nothing else depends on what the others
/// name; that is why no order between memory accesses is asked for.
#[derive(Debug)]
struct Sets {
    parent: Vec<AtomicU32>,
}

impl Sets {
    fn parent(&self, item: u32) -> u32 {
        self.parent[item as usize].load(Ordering::Relaxed)
    }

    fn find(&self, mut item: u32) -> u32 {
        loop {
            let above = self.parent(item);
            let next = self.parent(above);
            if above == next {
                return above;
            }
            // Halving the path keeps it short. Once an item names another it
            // always does, so this hides no set that was joined meanwhile.
            self.parent[item as usize].store(next, Ordering::Relaxed);
            item = next;
        }
    }

    fn join(&self, a: u32, b: u32) {
        loop {
            let (a, b) = (self.find(a), self.find(b));
            let (low, high) = (a.min(b), a.max(b));
            let order = Ordering::Relaxed;
            let parent = &self.parent[high as usize];
            // Fails if another thread has joined it to something else.
            if low == high || parent.compare_exchange(high, low, order, order).is_ok() {
                return;
            }
        }
    }
}

/// Vertices of which one is the lower end of an edge without a counterpart, once
/// for each edge. `same` is the vertex that stands for all at its position.
fn open_edges(
    cpu: &Cpu,
    vertices: usize,
    indices: &[[u32; 3]],
    same: impl Fn(u32) -> u32 + Sync + Send,
) -> Vec<u32> {
    // Edges by their lower end, in ranges of vertices.
    let range = vertices.div_ceil(PARTS).max(1);
    let edges = Parts::new(
        cpu,
        indices.len(),
        |triangle, parts: &mut [Vec<[u32; 2]>]| {
            let [a, b, c] = indices[triangle].map(&same);
            for edge in [[a, b], [b, c], [c, a]] {
                if edge[0] != edge[1] {
                    parts[edge[0].min(edge[1]) as usize / range].push(edge);
                }
            }
        },
    );
    let found = cpu.map(PARTS, |part| {
        let lower = |edge: &[u32; 2]| edge[0].min(edge[1]) as usize - part * range;
        let mut ends = vec![0_u32; range + 1];
        for edge in edges.part(part) {
            ends[lower(edge) + 1] += 1;
        }
        for at in 0..range {
            ends[at + 1] += ends[at];
        }
        // Upper ends, and whether the triangle runs up, by lower ends.
        let mut sorted = vec![(0, false); edges.len(part)];
        for edge in edges.part(part) {
            let at = &mut ends[lower(edge)];
            sorted[*at as usize] = (edge[0].max(edge[1]), edge[0] < edge[1]);
            *at += 1;
        }
        let mut open = Vec::new();
        let mut start = 0;
        // Filling has moved each end to where the next began.
        for (vertex, &end) in (part * range..).zip(&ends[..range]) {
            let edges = &mut sorted[start..end as usize];
            edges.sort_unstable();
            for edge in edges.chunk_by(|a, b| a.0 == b.0) {
                let up = edge.iter().filter(|(_, up)| *up).count();
                if 2 * up != edge.len() {
                    open.push(vertex as u32);
                }
            }
            start = end as usize;
        }
        open
    });
    found.concat()
}

impl Components {
    /// Vertices at the same position count as one. A part is closed if all of
    /// its edges have as many triangles on one side as on the other, and none of
    /// its triangles has holes.
    pub(crate) fn new(
        cpu: &Cpu,
        positions: &[Vec3],
        indices: &[[u32; 3]],
        has_holes: impl Fn(usize) -> bool,
    ) -> Self {
        let first = first_at(cpu, positions);
        let sets = Sets {
            parent: cpu.map(positions.len(), |vertex| {
                AtomicU32::new(first[vertex].load(Ordering::Relaxed))
            }),
        };
        cpu.map(indices.len(), |triangle| {
            let [a, b, c] = indices[triangle];
            sets.join(a, b);
            sets.join(a, c);
        });
        let part: Vec<u32> = cpu.map(positions.len(), |vertex| sets.find(vertex as u32));
        drop(sets);
        let part_of = |triangle: usize| part[indices[triangle][0] as usize] as usize;

        let mut open = vec![false; positions.len()];
        let mut watertightness = Watertightness::default();
        let same = |vertex: u32| first[vertex as usize].load(Ordering::Relaxed);
        for vertex in open_edges(cpu, positions.len(), indices, same) {
            watertightness.open_edges += 1;
            open[part[vertex as usize] as usize] = true;
        }
        drop(first);
        for triangle in (0..indices.len()).filter(|&triangle| has_holes(triangle)) {
            open[part_of(triangle)] = true;
        }

        // Six times the volume, from a corner of the part so that no digits
        // are lost to its distance from the origin.
        let volumes = cpu.map(indices.len(), |triangle| {
            let origin = positions[part_of(triangle)].as_dvec3();
            let corners = indices[triangle];
            let [a, b, c] = corners.map(|corner| positions[corner as usize].as_dvec3() - origin);
            a.cross(b).dot(c)
        });
        let mut volume = vec![0.0_f64; positions.len()];
        let mut used = vec![false; positions.len()];
        for (triangle, more) in volumes.into_iter().enumerate() {
            volume[part_of(triangle)] += more;
            used[part_of(triangle)] = true;
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
        let closed = cpu.map(indices.len(), |triangle| !open[part_of(triangle)]);
        Self {
            extents: Extents::new(cpu, positions, indices, &closed, part_of),
            closed,
            watertightness,
        }
    }
}
