//! The point-spread function in f64.

use std::f64::consts::{FRAC_PI_2, LN_2, PI};

use crate::exact::tail;
use crate::gauss::Rule;
use crate::within::within;

/// Optical distances below which the next term, of the order `T ln T`, is
/// lost in rounding.
const THIN: f64 = 1e-18;

/// Optical distance above which only the first term in 1/T counts.
const THICK: f64 = 1e100;

/// `N(γ)` in 1/sr at the optical distance `T` of the light, exact to a relative
/// error of 1e-12.
///
/// ```text
/// N = T / 2π ∫_0^∞ e^{−v} / (u² + (y + v)²) dv,    u = T sin γ,  y = T (1 − cos γ)
/// ```
///
/// Positive, falling with γ and with T: from +∞ at γ = 0, as `1/4γ`, to
/// `1/4π` at γ = π and T = 0, where it is `(π − γ) / (4π sin γ)`, and 0 at
/// T = ∞. A γ outside of [0, π] counts as the nearer end, T below 0 as 0, and
/// NaN as 0.
pub fn value(optical_distance: f64, gamma: f64) -> f64 {
    let t = optical_distance.max(0.0);
    let gamma = within(gamma, 0.0, PI);
    if gamma == 0.0 {
        return f64::INFINITY;
    }
    if t == f64::INFINITY {
        return 0.0;
    }
    let sine = gamma.sin();
    if t < THIN {
        // The sine knows π − γ better than f64 knows π.
        let rest = if gamma < FRAC_PI_2 {
            PI - gamma
        } else {
            sine.asin()
        };
        return rest / (4.0 * PI * sine);
    }
    let half = (0.5 * gamma).sin();
    if t > THICK {
        return 1.0 / (8.0 * PI * half * half) / t;
    }
    t * tail(2.0 * t * half * half, t * sine) / (2.0 * PI)
}

/// `∫ N dω` over the sphere, to a relative error of 1e-10: `π²/4` at T = 0,
/// falling to 0 like `ln T / T`. This is what the fog adds to an even
/// environment of unit radiance, per `T σ_s/σ_t e^{−T}`.
///
/// ```text
/// ∫ N dω = ∫_0^∞ e^{−r} / (T + r) · ln(1 + 2T/r) dr
/// ```
///
/// It follows from integrating over all of space in the two distances to the
/// light and to the eye.
pub fn total(optical_distance: f64) -> f64 {
    let t = optical_distance.max(0.0);
    if t == f64::INFINITY {
        return 0.0;
    }
    if t > THICK {
        /// Euler's constant.
        const EULER: f64 = 0.577_215_664_901_532_9;
        return (LN_2 + t.ln() + EULER) / t;
    }
    if t < THIN {
        return 0.25 * PI * PI;
    }
    if t == f64::INFINITY {
        return 0.0;
    }
    // With r = e^y the integrand is smooth and of one scale; it falls like r
    // below min(1, T) and stops at e^{-r}.
    let (start, end) = (t.min(1.0).ln() - 36.0, 3.7);
    let panels = ((end - start) / 2.0_f64).ceil();
    let width = (end - start) / panels;
    let rule = Rule::of(20);
    let mut sum = 0.0;
    for panel in 0..panels as u32 {
        for (node, weight) in rule.iter() {
            let r = (start + width * (f64::from(panel) + node)).exp();
            sum += width * weight * r * (-r).exp() / (t + r) * (2.0 * t / r).ln_1p();
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enormous_distances_continue_what_large_ones_begin() {
        for gamma in [1e-3, 1.0, PI] {
            let (near, far) = (value(0.99e100, gamma), value(1.01e100, gamma));
            assert!((near / far * (0.99 / 1.01) - 1.0).abs() < 1e-12);
            assert!(value(1e200, gamma) > 0.0);
        }
        let (near, far) = (0.99e100 * total(0.99e100), 1.01e100 * total(1.01e100));
        assert!((near / far - 1.0).abs() < 1e-3, "{near} {far}");
        assert!((far - near - f64::ln(1.01 / 0.99)).abs() < 1e-8);
        assert!(total(1e308) > 0.0 && total(f64::INFINITY) == 0.0);
    }

    /// By its definition, `[F(T sin γ, π/2) − F(T sin γ, γ/2)] / (2π sin γ e^{(cos γ − 1) T})`,
    /// with the large factor under the integral.
    fn by_definition(t: f64, gamma: f64) -> f64 {
        let steps = 200_000;
        let start = 0.5 * gamma;
        let step = (FRAC_PI_2 - start) / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|i| {
                let xi = start + (f64::from(i) + 0.5) * step;
                (t * ((1.0 - gamma.cos()) - gamma.sin() * xi.tan())).exp()
            })
            .sum();
        sum * step / (2.0 * PI * gamma.sin())
    }

    #[test]
    fn the_closed_form_is_the_definition() {
        for t in [0.0, 1e-6, 0.01, 0.3, 1.0, 4.0, 30.0, 104.0] {
            for gamma in [0.01, 0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.1] {
                let expected = by_definition(t, gamma);
                let error = value(t, gamma) / expected - 1.0;
                // Midpoints: the square of T/2 times the step.
                assert!(error.abs() < 1e-6, "T {t}, gamma {gamma}: {error:e}");
            }
        }
    }

    #[test]
    fn limits() {
        assert_eq!(value(1.0, 0.0), f64::INFINITY);
        assert_eq!(value(f64::INFINITY, 1.0), 0.0);
        assert!((value(0.0, PI) * 4.0 * PI - 0.5 * 2.0).abs() < 1e-12);
        for t in [0.0, 1.0, 100.0] {
            let gamma = 1e-9;
            assert!((value(t, gamma) * 4.0 * gamma - 1.0).abs() < 1e-5);
        }
        for gamma in [1e-8, 0.1, 2.0, PI - 1e-9, PI] {
            let ratio = value(2e-18, gamma) / value(0.5e-18, gamma);
            assert!((ratio - 1.0).abs() < 1e-13, "gamma {gamma}: {ratio}");
        }
        for (t, gamma) in [(f64::NAN, 1.0), (-1.0, 1.0), (1.0, 4.0), (1e300, 1e-300)] {
            let n = value(t, gamma);
            assert!(n >= 0.0, "T {t}, gamma {gamma}: {n}");
        }
    }

    #[test]
    fn it_falls_with_the_angle_and_with_the_distance() {
        for i in 0..60 {
            let t = 1e-4 * 1.3_f64.powi(i);
            for j in 1..100 {
                let gamma = PI * f64::from(j) / 100.0;
                let n = value(t, gamma);
                assert!(value(t, gamma - 0.01) > n && value(t / 1.3, gamma) > n);
            }
        }
    }

    #[test]
    fn the_total_is_the_integral_over_the_sphere() {
        for t in [0.0, 1e-12, 1e-3, 0.1, 1.0, 10.0, 104.0, 1e4] {
            // γ = e^y tames the logarithm at 0.
            let mut sum = 0.0;
            let (start, end) = (-46.0, PI.ln());
            let panels = 60;
            let width = (end - start) / f64::from(panels);
            let rule = Rule::of(16);
            for panel in 0..panels {
                for (node, weight) in rule.iter() {
                    let gamma = (start + width * (f64::from(panel) + node)).exp();
                    let ring = 2.0 * PI * gamma.sin();
                    sum += width * weight * gamma * ring * value(t, gamma);
                }
            }
            let error = total(t) / sum - 1.0;
            assert!(error.abs() < 1e-10, "T {t}: {error:e}");
        }
    }
}
