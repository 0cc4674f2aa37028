//! Where on a line the shadows of balls are, and short parts to sample them by.
//!
//! A lamp and a line share a plane, in which balls are discs. Seen from a point
//! light, a disc covers angles, and at `angle` from the foot point of a lamp at
//! distance `h` the line is at `h tan(angle)`; the light of a sun draws a disc
//! along its own direction. Off the shadows nothing changes along the line.

use glam::DVec3;

use super::span::Dark;
use super::{Lamp, Line, Span};

/// The shadows that balls cast along a line.
#[derive(Debug)]
pub(super) struct Shades {
    /// What may be in shadow.
    shadows: Dark,
    /// What may be inside of balls.
    bodies: Dark,
    /// Distance along the line of the point nearest to a point light, and its
    /// distance there.
    foot: Option<[f64; 2]>,
}

/// A sine below which light runs along the line.
const ALONG: f64 = 1e-9;

impl Shades {
    /// Those of balls of these centres and radii.
    pub(super) fn new(line: &Line, lamp: &Lamp, balls: impl Iterator<Item = (DVec3, f64)>) -> Self {
        // Towards the lamp, at right angles to the line.
        let (aside, foot) = match lamp {
            Lamp::Point(point) => {
                let (foot, offset) = line.nearest(point.position);
                let h = offset.length();
                let near = h <= ALONG * foot.abs().max(h);
                ((!near).then(|| -offset / h), Some([foot, h]))
            }
            Lamp::Sun(sun) => {
                let aside = sun.toward.reject_from_normalized(line.direction);
                let sine = aside.length();
                ((sine > ALONG).then(|| aside / sine), None)
            }
        };
        let mut shades = Self {
            shadows: Dark::default(),
            bodies: Dark::default(),
            foot,
        };
        for (centre, radius) in balls {
            // Slightly widened: a tangent plane touches.
            let radius = radius * (1.0 + 1e-9) + 1e-12;
            let from_eye = centre - line.origin;
            let along = from_eye.dot(line.direction);
            let off = from_eye - along * line.direction;
            let height = aside.map_or(0.0, |aside| off.dot(aside));
            let in_plane = off - aside.map_or(DVec3::ZERO, |aside| height * aside);
            let disc2 = radius * radius - in_plane.length_squared();
            if disc2 <= 0.0 {
                continue;
            }
            let disc = disc2.sqrt();
            if height < -disc {
                continue; // behind the line
            }
            if disc > height.abs() {
                let half = ((disc - height) * (disc + height)).sqrt();
                shades.add_body(Span::new(along - half, along + half));
            }
            if aside.is_none() {
                continue; // what is in front of a ball or behind it is one
            }
            let shadow = match (lamp, foot) {
                (Lamp::Sun(sun), _) => {
                    let along_line = sun.toward.dot(line.direction);
                    let sine = (sun.toward - along_line * line.direction).length();
                    let middle = along - height * along_line / sine;
                    Some(Span::new(middle - disc / sine, middle + disc / sine))
                }
                (Lamp::Point(_), Some([foot, h])) => {
                    seen([along - foot, h - height], disc).map(|angles| {
                        let [start, end] = angles.map(|angle| foot + h * tangent(angle));
                        Span::new(start, end)
                    })
                }
                (Lamp::Point(_), None) => None,
            };
            if let Some(shadow) = shadow {
                shades.shadows.add(shadow);
            }
        }
        shades
    }

    fn add_body(&mut self, body: Span) {
        self.bodies.add(body);
        self.shadows.add(body);
    }

    /// Cuts the lit parts of the line, and calls `visit` with each piece and with
    /// the stretch of it that should be sampled, which is the piece unless that
    /// is endless.
    ///
    /// What is without shadows is left whole. Half of about `count` pieces are
    /// dealt out evenly between what the ends of balls, of shadows and the foot
    /// point of a lamp cut; half by length, of which no more than `far` counts.
    /// Pieces are equal in length, and again in the angle at a lamp.
    pub(super) fn cut(
        &self,
        lit: &[Span],
        count: u32,
        far: f64,
        mut visit: impl FnMut(Span, Span),
    ) {
        let stretches: Vec<Span> = lit.iter().flat_map(|part| self.stretches(*part)).collect();
        let is_dark = |stretch: &&Span| self.shadows.contains(**stretch);
        let length = |stretch: &Span| (stretch.end - stretch.start).min(far);
        let dark = stretches.iter().filter(is_dark).count() as f64;
        let total: f64 = stretches.iter().filter(is_dark).map(length).sum();
        for stretch in &stretches {
            let sampled = Span::new(stretch.start, stretch.start + length(stretch));
            if !is_dark(&stretch) {
                visit(*stretch, sampled);
                continue;
            }
            let share = 0.5 * (length(stretch) / total + 1.0 / dark);
            let mut cuts = self.cuts(sampled, (f64::from(count) * share).ceil().max(1.0) as u32);
            cuts.push(sampled.end);
            let last = cuts.len() - 1;
            let mut start = sampled.start;
            for (index, &cut) in cuts.iter().enumerate() {
                let end = if index == last { stretch.end } else { cut };
                visit(Span::new(start, end), Span::new(start, cut));
                start = cut;
            }
        }
    }

    /// What the ends of balls and shadows, and the foot point, cut of a part.
    fn stretches(&self, part: Span) -> Vec<Span> {
        let spans = self.shadows.parts().iter().chain(self.bodies.parts());
        let ends = spans.flat_map(|span| [span.start, span.end]);
        let mut ends: Vec<f64> = ends
            .chain(self.foot.map(|[foot, _]| foot))
            .filter(|&end| part.start < end && end < part.end)
            .chain([part.start, part.end])
            .collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        ends.windows(2)
            .map(|ends| Span::new(ends[0], ends[1]))
            .collect()
    }

    /// About `count` points within a piece, in order.
    fn cuts(&self, piece: Span, count: u32) -> Vec<f64> {
        let angles = self.foot.filter(|&[_, h]| h > 0.0).map(|[foot, h]| {
            let angle = |x: f64| ((x - foot) / h).atan();
            (foot, h, [angle(piece.start), angle(piece.end)])
        });
        let of_each = if angles.is_some() {
            count.div_ceil(2)
        } else {
            count
        };
        let mut cuts = Vec::new();
        for step in 1..of_each {
            let share = f64::from(step) / f64::from(of_each);
            cuts.push(piece.start + share * (piece.end - piece.start));
            if let Some((foot, h, [from, to])) = angles {
                cuts.push(foot + h * (from + share * (to - from)).tan());
            }
        }
        cuts.retain(|&cut| piece.start < cut && cut < piece.end);
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }
}

/// The angles, from the foot point, under which a disc is seen, `None` if all
/// are away from the line. `centre` is from the lamp: along the line and down
/// to it.
fn seen(centre: [f64; 2], radius: f64) -> Option<[f64; 2]> {
    use std::f64::consts::FRAC_PI_2;
    let [along, down] = centre;
    let distance = along.hypot(down);
    if distance <= radius {
        return Some([-FRAC_PI_2, FRAC_PI_2]);
    }
    let (middle, half) = (along.atan2(down), (radius / distance).asin());
    let angles = [
        (middle - half).max(-FRAC_PI_2),
        (middle + half).min(FRAC_PI_2),
    ];
    (angles[0] < angles[1]).then_some(angles)
}

/// Infinite at right angles.
fn tangent(angle: f64) -> f64 {
    if angle.abs() < std::f64::consts::FRAC_PI_2 {
        angle.tan()
    } else {
        f64::INFINITY.copysign(angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::{PointLamp, Sun};

    fn line() -> Line {
        Line {
            origin: DVec3::ZERO,
            direction: DVec3::X,
            length: f64::INFINITY,
        }
    }

    fn lamp(x: f64, y: f64) -> Lamp {
        Lamp::Point(PointLamp::even(DVec3::new(x, y, 0.0), DVec3::ONE))
    }

    fn shadows(lamp: &Lamp, ball: (f64, f64, f64), radius: f64) -> Vec<Span> {
        let centre = DVec3::new(ball.0, ball.1, ball.2);
        let shades = Shades::new(&line(), lamp, std::iter::once((centre, radius)));
        shades.shadows.parts().to_vec()
    }

    #[test]
    fn shadows_are_where_similar_triangles_put_them() {
        let near = |found: &[Span], start: f64, end: f64| {
            assert_eq!(found.len(), 1, "{found:?}");
            assert!((found[0].start - start).abs() < 1e-6, "{found:?}");
            assert!((found[0].end - end).abs() < 1e-6 || found[0].end == end);
        };
        let toward = DVec3::new(1.0, 1.0, 0.0).normalize();
        let sun = Lamp::Sun(Sun {
            toward,
            irradiance: DVec3::ONE,
        });
        let root = 2.0_f64.sqrt();
        near(&shadows(&sun, (5.0, 2.0, 0.0), 1.0), 3.0 - root, 3.0 + root);
        near(
            &shadows(&sun, (5.0, 2.0, 0.6), 1.0),
            3.0 - 0.8 * root,
            3.0 + 0.8 * root,
        );
        // Half way down, the sine of half of what is seen is 1 / 5.
        let half = 10.0 * (0.2_f64).asin().tan();
        near(
            &shadows(&lamp(4.0, 10.0), (4.0, 5.0, 0.0), 1.0),
            4.0 - half,
            4.0 + half,
        );
        // A ball as high as the lamp darkens all behind it.
        let found = shadows(&lamp(0.0, 10.0), (10.0, 10.0, 0.0), 2.0);
        let start = 10.0 / (0.2_f64).asin().tan();
        near(&found, start, f64::INFINITY);
        // A lamp within a ball; balls off the plane, above the lamp, behind.
        let all = shadows(&lamp(0.0, 10.0), (1.0, 10.0, 0.0), 2.0);
        assert_eq!(all, [Span::new(f64::NEG_INFINITY, f64::INFINITY)]);
        for ball in [(0.0, 5.0, 1.1), (0.0, 15.0, 0.0), (0.0, -1.1, 0.0)] {
            assert_eq!(shadows(&lamp(0.0, 10.0), ball, 1.0), []);
        }
        // Light along the line: the ball alone.
        near(&shadows(&lamp(3.0, 0.0), (6.0, 0.6, 0.0), 1.0), 5.2, 6.8);
    }

    #[test]
    fn pieces_join_and_are_many_where_shadows_are() {
        let centre = DVec3::new(4.0, 5.0, 0.0);
        let balls = || std::iter::once((centre, 1.0));
        for (lamp, far) in [(lamp(4.0, 10.0), 1e5), (lamp(0.0, 5.0), 1e30)] {
            let shades = Shades::new(&line(), &lamp, balls());
            let (mut from, mut dark) = (0.0, 0);
            shades.cut(
                &[Span::new(0.0, f64::INFINITY)],
                64,
                far,
                |piece, sampled| {
                    assert_eq!((piece.start, sampled.start), (from, from));
                    assert!(piece.end > from && sampled.end > from);
                    assert!(sampled.end.is_finite() && sampled.end <= piece.end);
                    dark += usize::from(shades.shadows.contains(piece));
                    from = piece.end;
                },
            );
            assert_eq!(from, f64::INFINITY);
            assert!((60..80).contains(&dark), "{dark}");
        }
    }
}
