//! The paper's rule written down without further thought, to measure ours against: linear
//! curves without bounds of their errors, one node after the other.

use transmittance::{Accumulate, BlockerSegment, Evaluate};

/// A curve of at most `N` nodes, of which `M = N + 2` are there for a moment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plain<const N: usize, const M: usize> {
    depth: [f32; M],
    transmittance: [f32; M],
    len: usize,
}

impl<const N: usize, const M: usize> Plain<N, M> {
    pub(crate) fn new() -> Self {
        const { assert!(M == N + 2) }
        Self {
            depth: [0.0; M],
            transmittance: [1.0; M],
            len: 0,
        }
    }

    fn at(&self, depth: f32) -> f32 {
        let next = self.depth[..self.len].partition_point(|&d| d < depth);
        if next == 0 {
            return 1.0;
        }
        if next == self.len {
            return self.transmittance[next - 1];
        }
        let [a, b] = [next - 1, next];
        let share = (depth - self.depth[a]) / (self.depth[b] - self.depth[a]);
        self.transmittance[a] + (self.transmittance[b] - self.transmittance[a]) * share
    }

    fn put(&mut self, depth: f32) {
        let transmittance = self.at(depth);
        let index = self.depth[..self.len].partition_point(|&d| d < depth);
        self.depth.copy_within(index..self.len, index + 1);
        self.transmittance.copy_within(index..self.len, index + 1);
        self.depth[index] = depth;
        self.transmittance[index] = transmittance;
        self.len += 1;
    }

    fn remove_one(&mut self) {
        let (d, t) = (&self.depth, &self.transmittance);
        let area = |i: usize| {
            let before = (d[i] - d[i - 1]) * (t[i] - t[i + 1]);
            let behind = (d[i + 1] - d[i]) * (t[i - 1] - t[i]);
            (before - behind).abs()
        };
        let mut least = (f32::INFINITY, 1);
        for i in 1..self.len - 1 {
            let area = area(i);
            if area < least.0 {
                least = (area, i);
            }
        }
        self.depth.copy_within(least.1 + 1..self.len, least.1);
        self.transmittance
            .copy_within(least.1 + 1..self.len, least.1);
        self.len -= 1;
    }
}

impl<const N: usize, const M: usize> Accumulate for Plain<N, M> {
    type Curve = Self;

    fn insert(&mut self, segment: &BlockerSegment) {
        let (entry, exit) = (segment.entry(), segment.exit());
        self.put(entry);
        self.put(exit);
        let passed = (-segment.optical_depth()[0]).exp();
        let inverse = 1.0 / (exit - entry).max(f32::MIN_POSITIVE);
        for (depth, transmittance) in self.depth.iter().zip(&mut self.transmittance) {
            let share = ((depth - entry) * inverse).clamp(0.0, 1.0);
            *transmittance *= 1.0 - (1.0 - passed) * share;
        }
        while self.len > N {
            self.remove_one();
        }
    }

    fn finish(self) -> Self {
        self
    }
}

impl<const N: usize, const M: usize> Evaluate for Plain<N, M> {
    fn evaluate(&self, depth: f32) -> [f32; 1] {
        [self.at(depth)]
    }
}
