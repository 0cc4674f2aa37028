//! Lights in f64, and where along a line their emission has an edge.

use glam::{DQuat, DVec2, DVec3};
use scene::{Emission, Emitter, Texture};

use super::{Line, Span};

/// A light.
#[derive(Debug, Clone)]
pub enum Lamp {
    /// At a point.
    Point(PointLamp),
    /// Infinitely far away.
    Sun(Sun),
}

/// A light at a point.
#[derive(Debug, Clone)]
pub struct PointLamp {
    /// Where it is.
    pub position: DVec3,
    /// Radiant intensity before the emission pattern.
    pub intensity: DVec3,
    /// Nothing farther away is lit.
    pub range: f64,
    /// Whether it fades towards the range like `1 − (d / range)⁴`.
    fades: bool,
    pattern: Pattern,
}

/// Parallel light.
#[derive(Debug, Clone, Copy)]
pub struct Sun {
    /// Unit vector towards the light.
    pub toward: DVec3,
    /// Irradiance on a plane that faces it.
    pub irradiance: DVec3,
}

#[derive(Debug, Clone)]
enum Pattern {
    Even,
    Cosine { normal: DVec3 },
    Cone(Cone),
}

#[derive(Debug, Clone)]
struct Cone {
    axis: DVec3,
    right: DVec3,
    up: DVec3,
    /// Cosine at which the light ends.
    dark: f64,
    /// Cosine from which on it is full.
    full: f64,
    /// Half the side of the cookie at distance 1.
    tan_dark: f64,
    cookie: Option<Texture>,
}

impl Lamp {
    /// Reads an emitter.
    pub fn new(emitter: &Emitter) -> Self {
        match emitter {
            Emitter::Directional(sun) => Self::Sun(Sun {
                toward: -sun.direction().as_dvec3().normalize(),
                irradiance: sun.irradiance().as_dvec3(),
            }),
            Emitter::Point(point) => Self::Point(PointLamp {
                position: point.position().as_dvec3(),
                intensity: point.intensity().as_dvec3(),
                range: f64::from(point.range()),
                fades: point.fades(),
                pattern: Pattern::new(point.emission()),
            }),
        }
    }

    /// The unit vector from a point to the light, and how far away it is.
    pub fn seen_from(&self, point: DVec3) -> (DVec3, f64) {
        match self {
            Self::Sun(sun) => (sun.toward, f64::INFINITY),
            Self::Point(lamp) => {
                let offset = lamp.position - point;
                (offset.normalize_or_zero(), offset.length())
            }
        }
    }
}

impl PointLamp {
    /// A light of the given intensity that shines the same everywhere.
    pub fn even(position: DVec3, intensity: DVec3) -> Self {
        Self {
            position,
            intensity,
            range: f64::INFINITY,
            fades: false,
            pattern: Pattern::Even,
        }
    }

    /// A point of a surface of this unit normal, which emits with the cosine to it.
    pub fn cosine(position: DVec3, intensity: DVec3, normal: DVec3) -> Self {
        Self {
            pattern: Pattern::Cosine { normal },
            ..Self::even(position, intensity)
        }
    }

    /// The same light somewhere else.
    #[must_use]
    pub fn moved_to(&self, position: DVec3) -> Self {
        Self {
            position,
            ..self.clone()
        }
    }

    /// The factor on the intensity into the unit `direction`.
    pub fn emission(&self, direction: DVec3) -> DVec3 {
        match &self.pattern {
            Pattern::Even => DVec3::ONE,
            Pattern::Cosine { normal } => DVec3::splat(normal.dot(direction).max(0.0)),
            Pattern::Cone(cone) => cone.emission(direction),
        }
    }

    /// The factor on the intensity at the distance `d`.
    pub fn fading(&self, d: f64) -> f64 {
        if self.fades {
            (1.0 - (d / self.range).powi(4)).max(0.0)
        } else {
            1.0
        }
    }

    /// True if `point` is in range and the light shines towards it. A point
    /// on an edge may count either way.
    pub fn reaches(&self, point: DVec3) -> bool {
        let to_point = point - self.position;
        let distance = to_point.length();
        distance <= self.range
            && match &self.pattern {
                Pattern::Even => true,
                Pattern::Cosine { normal } => normal.dot(to_point) > 0.0,
                Pattern::Cone(cone) => cone.axis.dot(to_point) > cone.dark * distance,
            }
    }

    /// Appends the distances along `line` at which the light may begin or end
    /// or a derivative of its emission jumps: its range and the edges of its
    /// cone. A cookie has more: [`PointLamp::cookie_edges`].
    pub fn edges(&self, line: &Line, edges: &mut Vec<f64>) {
        let (foot, offset) = line.nearest(self.position);
        let h2 = offset.length_squared();
        if self.range.is_finite() && self.range * self.range > h2 {
            let half = (self.range * self.range - h2).sqrt();
            edges.extend([foot - half, foot + half]);
        }
        match &self.pattern {
            Pattern::Even => {}
            Pattern::Cosine { normal } => {
                push_root(normal.dot(line.direction), normal.dot(offset), foot, edges);
            }
            Pattern::Cone(cone) => cone.edges(line, foot, offset, edges),
        }
    }

    /// Appends where `line` passes the centres of the cookie's texels, between
    /// which it is interpolated.
    pub fn cookie_edges(&self, line: &Line, edges: &mut Vec<f64>) {
        let Pattern::Cone(cone) = &self.pattern else {
            return;
        };
        let Some(cookie) = &cone.cookie else {
            return;
        };
        let (foot, offset) = line.nearest(self.position);
        for (side, texels) in [(cone.right, cookie.width()), (cone.up, cookie.height())] {
            for texel in 0..texels {
                let k = (2.0 * f64::from(texel) + 1.0) / f64::from(texels) - 1.0;
                let normal = side - k * cone.tan_dark * cone.axis;
                push_root(normal.dot(line.direction), normal.dot(offset), foot, edges);
            }
        }
    }
}

impl Pattern {
    fn new(emission: &Emission) -> Self {
        match emission {
            Emission::Isotropic => Self::Even,
            Emission::Cosine { normal } => Self::Cosine {
                normal: normal.as_dvec3(),
            },
            Emission::Spot(spot) => {
                let q = spot.rotation();
                let [x, y, z, w] = [q.x, q.y, q.z, q.w].map(f64::from);
                let rotation = DQuat::from_xyzw(x, y, z, w).normalize();
                let dark = 1.0 - f64::from(spot.outer_versine());
                Self::Cone(Cone {
                    axis: rotation * DVec3::NEG_Z,
                    right: rotation * DVec3::X,
                    up: rotation * DVec3::Y,
                    dark,
                    full: dark + f64::from(spot.rim()),
                    tan_dark: f64::from(spot.tan_outer()),
                    cookie: spot.texture().cloned(),
                })
            }
        }
    }
}

impl Cone {
    fn emission(&self, direction: DVec3) -> DVec3 {
        let cos = self.axis.dot(direction);
        let ramp = ((cos - self.dark) / (self.full - self.dark)).clamp(0.0, 1.0);
        let grey = DVec3::splat(ramp * ramp);
        match &self.cookie {
            Some(cookie) if ramp > 0.0 => {
                // The cookie stands upright at distance 1: +Y is its upper edge.
                let half_side = cos * self.tan_dark;
                let u = 0.5 + 0.5 * self.right.dot(direction) / half_side;
                let v = 0.5 - 0.5 * self.up.dot(direction) / half_side;
                grey * texel(cookie, DVec2::new(u, v))
            }
            _ => grey,
        }
    }

    fn edges(&self, line: &Line, foot: f64, offset: DVec3, edges: &mut Vec<f64>) {
        let along = self.axis.dot(line.direction);
        let across = self.axis.dot(offset);
        let h2 = offset.length_squared();
        // axis·v = c |v| squared, for v = s ω + offset.
        for cos in [self.dark, self.full] {
            let c2 = cos * cos;
            let (a, b, c) = (
                along * along - c2,
                along * across,
                across * across - c2 * h2,
            );
            let discriminant = b * b - a * c;
            if discriminant < 0.0 {
                continue;
            }
            let q = -(b + discriminant.sqrt().copysign(b));
            for root in [q / a, c / q] {
                if root.is_finite() {
                    edges.push(foot + root);
                }
            }
        }
    }
}

/// Appends where `slope s + value = 0`, measured from the foot point.
fn push_root(slope: f64, value: f64, foot: f64, edges: &mut Vec<f64>) {
    let root = -value / slope;
    if root.is_finite() {
        edges.push(foot + root);
    }
}

/// Bilinear interpolation between texel centres at `(i + ½) / size`, constant
/// outside of the outermost centres.
pub(super) fn texel(texture: &Texture, uv: DVec2) -> DVec3 {
    let axis = |t: f64, size: u32| {
        let last = f64::from(size - 1);
        let position = (t * f64::from(size) - 0.5).clamp(0.0, last);
        let low = position.floor();
        let high = (low + 1.0).min(last);
        (low as usize, high as usize, position - low)
    };
    let (left, right, x) = axis(uv.x, texture.width());
    let (top, bottom, y) = axis(uv.y, texture.height());
    let at = |column: usize, row: usize| {
        texture.texels()[row * texture.width() as usize + column].as_dvec3()
    };
    let upper = (1.0 - x) * at(left, top) + x * at(right, top);
    let lower = (1.0 - x) * at(left, bottom) + x * at(right, bottom);
    (1.0 - y) * upper + y * lower
}

/// Sorts `edges` and calls `part` for every piece of `whole` between them,
/// with a position inside the piece.
pub(super) fn for_each_piece(whole: Span, edges: &mut Vec<f64>, mut part: impl FnMut(Span, f64)) {
    edges.retain(|edge| whole.start < *edge && *edge < whole.end);
    edges.sort_by(f64::total_cmp);
    edges.push(whole.end);
    let mut start = whole.start;
    for &end in edges.iter() {
        if start < end {
            let inside = if end.is_finite() {
                0.5 * (start + end)
            } else {
                start + 1.0 + start.abs()
            };
            part(Span::new(start, end), inside);
        }
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

    use glam::{Quat, Vec3};
    use scene::Cone;

    use super::*;

    fn spot(cookie: Option<Texture>) -> PointLamp {
        let cone = Cone {
            inner: 0.3,
            outer: FRAC_PI_4,
        };
        let emission = Emission::spot(Quat::from_rotation_y(-FRAC_PI_2), cone, cookie).unwrap();
        let emitter = Emitter::point(Vec3::ZERO, Vec3::ONE, 9.0, emission).unwrap();
        match Lamp::new(&emitter) {
            Lamp::Point(point) => point,
            Lamp::Sun(_) => panic!("a point was asked for"),
        }
    }

    #[test]
    fn a_spot_turned_towards_x_shines_there_and_ends_at_its_cone() {
        let lamp = spot(None);
        assert!((lamp.emission(DVec3::X) - DVec3::ONE).length() < 1e-12);
        assert_eq!(lamp.emission(DVec3::NEG_X), DVec3::ZERO);
        let edge = |angle: f64| lamp.emission(DVec3::new(angle.cos(), angle.sin(), 0.0)).x;
        assert!(edge(0.78) > 0.0 && edge(0.79) == 0.0);
        let outer = std::f64::consts::FRAC_1_SQRT_2;
        let between = (0.5_f64.cos() - outer) / (0.3_f64.cos() - outer);
        assert!((edge(0.5) - between * between).abs() < 1e-6);
    }

    #[test]
    fn edges_lie_where_the_cone_and_the_range_end() {
        let lamp = spot(None);
        let line = Line {
            origin: DVec3::new(2.0, -10.0, 0.0),
            direction: DVec3::Y,
            length: 20.0,
        };
        let mut edges = Vec::new();
        lamp.edges(&line, &mut edges);
        for expected in [8.0, 12.0, 10.0 - 77.0_f64.sqrt(), 10.0 + 77.0_f64.sqrt()] {
            assert!(
                edges.iter().any(|edge| (edge - expected).abs() < 1e-5),
                "{expected} {edges:?}"
            );
        }
        assert!(lamp.reaches(line.at(8.01)) && !lamp.reaches(line.at(7.99)));
    }

    #[test]
    fn a_cookie_is_upright() {
        // Seen along the light: top row red, bottom row green, right column darker.
        let texels = [Vec3::X, 0.5 * Vec3::X, Vec3::Y, 0.5 * Vec3::Y];
        let lamp = spot(Some(Texture::new(2, 2, texels.to_vec()).unwrap()));
        // The light looks along +X with +Y up: its right is +Z.
        let up_left = lamp.emission(DVec3::new(1.0, 0.5, -0.5).normalize());
        assert!(up_left.x > 0.0 && up_left.y < 1e-12);
        let up_right = lamp.emission(DVec3::new(1.0, 0.5, 0.5).normalize());
        assert!((up_right.x / up_left.x - 0.5).abs() < 1e-6);
        let below = lamp.emission(DVec3::new(1.0, -0.5, -0.5).normalize());
        assert!(below.y > 0.0 && below.x < 1e-12);
    }
}
