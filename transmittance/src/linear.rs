//! The rules of curves whose nodes hold transmittances.

use wide::f32x4;

use crate::BlockerSegment;
use crate::lookup::{INFLATE, Linear, ROUNDING, Rules, inverse_length};
use crate::node::Node;
use crate::numeric::{EXP_ERROR, Number, exp_neg, larger, smaller};

impl Rules for Linear {
    const CLEAR: f32 = 1.0;
    const DARK: f32 = f32::INFINITY;

    #[cfg(feature = "wgsl")]
    const WGSL: [&'static str; 2] = [
        include_str!("gpu/linear.wgsl"),
        include_str!("gpu/linear_insert.wgsl"),
    ];

    #[inline]
    fn transmittance(value: f32) -> f32 {
        value
    }

    #[inline(always)]
    fn transmittances(values: f32x4) -> f32x4 {
        values
    }

    #[inline]
    fn value(transmittance: f32) -> f32 {
        transmittance
    }

    #[inline(always)]
    fn first(a: f32, b: f32) -> f32 {
        larger(a, b)
    }

    #[inline]
    fn attenuate<const C: usize>(nodes: &mut [Node<C>], after: usize, segment: &BlockerSegment<C>) {
        let inverse = inverse_length(segment);
        let (inside, behind) = nodes.split_at_mut(after);
        for c in 0..C {
            let tau = segment.optical_depth()[c];
            let passed = exp_neg(tau);
            let lost = 1.0 - f64::from(passed);
            // The chord of the segment's exponential is above it by at most this.
            let sag = if segment.exit() > segment.entry() {
                sag(tau, passed)
            } else {
                0.0
            };
            // The old value and the segment's factor at the end of a stretch.
            let mut here = (inside[0].value[c], 1.0_f32);
            for index in 0..after {
                let next = match inside.get(index + 1) {
                    Some(node) => {
                        let way = f64::from(node.depth) - f64::from(segment.entry());
                        let factor = (1.0 - lost * (way * inverse)) as f32;
                        (node.value[c], larger(factor, passed))
                    }
                    None => (behind[0].value[c], passed),
                };
                // The exact factor lies up to `sag` below its chord, and the
                // product of two chords below the chord of the product by at
                // most a quarter of what both lose.
                let bend = 0.25 * (here.0 - next.0) * (here.1 - next.1);
                let node = &mut inside[index];
                node.value[c] = here.0 * here.1;
                node.above[c] *= here.1 * INFLATE;
                node.below[c] = (node.below[c] * here.1 + here.0 * sag + bend) * INFLATE;
                here = next;
            }
            for node in &mut *behind {
                node.value[c] *= passed;
                node.above[c] *= passed * INFLATE;
                node.below[c] *= passed * INFLATE;
            }
        }
    }

    fn multiply<const C: usize>(nodes: &mut [Node<C>], other: &[Node<C>]) {
        for index in 0..nodes.len() {
            let next = (index + 1).min(nodes.len() - 1);
            for c in 0..C {
                let (a, b) = (nodes[index], &other[index]);
                let lost = [
                    a.value[c] - nodes[next].value[c],
                    b.value[c] - other[next].value[c],
                ];
                let cross = |x: f32, y: f32| a.value[c] * y + b.value[c] * x;
                let above = cross(a.above[c], b.above[c])
                    + (a.above[c] * b.above[c]).max(a.below[c] * b.below[c]);
                let below = cross(a.below[c], b.below[c])
                    + (a.above[c] * b.below[c]).max(a.below[c] * b.above[c])
                    + 0.25 * lost[0] * lost[1];
                nodes[index].above[c] = above * INFLATE;
                nodes[index].below[c] = below * INFLATE;
            }
        }
        for (node, other) in nodes.iter_mut().zip(other) {
            for c in 0..C {
                node.value[c] *= other.value[c];
            }
        }
    }

    #[inline(always)]
    fn area<T: Number>(widths: [T; 2], values: [T; 3], _: [T; 3]) -> T {
        // The triangle of the three.
        let front = widths[0] * (values[1] - values[2]);
        T::from(0.5) * (front - widths[1] * (values[0] - values[1])).abs()
    }

    #[inline]
    fn spread(transmittance: [f32; 2], below: f32, above: f32) -> f32 {
        let all = transmittance[0] - transmittance[1];
        below.max(above).min(all.max(0.0) + below.min(above))
    }

    fn range(value: f32, below: f64, above: f64, insertions: u32) -> [f64; 2] {
        let value = f64::from(value);
        let rounding = roundings(value, insertions);
        let least = (value - below - rounding).max(0.0);
        let most = (value + above + rounding).min(1.0);
        [least, most]
    }

    fn error(
        values: [f64; 2],
        below: f32,
        above: f32,
        ends: [[f64; 2]; 2],
        insertions: u32,
    ) -> f64 {
        let rounding = roundings(values[0], insertions);
        let [first, last] = values;
        let up = (f64::from(above) + rounding).min(ends[0][1] - last);
        let down = (f64::from(below) + rounding).min(first - ends[1][0]);
        up.max(down).max(0.0) + ROUNDING
    }
}

/// The largest rounding error of a transmittance after `insertions`: each rounds a node once when
/// it is made, once when it is multiplied, and the factor is as exact as the exponential
/// function.
fn roundings(value: f64, insertions: u32) -> f64 {
    let each = 2.0 * ROUNDING + EXP_ERROR;
    f64::from(insertions) * each * value + f64::from(f32::MIN_POSITIVE)
}

/// An upper bound of the distance between `exp(−τ f)`, 0 ≤ f ≤ 1, and its
/// chord, at most 1.4 times that.
#[inline]
fn sag(tau: f32, passed: f32) -> f32 {
    // The distance is a concave function of f. At the middle it is
    // (1 − √T)² / 2, and the tangent there rises by at most half its slope.
    let middle = passed.sqrt();
    let slope = (1.0 - passed) - tau * middle;
    // For a small optical depth the slope is a difference of near equals.
    let curved = (1.0 - middle) * (1.0 - middle) + slope.abs();
    0.5 * smaller(curved, 0.25 * tau * tau) + 2e-7
}
