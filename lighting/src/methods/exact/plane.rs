//! The plane of a ray and its light, and the shadows in it.

use glam::{DVec2, DVec3, Vec3};

use crate::{Emitter, LightPath};

/// The plane of a ray and a light, with coordinates: `u` along the ray, `v`
/// towards the light.
pub(super) struct Plane {
    eye: DVec3,
    normal: DVec3,
    along: DVec3,
    up: DVec3,
    light: PlaneLight,
}

/// An end of the segment in which a triangle cuts a plane.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct End {
    /// Along `u` and `v`.
    pub(super) in_plane: (f64, f64),
    /// The corners of the edge that is cut, and where: 0 at the first, 1 at the
    /// second.
    edge: (usize, usize),
    at: f64,
}

impl End {
    /// Barycentric coordinates of the second and the third corner.
    pub(super) fn in_triangle(&self) -> DVec2 {
        const CORNERS: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let (from, to) = (CORNERS[self.edge.0], CORNERS[self.edge.1]);
        from + self.at * (to - from)
    }
}

enum PlaneLight {
    /// At (foot, h).
    Point { foot: f64, h: f64 },
    /// Towards (slope, 1), far away.
    Sun { slope: f64 },
}

impl Plane {
    /// `None` if the ray points at the light or away from it, to f64 precision.
    pub(super) fn new(path: &LightPath<'_>) -> Option<Self> {
        let eye = path.ray().origin().as_dvec3();
        let along = path.ray().direction().as_dvec3().normalize();
        let to_light = match path.emitter() {
            Emitter::Point(point) => point.position().as_dvec3() - eye,
            Emitter::Directional(sun) => -sun.direction().as_dvec3().normalize(),
        };
        let foot = to_light.dot(along);
        let normal = along.cross(to_light);
        let h = normal.length();
        if h <= 1e-12 * to_light.length() {
            return None;
        }
        let normal = normal / h;
        Some(Self {
            eye,
            normal,
            along,
            up: normal.cross(along),
            light: match path.emitter() {
                Emitter::Point(_) => PlaneLight::Point { foot, h },
                Emitter::Directional(_) => PlaneLight::Sun { slope: foot / h },
            },
        })
    }

    /// An interval of the ray's line that contains everything the box can hide from the
    /// light, of the half extent around a centre relative to the eye; `None` if it hides
    /// nothing.
    pub(super) fn shadow_of_box(&self, offset: DVec3, half: DVec3) -> Option<(f64, f64)> {
        // How far the box reaches from its centre along an axis.
        let margin = 1e-12 * (offset.abs().max_element() + half.max_element());
        let reach = |axis: DVec3| axis.abs().dot(half) + margin;
        if self.normal.dot(offset).abs() > reach(self.normal) {
            return None;
        }
        let (u, v) = (self.along.dot(offset), self.up.dot(offset));
        let (reach_u, reach_v) = (reach(self.along), reach(self.up));
        let high = v + reach_v;
        if high < 0.0 {
            return None;
        }
        let low = (v - reach_v).max(0.0);
        // The box lies in a rectangle of the plane, whose shadow is that of its
        // corners; where it reaches the light's height the shadow is unbounded.
        let (left, right) = (u - reach_u, u + reach_u);
        match self.light {
            PlaneLight::Sun { slope } => {
                let (near, far) = (slope * low, slope * high);
                Some((left - near.max(far), right - near.min(far)))
            }
            PlaneLight::Point { foot, h } => {
                if low >= h {
                    return None;
                }
                let near = h / (h - low);
                let far = if high < h {
                    h / (h - high)
                } else {
                    f64::INFINITY
                };
                let (left, right) = (left - foot, right - foot);
                let a = left * if left < 0.0 { far } else { near };
                let b = right * if right > 0.0 { far } else { near };
                // 0 · ∞: the edge of the box is straight below the light.
                let a = if a.is_nan() { 0.0 } else { a };
                let b = if b.is_nan() { 0.0 } else { b };
                Some((foot + a, foot + b))
            }
        }
    }

    pub(super) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The unit direction of the ray.
    pub(super) fn along(&self) -> DVec3 {
        self.along
    }

    /// The corners of a triangle, relative to the eye.
    pub(super) fn seen(&self, triangle: &[Vec3; 3]) -> [DVec3; 3] {
        triangle.map(|corner| corner.as_dvec3() - self.eye)
    }

    /// The interval of the ray's line that the triangle hides from the light.
    #[inline]
    pub(super) fn shadow_of_triangle(&self, corners: &[DVec3; 3]) -> Option<(f64, f64)> {
        let (_, [a, b]) = self.ends(corners)?;
        self.project(a.in_plane, b.in_plane)
    }

    /// The ends of the segment in which the triangle, its corners relative to the eye, cuts
    /// the plane, in the order of its edges.
    pub(super) fn cut(&self, corners: &[DVec3; 3]) -> Option<[End; 2]> {
        let (alone, [from, to]) = self.ends(corners)?;
        Some(if alone == 0 { [from, to] } else { [to, from] })
    }

    /// The ends on the edges from and to the corner that is alone on its side of the plane,
    /// after its number.
    #[inline]
    fn ends(&self, corners: &[DVec3; 3]) -> Option<(usize, [End; 2])> {
        /// By the corners that are above; 3 if all are on one side.
        const ALONE: [usize; 8] = [3, 0, 1, 2, 2, 1, 0, 3];
        let side = corners.map(|corner| self.normal.dot(corner));
        let [a, b, c] = side.map(|distance| usize::from(distance >= 0.0));
        let alone = ALONE[a + 2 * b + 4 * c];
        if alone == 3 {
            return None;
        }
        let end = |i: usize| {
            let j = (i + 1) % 3;
            let at = side[i] / (side[i] - side[j]);
            let point = corners[i] + at * (corners[j] - corners[i]);
            End {
                in_plane: (self.along.dot(point), self.up.dot(point)),
                edge: (i, j),
                at,
            }
        };
        Some((alone, [end(alone), end((alone + 2) % 3)]))
    }

    /// Projects a segment of the plane from the light onto the ray.
    #[inline]
    pub(super) fn project(&self, a: (f64, f64), b: (f64, f64)) -> Option<(f64, f64)> {
        // A processor cannot predict which end is lower, so a look-up takes the place of a
        // branch.
        let low = usize::from(a.1 > b.1);
        let (a, b) = ([a, b][low], [a, b][1 - low]);
        if b.1 <= 0.0 {
            return None;
        }
        let at_height = |v: f64| {
            let t = (v - a.1) / (b.1 - a.1);
            (a.0 + t * (b.0 - a.0), v)
        };
        // The part between ray and light; beyond the ray nothing is shadowed.
        let low = if a.1 < 0.0 { at_height(0.0) } else { a };
        let (x_low, x_high) = match self.light {
            PlaneLight::Sun { slope } => (low.0 - slope * low.1, b.0 - slope * b.1),
            PlaneLight::Point { foot, h } => {
                // A segment that touches the light lies on a line through it and hides a
                // single point, wherever rounding has put it.
                let rounding = 1e-12 * (h + foot.abs());
                let is_at_light = |point: (f64, f64)| {
                    (h - point.1).abs() <= rounding && (point.0 - foot).abs() <= rounding
                };
                if low.1 >= h || is_at_light(low) || is_at_light(b) {
                    return None;
                }
                let from_light = |point: (f64, f64)| foot + (point.0 - foot) * (h / (h - point.1));
                let x_high = if b.1 < h {
                    from_light(b)
                } else {
                    // The segment reaches the light's height: on that side its shadow has
                    // no end.
                    let aside = at_height(h).0 - foot;
                    if aside.abs() <= rounding {
                        // A surface through the light hides a single point.
                        return None;
                    }
                    aside * f64::INFINITY
                };
                (from_light(low), x_high)
            }
        };
        Some((x_low.min(x_high), x_low.max(x_high)))
    }
}
