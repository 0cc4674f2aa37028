//! The best curve that a subset of the exact curve's nodes can make.
//!
//! Its own exact curve, plain numerical integration, f64, all nodes.

use super::{Blocker, ends, transmittance};

/// What is least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Least {
    /// Area between the curves.
    Area,
    /// Largest distance.
    Maximum,
}

/// A point of the exact curve.
#[derive(Debug, Clone, Copy)]
struct Node {
    depth: f64,
    transmittance: f64,
    optical_depth: f64,
}

/// All of them, from front to back; steps are two at a depth.
fn nodes(blockers: &[Blocker]) -> Vec<Node> {
    let exact = |depth: f32| transmittance(blockers.iter().copied(), depth);
    let mut nodes = Vec::new();
    for end in ends(blockers.iter().copied()) {
        let mut push = |transmittance: f64| {
            nodes.push(Node {
                depth: f64::from(end),
                transmittance,
                // An opaque wall, as far as f64 can tell.
                optical_depth: -transmittance.max(f64::MIN_POSITIVE).ln(),
            });
        };
        push(exact(end));
        if blockers.iter().any(|b| b.entry == end && b.exit == end) {
            push(exact(end.next_up()));
        }
    }
    nodes
}

/// A curve between two nodes.
fn between(exponential: bool, a: Node, b: Node, share: f64) -> f64 {
    if exponential {
        (-(a.optical_depth + (b.optical_depth - a.optical_depth) * share)).exp()
    } else {
        a.transmittance + (b.transmittance - a.transmittance) * share
    }
}

/// Mean or largest error of the best `n` of the exact curve's nodes, first and
/// last among them, with linear or exponential lookup.
pub fn least_error(blockers: &[Blocker], n: usize, least: Least, exponential: bool) -> f64 {
    let nodes = nodes(blockers);
    let count = nodes.len();
    // Exact samples between each node and the next.
    const SAMPLES: [f64; 4] = [0.001, 1.0 / 3.0, 2.0 / 3.0, 0.999];
    let exact: Vec<[f64; 4]> = nodes
        .windows(2)
        .map(|pair| SAMPLES.map(|share| between(true, pair[0], pair[1], share)))
        .collect();
    let cost = |i: usize, j: usize| {
        let (a, b) = (nodes[i], nodes[j]);
        let mut cost = 0.0_f64;
        for x in i..j {
            let width = nodes[x + 1].depth - nodes[x].depth;
            if width == 0.0 {
                continue;
            }
            for (k, sample) in SAMPLES.iter().enumerate() {
                let share = (nodes[x].depth + width * sample - a.depth) / (b.depth - a.depth);
                let error = (between(exponential, a, b, share) - exact[x][k]).abs();
                cost = match least {
                    // The 3/8 rule, whose weights are 1 3 3 1.
                    Least::Area => cost + error * width * [1.0, 3.0, 3.0, 1.0][k] / 8.0,
                    Least::Maximum => cost.max(error),
                };
            }
        }
        cost
    };
    let mut best = vec![f64::INFINITY; count];
    best[0] = 0.0;
    let costs: Vec<Vec<f64>> = (0..count)
        .map(|i| (i + 1..count).map(|j| cost(i, j)).collect())
        .collect();
    for _ in 1..n {
        let mut next = best.clone();
        for j in 1..count {
            for i in 0..j {
                let with = match least {
                    Least::Area => best[i] + costs[i][j - i - 1],
                    Least::Maximum => best[i].max(costs[i][j - i - 1]),
                };
                next[j] = next[j].min(with);
            }
        }
        best = next;
    }
    match least {
        Least::Area => best[count - 1] / (nodes[count - 1].depth - nodes[0].depth),
        Least::Maximum => best[count - 1],
    }
}
