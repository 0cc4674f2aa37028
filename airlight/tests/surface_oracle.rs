//! The light that fog sends to surfaces, from the definition of single
//! scattering alone: no exponential integral, no ring, no closed form.

use std::f64::consts::PI;

use airlight::surface::exact::Lobe;

/// Midpoints of `count` equal parts of an interval, and their width.
fn midpoints(start: f64, end: f64, count: u32) -> impl Iterator<Item = (f64, f64)> {
    let width = (end - start) / f64::from(count);
    (0..count).map(move |i| (start + (f64::from(i) + 0.5) * width, width))
}

/// The airlight of an endless ray at angle γ to a lamp of unit intensity at the
/// distance `t`, for σ_t = σ_s = 1: `∫ e^{−(x + d)} / (4π d²) dx`, over x itself,
/// in steps that grow with the distance from the foot point.
fn airlight(t: f64, gamma: f64) -> f64 {
    let (foot, h) = (t * gamma.cos(), t * gamma.sin());
    // x = foot + h sinh y
    let start = (-foot / h).asinh();
    let end = ((60.0 + t) / h).asinh();
    midpoints(start, end, 4000)
        .map(|(y, dy)| {
            let s = h * y.sinh();
            let d2 = s * s + h * h;
            (-(foot + s) - d2.sqrt()).exp() / (4.0 * PI * d2) * h * y.cosh() * dy
        })
        .sum()
}

/// One ring of directions about the lamp.
struct Ray {
    gamma: f64,
    dgamma: f64,
    airlight: f64,
}

/// Rings from the lamp to its opposite.
fn rays(t: f64) -> Vec<Ray> {
    // γ = y²: the airlight has a logarithm at γ = 0.
    midpoints(0.0, PI.sqrt(), 2000)
        .map(|(y, dy)| Ray {
            gamma: y * y,
            dgamma: 2.0 * y * dy,
            airlight: airlight(t, y * y),
        })
        .collect()
}

/// `∫ max(0, r·ω)^n L(ω) dω` over directions about the lamp, and from it
/// `G_n = 2π T ∫`, since `L_a = σ_s σ_t I k / (2π T) · G_n`.
fn by_definition(n: f64, t: f64, theta: f64, rays: &[Ray]) -> f64 {
    let mut sum = 0.0;
    for ray in rays {
        let (sin, cos) = ray.gamma.sin_cos();
        let lobe: f64 = midpoints(0.0, 2.0 * PI, 500)
            .map(|(phi, dphi)| {
                let cos = cos * theta.cos() + sin * theta.sin() * phi.cos();
                if cos > 0.0 { cos.powf(n) * dphi } else { 0.0 }
            })
            .sum();
        sum += lobe * ray.airlight * sin * ray.dgamma;
    }
    2.0 * PI * t * sum
}

#[test]
fn quadrature_agrees_with_the_definition_of_single_scattering() {
    for t in [0.02, 0.7, 6.0] {
        let rays = rays(t);
        for n in [1.0, 1.5, 8.0, 60.0] {
            let lobe = Lobe::new(n).unwrap();
            for theta in [0.0, 0.6, 1.5, 2.4, PI] {
                let expected = by_definition(n, t, theta, &rays);
                let error = lobe.value(t, theta) / expected - 1.0;
                // Midpoints: along a ray (2T + 1)² dy² / 24, 2e-5 at T = 6; in
                // γ n dγ² / 24, 3e-5 at n = 60, where a lobe is cut at γ = π; in φ
                // dφ² / 12 of the rings that a lobe's edge crosses, 1e-5.
                assert!(
                    error.abs() < 5e-5,
                    "n {n}, T {t}, theta {theta}: {error:e}, expected {expected}"
                );
            }
        }
    }
}

/// A linear lobe and its opposite differ by a cosine without a clamp, of which
/// only the part along the lamp's axis is left.
#[test]
fn front_and_back_differ_by_the_net_flux() {
    let lobe = Lobe::new(1.0).unwrap();
    for t in [0.3, 2.0] {
        let along: f64 = rays(t)
            .iter()
            .map(|ray| {
                let (sin, cos) = ray.gamma.sin_cos();
                ray.airlight * cos * 2.0 * PI * sin * ray.dgamma
            })
            .sum();
        for theta in [0.2_f64, 1.0] {
            let net = lobe.value(t, theta) - lobe.value(t, PI - theta);
            let expected = 2.0 * PI * t * along * theta.cos();
            assert!((net / expected - 1.0).abs() < 5e-5, "T {t}, theta {theta}");
        }
    }
}
