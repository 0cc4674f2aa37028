//! What a surface in fog reflects of a lamp.

use std::f32::consts::PI;

use super::grid::Directions;
use super::{GlossTable, LobeTable, checked_exponent};
use crate::Error;
use crate::within::within;

/// A Lambertian part and a Phong lobe, in one colour channel: radiance
/// `k_d max(0, cos θ_s) + k_s max(0, cos θ'_s)^n` per irradiance on a plane that
/// faces the lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    diffuse: f32,
    glossy: f32,
    exponent: f32,
}

impl Material {
    /// `diffuse` is `k_d` in 1/sr, the albedo over π; `glossy` is `k_s` in 1/sr;
    /// `exponent` is `n`.
    ///
    /// # Errors
    /// [`Error::BadValue`] if one of the first two is not finite or below 0, or
    /// if the exponent is not from 1 to 200.
    pub fn new(diffuse: f32, glossy: f32, exponent: f32) -> Result<Self, Error> {
        for (what, value) in [("k_d", diffuse), ("k_s", glossy)] {
            if !(0.0..f32::INFINITY).contains(&value) {
                return Err(Error::bad_value(what, value, "a finite number, at least 0"));
            }
        }
        checked_exponent(exponent.into())?;
        Ok(Self {
            diffuse,
            glossy,
            exponent,
        })
    }
}

/// Where a lamp stands, as seen from a point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// To the lamp, in metres, at least 0.
    pub distance: f32,
    /// Cosine of the angle `θ_s` between the normal and the lamp.
    pub cos_normal: f32,
    /// Cosine of the angle `θ'_s` between the mirrored direction of view and
    /// the lamp.
    pub cos_mirror: f32,
}

/// Reflected radiance per radiant intensity of the lamp, in 1/m².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Radiance {
    /// Of the light that came straight from the lamp:
    /// `e^{−T} / D² · [k_d max(0, cos θ_s) + k_s max(0, cos θ'_s)^n]`, 0 if the
    /// lamp is behind the surface.
    pub direct: f32,
    /// Of the light that the fog scattered on its way:
    /// `σ_s / (2π D) · [k_d G_0 + k_s G_n]`, also if the lamp is behind the surface.
    pub scattered: f32,
}

/// Everything that surfaces of any exponent need: `G_0` and `G_n`, 455 KiB.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    lambertian: LobeTable,
    glossy: GlossTable,
}

impl Table {
    /// Both tables: a fraction of a second of quadrature.
    #[expect(
        clippy::new_without_default,
        reason = "nothing that takes so long is a default"
    )]
    pub fn new() -> Self {
        let directions = Directions::new();
        Self {
            lambertian: LobeTable::of(1.0, &directions),
            glossy: GlossTable::of(&directions),
        }
    }

    /// `G_0`.
    pub fn lambertian(&self) -> &LobeTable {
        &self.lambertian
    }

    /// `G_n`.
    pub fn glossy(&self) -> &GlossTable {
        &self.glossy
    }

    /// Reflected radiance in one colour channel, whose scattering is `sigma_s`
    /// and whose extinction is `sigma_t`, both in 1/m and at least 0.
    ///
    /// The scattered light has the relative error of the tables and a few
    /// roundings, and is stable for `σ_t → 0`, since `σ_s σ_t / T` is `σ_s / D`.
    /// At distance 0 what is reflected at all is +∞, at an infinite distance it
    /// is 0. Never NaN; numbers that are no lengths or no coefficients (NaN,
    /// negative) count as 0.
    pub fn radiance(
        &self,
        sigma_s: f32,
        sigma_t: f32,
        receiver: &Receiver,
        material: &Material,
    ) -> Radiance {
        let distance = receiver.distance.max(0.0);
        if distance == f32::INFINITY {
            return Radiance::default();
        }
        let t = within(sigma_t, 0.0, f32::MAX) * distance;
        let k = material;

        let (cos_normal, cos_mirror) = (receiver.cos_normal, receiver.cos_mirror);
        let mut lit = 0.0;
        if cos_normal > 0.0 {
            lit = k.diffuse * cos_normal.min(1.0);
            if cos_mirror > 0.0 {
                lit += k.glossy * cos_mirror.min(1.0).powf(k.exponent);
            }
        }
        let mut gathered = 0.0;
        if k.diffuse > 0.0 {
            gathered += k.diffuse * self.lambertian.value(t, cos_normal);
        }
        if k.glossy > 0.0 {
            gathered += k.glossy * self.glossy.value(k.exponent, t, cos_mirror);
        }
        Radiance {
            // Divided one by one: the square may leave the range of numbers.
            direct: quotient(quotient(lit * (-t).exp(), distance), distance),
            scattered: quotient(sigma_s.max(0.0) * gathered * (0.5 / PI), distance),
        }
    }
}

/// Nothing stays nothing, whatever it is divided by.
fn quotient(value: f32, divisor: f32) -> f32 {
    if value > 0.0 { value / divisor } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::exact;
    use super::*;

    #[test]
    fn parts_are_what_the_equation_says() {
        let table = Table::new();
        let material = Material::new(0.3, 0.7, 17.5).unwrap();
        let receiver = Receiver {
            distance: 4.0,
            cos_normal: 0.4,
            cos_mirror: 0.9,
        };
        let (sigma_s, sigma_t) = (0.2_f32, 0.5_f32);
        let light = table.radiance(sigma_s, sigma_t, &receiver, &material);
        let g = |n, cos: f32| {
            let lobe = exact::Lobe::new(n).unwrap();
            lobe.value(2.0, f64::from(cos).acos())
        };
        let scattered = 0.2 * 0.5 / (2.0 * std::f64::consts::PI * 2.0)
            * (0.3 * g(1.0, 0.4) + 0.7 * g(17.5, 0.9));
        let direct = (-2.0_f64).exp() / 16.0 * (0.3 * 0.4 + 0.7 * 0.9_f64.powf(17.5));
        assert!((f64::from(light.scattered) / scattered - 1.0).abs() < 1e-4);
        assert!((f64::from(light.direct) / direct - 1.0).abs() < 1e-5);
    }

    #[test]
    fn thin_fog_needs_no_extinction() {
        let table = Table::new();
        let material = Material::new(1.0, 0.5, 3.0).unwrap();
        let receiver = Receiver {
            distance: 2.0,
            cos_normal: -0.2,
            cos_mirror: 0.3,
        };
        let without = table.radiance(0.1, 0.0, &receiver, &material);
        let with = table.radiance(0.1, 1e-30, &receiver, &material);
        assert_eq!(without.direct, 0.0, "the lamp is behind");
        assert!(without.scattered > 0.0);
        assert!((with.scattered / without.scattered - 1.0).abs() < 1e-6);
    }

    #[test]
    fn no_input_gives_nan() {
        let table = Table::new();
        let materials = [
            Material::new(0.0, 0.0, 1.0).unwrap(),
            Material::new(f32::MAX, f32::MAX, 200.0).unwrap(),
            Material::new(0.5, 0.0, 5.0).unwrap(),
        ];
        let odd = [
            f32::NAN,
            f32::INFINITY,
            -1.0,
            0.0,
            1e-40,
            1e-30,
            1.0,
            1e30,
            f32::MAX,
        ];
        for material in &materials {
            for sigma_s in odd {
                for sigma_t in odd {
                    for distance in odd {
                        for cos in [f32::NAN, -1.0, 0.0, 1.0, 7.0] {
                            let receiver = Receiver {
                                distance,
                                cos_normal: cos,
                                cos_mirror: cos,
                            };
                            let light = table.radiance(sigma_s, sigma_t, &receiver, material);
                            assert!(
                                light.direct >= 0.0 && light.scattered >= 0.0,
                                "{sigma_s} {sigma_t} {receiver:?} {material:?}: {light:?}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn materials_that_are_none_are_refused() {
        for (diffuse, glossy, n, what) in [
            (-1.0, 0.0, 1.0, "k_d"),
            (f32::NAN, 0.0, 1.0, "k_d"),
            (0.0, f32::INFINITY, 1.0, "k_s"),
            (0.0, 0.0, 0.5, "exponent"),
        ] {
            let error = Material::new(diffuse, glossy, n).unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
        }
    }
}
