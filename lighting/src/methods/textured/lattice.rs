//! The positions of the steps along a ray.

use glam::{DVec2, DVec3};

use crate::path::axis_of;
use crate::{Emitter, Interval, LightPath};

/// The surfaces on which the ends of steps lie; see the [module](super).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Placement {
    /// Cones around the line through eye and light, with their apex at the light, so that steps
    /// are equal angles there. For parallel light, which has no such angle, the same as
    /// [`Placement::Span`].
    #[default]
    Angle,
    /// Ellipsoids around the eye with the proportions of a beam that is `reach` metres long. On
    /// each ray steps have the same length, which follows from the angle between ray and axis.
    Length {
        /// Length of the beam, m. Numbers that are not above 0, and NaN, count as 0, which
        /// gives the shortest possible steps.
        reach: f32,
    },
    /// No surfaces that neighbouring rays share: each ray divides its own part of the beam into
    /// equal lengths.
    Span,
}

/// How rays are divided into steps, for one light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Steps {
    pub(super) placement: Placement,
    /// Steps across the beam.
    pub(super) count: u32,
    /// The angle of a step at the light.
    pub(super) turn: f64,
    /// Axis of a spotlight.
    pub(super) axis: DVec3,
    /// 1 / (4 sin² of the half angle of the beam) minus 1: how much more a length across the
    /// beam counts than one along it.
    pub(super) stretch: f64,
}

/// Angles are not divided below this, because an `f32` has no more digits.
const LEAST_TURN: f64 = 1e-6;

/// The largest number of steps across the beam: shaders number them by an `f32`, which counts
/// to 2²⁴.
pub(super) const MOST_STEPS: u32 = 1 << 20;

/// A ray that passes the light at less than this share of the light's distance from the eye, or
/// at less than this many metres, counts as one through the light. It is slightly more than the
/// distance that [`LightPath::off_the_light`] leaves.
pub(super) const THROUGH: f64 = 1.001e-4;
pub(super) const AT_THE_LIGHT: f64 = 1.001e-12;

/// Steps are no shorter than this share of the distance from the eye. However short the reach,
/// rays take no more than the inverse of this times as many steps as fit across the beam.
pub(super) const LEAST_STEP: f64 = 1e-6;
pub(super) const MOST_BEAMS: f64 = 4.0;

impl Steps {
    /// Steps of which `count` fit across the beam of a light; 0 counts as 1, and more than
    /// [`MOST_STEPS`] as these.
    pub(super) fn new(light: &Emitter, count: u32, placement: Placement) -> Self {
        let count = count.clamp(1, MOST_STEPS);
        let placement = match placement {
            // `max` turns NaN into 0.
            Placement::Length { reach } => Placement::Length {
                reach: if reach > 0.0 {
                    reach.min(f32::MAX)
                } else {
                    0.0
                },
            },
            other => other,
        };
        let (half, axis, stretch) = match light.spot() {
            Some(spot) => {
                let versine = f64::from(spot.outer_versine());
                let sine2 = versine * (2.0 - versine);
                let half = 2.0 * (0.5 * versine).sqrt().asin();
                (half, axis_of(spot), 0.25 / sine2 - 1.0)
            }
            None => (std::f64::consts::FRAC_PI_2, DVec3::Z, 0.0),
        };
        Self {
            placement,
            count,
            turn: (2.0 * half / f64::from(count)).max(LEAST_TURN),
            axis,
            stretch,
        }
    }

    /// The steps of a ray that lie within `part`.
    pub(super) fn of_path(&self, path: &LightPath<'_>, part: Interval) -> Lattice {
        let count = f64::from(self.count);
        let length = f64::from(part.end) - f64::from(part.start);
        match (self.placement, path.emitter()) {
            (Placement::Angle, Emitter::Point(_)) => {
                let (foot, h) = (f64::from(path.foot()), f64::from(path.h()));
                if h <= (THROUGH * foot.hypot(h)).max(AT_THE_LIGHT) {
                    return Lattice::Through { foot };
                }
                Lattice::Turns {
                    foot,
                    h,
                    eye: DVec2::new(h, -foot).normalize(),
                    turn: self.turn,
                }
            }
            (Placement::Length { reach }, _) => {
                let along = path.ray().direction().as_dvec3().normalize().dot(self.axis);
                let stretch = 1.0 + self.stretch * (1.0 - along * along).max(0.0);
                let step = f64::from(reach) / (count * stretch.sqrt());
                let least = (LEAST_STEP * f64::from(part.end)).max(length / (MOST_BEAMS * count));
                Lattice::Equal {
                    from: 0.0,
                    step: step.max(least),
                }
            }
            (Placement::Angle | Placement::Span, _) => Lattice::Equal {
                from: part.start.into(),
                step: length / count,
            },
        }
    }
}

/// Numbered positions along a ray.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lattice {
    /// At equal angles at a light, counted from the eye.
    Turns {
        foot: f64,
        h: f64,
        /// The direction from the light to the eye, in components towards the foot point and
        /// along the ray.
        eye: DVec2,
        turn: f64,
    },
    /// At the light alone: all points of a ray through the light are at one of two angles.
    Through { foot: f64 },
    /// At equal distances.
    Equal { from: f64, step: f64 },
}

impl Lattice {
    /// Whether the ray runs through the light.
    pub(super) fn is_through_the_light(&self) -> bool {
        matches!(self, Self::Through { .. })
    }

    /// The index of the last position that is not behind the distance `x`, to rounding.
    fn number(&self, x: f32) -> f64 {
        let x = f64::from(x);
        let number = match *self {
            Self::Turns { foot, h, turn, .. } => {
                // This is the angle between the directions to the eye and to x, without a
                // difference of two angles.
                (h * x).atan2(h * h - foot * (x - foot)) / turn
            }
            Self::Through { foot } => f64::from(u8::from(x >= foot)),
            Self::Equal { from, step } => (x - from) / step,
        };
        number.floor().max(0.0)
    }

    /// The positions behind a distance, in order.
    pub(super) fn behind(&self, x: f32) -> Marks {
        let number = self.number(x);
        let (turned, turn) = match *self {
            Self::Turns { turn, .. } => (DVec2::from_angle(number * turn), DVec2::from_angle(turn)),
            Self::Through { .. } | Self::Equal { .. } => (DVec2::X, DVec2::X),
        };
        Marks {
            lattice: *self,
            number,
            turned,
            turn,
        }
    }

    /// The middle of a step or of a part of it: half of its angle, or half of its length if it
    /// has no angle.
    pub(super) fn middle(&self, start: f32, end: f32) -> f32 {
        let [a, b] = [start, end].map(f64::from);
        let x = match *self {
            Self::Turns { foot, h, .. } => {
                let [a, b] = [a - foot, b - foot];
                let [d_a, d_b] = [a.hypot(h), b.hypot(h)];
                // The bisector of two directions divides the ray in the ratio of their
                // distances.
                foot + (a * d_b + b * d_a) / (d_a + d_b)
            }
            Self::Through { .. } | Self::Equal { .. } => 0.5 * (a + b),
        };
        (x as f32).clamp(start, end)
    }
}

/// Positions along a ray, one after the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marks {
    lattice: Lattice,
    number: f64,
    /// Cosine and sine of the angle of the last position, and of a step.
    turned: DVec2,
    turn: DVec2,
}

impl Marks {
    /// The next position; infinite if there is none.
    pub(super) fn advance(&mut self) -> f32 {
        self.number += 1.0;
        match self.lattice {
            Lattice::Turns { foot, h, eye, turn } => {
                self.turned = self.turned.rotate(self.turn);
                if self.number * turn >= std::f64::consts::PI {
                    return f32::INFINITY;
                }
                let towards = eye.rotate(self.turned);
                // Beyond this angle, rays of the light do not meet the ray from the eye.
                match towards.x > 0.0 {
                    true => (foot + h * (towards.y / towards.x)) as f32,
                    false => f32::INFINITY,
                }
            }
            Lattice::Through { foot } => match self.number <= 1.0 {
                true => foot as f32,
                false => f32::INFINITY,
            },
            Lattice::Equal { from, step } => (from + self.number * step) as f32,
        }
    }
}
