//! The function that is tabulated, in double precision.

use crate::gauss::Rule;
use crate::{Phase, ScatteringAngle};

/// `v (1 + v) ∫_y^∞ p(cos θ) e^{−(y'−y)} / (u² + y'²) dy'` for `v = max(u, y)`,
/// where `tan(θ/2) = y'/u`.
///
/// The factors make it a slowly varying function: for isotropic scattering it
/// is between 0.5 and 1.6 times p.
#[derive(Debug)]
pub(super) struct Tail<'a, P> {
    phase: &'a P,
    /// The finest detail of the phase function, as a ratio of u and y'.
    narrow: f64,
    rule: Rule,
}

impl<'a, P: Phase> Tail<'a, P> {
    pub(super) fn new(phase: &'a P) -> Self {
        let [forward, backward] = phase.peaks();
        Self {
            phase,
            narrow: forward.min(backward).clamp(1e-6, 1.0),
            rule: Rule::of(10),
        }
    }

    /// The phase function itself.
    pub(super) fn phase_function(&self) -> &P {
        self.phase
    }

    /// p where `tan(θ/2) = w/h`.
    pub(super) fn phase_at(&self, w: f64, h: f64) -> f64 {
        self.phase
            .value_f64(ScatteringAngle::from_half_tangent(w, h))
    }

    /// p at `b` on a side of the foot point.
    pub(super) fn phase(&self, b: f64, behind: bool) -> f64 {
        let (u, y) = if behind { (b, 1.0) } else { (1.0, b) };
        self.phase_at(y, u)
    }

    /// The integral at `v` and `b`, on a side of the foot point.
    ///
    /// In units of v, with panels that grow with the distance from the start
    /// as the poles of the integrand recede, but for the exponential: two
    /// e-foldings a panel.
    pub(super) fn value(&self, v: f64, b: f64, behind: bool) -> f64 {
        let (u, y) = if behind { (b, 1.0) } else { (1.0, b) };
        // For smaller v the exponential does not matter.
        let v = v.max(1e-12);
        // The exponential is 1e-17 there.
        let end = 40.0 / v;
        let longest = 2.0 / v;
        let (mut from, mut width) = (0.0, (0.5 * self.narrow).min(longest));
        let mut sum = 0.0;
        while from < end {
            for (node, weight) in self.rule.iter() {
                let t = from + node * width;
                let y = y + t;
                let p = self.phase_at(y, u);
                sum += weight * width * (-v * t).exp() * p / (u * u + y * y);
            }
            from += width;
            width = from.min(longest);
        }
        sum * (1.0 + v)
    }
}
