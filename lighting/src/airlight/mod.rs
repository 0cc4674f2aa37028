//! How much light arrives from a part of an eye ray.
//!
//! The airlight of the interval `[a, b]` of a ray, for one light, is
//!
//! ```text
//! L[a, b] = ∫_a^b σ_s p(cos θ) I exp(−σ_t (x + d)) / d² dx        (point light)
//! L[a, b] = ∫_a^b σ_s p(cos θ) E exp(−σ_t (x + l)) dx             (sun)
//! ```
//!
//! where `d` is the distance to the light and `l` the length that sunlight travels in the
//! medium; see [`LightPath`].

mod analytic;
mod cookie;
mod daylight;
mod directional;
mod equi_angular;
mod lamp;
mod midpoint;
mod per_frame;
mod quadrature;

pub use analytic::Analytic;
pub use daylight::{Daylight, DaylightError};
pub use directional::directional;
pub use equi_angular::EquiAngular;
pub use midpoint::Midpoint;
pub use per_frame::PerFrame;
pub use quadrature::Quadrature;

#[cfg(feature = "shadow-map")]
pub(crate) use directional::mean_exponential;
pub(crate) use midpoint::far_end;

use glam::Vec3;

use crate::{Interval, LightPath};

/// Integrates the light of an interval that is scattered towards the eye.
pub trait AirlightEvaluator: Sync {
    /// The radiance that reaches the eye from `interval`, if all of it is lit. The interval
    /// lies within `path.span()`. The result is never NaN; it is +∞ for an interval that
    /// contains a point light (see [`LightPath::off_the_light`]).
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3;

    /// Appends the radiance of each part to `radiances`. A part is the index of its path and an
    /// interval; all paths have the same light and medium. The results equal those of
    /// [`radiance`](AirlightEvaluator::radiance) to rounding, and take less time if there are
    /// many. A result does not depend on the other parts, bit for bit.
    fn radiances(
        &self,
        paths: &[LightPath<'_>],
        parts: &[(usize, Interval)],
        radiances: &mut Vec<Vec3>,
    ) {
        let each = |&(path, interval): &(usize, Interval)| self.radiance(&paths[path], interval);
        radiances.extend(parts.iter().map(each));
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use reference::random::Random;

    use super::*;
    use crate::scene::{Bounds, Cone, Emission, Medium, PhaseFunction, Texture};
    use crate::{Emitter, Ray};

    /// Lights of every kind, in fog that ends and fog that does not: parts together are
    /// what each is alone, and what stands beside one changes nothing.
    #[test]
    fn parts_together_are_parts_one_by_one() {
        let sigma = Vec3::new(0.1, 0.2, 0.3);
        let open = Medium::new(sigma, 0.1 * sigma, PhaseFunction::Rayleigh).unwrap();
        let bounds = Bounds::new(Vec3::new(-3.0, -1.0, -9.0), Vec3::new(2.0, 1.5, -1.0)).unwrap();
        let cone = Cone {
            inner: 0.2,
            outer: 0.7,
        };
        let point = |position: Vec3, emission| {
            Emitter::point(position, Vec3::new(1.0, 2.0, 3.0), 30.0, emission).unwrap()
        };
        let down = Quat::from_rotation_x(-1.4);
        let lights = [
            Emitter::directional(Vec3::new(0.2, -1.0, 0.1), Vec3::ONE).unwrap(),
            point(Vec3::new(0.2, 0.4, -4.0), Emission::Isotropic),
            point(Vec3::new(-4.0, 3.0, -3.0), Emission::Isotropic),
            point(
                Vec3::new(0.2, 1.0, -4.0),
                Emission::Cosine {
                    normal: Vec3::NEG_Y,
                },
            ),
            point(
                Vec3::new(0.2, 2.0, -4.0),
                Emission::spot(down, cone, None).unwrap(),
            ),
        ];
        let table = airlight::Table::new(&PhaseFunction::Rayleigh, 8).unwrap();
        let coarse = airlight::Quadrature::with_tolerance(PhaseFunction::Rayleigh, 1e-3).unwrap();
        for (light, medium) in
            (lights.iter()).flat_map(|light| [(light, open), (light, open.within(bounds))])
        {
            let rays = (0..21).map(|i| {
                let towards = Vec3::new(0.04 * i as f32 - 0.4, 0.1, -1.0);
                let length = if i % 3 == 0 { f32::INFINITY } else { 7.0 };
                Ray::new(Vec3::ZERO, towards, length).unwrap()
            });
            let paths: Vec<_> = rays
                .filter_map(|ray| LightPath::new(&ray, light, &medium))
                .collect();
            let mut parts = Vec::new();
            for (i, path) in paths.iter().enumerate() {
                let span = path.span();
                let middle = span.start + 0.4 * span.end.min(9.0);
                parts.push((i, Interval::new(span.start, middle)));
                parts.push((i, Interval::new(middle, middle)));
                parts.push((i, Interval::new(middle, span.end)));
            }
            fn check(
                airlight: &impl AirlightEvaluator,
                paths: &[LightPath<'_>],
                parts: &[(usize, Interval)],
            ) {
                let (mut found, mut again) = (vec![Vec3::ONE], Vec::new());
                airlight.radiances(paths, parts, &mut found);
                airlight.radiances(paths, &parts[1..], &mut again);
                assert_eq!(found[2..], again, "what stands beside a part");
                for (&(path, interval), found) in parts.iter().zip(&found[1..]) {
                    let alone = airlight.radiance(&paths[path], interval);
                    let error = (*found - alone).abs().max_element();
                    assert!(error <= 3e-6 * alone.max_element(), "{found} {alone}");
                }
            }
            check(&Midpoint, &paths, &parts);
            for nodes in [1, 4, 11] {
                check(&EquiAngular::new(nodes).unwrap(), &paths, &parts);
            }
            let fallback = Quadrature::with_tolerance(PhaseFunction::Rayleigh, 1e-4).unwrap();
            check(
                &Analytic::new(table.clone(), fallback.clone()),
                &paths,
                &parts,
            );
            check(
                &Analytic::new(coarse.clone(), fallback.clone()),
                &paths,
                &parts,
            );
            let of_eye = PerFrame::of_light(fallback, Vec3::ZERO, light, &medium, 64).unwrap();
            check(&of_eye, &paths, &parts);
        }
    }

    /// A white cookie changes nothing, also on parts of rays that begin beside the light, behind
    /// the apex of its cone. Fuzzing found one that took a billion steps.
    #[test]
    fn a_cookie_is_seen_in_front_of_its_light_alone() {
        let mut random = Random::new(7);
        let sigma = Vec3::splat(0.15);
        let medium = Medium::new(sigma, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let quadrature = Quadrature::with_tolerance(PhaseFunction::Isotropic, 1e-4).unwrap();
        let cone = Cone {
            inner: 0.0,
            outer: 0.7,
        };
        let white = Texture::new(2, 3, vec![Vec3::ONE; 6]).unwrap();
        let mut seen = 0;
        for i in 0..400 {
            let aside = 10.0_f32.powf(random.between(-5.0, 0.0));
            let position = Vec3::new(aside, 0.0, -3.765_395_6);
            let mut part = || random.between(-1.0, 1.0);
            let rotation = Quat::from_xyzw(part(), part(), part(), part()).normalize();
            let light = |cookie| {
                let emission = Emission::spot(rotation, cone, cookie).unwrap();
                Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).unwrap()
            };
            let lights = [light(None), light(Some(white.clone()))];
            let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, f32::INFINITY).unwrap();
            let paths = lights.each_ref();
            let paths = paths.map(|light| LightPath::new(&ray, light, &medium));
            let [Some(plain), Some(textured)] = paths else {
                continue;
            };
            let interval = match i % 3 {
                0 => plain.span(),
                1 => Interval::new(plain.foot(), f32::INFINITY),
                _ => Interval::new(0.0, plain.foot()),
            };
            let expected = quadrature.radiance(&plain, interval).x;
            let found = quadrature.radiance(&textured, interval).x;
            seen += u32::from(expected > 0.0);
            // Beyond the span there is a rim within a piece, which only counts as dark.
            let error = match i % 3 {
                0 => 2e-3,
                _ => 0.1,
            };
            assert!(
                (found - expected).abs() <= error * quadrature.radiance(&plain, plain.span()).x,
                "{found} for {expected}, {i}"
            );
        }
        assert!(seen > 100, "{seen}");
    }
}
