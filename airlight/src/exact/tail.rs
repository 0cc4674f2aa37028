//! The scaled complex exponential integral, of which the airlight of an
//! isotropic medium consists.

use std::f64::consts::FRAC_PI_2;

/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;

/// `R(y, u) = ∫_0^∞ e^{−v} / (u² + (y + v)²) dv = −Im(e^z E₁(z)) / u` at
/// `z = y − iu`, for `y, u ≥ 0`: positive and falling in both, `+∞` at
/// `y = u = 0`.
///
/// Relative error below 3e-14. Both ways of computing it carry the
/// imaginary part divided by `u`, so that `u = 0` is an ordinary value.
pub fn tail(y: f64, u: f64) -> f64 {
    let modulus = y.hypot(u);
    // The series loses digits as its terms, like e^|z| / |z|, outgrow the
    // result, like e^{−y} / |z|²; the fraction needs ever more steps near 0.
    if modulus + y < 4.0 {
        series(y, u, modulus)
    } else {
        fraction(y, u, modulus)
    }
}

/// `E₁(z) = −γ − ln z − Σ (−z)^k / (k k!)`.
fn series(y: f64, u: f64, modulus: f64) -> f64 {
    if modulus == 0.0 {
        return f64::INFINITY;
    }
    // −arg z / u
    let angle = if u == 0.0 {
        1.0 / y
    } else if y == 0.0 {
        FRAC_PI_2 / u
    } else {
        u.atan2(y) / u
    };
    let mut real = -EULER - modulus.ln();
    let mut imaginary = angle;
    // (−z)^k / k! = a + i u b
    let (mut a, mut b) = (1.0, 0.0);
    for k in 1..60 {
        let k = f64::from(k);
        (a, b) = (-(y * a + u * u * b) / k, (a - y * b) / k);
        real -= a / k;
        imaginary -= b / k;
        if (a.abs() + b.abs()) < 1e-18 * k {
            break;
        }
    }
    let sinc = if u == 0.0 { 1.0 } else { u.sin() / u };
    y.exp() * (imaginary * u.cos() - real * sinc)
}

/// The even part of Stieltjes' continued fraction,
/// `e^z E₁(z) = 1 / (z + 1 − 1² / (z + 3 − 2² / (z + 5 − …)))`.
///
/// From the inside out every denominator has an imaginary part of the same
/// sign, so that it is a sum without cancellation.
fn fraction(y: f64, u: f64, modulus: f64) -> f64 {
    // The error after n steps falls like exp(−4 √n Re √z), with (Re √z)² = (|z| + y) / 2. So
    // many steps bring it to 1e-17, and a few more are for safety.
    let steps = (4.0 + 192.0 / (modulus + y)) as u32;
    let mut real = y + f64::from(2 * steps + 1);
    // The imaginary part divided by −u.
    let mut imaginary = 1.0;
    let mut k = f64::from(steps);
    for _ in 0..steps {
        let factor = k * k / (real * real + u * u * imaginary * imaginary);
        real = y + (2.0 * k - 1.0) - factor * real;
        imaginary = 1.0 + factor * imaginary;
        k -= 1.0;
    }
    // Divided first: the square of a large modulus may overflow.
    let size = real.hypot(u * imaginary);
    imaginary / size / size
}
