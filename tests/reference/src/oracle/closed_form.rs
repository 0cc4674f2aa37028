//! Airlight of a point light in isotropic, unbounded fog, without quadrature.
//!
//! ```text
//! L[a, b] = σ_s I / (2π h) · (e^{−σ_t (x_a + d_a)} Im E(z_a) − e^{−σ_t (x_b + d_b)} Im E(z_b))
//! E(z) = e^z E₁(z),   z = σ_t ((s + d) − i h)
//! ```
//!
//! Equivalent to the form of Sun, Ramamoorthi, Narasimhan, Nayar: A practical
//! analytic single scattering model for real time rendering, SIGGRAPH 2005,
//! without its growing factors. The difference cancels for short parts and for
//! parts that end in front of the light near the axis; it checks the
//! quadrature elsewhere.

use std::f64::consts::PI;

/// Airlight per unit of intensity from the part between `start` and `end`
/// (which may be infinite) of a line that passes the light at the distance
/// `h > 0`, with the foot point at distance `foot` from the eye; one channel.
///
/// For `sigma_t = 0`, absorption and out-scattering are neglected.
pub fn isotropic(sigma_s: f64, sigma_t: f64, foot: f64, h: f64, start: f64, end: f64) -> f64 {
    if sigma_t == 0.0 {
        let eta = |x: f64| ((x - foot) / h).atan();
        return sigma_s * (eta(end) - eta(start)) / (4.0 * PI * h);
    }
    let term = |x: f64| {
        if x.is_infinite() {
            return 0.0;
        }
        let s = x - foot;
        let d = s.hypot(h);
        let sum = if s < 0.0 { h * h / (d - s) } else { s + d };
        (-sigma_t * (x + d)).exp() * scaled_e1([sigma_t * sum, -sigma_t * h])[1]
    };
    sigma_s / (2.0 * PI * h) * (term(start) - term(end))
}

/// `e^z E₁(z)` for `Re z ≥ 0 > Im z`, as real and imaginary part; relative
/// error of the modulus about 1e-13.
///
/// The power series up to |z| = 3, beyond it the continued fraction
/// `1/(z + 1 − 1/(z + 3 − 4/(z + 5 − 9/(z + 7 − …))))`, evaluated by Lentz's
/// method (Abramowitz and Stegun 5.1.11, 5.1.22).
pub fn scaled_e1(z: [f64; 2]) -> [f64; 2] {
    let modulus = z[0].hypot(z[1]);
    if modulus <= 3.0 {
        // E₁(z) = −γ − ln z − Σ (−z)ⁿ / (n n!)
        const EULER: f64 = 0.577_215_664_901_532_9;
        let mut sum = [-EULER - modulus.ln(), -z[1].atan2(z[0])];
        let mut power = [1.0, 0.0];
        for n in 1..80 {
            let n = f64::from(n);
            power = multiply(power, [-z[0] / n, -z[1] / n]);
            sum = [sum[0] - power[0] / n, sum[1] - power[1] / n];
        }
        let scale = z[0].exp();
        return multiply([scale * z[1].cos(), scale * z[1].sin()], sum);
    }
    let mut b = [z[0] + 1.0, z[1]];
    let mut c = [f64::MAX.sqrt(), 0.0];
    let mut d = inverse(b);
    let mut fraction = d;
    for n in 1..2000 {
        let a = -f64::from(n) * f64::from(n);
        b[0] += 2.0;
        d = inverse([a * d[0] + b[0], a * d[1] + b[1]]);
        let inverse_c = inverse(c);
        c = [b[0] + a * inverse_c[0], b[1] + a * inverse_c[1]];
        let factor = multiply(c, d);
        fraction = multiply(fraction, factor);
        if (factor[0] - 1.0).abs() + factor[1].abs() < 1e-16 {
            break;
        }
    }
    fraction
}

fn multiply(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn inverse(a: [f64; 2]) -> [f64; 2] {
    let norm = a[0] * a[0] + a[1] * a[1];
    [a[0] / norm, -a[1] / norm]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `E₁(z) e^z = ∫_0^∞ e^{−t} / (z + t) dt` by brute force.
    fn by_integration(z: [f64; 2]) -> [f64; 2] {
        let (steps, top) = (400_000, 40.0);
        let h = top / f64::from(steps);
        let mut sum = [0.0; 2];
        for i in 0..steps {
            let t = h * (f64::from(i) + 0.5);
            let term = inverse([z[0] + t, z[1]]);
            let weight = h * (-t).exp();
            sum = [sum[0] + weight * term[0], sum[1] + weight * term[1]];
        }
        sum
    }

    #[test]
    fn the_scaled_exponential_integral_equals_its_defining_integral() {
        for z in [
            [0.1, -0.3],
            [0.0, -2.9],
            [0.0, -3.1],
            [2.0, -2.0],
            [2.3, -2.0],
            [3.1, -1e-3],
            [40.0, -7.0],
        ] {
            let (value, expected) = (scaled_e1(z), by_integration(z));
            for part in 0..2 {
                let error = (value[part] - expected[part]).abs();
                assert!(error < 1e-8, "{z:?}: {value:?} {expected:?}");
            }
        }
    }

    #[test]
    fn series_and_continued_fraction_meet() {
        for angle in [0.01, 0.5, 1.0, 1.5, std::f64::consts::FRAC_PI_2] {
            let at = |r: f64| scaled_e1([r * f64::cos(angle), -r * f64::sin(angle)]);
            let (below, above) = (at(3.0), at(3.0 + 1e-12));
            for part in 0..2 {
                assert!(
                    (below[part] - above[part]).abs() < 1e-11,
                    "{angle}: {below:?} {above:?}"
                );
            }
        }
    }
}
