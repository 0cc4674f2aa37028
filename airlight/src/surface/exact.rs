//! The light that fog sends to a surface, by quadrature in f64.

use std::f64::consts::{FRAC_PI_2, PI};

use super::ring::Ring;
use crate::Error;
use crate::gauss::Rule;
use crate::point_spread;
use crate::within::within;

/// Nodes of the rule on each panel.
const NODES: u32 = 16;

/// How far the two halves of a panel may be from the whole, relative to the
/// integral: what is left in the halves is smaller by far.
const TOLERANCE: f64 = 1e-12;

/// Halvings of a panel: the integrand is smooth enough for a few, and
/// rounding must not cause many.
const DEPTH: u32 = 8;

/// Beyond this optical distance all the light is within 1e-6 of the lamp's
/// direction or too faint for any purpose.
const FARTHEST: f64 = 1e6;

/// `G_n` of one cosine lobe, the truth behind [`super::LobeTable`].
///
/// ```text
/// G_n(T, θ) = ∫ max(0, r·ω)^n e^{−T cos γ} / sin γ [F(T sin γ, π/2) − F(T sin γ, γ/2)] dω
///           = e^{−T} ∫_0^π K(T, γ) C_n(γ, θ) dγ
/// ```
///
/// with θ the angle between the lobe's axis `r` and the light, and γ that
/// between ω and the light. `sin γ` cancels against the solid angle, `C_n` is
/// the lobe integrated over a ring about the light, and `K` that part of an
/// endless ray's airlight which is left when everything steep is taken out:
/// a bounded, smooth integral over one variable.
#[derive(Debug, Clone)]
pub struct Lobe {
    ring: Ring,
    rule: Rule,
}

impl Lobe {
    /// The lobe `max(0, cos)^exponent`. Exponent 1 about the normal is `G_0`,
    /// that of a Lambertian surface.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the exponent is from 1 to 200.
    pub fn new(exponent: f64) -> Result<Self, Error> {
        Ok(Self {
            ring: Ring::new(super::checked_exponent(exponent)?),
            rule: Rule::of(NODES),
        })
    }

    /// `G_n(T, θ)`, dimensionless, to a relative error of 1e-10 and at most
    /// 8.08, which is `G_1(0, 0) = 2π (π/4 + ½)`.
    ///
    /// `T` is from 0 to infinity, where it is 0; θ from 0 to π. Angles outside
    /// count as the nearer end, a negative T as 0, and NaN as 0. Exponents between
    /// 1 and 2 take up to ten times as long as others.
    pub fn value(&self, optical_distance: f64, theta: f64) -> f64 {
        let t = optical_distance.max(0.0);
        (-t).exp() * self.scaled(t, theta)
    }

    /// `e^T G_n(T, θ)`, which falls no faster than `1/T`. A `T` above 1e6 counts
    /// as 1e6.
    pub fn scaled(&self, optical_distance: f64, theta: f64) -> f64 {
        let t = within(optical_distance, 0.0, FARTHEST);
        let theta = within(theta, 0.0, PI);
        // γ = y³ takes the logarithm out of K at γ = 0.
        let integrand = |y: f64| {
            let gamma = y * y * y;
            3.0 * y * y * ring_light(t, gamma) * self.ring.value(gamma, theta)
        };
        let panels: Vec<(f64, f64, f64)> = self
            .cuts(t, theta)
            .windows(2)
            .map(|ends| {
                let (start, end) = (ends[0].cbrt(), ends[1].cbrt());
                (start, end, self.panel(&integrand, start, end))
            })
            .collect();
        let estimate: f64 = panels.iter().map(|panel| panel.2).sum();
        panels
            .iter()
            .map(|&(start, end, whole)| {
                self.refined(&integrand, start, end, whole, TOLERANCE * estimate, DEPTH)
            })
            .sum()
    }

    /// Angles γ between which the integrand is smooth and of one scale.
    fn cuts(&self, t: f64, theta: f64) -> Vec<f64> {
        let start = (theta - FRAC_PI_2).max(0.0);
        let end = (theta + FRAC_PI_2).min(PI);
        let kink = (FRAC_PI_2 - theta).abs();
        // A lobe is about 1/√n wide; K falls over 1/T.
        let width = 4.0 / self.ring.exponent().sqrt();
        let mut cuts = vec![
            start,
            end,
            kink,
            PI - kink,
            theta,
            theta - width,
            theta + width,
            0.03 / (1.0 + t),
            0.3 / (1.0 + t),
        ];
        cuts.retain(|cut| (start..=end).contains(cut));
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }

    fn panel(&self, integrand: &impl Fn(f64) -> f64, start: f64, end: f64) -> f64 {
        let length = end - start;
        let sum: f64 = self
            .rule
            .iter()
            .map(|(node, weight)| weight * integrand(start + length * node))
            .sum();
        length * sum
    }

    fn refined(
        &self,
        integrand: &impl Fn(f64) -> f64,
        start: f64,
        end: f64,
        whole: f64,
        tolerance: f64,
        depth: u32,
    ) -> f64 {
        let middle = 0.5 * (start + end);
        let left = self.panel(integrand, start, middle);
        let right = self.panel(integrand, middle, end);
        if (left + right - whole).abs() <= tolerance || depth == 0 {
            return left + right;
        }
        self.refined(integrand, start, middle, left, 0.5 * tolerance, depth - 1)
            + self.refined(integrand, middle, end, right, 0.5 * tolerance, depth - 1)
    }
}

/// `K(T, γ) = 2π sin γ N(γ)`, the light of a ring of directions at γ from the
/// light, per radian of γ and of azimuth; between 0 and `(π − γ)/2`.
pub(super) fn ring_light(t: f64, gamma: f64) -> f64 {
    // Closer than that it is π/2, less some T γ ln γ; N may overflow.
    if gamma > 1e-30 {
        2.0 * PI * gamma.sin() * point_spread::exact::value(t, gamma)
    } else {
        FRAC_PI_2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // At T = 0: 2π ∫_0^{π/2} ½(π − γ) cos^n γ dγ for θ = 0.
        let cases = [
            (1.0, 0.0, 2.0 * PI * (0.25 * PI + 0.5)),
            (2.0, 0.0, 2.0 * PI * (3.0 * PI * PI / 32.0 + 0.125)),
            (3.0, 0.0, 2.0 * PI * (PI / 6.0 + 7.0 / 18.0)),
            (1.0, PI, PI * (0.5 * PI - 1.0)),
        ];
        for (n, theta, expected) in cases {
            let error = Lobe::new(n).unwrap().value(0.0, theta) / expected - 1.0;
            assert!(error.abs() < 1e-12, "n {n}, theta {theta}: {error:e}");
        }
    }

    #[test]
    fn no_input_gives_nan_or_takes_long() {
        let odd = [
            f64::NAN,
            f64::INFINITY,
            f64::MAX,
            -1.0,
            0.0,
            1e-320,
            1e-20,
            1.0,
            1e4,
        ];
        let lobe = Lobe::new(1.5).unwrap();
        for t in odd {
            for theta in odd {
                assert!(lobe.value(t, theta) >= 0.0, "T {t}, theta {theta}");
                assert!(lobe.scaled(t, theta) >= 0.0, "T {t}, theta {theta}");
            }
        }
        assert_eq!(lobe.value(f64::INFINITY, 1.0), 0.0);
    }

    #[test]
    fn exponents_out_of_range_are_refused() {
        for n in [f64::NAN, 0.999, 201.0] {
            assert!(Lobe::new(n).is_err());
        }
    }
}
