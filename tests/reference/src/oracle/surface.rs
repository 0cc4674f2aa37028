//! Light that reaches a surface by way of the fog, and an environment behind fog.
//!
//! Both are integrals over directions of what arrives from them, by nested adaptive
//! quadrature: of the oracle's own airlight for lamps, and of the definition for
//! environments. Directions are counted in polar coordinates about the lamp, or about
//! the direction of view, where the airlight grows like `1/sin γ` and `dω` makes up
//! for it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use scene::{Emitter, Medium};

use super::airlight::{Airlight, reach};
use super::quadrature::{Estimate, Piece, Tolerance, integrate};
use super::{Fog, Lamp, Line};

/// `∫ max(0, n·ω) L_a(ω) dω` with the airlight `L_a` of the endless rays that start at
/// `position`, nothing in the way: the irradiance, by light that was scattered once, of a
/// surface with the unit `normal`.
///
/// The error is within some 10 times `tolerance` of the result, or of 1e-2 of what the
/// lamp itself sends if that is more.
pub fn scattered_irradiance(
    position: glam::Vec3,
    normal: glam::Vec3,
    emitter: &Emitter,
    medium: &Medium,
    tolerance: f64,
) -> DVec3 {
    let (start, normal) = (position.as_dvec3(), normal.as_dvec3().normalize());
    let (fog, lamp) = (Fog::new(medium), Lamp::new(emitter));
    // `scale` is light that was scattered over the length 1/σ_t, or over the distance.
    let (pole, scale) = match &lamp {
        Lamp::Sun(sun) => (sun.toward, sun.irradiance),
        Lamp::Point(point) => {
            let offset = point.position - start;
            let distance = offset.length();
            let through = (-fog.sigma_t * distance).exp();
            let scale = fog.sigma_s * point.intensity * through / distance;
            (offset / distance, scale)
        }
    };
    let within = Tolerance {
        relative: tolerance,
        absolute: 1e-2 * tolerance * scale.max_element(),
    };
    let (u, v) = pole.any_orthonormal_pair();
    around(within, |psi| {
        let side = u * psi.cos() + v * psi.sin();
        polar(normal, pole, side, within, |direction| {
            let line = Line {
                origin: start,
                direction,
                length: f64::INFINITY,
            };
            let Some(part) = reach(&line, &lamp, &fog) else {
                return DVec3::ZERO;
            };
            let mut airlight = Airlight::new(&line, &fog);
            airlight.add(&lamp, &[part]);
            airlight.total(within).value
        })
    })
}

/// What an eye in fog sees in `direction` of an environment that is `distance` away in
/// all directions, in one channel: `e^{−T} L`, and the airlight of all that lies around
/// it, each `dω` of it a lamp of the intensity `L D² dω`.
pub fn environment_in_fog(
    (sigma_s, sigma_t): (f64, f64),
    distance: f64,
    direction: DVec3,
    tolerance: f64,
    radiance: impl Fn(DVec3) -> f64,
) -> f64 {
    let within = Tolerance::relative(tolerance);
    let (u, v) = direction.any_orthonormal_pair();
    let halo = around(within, |psi| {
        let side = u * psi.cos() + v * psi.sin();
        let f = |_: usize, gamma: f64| {
            let from = direction * gamma.cos() + side * gamma.sin();
            DVec3::splat(radiance(from) * endless(sigma_t, distance, gamma, within))
        };
        let mut pieces = vec![
            Piece::new(0, 0.0, FRAC_PI_2, &f),
            Piece::new(0, FRAC_PI_2, PI, &f),
        ];
        integrate(&mut pieces, within, f).value
    });
    let clear = (-sigma_t * distance).exp() * radiance(direction);
    clear + sigma_s / (4.0 * PI) * distance * halo.x
}

/// `∫ e^{−σ_t (x + d)} dη` along an endless ray at the angle γ from a lamp at the distance
/// `D`: `x = D cos γ + h tan η`, `d = h / cos η`, `h = D sin γ`.
fn endless(sigma_t: f64, distance: f64, gamma: f64, within: Tolerance) -> f64 {
    let (foot, h) = (distance * gamma.cos(), distance * gamma.sin());
    let f = |_: usize, eta: f64| {
        let x = foot + h * eta.tan();
        DVec3::splat((-sigma_t * (x + h / eta.cos())).exp())
    };
    let start = gamma - FRAC_PI_2;
    let middle = 0.5 * (start + FRAC_PI_2);
    let mut pieces = vec![
        Piece::new(0, start, middle, &f),
        Piece::new(0, middle, FRAC_PI_2, &f),
    ];
    integrate(&mut pieces, within, f).value.x
}

/// `∫_0^{2π} f dψ`.
fn around(within: Tolerance, f: impl Fn(f64) -> DVec3) -> DVec3 {
    let f = |_: usize, psi: f64| f(psi);
    let mut pieces: Vec<Piece> = (0..4)
        .map(|i| 0.25 * TAU * f64::from(i))
        .map(|start| Piece::new(0, start, start + 0.25 * TAU, &f))
        .collect();
    let Estimate { value, .. } = integrate(&mut pieces, within, f);
    value
}

/// `∫ max(0, n·ω) L(ω) sin γ dγ` over the half circle from `pole` by way of `side`.
fn polar(
    normal: DVec3,
    pole: DVec3,
    side: DVec3,
    within: Tolerance,
    radiance: impl Fn(DVec3) -> DVec3,
) -> DVec3 {
    let (a, b) = (normal.dot(pole), normal.dot(side));
    let f = |_: usize, gamma: f64| {
        let direction = pole * gamma.cos() + side * gamma.sin();
        let cos = a * gamma.cos() + b * gamma.sin();
        if cos <= 0.0 {
            return DVec3::ZERO;
        }
        cos * gamma.sin() * radiance(direction)
    };
    // The surface ends where a cos γ + b sin γ = 0.
    let horizon = (-a).atan2(b).rem_euclid(PI);
    let mut pieces: Vec<Piece> = [0.0, 0.5 * horizon, horizon, 0.5 * (horizon + PI), PI]
        .windows(2)
        .filter(|ends| ends[0] < ends[1])
        .map(|ends| Piece::new(0, ends[0], ends[1], &f))
        .collect();
    integrate(&mut pieces, within, f).value
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use scene::{Emission, PhaseFunction};

    use super::*;

    #[test]
    fn the_published_values_of_thin_fog_come_out() {
        // σ_s I / (2π D) G_0(0, θ).
        let thin = Medium::new(Vec3::splat(1e-9), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let lamp =
            Emitter::point(Vec3::Y * 2.0, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        for (normal, g) in [
            (Vec3::Y, TAU * (0.25 * PI + 0.5)),
            (Vec3::NEG_Y, PI * (FRAC_PI_2 - 1.0)),
        ] {
            let light = scattered_irradiance(Vec3::ZERO, normal, &lamp, &thin, 1e-7);
            let found = light.x * 2.0 * PI * 2.0 / 1e-9;
            // D/σ_t ln of it is missing: 1e-9 × 20.
            assert!((found / g - 1.0).abs() < 1e-6, "{found} {g}");
        }
    }

    #[test]
    fn suns_send_a_quarter_of_the_albedo() {
        let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let sun = Emitter::directional(Vec3::new(0.4, -1.0, 0.1), Vec3::ONE).unwrap();
        for normal in [Vec3::Y, Vec3::X, Vec3::NEG_Y] {
            let light = scattered_irradiance(Vec3::ZERO, normal, &sun, &fog, 1e-6);
            assert!((light.x - 0.25).abs() < 1e-6, "{light}");
        }
    }

    #[test]
    fn thin_fog_scatters_a_quarter_of_pi_squared_of_an_even_environment() {
        let t = 1e-6;
        let seen = environment_in_fog((t, t), 1.0, DVec3::Y, 1e-8, |_| 1.0);
        let halo = (seen - (-t).exp()) / t;
        // T ln T of it is missing.
        assert!((halo / (0.25 * PI * PI) - 1.0).abs() < 1e-4, "{halo}");
    }
}
