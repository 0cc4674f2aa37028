//! Where the steps of a ray are.

use glam::{DVec2, DVec3};

use crate::path::axis_of;
use crate::{Emitter, Interval, LightPath};

/// Which surfaces the ends of steps lie on; see the [module](super).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Placement {
    /// Cones around the line through eye and light, with their apex at the light: steps
    /// are equal angles there. For parallel light, which has no such angle, the same as
    /// [`Placement::Span`].
    #[default]
    Angle,
    /// Ellipsoids around the eye with the proportions of a beam that is `reach` metres
    /// long: on each ray steps are equally long, and their length follows from the angle
    /// between ray and axis.
    Length {
        /// Length of the beam, m. What is not above 0, NaN included, counts as 0: steps are
        /// as short as they may be.
        reach: f32,
    },
    /// None that neighbouring rays share: each ray divides its own part of the beam into
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
    /// 1 / (4 sin² of the half angle of the beam) less 1: how much more a length across
    /// the beam counts than one along it.
    pub(super) stretch: f64,
}

/// Angles are not divided further than this: an `f32` has no more digits.
const LEAST_TURN: f64 = 1e-6;

/// Steps across the beam, at most: shaders number them by an `f32`, which counts to 2²⁴.
pub(super) const MOST_STEPS: u32 = 1 << 20;

/// Rays that pass the light closer than this share of the distance between it and the eye,
/// or than this many metres, run through it: a hair more than
/// [`LightPath::off_the_light`] leaves between them.
pub(super) const THROUGH: f64 = 1.001e-4;
pub(super) const AT_THE_LIGHT: f64 = 1.001e-12;

/// Steps are no shorter than this share of the distance from the eye, and rays take no
/// more than so many times as many as there are across the beam, however short the reach.
pub(super) const LEAST_STEP: f64 = 1e-6;
pub(super) const MOST_BEAMS: f64 = 4.0;

impl Steps {
    /// So many steps (0 counts as 1, and more than [`MOST_STEPS`] as these) across the beam
    /// of a light.
    pub(super) fn new(light: &Emitter, count: u32, placement: Placement) -> Self {
        let count = count.clamp(1, MOST_STEPS);
        let placement = match placement {
            // NaN is not more.
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

    /// The steps of a ray, of which those within `part` are wanted.
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
    /// At equal angles at a light, measured from the eye.
    Turns {
        foot: f64,
        h: f64,
        /// The direction from the light to the eye, along that to the foot point and
        /// along the ray.
        eye: DVec2,
        turn: f64,
    },
    /// At the light alone, on a ray through it, all of which is at two angles.
    Through { foot: f64 },
    /// At equal distances.
    Equal { from: f64, step: f64 },
}

impl Lattice {
    /// Whether the ray runs through the light.
    pub(super) fn is_through_the_light(&self) -> bool {
        matches!(self, Self::Through { .. })
    }

    /// The number of the last position that is not behind the distance `x`, to rounding.
    fn number(&self, x: f32) -> f64 {
        let x = f64::from(x);
        let number = match *self {
            Self::Turns { foot, h, turn, .. } => {
                // The angle between the directions to the eye and to x, without a
                // difference of the two.
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

    /// The middle of a step or of a part of it: half of its angle, or of its length where
    /// that has none.
    pub(super) fn middle(&self, start: f32, end: f32) -> f32 {
        let [a, b] = [start, end].map(f64::from);
        let x = match *self {
            Self::Turns { foot, h, .. } => {
                let [a, b] = [a - foot, b - foot];
                let [d_a, d_b] = [a.hypot(h), b.hypot(h)];
                // The bisector of two directions meets the ray by the ratio of distances.
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
    /// Cosine and sine of the angle of the last one, and of a step.
    turned: DVec2,
    turn: DVec2,
}

impl Marks {
    /// The next position; infinite when there is none.
    pub(super) fn advance(&mut self) -> f32 {
        self.number += 1.0;
        match self.lattice {
            Lattice::Turns { foot, h, eye, turn } => {
                self.turned = self.turned.rotate(self.turn);
                if self.number * turn >= std::f64::consts::PI {
                    return f32::INFINITY;
                }
                let towards = eye.rotate(self.turned);
                // Rays of the light that do not come down to the line of the eye's.
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
