//! Pieces of a segment over each of which one Gauss–Legendre rule is good.

use crate::side::{Kind, Side};
use crate::{ScatteringAngle, gauss};

/// Where to evaluate an integrand along a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Distance along the ray from the start of the segment, m.
    pub distance: f32,
    /// `Σ weight f ≈ ∫ f / d² dx`, 1/m.
    pub weight: f32,
    /// The angle by which light is scattered there.
    pub angle: ScatteringAngle<f32>,
}

/// A Gauss–Legendre rule in single precision.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rule {
    /// Nodes in (0, 1) and weights that sum to 1.
    nodes: Vec<(f32, f32)>,
}

impl Rule {
    pub(super) fn of(count: u32) -> Self {
        let nodes = gauss::Rule::of(count)
            .iter()
            .map(|(node, weight)| (node as f32, weight as f32))
            .collect();
        Self { nodes }
    }

    pub(super) fn nodes(&self) -> &[(f32, f32)] {
        &self.nodes
    }
}

/// A part of a [`Side`], in single precision: everything that was a
/// difference has been formed.
///
/// With `t` from 0 to 1, and `f = α t / (1 − (1−α) t)` from 0 to 1 as well,
/// which puts the geometric mean of the ends of `b` in the middle, everything
/// of the side is linear in `f`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    alpha: f32,
    a: f32,
    reversed: bool,
    /// b and its change.
    b: [f32; 2],
    /// Optical depth since the start of the segment, and its change.
    depth: [f32; 2],
    /// `o` from the end that is nearer to the eye, `base + o`, and their
    /// changes.
    offset: [f32; 2],
    rest: [f32; 2],
    /// The distance from the start of the segment is
    /// `way[0] + o (way[1] + way[2] / (base + o))`.
    way: [f32; 3],
    scale: f32,
}

/// What a piece covers, for the choice of its rule: with `n` nodes the error
/// falls like `ρ^{−2n}`, where ρ is the sum of the half-axes of the largest
/// ellipse around the piece, with foci at its ends, that is free of poles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Span {
    /// `1/ρ` if `b` is shifted by the width of a peak, with the poles of p at
    /// 45° to it.
    shifted: f64,
    /// `1/ρ` behind the foot point, where there may be a double pole at 0.
    behind: f64,
    /// Change of the exponent.
    depth: f64,
}

/// tan(π/8)
const TANGENT: f64 = std::f64::consts::SQRT_2 - 1.0;

impl Span {
    /// The span over which a rule has this relative error, for a phase function of this
    /// [`steepness`](crate::Phase::steepness). The constants were fitted to
    /// measured errors, see the tests.
    pub(super) fn of_rule(nodes: u32, error: f64, steepness: f64) -> Self {
        let order = f64::from(2 * nodes);
        let factorial: f64 = (1..=2 * nodes).map(f64::from).product();
        Self {
            shifted: (error / 100.0).powf(1.0 / order),
            behind: (error / (100.0 * steepness)).powf(1.0 / order),
            // The error of the rule for e^{−x} is (depth/4)^{2n} 2 / (2n)!.
            depth: 4.0 * (error * factorial / 20.0).powf(1.0 / order),
        }
    }

    /// The span of pieces over which `b` grows by the factor `growth`, and the exponent by
    /// `depth`.
    pub(super) fn largest(growth: f64, depth: f64) -> Self {
        // The last piece of a side may be a tenth longer.
        let alpha = (1.1 * growth).sqrt().recip();
        Self {
            shifted: Self::new(alpha, depth, Kind::Front).shifted,
            behind: Self::new(alpha, depth, Kind::Behind).behind,
            depth: 1.1 * depth,
        }
    }

    /// The span of a piece with `√(b_a/b_b) = alpha`.
    fn new(alpha: f64, depth: f64, kind: Kind) -> Self {
        // With z from −1 to 1, b is proportional to (1 + kz) / (1 − kz).
        let k = ((1.0 - alpha) / (1.0 + alpha)).abs();
        let mut span = Self {
            depth,
            ..Self::default()
        };
        if kind == Kind::Behind {
            // b = 0 is at z = −1/k.
            span.behind = k / (1.0 + (1.0 - k * k).max(0.0).sqrt());
        } else {
            // b = i^{1/2} is at z = i tan(π/8) / k.
            span.shifted = k / (TANGENT + (TANGENT * TANGENT + k * k).sqrt());
        }
        span
    }

    /// The least `√(b_a/b_b)` of pieces in front of the foot point, and behind it.
    pub(super) fn least_alphas(&self) -> [f64; 2] {
        // With the k of `Span::new`: shifted = k / (T + √(T² + k²)), and behind is
        // (1 − √alpha) / (1 + √alpha).
        let k = 2.0 * TANGENT * self.shifted / (1.0 - self.shifted * self.shifted);
        let part = |k: f64| (1.0 - k) / (1.0 + k);
        let front = if self.shifted < 1.0 && k < 1.0 {
            part(k)
        } else {
            0.0
        };
        let behind = if self.behind < 1.0 {
            part(self.behind)
        } else {
            0.0
        };
        [front, behind * behind]
    }

    /// Change of the exponent.
    pub(super) fn depth(&self) -> f64 {
        self.depth
    }

    /// All of it, for shaders.
    #[cfg(feature = "wgsl")]
    pub(super) fn bounds(&self) -> [f32; 3] {
        [self.shifted, self.behind, self.depth].map(|bound| bound as f32)
    }

    /// Whether it is no more than `most`.
    pub(super) fn within(&self, most: &Self) -> bool {
        self.shifted <= most.shifted && self.behind <= most.behind && self.depth <= most.depth
    }
}

/// A node, and where it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) node: Node,
    /// Optical depth since the start of the segment.
    pub(super) depth: f32,
    /// `f`.
    pub(super) share: f32,
    /// `a² + b²`.
    pub(super) squares: f32,
}

impl Piece {
    /// The piece from `start` to `end` of a side, whose unit is `unit` metres, and its span.
    pub(super) fn new(side: &Side, start: f64, end: f64, unit: f64) -> (Self, Span) {
        let width = end - start;
        let (b, b_end) = (side.b(start), side.b(end));
        let fades = side.fades(start);
        let alpha = if fades {
            // base + o is proportional to b, and works on the axis as well, where b is 0.
            ((side.base + start) / (side.base + end)).sqrt()
        } else {
            ((b + side.finest) / (b_end + side.finest)).sqrt()
        };
        // The position is s = (t − h²/t) / 2, and both terms are elementary in o on every side.
        let half = 0.5 * unit / side.scale;
        let squares = [side.unit * side.unit, side.a * side.a];
        let (way, offset) = match side.kind {
            Kind::Front => ([half * squares[0], half], [start, width]),
            Kind::Behind => ([half, half * squares[1]], [start, width]),
            Kind::Thin => ([half * squares[0], half], [side.extent - start, -width]),
        };
        let single = |pair: [f64; 2]| pair.map(|value| value as f32);
        let piece = Self {
            alpha: alpha as f32,
            a: side.a as f32,
            reversed: side.kind == Kind::Thin,
            b: single([b, side.unit * width]),
            depth: single([side.depth + side.rate * start, side.rate * width]),
            offset: single(offset),
            rest: single([side.base + start, width]),
            way: [(unit * side.offset) as f32, way[0] as f32, way[1] as f32],
            scale: (2.0 * side.scale * width) as f32,
        };
        let mut span = Span::new(alpha, side.rate * width, side.kind);
        if fades {
            span.behind = Span::new(alpha, span.depth, Kind::Behind).behind;
        }
        (piece, span)
    }

    /// The node at `t`, with the weight per weight in `t`, in units of the
    /// segment, and the optical depth since its start.
    pub(super) fn at(&self, t: f32) -> (Node, f32) {
        let place = self.place(t);
        (place.node, place.depth)
    }

    /// The same, and where in the piece it is.
    pub(super) fn place(&self, t: f32) -> Place {
        let denominator = 1.0 - (1.0 - self.alpha) * t;
        let jacobian = self.alpha / (denominator * denominator);
        let f = self.alpha * t / denominator;
        let along = |[start, change]: [f32; 2]| start + change * f;
        let (a, b) = (self.a, along(self.b));
        let angle = if self.reversed {
            ScatteringAngle::from_half_tangent(a, b)
        } else {
            ScatteringAngle::from_half_tangent(b, a)
        };
        let way = along(self.offset) * (self.way[1] + self.way[2] / along(self.rest));
        let squares = a * a + b * b;
        Place {
            node: Node {
                distance: self.way[0] + way,
                weight: self.scale * jacobian / squares,
                angle,
            },
            depth: along(self.depth),
            share: f,
            squares,
        }
    }
}
