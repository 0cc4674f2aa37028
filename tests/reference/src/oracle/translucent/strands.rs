//! Pieces of strand in f64, and the shadows that they cast on a line.

use glam::{DVec3, Vec3};
use scene::Piece;

use crate::oracle::visibility::Region;
use crate::oracle::{Lamp, Line, Span};

/// Pieces of strand in a row that are looked at together.
const LOCK: usize = 16;

/// All pieces of all strands.
#[derive(Debug, Clone, Default)]
pub(super) struct Hair {
    ribbons: Vec<Ribbon>,
    /// Balls around [`LOCK`] of them after the other.
    locks: Vec<Ball>,
}

/// A piece of strand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ribbon {
    ends: [DVec3; 2],
    radius: f64,
    passed: f64,
}

/// Centre and radius.
type Ball = (DVec3, f64);

/// The plane of a line and a lamp: what does not touch it is not between the two.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    origin: DVec3,
    normal: DVec3,
}

impl Plane {
    /// `None` if the line runs through the lamp, or along the light of a sun.
    pub(super) fn new(line: &Line, lamp: &Lamp) -> Option<Self> {
        let towards = match lamp {
            Lamp::Point(point) => point.position - line.origin,
            Lamp::Sun(sun) => sun.toward,
        };
        let normal = line.direction.cross(towards);
        (normal.length() > 1e-9 * towards.length()).then(|| Self {
            origin: line.origin,
            normal: normal.normalize(),
        })
    }

    pub(super) fn touches(self, (centre, radius): Ball) -> bool {
        (centre - self.origin).dot(self.normal).abs() <= radius * (1.0 + 1e-9) + 1e-12
    }
}

impl Hair {
    pub(super) fn new(ribbons: Vec<Ribbon>) -> Self {
        let around = |ribbons: &[Ribbon]| {
            let centre: DVec3 = ribbons.iter().flat_map(|ribbon| ribbon.ends).sum();
            let centre = centre / (2 * ribbons.len()) as f64;
            let reach = ribbons.iter().map(|ribbon| {
                let (own, radius) = ribbon.ball_around();
                centre.distance(own) + radius
            });
            (centre, reach.fold(0.0, f64::max))
        };
        Self {
            locks: ribbons.chunks(LOCK).map(around).collect(),
            ribbons,
        }
    }

    pub(super) fn ribbons(&self) -> &[Ribbon] {
        &self.ribbons
    }

    /// Those that touch a plane, or all without one.
    pub(super) fn near(&self, plane: Option<Plane>) -> impl Iterator<Item = &Ribbon> {
        let touches = move |ball| plane.is_none_or(|plane| plane.touches(ball));
        let locks = self.ribbons.chunks(LOCK).zip(&self.locks);
        locks
            .filter(move |(_, ball)| touches(**ball))
            .flat_map(|(ribbons, _)| ribbons)
            .filter(move |ribbon| touches(ribbon.ball_around()))
    }

    /// Where on a part of a line they are in front of a lamp, and what share of its light
    /// each of them lets pass.
    pub(super) fn shadows(&self, line: &Line, lamp: &Lamp, span: Span) -> Vec<(Span, f64)> {
        let region = Region::new(line, lamp, span);
        let shadow = |ribbon: &Ribbon| {
            let [a, b] = ribbon.ends;
            let light = match lamp {
                Lamp::Point(point) => point.position - a,
                Lamp::Sun(sun) => sun.toward,
            };
            let across = ribbon.radius * (b - a).cross(light).try_normalize()?;
            let [p, q, r, s] = [a - across, a + across, b + across, b - across];
            let halves = [[p, q, r], [p, r, s]].map(|triangle| region.shadow(&triangle));
            let whole = match halves {
                [Some(one), Some(other)] => {
                    Span::new(one.start.min(other.start), one.end.max(other.end))
                }
                [one, other] => one.or(other)?,
            };
            Some((whole, ribbon.passed))
        };
        self.near(Plane::new(line, lamp))
            .filter_map(shadow)
            .collect()
    }

    /// Share of light that they let pass over `distance` from a point.
    pub(super) fn passed(&self, point: DVec3, towards: DVec3, distance: f64) -> f64 {
        let crossed = self.ribbons.iter();
        let crossed = crossed.filter(|ribbon| ribbon.is_crossed(point, towards, distance));
        crossed.map(|ribbon| ribbon.passed).product()
    }
}

impl From<Piece> for Ribbon {
    fn from(piece: Piece) -> Self {
        Self {
            ends: piece.axis.map(Vec3::as_dvec3),
            radius: piece.radius.into(),
            passed: 1.0 - f64::from(piece.opacity),
        }
    }
}

impl Ribbon {
    pub(super) fn ball_around(&self) -> Ball {
        let [a, b] = self.ends;
        (0.5 * (a + b), 0.5 * a.distance(b) + self.radius)
    }

    /// True if the path from `point` meets the ribbon that a light at the end
    /// of the path sees: along the axis, and across it at right angles to both
    /// axis and light.
    fn is_crossed(&self, point: DVec3, towards: DVec3, distance: f64) -> bool {
        let [a, b] = self.ends;
        let along = b - a;
        // From the light's side for a lamp; any point of the axis does for a sun.
        let light = if distance.is_finite() {
            point + distance * towards - a
        } else {
            towards
        };
        let Some(across) = along.cross(light).try_normalize() else {
            return false;
        };
        // point + t towards = a + s along + w across
        let normal = along.cross(across);
        let speed = normal.dot(towards);
        if speed == 0.0 {
            return false;
        }
        let t = normal.dot(a - point) / speed;
        if !(t > 0.0 && t < distance) {
            return false;
        }
        let offset = point + t * towards - a;
        let s = offset.dot(along) / along.length_squared();
        (0.0..=1.0).contains(&s) && offset.dot(across).abs() <= self.radius
    }
}

#[cfg(test)]
mod tests {
    use scene::{Emission, Emitter, Ray};

    use super::*;
    use crate::random::Random;

    #[test]
    fn shadows_on_a_line_are_where_the_way_to_the_lamp_crosses_strands() {
        let mut random = Random::new(11);
        let ribbons = (0..500).map(|_| {
            let middle = Vec3::from_array(random.vector(1.0)).as_dvec3();
            let half = Vec3::from_array(random.vector(0.2)).as_dvec3();
            Ribbon {
                ends: [middle - half, middle + half],
                radius: random.between(0.001, 0.05).into(),
                passed: random.between(0.2, 0.9).into(),
            }
        });
        let hair = Hair::new(ribbons.collect());
        let mut dimmed = 0;
        for case in 0..40 {
            let position = Vec3::new(random.between(-1.0, 1.0), 3.0, random.between(-1.0, 1.0));
            let lamp = Lamp::new(&match case % 2 {
                0 => Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic)
                    .expect("a lamp"),
                _ => Emitter::directional(-position, Vec3::ONE).expect("a sun"),
            });
            let origin = Vec3::new(-4.0, random.between(-2.0, 0.5), random.between(-1.0, 1.0));
            let target = Vec3::from_array(random.vector(0.5)) - 0.5 * Vec3::Y;
            let line = Line::new(&Ray::new(origin, target - origin, 9.0).expect("a ray"));
            let shadows = hair.shadows(&line, &lamp, Span::new(0.0, 9.0));
            for step in 0..200 {
                let x = 9.0 * (f64::from(step) + 0.5) / 200.0;
                let is_edge = |x: f64, end: f64| (x - end).abs() < 1e-6;
                if (shadows.iter()).any(|(span, _)| is_edge(x, span.start) || is_edge(x, span.end))
                {
                    continue;
                }
                let over = shadows
                    .iter()
                    .filter(|(span, _)| span.start < x && x < span.end);
                let found: f64 = over.map(|(_, passed)| passed).product();
                let (towards, distance) = lamp.seen_from(line.at(x));
                let truth = hair.passed(line.at(x), towards, distance);
                assert!((found - truth).abs() < 1e-9, "{case} {x}: {found} {truth}");
                dimmed += usize::from(truth < 1.0);
            }
        }
        assert!(dimmed > 500, "{dimmed}");
    }
}
