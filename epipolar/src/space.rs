//! The epipolar space of an eye and a light, and the way there and back.
//!
//! Based on: Wyman, Voxelized Shadow Volumes, HPG 2011, as reviewed in Wyman
//! and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013, section 2.6.
//!
//! The papers speak of three angles. Here every angle is carried as a vector,
//! and the angle φ at the light as a pair (w, q) with q / w = D tan φ up to a
//! common factor, where D is the distance of the light. In that form a
//! directional light is the limit D → ∞ (q / w is the distance from the axis),
//! and no formula divides by D or by a sine.

use glam::{DVec3, Vec2, Vec3};

use crate::angle::{length, normalised};
use crate::error::position;
use crate::light::Kind;
use crate::{Angle, Error, Light};

/// Eye and light must be this far apart, metres: products of distances stay
/// normal numbers in f32.
pub const SMALLEST_DISTANCE: f64 = 1e-18;

/// Distances above this, in metres, count as infinite.
pub const FARTHEST: f32 = crate::error::MAX_COORDINATE;

/// An eye, a light, and a frame around the axis between them.
///
/// ```text
///                  X
///                 /  \
///              /       \            across
///           / α          \ φ          ↑
///   E eye ────────────────── P light  → axis
/// ```
///
/// For a point X: α is the angle at the eye between the axis and X, φ the
/// angle at the light between the eye and X, and θ the angle of the plane E P X
/// around the axis. All points of an eye ray have the same (α, θ), all points of a
/// light ray the same (θ, φ); along a light ray α grows away from the light.
/// For a directional light φ is replaced by the distance from the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Space {
    light: Light,
    eye: Vec3,
    axis: Vec3,
    right: Vec3,
    up: Vec3,
    distance: f32,
}

/// The angle at a point light, or the distance from the axis of a directional
/// one.
///
/// A pair (w, q) of any positive length: φ is its angle, or the distance is
/// q / w in metres. `q ≥ 0`; both are ordered by the sign of the cross product.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phi(Vec2);

/// The direction of an eye ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyeRay {
    /// Angle with the axis, in [0, π]; its vector has length 1.
    pub alpha: Angle,
    /// Angle around the axis, any on the axis.
    pub theta: Angle,
}

/// A point in epipolar coordinates. On the axis, θ is arbitrary and the angles
/// do not tell where the point is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinates {
    /// The eye ray on which it lies.
    pub ray: EyeRay,
    /// The light ray on which it lies, together with θ.
    pub phi: Phi,
}

/// A ray along which light travels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightRay {
    /// The light, or for a directional light the point nearest to the eye.
    pub origin: Vec3,
    /// Unit direction, away from the light.
    pub direction: Vec3,
}

impl Phi {
    /// From an angle in [0, π] or a distance in metres, each as the pair of the
    /// type's description.
    pub fn of(pair: Vec2) -> Self {
        Self(pair)
    }

    /// The pair (w, q).
    pub fn pair(self) -> Vec2 {
        self.0
    }
}

impl Space {
    /// The space of `light` seen from `eye`.
    ///
    /// # Errors
    /// [`Error::EyeAtLight`] below [`SMALLEST_DISTANCE`],
    /// [`Error::BadVector`] unless the eye is finite and within 1e18 m.
    pub fn new(light: Light, eye: Vec3) -> Result<Self, Error> {
        let eye = position("the position of the eye", eye)?;
        let (axis, distance) = match light.0 {
            Kind::Directional(travel) => (-travel, f32::INFINITY),
            Kind::Point(position) | Kind::Spot { position, .. } => {
                let to_light = position.as_dvec3() - eye.as_dvec3();
                let distance = to_light.length();
                if distance < SMALLEST_DISTANCE {
                    return Err(Error::EyeAtLight { distance });
                }
                (to_light / distance, distance as f32)
            }
        };
        let (right, up) = axis.any_orthonormal_pair();
        Ok(Self {
            light,
            eye,
            axis: axis.as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            distance,
        })
    }

    /// The same space with θ counted from another direction, `radians` further
    /// around. Many lights side by side want different ones each, or their
    /// sampling errors line up as bands.
    #[must_use]
    pub fn rotated(self, radians: f32) -> Self {
        let (sin, cos) = f64::from(radians).sin_cos();
        let (right, up) = (self.right.as_dvec3(), self.up.as_dvec3());
        Self {
            right: (cos * right + sin * up).as_vec3(),
            up: (cos * up - sin * right).as_vec3(),
            ..self
        }
    }

    /// The light.
    pub fn light(&self) -> Light {
        self.light
    }

    /// The eye.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// Distance between eye and light in metres, +∞ for a directional light.
    pub fn distance(&self) -> f32 {
        self.distance
    }

    /// Unit vectors: from the eye to the light, and those of θ = 0 and θ = π/2.
    pub fn frame(&self) -> [Vec3; 3] {
        [self.axis, self.right, self.up]
    }

    pub(crate) fn frame64(&self) -> [DVec3; 3] {
        self.frame().map(|v| v.as_dvec3())
    }

    /// Whether the light is parallel, so that φ is a distance.
    pub fn is_directional(&self) -> bool {
        self.distance == f32::INFINITY
    }

    /// The coordinates of the ray along `direction`, of any length. Angles are
    /// right to 5e-7 rad (8 roundings), next to the axis as well. A direction
    /// that is 0 or not finite counts as the direction to the light.
    #[inline]
    pub fn ray(&self, direction: Vec3) -> EyeRay {
        let largest = direction.abs().max_element();
        if !(largest > 0.0 && direction.is_finite()) {
            return EyeRay {
                alpha: Angle::of(Vec2::X),
                theta: Angle::of(Vec2::X),
            };
        }
        // Squares of these are normal numbers.
        let v = if (1e-9..1e9).contains(&largest) {
            direction
        } else {
            direction / largest
        };
        let theta = Vec2::new(v.dot(self.right), v.dot(self.up));
        let alpha = Vec2::new(v.dot(self.axis), length(theta));
        EyeRay {
            alpha: Angle::of(alpha / alpha.length()),
            theta: Angle::of(theta),
        }
    }

    /// The coordinates of a point; errors of the angles as for
    /// [`Space::ray`]. The eye itself is at α = φ = 0, the light at α = φ = 0 too.
    /// A point beyond [`FARTHEST`] counts as the end of its eye ray.
    pub fn coordinates(&self, point: Vec3) -> Coordinates {
        let from_eye = point - self.eye;
        let ray = self.ray(from_eye);
        if !(point.is_finite() && point.abs().max_element() <= FARTHEST) {
            return Coordinates {
                ray,
                phi: self.phi_along(&ray, f32::INFINITY),
            };
        }
        let across = |v: Vec3| length(Vec2::new(v.dot(self.right), v.dot(self.up)));
        let phi = match self.light.position() {
            None => Vec2::new(1.0, across(from_eye)),
            Some(position) => {
                let from_light = point - position;
                // Both have the same distance from the axis; the shorter one
                // has lost less to rounding.
                let nearer = if from_light.length_squared() < from_eye.length_squared() {
                    from_light
                } else {
                    from_eye
                };
                Vec2::new(-from_light.dot(self.axis), across(nearer))
            }
        };
        Coordinates { ray, phi: Phi(phi) }
    }

    /// The point at which an eye ray and a light ray of one plane meet: the way
    /// back from [`Space::coordinates`]. `None` if they do not meet in front of
    /// the eye (α + φ ≥ π), or meet everywhere because both lie on the axis.
    pub fn point(&self, coordinates: &Coordinates) -> Option<Vec3> {
        let EyeRay { alpha, theta } = coordinates.ray;
        let around = theta.unit();
        let out = around.x * self.right + around.y * self.up;
        let Vec2 { x: cos, y: sin } = alpha.unit();
        let point = match self.light.position() {
            None => {
                let across = coordinates.phi.0.y / coordinates.phi.0.x;
                if !(sin > 0.0) {
                    return None;
                }
                self.eye + across / sin * (cos * self.axis + sin * out)
            }
            Some(position) => {
                let phi = normalised(coordinates.phi.0);
                let sine_of_sum = sin * phi.x + cos * phi.y;
                if !(sine_of_sum > 0.0) {
                    return None;
                }
                let scale = self.distance / sine_of_sum;
                if phi.y < sin {
                    self.eye + scale * phi.y * (cos * self.axis + sin * out)
                } else {
                    position + scale * sin * (phi.y * out - phi.x * self.axis)
                }
            }
        };
        point.is_finite().then_some(point)
    }

    /// φ of the point at `distance` (metres, ≥ 0, may be infinite) along a ray.
    #[inline]
    pub fn phi_along(&self, ray: &EyeRay, distance: f32) -> Phi {
        let Vec2 { x: cos, y: sin } = ray.alpha.vector();
        if !(distance <= FARTHEST) {
            // The limit of the pairs below divided by the distance.
            let w = if self.is_directional() { 0.0 } else { -cos };
            return Phi(Vec2::new(w, sin));
        }
        let w = if self.is_directional() {
            1.0
        } else {
            self.distance - distance * cos
        };
        Phi(Vec2::new(w, distance * sin))
    }

    /// The distance along a ray at which it has reached φ, +∞ if it never
    /// does; 0 on the axis.
    #[inline]
    pub fn distance_along(&self, ray: &EyeRay, phi: Phi) -> f32 {
        let Vec2 { x: cos, y: sin } = ray.alpha.vector();
        let Vec2 { x: w, y: q } = phi.0;
        if !(q > 0.0) {
            return 0.0;
        }
        // x = D sin φ / sin(α + φ).
        let (numerator, denominator) = if self.is_directional() {
            (q, sin * w)
        } else {
            (self.distance * q, sin * w + cos * q)
        };
        if denominator > 0.0 {
            numerator / denominator
        } else {
            f32::INFINITY
        }
    }

    /// The light ray of the plane θ that has the given φ.
    pub fn light_ray(&self, theta: Angle, phi: Phi) -> LightRay {
        self.light_ray_of_units(theta.unit(), self.unit(phi))
    }

    /// α of the point at `distance` along a light ray (metres; negative towards
    /// a directional light).
    pub fn alpha_along(&self, phi: Phi, distance: f32) -> Angle {
        self.alpha_along_unit(self.unit(phi), distance)
    }

    /// The pair of length 1 for a light at a point, with w = 1 for a
    /// directional one.
    fn unit(&self, Phi(pair): Phi) -> Vec2 {
        if self.is_directional() {
            Vec2::new(1.0, pair.y / pair.x)
        } else {
            normalised(pair)
        }
    }

    #[inline]
    pub(crate) fn light_ray_of_units(&self, around: Vec2, phi: Vec2) -> LightRay {
        let out = around.x * self.right + around.y * self.up;
        match self.light.position() {
            None => LightRay {
                origin: self.eye + phi.y * out,
                direction: -self.axis,
            },
            Some(position) => LightRay {
                origin: position,
                direction: phi.y * out - phi.x * self.axis,
            },
        }
    }

    #[inline]
    pub(crate) fn alpha_along_unit(&self, phi: Vec2, distance: f32) -> Angle {
        Angle::of(if self.is_directional() {
            Vec2::new(-distance, phi.y)
        } else {
            let distance = distance.max(0.0);
            Vec2::new(self.distance - distance * phi.x, distance * phi.y)
        })
    }
}
