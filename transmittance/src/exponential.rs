//! The rules of curves whose nodes hold optical depths.

use wide::f32x4;

use crate::BlockerSegment;
use crate::lookup::{Exponential, INFLATE, ROUNDING, Rules, inverse_length};
use crate::node::Node;
use crate::numeric::{EXP_ERROR, Number, exp_neg, exp_neg_4, smaller};

impl Rules for Exponential {
    const CLEAR: f32 = 0.0;
    // exp(−128) is 3e-56, so that larger depths are all the same. Their roundings would make
    // bounds useless.
    const DARK: f32 = 128.0;

    #[cfg(feature = "wgsl")]
    const WGSL: [&'static str; 2] = [
        include_str!("gpu/exponential.wgsl"),
        include_str!("gpu/exponential_insert.wgsl"),
    ];

    #[inline]
    fn transmittance(value: f32) -> f32 {
        exp_neg(value)
    }

    #[inline(always)]
    fn transmittances(values: f32x4) -> f32x4 {
        exp_neg_4(values)
    }

    #[inline]
    fn value(transmittance: f32) -> f32 {
        0.0 - transmittance.ln()
    }

    #[inline(always)]
    fn first(a: f32, b: f32) -> f32 {
        smaller(a, b)
    }

    #[inline]
    fn attenuate<const C: usize>(nodes: &mut [Node<C>], after: usize, segment: &BlockerSegment<C>) {
        // Where no light is left, values stop growing before they overflow.
        const LARGEST: f32 = 1e38;
        let tau = segment.optical_depth();
        let inverse = inverse_length(segment);
        let (inside, behind) = nodes.split_at_mut(after);
        for node in inside.iter_mut().skip(1) {
            let fraction = (f64::from(node.depth) - f64::from(segment.entry())) * inverse;
            for (value, tau) in node.value.iter_mut().zip(tau) {
                // Rounding must not give a node more than those behind it get, or the curve
                // would rise.
                let sum = (f64::from(*value) + f64::from(tau) * fraction) as f32;
                *value = smaller(sum, *value + tau);
            }
        }
        for node in behind {
            for (value, tau) in node.value.iter_mut().zip(tau) {
                *value = smaller(*value + tau, LARGEST);
            }
        }
    }

    fn multiply<const C: usize>(nodes: &mut [Node<C>], other: &[Node<C>]) {
        for (node, other) in nodes.iter_mut().zip(other) {
            for c in 0..C {
                node.value[c] = (node.value[c] + other.value[c]).min(1e38);
                node.above[c] = (node.above[c] + other.above[c]) * INFLATE;
                node.below[c] = (node.below[c] + other.below[c]) * INFLATE;
            }
        }
    }

    #[inline(always)]
    fn area<T: Number>(widths: [T; 2], values: [T; 3], transmittances: [T; 3]) -> T {
        // The mean of an exponential over a stretch is (T₀ − T₁) / u with u = τ₁ − τ₀. For small
        // u, where the differences lose their digits, it is computed as the mean of the ends times
        // the series of tanh(u/2) / (u/2).
        let number = T::from;
        let mean = |a: usize, b: usize| {
            let u = values[b] - values[a];
            let u2 = u * u;
            let last = number(1.0 / 120.0) - u2 * number(17.0 / 20160.0);
            let series = number(1.0) - u2 * (number(1.0 / 12.0) - u2 * last);
            let mean = number(0.5) * (transmittances[a] + transmittances[b]);
            let quotient = (transmittances[a] - transmittances[b]) / u.larger(number(0.1));
            u.choose_above(0.5, quotient, mean * series)
        };
        let both = mean(0, 2);
        (widths[0] * (mean(0, 1) - both) + widths[1] * (mean(1, 2) - both)).abs()
    }

    #[inline]
    fn spread(transmittance: [f32; 2], below: f32, above: f32) -> f32 {
        let bound = transmittance[0] * (1.0 - exp_neg(below.max(above)));
        bound.min(transmittance[0] - transmittance[1])
    }

    fn range(value: f32, below: f64, above: f64, insertions: u32) -> [f64; 2] {
        let value = f64::from(value);
        let rounding = share_rounded(insertions) * value;
        let deepest = value + above + rounding;
        // The bounds are cut off at DARK: of a curve that is deeper only that is known.
        let least = if deepest < DARK {
            (-deepest).exp()
        } else {
            0.0
        };
        let shallowest = (value - rounding).min(DARK) - below;
        [least, (-shallowest.max(0.0)).exp()]
    }

    fn error(
        values: [f64; 2],
        below: f32,
        above: f32,
        ends: [[f64; 2]; 2],
        insertions: u32,
    ) -> f64 {
        let share = share_rounded(insertions);
        if share > 0.5 {
            return 1.0;
        }
        // The curve exp(−v) that exact arithmetic would have stored falls from
        // v = first to v = last.
        let (first, last) = (values[0] * (1.0 - share), values[1] * (1.0 + share));
        let below = f64::from(below);
        // The exact curve is at most `most`, what it is at the left end, and at
        // most exp(below − v), which is `reached` at v = first. The share
        // 1 − exp(−below) of the lesser is the most that it can exceed exp(−v).
        let most = ends[0][1];
        let reached = (below - first.min(DARK)).min(0.0).exp();
        let excess = most.min(reached) * -(-below).exp_m1();
        let mut up = excess.min(most - (-last.min(DARK)).exp());
        if last > DARK {
            // Where the curve is dark, `below` is measured from DARK.
            up = up.max(most.min((below - DARK).exp()));
        }
        // The exact curve is at least exp(−above − v) or dark, and at least what it is at
        // the right end.
        let falls_from = (-first).exp();
        let down = falls_from * -(-f64::from(above)).exp_m1() + (-DARK).exp();
        let down = down.min(falls_from - ends[1][0]);
        // The stored curve differs from this one by a share of the optical depth
        // at each depth: by at most share · τ e^(−τ (1 − share)), which is
        // largest where τ = 1 / (1 − share).
        let at = (1.0 / (1.0 - share)).max(values[0]).min(values[1]);
        let rounding = share * at * (-at * (1.0 - share)).exp();
        up.max(down).max(0.0) + rounding + EXP_ERROR * falls_from + f64::from(f32::MIN_POSITIVE)
    }
}

/// [`Rules::DARK`] in the arithmetic of bounds.
const DARK: f64 = Exponential::DARK as f64;

/// Share by which roundings can have changed an optical depth: each insertion
/// rounds a node once when it is made and once when the blocker is added to it,
/// by at most half an ULP of the final value.
fn share_rounded(insertions: u32) -> f64 {
    2.0 * f64::from(insertions) * ROUNDING
}
