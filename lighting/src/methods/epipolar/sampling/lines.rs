//! Epipolar lines of a picture, by where they leave it.

use glam::{DVec2, DVec3};

use crate::scene::{Camera, Emitter};

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) from: [u32; 2],
    pub(super) size: [u32; 2],
}

impl Area {
    /// Whether a pixel is inside.
    pub(super) fn contains(&self, pixel: [u32; 2]) -> bool {
        (0..2).all(|i| (self.from[i]..self.from[i] + self.size[i]).contains(&pixel[i]))
    }
}

/// An epipole farther away than so many times the width and height of a picture is at
/// infinity: the lines through it are parallel to 1e-9.
const AT_INFINITY: f64 = 1e9;

/// The epipole of a light, and the area whose border its lines divide evenly.
///
/// The epipole is the point e = (x, y) / w of the picture, in pixels from the corner of
/// the area. A light behind the eye has the picture of its antipode, through which the
/// same lines run; w is 0 if the lines are parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Epipole {
    at: DVec2,
    w: f64,
    size: DVec2,
}

/// Where a point of the area lies on the lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Where its line leaves the area: pixels along the border, clockwise from the
    /// upper left corner.
    pub(super) border: f64,
    /// Its distance from the epipole as a share of that of the border, above 0.
    pub(super) share: f64,
    /// Its distance from the epipole, pixels; infinite for parallel lines.
    pub(super) radius: f64,
}

/// A line from the border of the area towards the epipole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub(super) border: DVec2,
    /// A unit vector.
    pub(super) inward: DVec2,
    /// Pixels up to the epipole; infinite for parallel lines.
    pub(super) radius: f64,
    /// Pixels up to the epipole or the other border.
    pub(super) length: f64,
}

impl Line {
    /// The point at a distance from the border.
    pub(super) fn at(&self, distance: f64) -> DVec2 {
        self.border + distance * self.inward
    }

    /// The distance from the border of the point of the line that is closest to another
    /// one.
    pub(super) fn closest(&self, point: DVec2) -> f64 {
        (point - self.border).dot(self.inward)
    }
}

impl Epipole {
    /// That of a light in the picture of `camera`; `None` for a light at the eye, which
    /// has no picture.
    pub(super) fn new(
        camera: &Camera,
        size: [u32; 2],
        emitter: &Emitter,
        area: Area,
    ) -> Option<Self> {
        let to_light = match emitter {
            Emitter::Point(point) => point.position().as_dvec3() - camera.eye().as_dvec3(),
            Emitter::Directional(sun) => -sun.direction().as_dvec3(),
        };
        let local: DVec3 = camera.rotation().as_dquat().inverse() * to_light.try_normalize()?;
        let [width, height] = size.map(f64::from);
        // The inverse of `Camera::direction`.
        let scale = height / (0.5 * f64::from(camera.vertical_fov())).tan();
        let w = -local.z;
        let x = 0.5 * (local.x * scale + width * w) - f64::from(area.from[0]) * w;
        let y = 0.5 * (height * w - local.y * scale) - f64::from(area.from[1]) * w;
        let at = DVec2::new(x, y);
        let (at, w) = match w.abs() * AT_INFINITY * (width + height) > at.length() {
            true => (at * w.signum(), w.abs()),
            false => (at, 0.0),
        };
        Some(Self {
            at,
            w,
            size: DVec2::from(area.size.map(f64::from)),
        })
    }

    /// The vector from the epipole to a point, times w.
    fn away(&self, point: DVec2) -> DVec2 {
        point * self.w - self.at
    }

    /// Pixels around the area.
    pub(super) fn perimeter(&self) -> f64 {
        2.0 * (self.size.x + self.size.y)
    }

    /// How far it is from a point to the border in a direction, in units of its length.
    fn distance_to_border(&self, point: DVec2, direction: DVec2) -> f64 {
        let along = |i: usize| {
            let (at, step) = (point[i], direction[i]);
            match step {
                step if step > 0.0 => (self.size[i] - at) / step,
                step if step < 0.0 => -at / step,
                _ => f64::INFINITY,
            }
        };
        along(0).min(along(1)).max(0.0)
    }

    /// Where a point of the area is; `None` for the epipole itself.
    pub(super) fn place(&self, point: DVec2) -> Option<Place> {
        let away = self.away(point);
        let t = self.distance_to_border(point, away);
        if !t.is_finite() {
            return None;
        }
        let end = point + t * away;
        let DVec2 { x: w, y: h } = self.size;
        // The side that is met: the one whose border is closest to the end.
        let sides = [
            (end.y, end.x),
            (w - end.x, w + end.y),
            (h - end.y, w + h + (w - end.x)),
            (end.x, 2.0 * w + h + (h - end.y)),
        ];
        let outward = [-away.y, away.x, away.y, -away.x];
        let met = (0..4)
            .filter(|side| outward[*side] > 0.0)
            .min_by(|a, b| sides[*a].0.total_cmp(&sides[*b].0))?;
        Some(Place {
            border: sides[met].1.clamp(0.0, self.perimeter()),
            share: 1.0 / (1.0 + t * self.w),
            radius: away.length() / self.w,
        })
    }

    /// The line that leaves the area at a place of the border; `None` if lines enter
    /// there.
    pub(super) fn line(&self, border: f64) -> Option<Line> {
        let DVec2 { x: w, y: h } = self.size;
        let (point, outward) = if border < w {
            (DVec2::new(border, 0.0), DVec2::NEG_Y)
        } else if border < w + h {
            (DVec2::new(w, border - w), DVec2::X)
        } else if border < 2.0 * w + h {
            (DVec2::new(2.0 * w + h - border, h), DVec2::Y)
        } else {
            (
                DVec2::new(0.0, (self.perimeter() - border).clamp(0.0, h)),
                DVec2::NEG_X,
            )
        };
        let away = self.away(point);
        if !(away.dot(outward) > 0.0) {
            return None;
        }
        let inward = -away.normalize();
        let radius = away.length() / self.w;
        Some(Line {
            border: point,
            inward,
            radius,
            length: self.distance_to_border(point, inward).min(radius),
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use reference::random::Random;

    use super::*;
    use crate::scene::Emission;

    const SIZE: [u32; 2] = [40, 30];
    const WHOLE: Area = Area {
        from: [0, 0],
        size: SIZE,
    };

    fn camera() -> Camera {
        Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 2.5, -4.0), 1.1).unwrap()
    }

    fn sun(towards: Vec3) -> Emitter {
        Emitter::directional(-towards, Vec3::ONE).unwrap()
    }

    /// In view, outside, far outside, at infinity, behind, and behind in view.
    fn directions() -> Vec<Vec3> {
        let camera = camera();
        let near = [(20.3, 11.2), (3.0, 29.0), (60.0, -8.0), (4e3, 15.0)];
        let mut all: Vec<Vec3> = near
            .iter()
            .flat_map(|(x, y)| {
                let direction = camera.direction(*x, *y, SIZE[0], SIZE[1]);
                [direction, -direction]
            })
            .collect();
        all.extend([
            camera.rotation() * Vec3::X,
            camera.rotation() * Vec3::new(0.5, -1.0, 1e-12),
        ]);
        all
    }

    #[test]
    fn the_epipole_is_the_picture_of_the_light() {
        let camera = camera();
        for (x, y) in [(20.3_f32, 11.2_f32), (-70.0, 4.0)] {
            let direction = camera.direction(x, y, SIZE[0], SIZE[1]);
            let lamp = |at| Emitter::point(at, Vec3::ONE, f32::INFINITY, Emission::Isotropic);
            let lights = [
                sun(direction),
                sun(-direction),
                lamp(camera.eye() + 7.0 * direction).unwrap(),
                lamp(camera.eye() - 7.0 * direction).unwrap(),
            ];
            for light in lights {
                let epipole = Epipole::new(&camera, SIZE, &light, WHOLE).unwrap();
                let found = epipole.at / epipole.w;
                let expected = DVec2::new(f64::from(x), f64::from(y));
                assert!((found - expected).length() < 1e-3, "{found}");
                let area = Area {
                    from: [7, 3],
                    size: [9, 11],
                };
                let inside = Epipole::new(&camera, SIZE, &light, area).unwrap();
                let found = inside.at / inside.w + DVec2::new(7.0, 3.0);
                assert!((found - expected).length() < 1e-3, "{found}");
            }
            let at_eye = lamp(camera.eye()).unwrap();
            assert!(Epipole::new(&camera, SIZE, &at_eye, WHOLE).is_none());
        }
    }

    /// The line of every point runs through it, at the distance from the epipole that
    /// its place says.
    #[test]
    fn every_point_is_on_the_line_of_its_place() {
        let camera = camera();
        let mut random = Random::new(5);
        for direction in directions() {
            let epipole = Epipole::new(&camera, SIZE, &sun(direction), WHOLE).unwrap();
            for _ in 0..200 {
                let at = random.vector(1.0);
                let unit = |x: f32| 0.5 * (1.0 + f64::from(x));
                let point = DVec2::new(unit(at[0]) * 40.0, unit(at[1]) * 30.0);
                let place = epipole.place(point).unwrap();
                let line = epipole.line(place.border).unwrap();
                let closest = line.closest(point);
                let off = (line.at(closest) - point).length();
                assert!(off < 1e-4, "{direction} {point} {off}");
                assert!(closest > -1e-6 && closest < line.length + 1e-6);
                assert!(place.share > 0.0 && place.share <= 1.0);
                if place.radius < 1e5 {
                    let left = line.radius - closest;
                    assert!((left - place.radius).abs() < 1e-4);
                    assert!((left / line.radius - place.share).abs() < 1e-5);
                } else {
                    assert!(place.share > 0.99);
                }
            }
        }
    }

    /// All around the border a line either leaves or enters.
    #[test]
    fn lines_leave_where_the_epipole_is_on_the_inner_side() {
        let camera = camera();
        for direction in directions() {
            let epipole = Epipole::new(&camera, SIZE, &sun(direction), WHOLE).unwrap();
            let found = (0..1400).filter_map(|i| epipole.line(f64::from(i) * 0.1));
            let mut count = 0;
            for line in found {
                assert!((line.inward.length() - 1.0).abs() < 1e-12);
                assert!(line.length >= 0.0 && line.length < 51.0, "{line:?}");
                let end = line.at(line.length);
                assert!(end.x > -1e-6 && end.x < 40.0 + 1e-6, "{end}");
                assert!(end.y > -1e-6 && end.y < 30.0 + 1e-6, "{end}");
                count += 1;
            }
            let inside = epipole.w > 0.0 && {
                let at = epipole.at / epipole.w;
                at.x > 0.0 && at.y > 0.0 && at.x < 40.0 && at.y < 30.0
            };
            assert!(count == 1400 || !inside, "{count}");
            assert!((300..=1400).contains(&count), "{count}");
        }
    }
}
