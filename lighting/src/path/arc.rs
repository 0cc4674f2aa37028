//! The equi-angular variable: an interval of a ray as an arc seen from a light.

use std::f32::consts::PI;

use glam::DVec2;

use crate::{Interval, LightPath};

/// An interval of a path as an arc seen from a point light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arc {
    interval: Interval,
    /// Distances of both ends from the light.
    d_a: f32,
    d_b: f32,
    /// The angle Δη between the ends, seen from the light.
    angle: f32,
    /// π − Δη. Where the ray nearly meets the light Δη is close to π, and an f32 of it has lost
    /// the digits that its sine depends on.
    supplement: f32,
}

impl Arc {
    /// `None` if the interval is empty.
    pub(crate) fn new(path: &LightPath<'_>, interval: Interval) -> Option<Self> {
        if !(interval.start < interval.end) {
            return None;
        }
        let h = path.h();
        let s_a = interval.start - path.foot();
        let d_a = s_a.hypot(h);
        // The tangent of Δη is across / along. For an infinite end, both are divided by the
        // distance of the end.
        let (across, along, d_b) = if interval.end == f32::INFINITY {
            (h, s_a, f32::INFINITY)
        } else {
            let s_b = interval.end - path.foot();
            (h * (s_b - s_a), h * h + s_a * s_b, s_b.hypot(h))
        };
        // Of the angle and its supplement, the smaller one has all its digits.
        let smaller = across.atan2(along.abs());
        let (angle, supplement) = if along >= 0.0 {
            (smaller, PI - smaller)
        } else {
            (PI - smaller, smaller)
        };
        Some(Self {
            interval,
            d_a,
            d_b,
            angle,
            supplement,
        })
    }
}

/// Positions at equal steps of the angle, without a sine for each. The direction from the light
/// is rotated by the same small angle each time. In f64, the drift of thousands of rotations
/// does not reach the digits of an f32.
#[derive(Debug, Clone)]
pub(crate) struct Turns {
    arc: Arc,
    /// Cosine and sine of the whole angle, of one step, and of the steps so far.
    whole: DVec2,
    step: DVec2,
    turned: DVec2,
}

impl Turns {
    /// Divides the arc into `steps` equal steps, at least 1.
    pub(crate) fn new(arc: Arc, steps: f64) -> Self {
        let (whole, step, turned) = if arc.angle > 1e-3 {
            let angle = if arc.supplement < 1.0 {
                std::f64::consts::PI - f64::from(arc.supplement)
            } else {
                f64::from(arc.angle)
            };
            let turn = DVec2::from_angle;
            (turn(angle), turn(angle / steps), DVec2::X)
        } else {
            // The sine of so small an angle is the angle, which may be 0.
            let shear = |angle| DVec2::new(1.0, angle);
            (shear(1.0), shear(1.0 / steps), shear(0.0))
        };
        Self {
            arc,
            whole,
            step,
            turned,
        }
    }

    /// The distance from the eye at the end of the next step.
    pub(crate) fn advance(&mut self) -> f32 {
        self.turned = if self.arc.angle > 1e-3 {
            self.step.rotate(self.turned)
        } else {
            DVec2::new(1.0, self.turned.y + self.step.y)
        };
        // Sines of the angles to the end and from the start.
        let from_a = self.whole.y * self.turned.x - self.whole.x * self.turned.y;
        let from_b = self.turned.y;
        let Interval { start, end } = self.arc.interval;
        let d_a = f64::from(self.arc.d_a);
        if self.arc.d_b == f32::INFINITY {
            return start + (d_a * (from_b / from_a)) as f32;
        }
        let weight_a = from_a * f64::from(self.arc.d_b);
        let weight_b = from_b * d_a;
        let share = (weight_b / (weight_a + weight_b)) as f32;
        (start + (end - start) * share).clamp(start, end)
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use glam::Vec3;

    use super::*;
    use crate::scene::{Emission, Medium, PhaseFunction};
    use crate::{Emitter, Ray};

    impl Arc {
        /// The distance from the eye at the fraction `t` in (0, 1) of the angle.
        pub(crate) fn position(&self, t: f32) -> f32 {
            let Interval { start, end } = self.interval;
            // sin((1−t)Δη) and sin(tΔη), or their ratio's limit for Δη → 0.
            // In the middle they are equal: the bisector needs no sines.
            let (from_a, from_b) = if self.angle > 1e-3 && t != 0.5 {
                (self.sine(1.0 - t, t), self.sine(t, 1.0 - t))
            } else {
                (1.0 - t, t)
            };
            if self.d_b == f32::INFINITY {
                start + self.d_a * (from_b / from_a)
            } else {
                let weight_a = from_a * self.d_b;
                let weight_b = from_b * self.d_a;
                (start + (end - start) * (weight_b / (weight_a + weight_b))).clamp(start, end)
            }
        }

        /// `sin(part Δη)`; `part` and `rest` add up to 1.
        fn sine(&self, part: f32, rest: f32) -> f32 {
            let angle = part * self.angle;
            if angle > FRAC_PI_2 {
                (self.supplement + rest * self.angle).sin()
            } else {
                angle.sin()
            }
        }
    }

    #[test]
    fn turning_step_by_step_ends_where_sines_say() {
        let fog = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        for length in [1e-3, 3.0, 20.0, f32::INFINITY] {
            for light in [
                Vec3::new(0.0, 1.0, -5.0),
                Vec3::new(0.0, 1e-3, -5.0),
                Vec3::new(0.0, 1e-4, 5.0),
                Vec3::new(0.0, 0.0, 5.0),
                Vec3::new(300.0, 0.0, -1.0),
            ] {
                let lamp = Emitter::point(light, Vec3::ONE, f32::INFINITY, Emission::Isotropic);
                let lamp = lamp.unwrap();
                let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, length).unwrap();
                let path = LightPath::new(&ray, &lamp, &fog).unwrap().off_the_light();
                let arc = Arc::new(&path, path.span()).unwrap();
                for steps in [1_u32, 7, 4096] {
                    let mut turns = Turns::new(arc, f64::from(steps));
                    for i in 1..steps {
                        let x = turns.advance();
                        let expected = arc.position(i as f32 / steps as f32);
                        // The fraction and the sines are rounded, and the sine
                        // to an infinite end is small.
                        let distance = expected + arc.d_a;
                        let tolerance =
                            4.0 * f32::EPSILON * distance * (distance / path.h().max(0.1)).max(1.0);
                        assert!(
                            (x - expected).abs() <= tolerance.max(1e-6 * length.min(1.0)),
                            "{length} {light} {i}/{steps}: {x} {expected}"
                        );
                    }
                }
            }
        }
    }
}
