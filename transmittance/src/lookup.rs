//! What a node holds and how the curve runs between two of them.

use std::fmt::Debug;

use crate::Segment;
use crate::exponential::{EXP_ERROR, exp_neg};
use crate::node::{Node, larger, smaller};

/// How a curve runs between its nodes: [`Linear`] or [`Exponential`].
pub trait Lookup: Rules {}

/// Nodes hold transmittances, and transmittance is interpolated linearly: the
/// paper's first choice.
///
/// The product of two such curves is not one: each blocker that overlaps others
/// adds to the error, in an order-dependent way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Linear;

/// Nodes hold optical depths, which are interpolated linearly, so that
/// transmittance runs exponentially: the paper's second choice.
///
/// This is what a homogeneous blocker does. Sums of optical depths are exact,
/// so that only the removal of nodes costs accuracy; and where the paper's
/// transmittance of 0 makes everything in front of an opaque node black, up to
/// the node before it, an optical depth remembers what was there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exponential;

impl Lookup for Linear {}
impl Lookup for Exponential {}

/// Half a unit in the last place of a number of size 1: the relative error of
/// one rounding to f32.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Makes up for the roundings of a bound's own arithmetic in f32.
const INFLATE: f32 = 1.000_001;

/// The algebra behind [`Lookup`].
pub trait Rules: Debug + Clone + Copy + Default + PartialEq + Send + Sync + 'static {
    /// Value where nothing is in the way.
    const CLEAR: f32;

    /// Values from here on are all as good as the end of the light; infinite if
    /// no value is.
    const DARK: f32;

    /// The same rules for shaders: of lookups, and of insertions.
    #[cfg(feature = "wgpu")]
    const WGSL: [&'static str; 2];

    /// Transmittance of a value.
    fn transmittance(value: f32) -> f32;

    /// Value of a transmittance that is greater than 0.
    fn value(transmittance: f32) -> f32;

    /// Multiplies the curve by a segment. The first node is at its entry, the
    /// node `after` is at its exit.
    fn attenuate<const C: usize>(nodes: &mut [Node<C>], after: usize, segment: &Segment<C>);

    /// Multiplies a curve by another that has its nodes at the same depths.
    fn multiply<const C: usize>(nodes: &mut [Node<C>], other: &[Node<C>]);

    /// Area between the curve through three nodes and the curve through the
    /// outer two, from the lengths of the two stretches, and the values and the
    /// transmittances of the nodes.
    fn area(widths: [f32; 2], values: [f32; 3], transmittances: [f32; 3]) -> f32;

    /// Transmittances that the exact curve cannot leave on a stretch where it
    /// is within `below` and `above` of a value, as an error of transmittance.
    /// For choosing, not for certifying: nothing is rounded up.
    fn spread(transmittance: [f32; 2], below: f32, above: f32) -> f32;

    /// Bounds of the exact transmittance at a node of value `value` whose exact
    /// value is at most `below` less and `above` more, after `insertions`.
    fn range(value: f32, below: f64, above: f64, insertions: u32) -> [f64; 2];

    /// The largest error of the transmittance on a stretch. `values` are those
    /// that are interpolated at its two ends, `ends` the exact transmittances
    /// there as [`Rules::range`] gives them.
    fn error(values: [f64; 2], below: f32, above: f32, ends: [[f64; 2]; 2], insertions: u32)
    -> f64;
}

impl Rules for Exponential {
    const CLEAR: f32 = 0.0;
    // exp(−128) is 3e-56. Larger depths have coarser roundings.
    const DARK: f32 = 128.0;

    #[cfg(feature = "wgpu")]
    const WGSL: [&'static str; 2] = [
        include_str!("gpu/exponential.wgsl"),
        include_str!("gpu/exponential_insert.wgsl"),
    ];

    #[inline]
    fn transmittance(value: f32) -> f32 {
        exp_neg(value)
    }

    #[inline]
    fn value(transmittance: f32) -> f32 {
        0.0 - transmittance.ln()
    }

    #[inline]
    fn attenuate<const C: usize>(nodes: &mut [Node<C>], after: usize, segment: &Segment<C>) {
        // Where light has long gone, values stop growing before they overflow.
        const LARGEST: f32 = 1e38;
        let tau = segment.optical_depth();
        let inverse = inverse_length(segment);
        let (inside, behind) = nodes.split_at_mut(after);
        for node in inside.iter_mut().skip(1) {
            let fraction = (f64::from(node.depth) - f64::from(segment.entry())) * inverse;
            for (value, tau) in node.value.iter_mut().zip(tau) {
                // The last step could round beyond what a node behind gets.
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

    #[inline]
    fn area(widths: [f32; 2], values: [f32; 3], transmittances: [f32; 3]) -> f32 {
        // Mean of an exponential: (T₀ − T₁) / (τ₁ − τ₀), and its series where
        // that loses its digits, the mean of the ends times tanh(u/2) / (u/2).
        let mean = |a: usize, b: usize| {
            let u = values[b] - values[a];
            let u2 = u * u;
            let series = 1.0 - u2 * (1.0 / 12.0 - u2 * (1.0 / 120.0 - u2 * (17.0 / 20160.0)));
            let mean = 0.5 * (transmittances[a] + transmittances[b]);
            let quotient = (transmittances[a] - transmittances[b]) / larger(u, 0.1);
            if u > 0.5 { quotient } else { mean * series }
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
        // Beyond the dark nothing is known of the exact optical depth.
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
            // From there on `below` is the distance from the dark.
            up = up.max(most.min((below - DARK).exp()));
        }
        // It is at least exp(−above − v) or dark, and at least what it is at the
        // right end.
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

impl Rules for Linear {
    const CLEAR: f32 = 1.0;
    const DARK: f32 = f32::INFINITY;

    #[cfg(feature = "wgpu")]
    const WGSL: [&'static str; 2] = [
        include_str!("gpu/linear.wgsl"),
        include_str!("gpu/linear_insert.wgsl"),
    ];

    #[inline]
    fn transmittance(value: f32) -> f32 {
        value
    }

    #[inline]
    fn value(transmittance: f32) -> f32 {
        transmittance
    }

    #[inline]
    fn attenuate<const C: usize>(nodes: &mut [Node<C>], after: usize, segment: &Segment<C>) {
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

    #[inline]
    fn area(widths: [f32; 2], values: [f32; 3], _: [f32; 3]) -> f32 {
        // The triangle of the three.
        0.5 * (widths[0] * (values[1] - values[2]) - widths[1] * (values[0] - values[1])).abs()
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

/// What the roundings of `insertions` can have done to a transmittance: each
/// rounds a node once when it is made, once when it is multiplied, and the
/// factor is as exact as the exponential function.
fn roundings(value: f64, insertions: u32) -> f64 {
    let each = 2.0 * ROUNDING + EXP_ERROR;
    f64::from(insertions) * each * value + f64::from(f32::MIN_POSITIVE)
}

/// One over the length of a segment. In f64 neither can overflow; for a surface,
/// which has no inside, the result is of no use.
#[inline]
fn inverse_length<const C: usize>(segment: &Segment<C>) -> f64 {
    (f64::from(segment.exit()) - f64::from(segment.entry())).recip()
}

/// An upper bound of the distance between `exp(−τ f)`, 0 ≤ f ≤ 1, and its
/// chord, at most 1.4 times that.
#[inline]
fn sag(tau: f32, passed: f32) -> f32 {
    // The distance is a concave function of f. At the middle it is
    // (1 − √T)² / 2, and the tangent there rises by at most half its slope.
    let middle = passed.sqrt();
    let slope = (1.0 - passed) - tau * middle;
    // A small optical depth makes the slope a difference of near equals.
    let curved = (1.0 - middle) * (1.0 - middle) + slope.abs();
    0.5 * smaller(curved, 0.25 * tau * tau) + 2e-7
}
