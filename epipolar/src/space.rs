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

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::angle::normalised;
use crate::error::position;
use crate::light::Kind;
use crate::limits::{FARTHEST, SMALLEST_DISTANCE};
use crate::{Angle, Error, Light};

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
    /// The same three before they were rounded: a component across the axis
    /// keeps its digits beside a large one along it.
    exact: [DVec3; 3],
    distance: f32,
}

/// The angle at a point light, or the distance from the axis of a directional
/// one.
///
/// A pair (w, q) of any positive length: φ is its angle, or the distance is
/// q / w in metres. `q ≥ 0`; both are ordered by the sign of the cross product.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phi(pub(crate) Vec2);

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
    pub origin: [f32; 3],
    /// Unit direction, away from the light.
    pub direction: [f32; 3],
}

impl Phi {
    /// From an angle in [0, π] or a distance in metres, each as the pair of the
    /// type's description.
    #[inline(always)]
    pub fn of(pair: impl Into<[f32; 2]>) -> Self {
        Self(Vec2::from(pair.into()))
    }

    /// The pair (w, q).
    pub fn pair(self) -> [f32; 2] {
        self.0.into()
    }
}

impl Space {
    /// The space of `light` seen from `eye`.
    ///
    /// # Errors
    /// [`Error::EyeAtLight`] below [`SMALLEST_DISTANCE`],
    /// [`Error::BadVector`] unless the eye is finite and within 1e18 m.
    pub fn new(light: Light, eye: impl Into<[f32; 3]>) -> Result<Self, Error> {
        let eye = position("the position of the eye", eye.into())?;
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
        Ok(Self::with_frame(light, eye, distance, [axis, right, up]))
    }

    fn with_frame(light: Light, eye: Vec3, distance: f32, exact: [DVec3; 3]) -> Self {
        let [axis, right, up] = exact.map(|v| v.as_vec3());
        Self {
            light,
            eye,
            axis,
            right,
            up,
            exact,
            distance,
        }
    }

    /// The same space with θ counted from another direction, `radians` further
    /// around. Many lights side by side want different ones each, or their
    /// sampling errors line up as bands.
    #[must_use]
    pub fn rotated(self, radians: f32) -> Self {
        let (sin, cos) = f64::from(radians).sin_cos();
        let [axis, right, up] = self.exact;
        let frame = [axis, cos * right + sin * up, cos * up - sin * right];
        Self::with_frame(self.light, self.eye, self.distance, frame)
    }

    /// The light.
    pub fn light(&self) -> Light {
        self.light
    }

    /// The eye.
    pub fn eye(&self) -> [f32; 3] {
        self.eye.into()
    }

    pub(crate) fn eye_point(&self) -> Vec3 {
        self.eye
    }

    /// Distance between eye and light in metres, +∞ for a directional light.
    pub fn distance(&self) -> f32 {
        self.distance
    }

    /// Unit vectors: from the eye to the light, and those of θ = 0 and θ = π/2.
    pub fn frame(&self) -> [[f32; 3]; 3] {
        [self.axis, self.right, self.up].map(Vec3::into)
    }

    pub(crate) fn frame64(&self) -> [DVec3; 3] {
        [self.axis, self.right, self.up].map(|v| v.as_dvec3())
    }

    /// The unit vector from the eye to the light before it was rounded.
    #[cfg(feature = "wgsl")]
    pub(crate) fn exact_axis(&self) -> DVec3 {
        self.exact[0]
    }

    /// Whether the light is parallel, so that φ is a distance.
    pub fn is_directional(&self) -> bool {
        self.distance == f32::INFINITY
    }

    /// The coordinates of the ray along `direction`, of any length. α and π − α
    /// have a relative error of 4e-7, down to 1e-9 rad; θ is right to 4e-7 rad. A
    /// direction that is 0 or not finite counts as the direction to the light.
    #[inline]
    pub fn ray(&self, direction: impl Into<[f32; 3]>) -> EyeRay {
        let [alpha, theta] = self.angles(direction.into());
        EyeRay {
            alpha: Angle::of(alpha),
            theta: Angle::of(theta),
        }
    }

    /// The vectors of α and θ of a ray, without a branch.
    #[inline(always)]
    pub(crate) fn angles(&self, [x, y, z]: [f32; 3]) -> [[f32; 2]; 2] {
        let largest = x.abs().max(y.abs()).max(z.abs());
        let usable = (largest > 0.0) & x.is_finite() & y.is_finite() & z.is_finite();
        let v = DVec3::new(x.into(), y.into(), z.into());
        let angles = self.angles_along(v, largest.into());
        if usable { angles } else { [[1.0, 0.0]; 2] }
    }

    /// The same of a vector of numbers of f32, or sums of such, and its largest component.
    #[inline(always)]
    fn angles_along(&self, v: DVec3, largest: f64) -> [[f32; 2]; 2] {
        let theta = self.across(v);
        let alpha = DVec2::new(v.dot(self.exact[0]), theta.length());
        // θ is scaled by a power of two, so as not to overflow or underflow in f32.
        let exponent = largest.to_bits() & (0x7ff << 52);
        let scale = f64::from_bits((2046_u64 << 52).wrapping_sub(exponent));
        let unit = alpha * (1.0 / alpha.length());
        [unit, theta * scale].map(|v| v.as_vec2().into())
    }

    /// The components across the axis.
    #[inline(always)]
    fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.exact[1]), v.dot(self.exact[2]))
    }

    /// The coordinates of a point: α, φ and their distances from π have a
    /// relative error of 4e-7, down to 1e-9 rad; for a directional light so has
    /// the distance from the axis. The eye itself is at α = φ = 0, the light at
    /// α = φ = 0 too. A point beyond [`FARTHEST`] counts as the end of its eye ray.
    pub fn coordinates(&self, point: impl Into<[f32; 3]>) -> Coordinates {
        let point = Vec3::from(point.into());
        if !(point.is_finite() && point.abs().max_element() <= FARTHEST) {
            let ray = self.ray(point - self.eye);
            return Coordinates {
                ray,
                phi: self.phi_along(&ray, f32::INFINITY),
            };
        }
        let from_eye = point.as_dvec3() - self.eye.as_dvec3();
        let largest = from_eye.abs().max_element();
        let ray = if largest > 0.0 {
            let [alpha, theta] = self.angles_along(from_eye, largest).map(Angle::of);
            EyeRay { alpha, theta }
        } else {
            self.ray(Vec3::ZERO)
        };
        let phi = match self.light.at() {
            None => DVec2::new(1.0, self.across(from_eye).length()),
            Some(position) => {
                let from_light = point.as_dvec3() - position.as_dvec3();
                // Both vectors have the same component across the axis; the shorter one has
                // lost less of it to rounding.
                let nearer = if from_light.length_squared() < from_eye.length_squared() {
                    from_light
                } else {
                    from_eye
                };
                DVec2::new(-from_light.dot(self.exact[0]), self.across(nearer).length())
            }
        };
        Coordinates {
            ray,
            phi: Phi(phi.as_vec2()),
        }
    }

    /// The point at which an eye ray and a light ray of one plane meet: the way
    /// back from [`Space::coordinates`]. `None` if they do not meet in front of
    /// the eye (α + φ > π), or meet everywhere because both lie on the axis.
    ///
    /// The error is that of the angles, of 1e-7 rad, times the distances from
    /// eye and light, over sin(α + φ). Rays that are parallel to the rounding of
    /// the coordinates meet where the angle between them is that rounding: at
    /// about 1e7 times the distance between eye and light.
    pub fn point(&self, coordinates: &Coordinates) -> Option<[f32; 3]> {
        let EyeRay { alpha, theta } = coordinates.ray;
        let [axis, right, up] = self.exact;
        let around = normalised(theta.0.as_dvec2());
        let out = around.x * right + around.y * up;
        let DVec2 { x: cos, y: sin } = normalised(alpha.0.as_dvec2());
        let along_eye_ray = cos * axis + sin * out;
        let pair = coordinates.phi.0.as_dvec2();
        let eye = self.eye.as_dvec3();
        let point = match self.light.at() {
            None => {
                if !(sin > 0.0) {
                    return None;
                }
                eye + pair.y / pair.x / sin * along_eye_ray
            }
            Some(position) => {
                let phi = normalised(pair);
                // sin(α + φ), and what the roundings of the four can make of 0.
                let (a, b) = (sin * phi.x, cos * phi.y);
                let rounding = (a.abs() + b.abs()) * f64::from(f32::EPSILON);
                if !(a + b >= -rounding && rounding > 0.0) {
                    return None;
                }
                let scale = f64::from(self.distance) / (a + b).max(rounding);
                if phi.y < sin {
                    eye + scale * phi.y * along_eye_ray
                } else {
                    position.as_dvec3() + scale * sin * (phi.y * out - phi.x * axis)
                }
            }
        };
        let point = point.as_vec3();
        point.is_finite().then_some(point.into())
    }

    /// φ of the point at `distance` (metres, ≥ 0, may be infinite) along a ray.
    #[inline]
    pub fn phi_along(&self, ray: &EyeRay, distance: f32) -> Phi {
        if self.is_directional() {
            self.phi_of::<true>(ray.alpha.0, distance)
        } else {
            self.phi_of::<false>(ray.alpha.0, distance)
        }
    }

    /// [`Space::phi_along`] for a light that is known to be directional or not.
    #[inline(always)]
    pub(crate) fn phi_of<const DIRECTIONAL: bool>(&self, alpha: Vec2, distance: f32) -> Phi {
        let Vec2 { x: cos, y: sin } = alpha;
        // The limit of the pairs below divided by the distance.
        let endless = Vec2::new(if DIRECTIONAL { 0.0 } else { -cos }, sin);
        let w = if DIRECTIONAL {
            1.0
        } else {
            self.distance - distance * cos
        };
        let reached = Vec2::new(w, distance * sin);
        let ends = distance <= FARTHEST;
        Phi(if ends { reached } else { endless })
    }

    /// The distance along a ray at which it has reached φ, +∞ if it never
    /// does; 0 on the axis.
    #[inline]
    pub fn distance_along(&self, ray: &EyeRay, phi: Phi) -> f32 {
        self.distance_at(ray.alpha, phi)
    }

    /// [`Space::distance_along`] for the α of a ray, without a branch, so that a loop over many
    /// is compiled to vector instructions.
    #[inline(always)]
    pub fn distance_at(&self, alpha: Angle, phi: Phi) -> f32 {
        let Vec2 { x: cos, y: sin } = alpha.0;
        let Vec2 { x: w, y: q } = phi.0;
        // x = D sin φ / sin(α + φ).
        let (numerator, denominator) = if self.is_directional() {
            (q, sin * w)
        } else {
            (self.distance * q, sin * w + cos * q)
        };
        let ratio = numerator / denominator;
        let reached = if denominator > 0.0 {
            ratio
        } else {
            f32::INFINITY
        };
        if q > 0.0 { reached } else { 0.0 }
    }

    /// The light ray of the plane θ that has the given φ.
    pub fn light_ray(&self, theta: Angle, phi: Phi) -> LightRay {
        self.light_ray_of_units(theta.unit_vector(), self.unit(phi))
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
            normalised(pair.as_dvec2()).as_vec2()
        }
    }

    #[inline]
    pub(crate) fn light_ray_of_units(&self, around: Vec2, phi: Vec2) -> LightRay {
        let out = around.x * self.right + around.y * self.up;
        match self.light.at() {
            None => LightRay {
                origin: (self.eye + phi.y * out).into(),
                direction: (-self.axis).into(),
            },
            Some(position) => LightRay {
                origin: position.into(),
                direction: (phi.y * out - phi.x * self.axis).into(),
            },
        }
    }

    #[inline]
    fn alpha_along_unit(&self, phi: Vec2, distance: f32) -> Angle {
        Angle(if self.is_directional() {
            self.alpha_of::<true>(phi, distance)
        } else {
            self.alpha_of::<false>(phi, distance)
        })
    }

    /// The vector of [`Space::alpha_along`] for a pair of length 1, or with w = 1.
    #[inline(always)]
    pub(crate) fn alpha_of<const DIRECTIONAL: bool>(&self, phi: Vec2, distance: f32) -> Vec2 {
        if DIRECTIONAL {
            return Vec2::new(-distance, phi.y);
        }
        let distance = distance.max(0.0);
        Vec2::new(self.distance - distance * phi.x, distance * phi.y)
    }
}
