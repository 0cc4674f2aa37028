//! The integrand of the airlight at several positions at once.

use wide::f32x4;

use super::LightPath;
use crate::scene::{Emission, PhaseFunction, PointEmitter, ScatteringAngle};

/// How many positions there are.
pub(crate) const LANES: usize = 4;

/// A number for each position.
pub(crate) type Lanes = f32x4;

/// The sine of angles from 0 to π/2, relative error 2e-7: its series, of which
/// x¹⁵/15! < 7e-10 is left out.
pub(super) fn sine(x: Lanes) -> Lanes {
    let z = x * x;
    let p = 1.0 / 362_880.0 - z * (1.0 / 39_916_800.0 - z * (1.0 / 6_227_020_800.0));
    let p = 1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z * p));
    x - x * z * p
}

/// What `f` is in each lane: for what has no vector instructions.
fn lane_by_lane<const N: usize>(values: [Lanes; N], f: impl Fn([f32; N]) -> f32) -> Lanes {
    let values = values.map(Lanes::to_array);
    Lanes::new(std::array::from_fn(|i| f(values.map(|lanes| lanes[i]))))
}

impl LightPath<'_> {
    /// [`LightPath::source`] of a point light at several positions, by channel; the
    /// same to 1e-6.
    pub(crate) fn sources(&self, point: &PointEmitter, x: Lanes) -> [Lanes; 3] {
        let s = x - self.foot;
        let d = (s * s + self.h * self.h).sqrt();
        let phase = match self.medium.phase() {
            phase @ PhaseFunction::Isotropic => phase.value(ScatteringAngle::from_cos(0.0)).into(),
            phase => lane_by_lane([s], |[s]| {
                phase.value(ScatteringAngle::from_foot(s, self.h))
            }),
        };
        let leg = if self.is_immersed() {
            d
        } else {
            lane_by_lane([x, d], |[x, d]| {
                let to_light = -self.from_light(x - self.foot).0;
                self.medium.length_inside(self.ray.at(x), to_light, d)
            })
        };
        let window = if point.fades() {
            lane_by_lane([d], |[d]| point.window_inside(d))
        } else {
            Lanes::ONE
        };
        let way = (x - self.entry) + leg;
        let (sigma_t, sigma_s) = (self.medium.sigma_t(), self.medium.sigma_s());
        let transmittance = |sigma: f32| (-sigma * way).exp();
        let mut through = transmittance(sigma_t.x);
        let mut light = self.intensities(point, s, d);
        for (channel, light) in light.iter_mut().enumerate() {
            // Grey media are common and an exponential is most of the work.
            if channel > 0 && sigma_t[channel] != sigma_t[channel - 1] {
                through = transmittance(sigma_t[channel]);
            }
            *light *= sigma_s[channel] * (phase * window) * through;
        }
        light
    }

    /// The intensities of a point light, by channel, towards positions behind the foot
    /// point at distances from the light.
    fn intensities(&self, point: &PointEmitter, s: Lanes, d: Lanes) -> [Lanes; 3] {
        let intensity = point.intensity().to_array().map(Lanes::from);
        match point.emission() {
            Emission::Isotropic => intensity,
            Emission::Cosine { normal } => {
                let along = normal.dot(self.ray.direction());
                let across = normal.dot(self.to_foot) * self.h;
                let cos = ((s * along + across) / d).fast_max(Lanes::ZERO);
                intensity.map(|channel| channel * cos)
            }
            Emission::Spot(_) => {
                let factors = s
                    .to_array()
                    .map(|s| point.emission().factor(self.from_light(s).0));
                std::array::from_fn(|channel| {
                    intensity[channel] * Lanes::new(factors.map(|factor| factor[channel]))
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};

    use super::*;
    use crate::Ray;
    use crate::path::Arc;
    use crate::scene::{Bounds, Cone, Medium};

    #[test]
    fn sines_keep_their_digits() {
        for i in 0..10_000 {
            let x = std::f32::consts::FRAC_PI_2 * (i as f32 + 0.5) / 1e4;
            let (found, truth) = (sine(x.into()).to_array()[0], f64::from(x).sin());
            assert!(
                (f64::from(found) / truth - 1.0).abs() < 2e-7,
                "{x}: {found}"
            );
        }
    }

    /// Lights of every kind, in every kind of medium: four positions at once are what
    /// each is alone.
    #[test]
    fn positions_at_once_are_positions_one_by_one() {
        let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -6.0), Vec3::new(2.0, 1.5, -1.0)).unwrap();
        let sigma = [Vec3::new(0.1, 0.1, 0.4), Vec3::splat(3.0)];
        let phases = [
            PhaseFunction::Isotropic,
            PhaseFunction::HenyeyGreenstein { g: 0.7 },
            PhaseFunction::Rayleigh,
        ];
        let emissions = [
            Emission::Isotropic,
            Emission::Cosine {
                normal: Vec3::NEG_Y,
            },
            Emission::spot(
                Quat::from_rotation_x(-1.2),
                Cone {
                    inner: 0.3,
                    outer: 0.9,
                },
                None,
            )
            .unwrap(),
        ];
        let mut compared = 0;
        for (sigma, phase, emission) in sigma
            .into_iter()
            .flat_map(|sigma| phases.map(|phase| (sigma, phase)))
            .flat_map(|(sigma, phase)| emissions.clone().map(|emission| (sigma, phase, emission)))
        {
            let open = Medium::new(sigma, 0.1 * sigma, phase).unwrap();
            for (medium, range) in [(open, f32::INFINITY), (open.within(bounds), 7.0)] {
                let position = Vec3::new(0.3, 2.0, -3.5);
                let lamp = crate::Emitter::point(
                    position,
                    Vec3::new(1.0, 2.0, 3.0),
                    range,
                    emission.clone(),
                )
                .unwrap();
                for i in 0..40 {
                    let towards = Vec3::new(0.05 * i as f32 - 1.0, 0.1, -2.0);
                    let length = if i % 5 == 0 { f32::INFINITY } else { 8.0 };
                    let ray = Ray::new(Vec3::ZERO, towards, length).unwrap();
                    let Some(path) = LightPath::new(&ray, &lamp, &medium) else {
                        continue;
                    };
                    let crate::Emitter::Point(point) = &lamp else {
                        continue;
                    };
                    let Some(arc) = Arc::new(&path, path.span()) else {
                        continue;
                    };
                    let t = Lanes::new([0.07, 0.33, 0.5, 0.93]);
                    let x = arc.positions(t).to_array();
                    for (x, t) in x.into_iter().zip(t.to_array()) {
                        let alone = arc.position(t);
                        let d = path.from_light(alone - path.foot()).1;
                        assert!((x - alone).abs() <= 1e-6 * (x + d), "{t}: {x} {alone}");
                    }
                    let found = path.sources(point, x.into());
                    for (lane, x) in x.into_iter().enumerate() {
                        let alone = path.source(x);
                        for (channel, found) in found.iter().enumerate() {
                            let (found, alone) = (found.to_array()[lane], alone[channel]);
                            assert!(
                                (found - alone).abs() <= 2e-6 * alone + 1e-36,
                                "{found} {alone}"
                            );
                            compared += usize::from(alone > 0.0);
                        }
                    }
                }
            }
        }
        assert!(compared > 5000, "{compared}");
    }
}
