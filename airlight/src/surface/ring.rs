//! Cosine lobes, integrated over rings about the direction to the light.

use std::f64::consts::PI;

use crate::gauss::Rule;

/// The lobe `max(0, cos)^n` about some axis, `1 ≤ n ≤ 200`.
///
/// Both forms of [`Ring::value`] separate what depends on `n` alone, which is
/// kept, from what depends on the ring, which is then free of powers but for
/// one.
#[derive(Debug, Clone)]
pub(crate) struct Ring {
    exponent: f64,
    /// `sin² ψ` and `4 w cos^{2n+1} ψ` at the nodes ψ of a rule over [0, π/2].
    partial: Vec<(f64, f64)>,
    /// `2π binom(n, k)²` for k from 0.
    full: Vec<f64>,
}

impl Ring {
    pub(crate) fn new(exponent: f64) -> Self {
        // Beyond this angle cos^{2n+1} is below 2^-60.
        let power = 2.0 * exponent + 1.0;
        let end = (-60.0 * std::f64::consts::LN_2 / power).exp().acos();
        let partial = Rule::of(64)
            .iter()
            .map(|(node, weight)| {
                let (sin, cos) = (end * node).sin_cos();
                (sin * sin, 4.0 * end * weight * (power * cos.ln()).exp())
            })
            .collect();
        // The largest binomial is at n/2; its squares then fall off like a
        // Gaussian, and beyond n like k^{-2n-2}, exactly zero for whole n.
        let mut full = vec![2.0 * PI];
        let mut binomial = 1.0_f64;
        for k in 0..512 {
            let k = f64::from(k);
            binomial *= (exponent - k) / (k + 1.0);
            if binomial == 0.0 || (k > exponent && binomial * binomial < 1e-16) {
                break;
            }
            full.push(2.0 * PI * binomial * binomial);
        }
        Self {
            exponent,
            partial,
            full,
        }
    }

    pub(crate) fn exponent(&self) -> f64 {
        self.exponent
    }

    /// `∫_0^{2π} max(0, cos γ cos θ + sin γ sin θ cos φ)^n dφ`: the lobe over
    /// the ring at angle γ from the light, if the lobe's axis is at θ from it.
    pub(crate) fn value(&self, gamma: f64, theta: f64) -> f64 {
        // The largest and the smallest cosine on the ring.
        let largest = (gamma - theta).cos();
        let smallest = (gamma + theta).cos();
        if !(largest > 0.0) {
            return 0.0;
        }
        if smallest < 0.0 {
            // With sin(φ/2) = √m sin ψ, ψ from 0 to where the cosine is 0:
            // 4 largest^n √m ∫ cos^{2n+1} ψ / √(1 − m sin² ψ) dψ.
            let m = largest / (largest - smallest);
            let integral: f64 = self
                .partial
                .iter()
                .map(|&(sin2, weight)| weight / (1.0 - m * sin2).sqrt())
                .sum();
            (self.exponent * largest.ln()).exp() * m.sqrt() * integral
        } else {
            // a + b cos φ = A |1 + β e^{iφ}|², expanded and integrated:
            // 2π A^n Σ binom(n, k)² β^{2k}.
            let (p, q) = (largest.sqrt(), smallest.sqrt());
            let amplitude = 0.25 * (p + q) * (p + q);
            let beta2 = ((p - q) / (p + q)).powi(2);
            let sum = self.full.iter().rev().fold(0.0, |sum, c| sum * beta2 + c);
            (self.exponent * amplitude.ln()).exp() * sum
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, by the midpoint rule; it converges like steps^{-n-1}
    /// where the lobe ends on the ring.
    fn by_midpoints(n: f64, gamma: f64, theta: f64, steps: u32) -> f64 {
        let step = PI / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|i| {
                let phi = (f64::from(i) + 0.5) * step;
                let cos = gamma.cos() * theta.cos() + gamma.sin() * theta.sin() * phi.cos();
                cos.max(0.0).powf(n)
            })
            .sum();
        2.0 * step * sum
    }

    #[test]
    fn rings_agree_with_the_definition() {
        for n in [1.0, 1.3, 2.0, 2.5, 7.0, 33.3, 200.0] {
            let lobe = Ring::new(n);
            for i in 0..=24 {
                for j in 0..=24 {
                    let gamma = PI * f64::from(i) / 24.0;
                    let theta = PI * f64::from(j) / 24.0;
                    let expected = by_midpoints(n, gamma, theta, 20_000);
                    let value = lobe.value(gamma, theta);
                    assert!(
                        (value - expected).abs() < 2e-8 * 2.0 * PI,
                        "n {n}, gamma {gamma}, theta {theta}: {value}, expected {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_linear_lobe_has_the_elementary_ring() {
        let lobe = Ring::new(1.0);
        for i in 1..200 {
            for j in 1..200 {
                let gamma = PI * (f64::from(i) + 0.3) / 201.0;
                let theta = PI * f64::from(j) / 200.0;
                let a = gamma.cos() * theta.cos();
                let b = gamma.sin() * theta.sin();
                let expected = if a >= b {
                    2.0 * PI * a
                } else if a <= -b {
                    0.0
                } else {
                    2.0 * (a * (-a / b).acos() + (b * b - a * a).sqrt())
                };
                let value = lobe.value(gamma, theta);
                assert!((value - expected).abs() < 1e-12, "{value} {expected}");
            }
        }
    }
}
