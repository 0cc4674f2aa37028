//! Eye rays and the intervals they fall into.

use glam::Vec3;

/// An eye ray: the points `origin + x direction` for `0 ≤ x ≤ length`.
///
/// Laid out as eight `f32`, so that a buffer of rays is an `array` of two
/// `vec4<f32>` each in a shader. A ray that meets no surface stores the length
/// `f32::MAX`, never an infinity.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Ray {
    origin: Vec3,
    length: f32,
    direction: Vec3,
    padding: f32,
}

impl Ray {
    /// A ray from `origin` along `direction` (made a unit vector here) to the
    /// first surface at distance `length`; infinite if there is none.
    ///
    /// `None` if the origin or the direction is not finite, the direction is
    /// 0, or the length is NaN or negative.
    pub fn new(
        origin: impl Into<[f32; 3]>,
        direction: impl Into<[f32; 3]>,
        length: f32,
    ) -> Option<Self> {
        let [origin, direction] = [origin.into(), direction.into()].map(Vec3::from_array);
        let direction = direction.try_normalize()?;
        (origin.is_finite() && length >= 0.0).then_some(Self {
            origin,
            length: length.min(f32::MAX),
            direction,
            padding: 0.0,
        })
    }

    /// Where the ray starts: the eye.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Unit direction.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Distance to the first surface; infinite for the sky.
    pub fn length(&self) -> f32 {
        if self.length == f32::MAX {
            f32::INFINITY
        } else {
            self.length
        }
    }

    /// The same ray with another end.
    #[must_use]
    pub fn with_length(self, length: f32) -> Self {
        Self {
            length: length.clamp(0.0, f32::MAX),
            ..self
        }
    }

    /// The point at distance `x`.
    pub fn at(&self, x: f32) -> Vec3 {
        self.origin + x * self.direction
    }
}

/// A part of a ray between two distances from its origin; `end` may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Distance at which it starts.
    pub start: f32,
    /// Distance at which it ends, at least `start`.
    pub end: f32,
}

impl Interval {
    /// The interval from `start` to `end`.
    pub const fn new(start: f32, end: f32) -> Self {
        Self { start, end }
    }

    /// `end − start`.
    pub fn length(self) -> f32 {
        self.end - self.start
    }
}
