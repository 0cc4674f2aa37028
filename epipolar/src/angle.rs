//! Angles that keep their digits wherever they are.

use glam::{DVec2, Vec2};

use crate::numeric;

/// An angle, carried as a vector that points at it.
///
/// Near 0 the y-component holds the angle to full relative precision, near π
/// it holds π minus the angle; an angle in radians would have an ULP of 2.4e-7
/// there, and a cosine would not tell the first 3.5e-4 rad apart. The length of
/// the vector has no meaning. The vector 0 counts as the angle 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle(pub(crate) Vec2);

impl Angle {
    /// The angle of a vector of any length.
    #[inline(always)]
    pub fn of(vector: impl Into<[f32; 2]>) -> Self {
        Self(Vec2::from(vector.into()))
    }

    /// From radians, with cosine and sine rounded once.
    pub fn from_radians(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self(DVec2::new(cos, sin).as_vec2())
    }

    /// A vector that points at it.
    pub fn vector(self) -> [f32; 2] {
        self.0.into()
    }

    /// In [-π, π]; relative error 3e-7.
    pub fn radians(self) -> f32 {
        numeric::angle(self.0.y, self.0.x)
    }

    /// Cosine and sine.
    pub fn unit(self) -> [f32; 2] {
        self.unit_vector().into()
    }

    pub(crate) fn unit_vector(self) -> Vec2 {
        normalised(self.0.as_dvec2()).as_vec2()
    }

    /// The angle by which `self` is ahead of `other`, in [-π, π]: no digits are
    /// lost if they are close to each other.
    #[inline(always)]
    pub fn relative_to(self, other: Self) -> f32 {
        numeric::angle(cross(other.0, self.0) as f32, other.0.dot(self.0))
    }
}

/// `a.x b.y − a.y b.x`, rounded once: both products are exact in f64, so that
/// vectors next to each other lose no digits.
#[inline(always)]
pub(crate) fn cross(a: Vec2, b: Vec2) -> f64 {
    f64::from(a.x) * f64::from(b.y) - f64::from(a.y) * f64::from(b.x)
}

/// The unit vector along `vector`, a vector of f32 of any length; (1, 0) if it
/// has none.
#[inline]
pub(crate) fn normalised(vector: DVec2) -> DVec2 {
    // Squares of numbers of f32 neither overflow nor underflow in f64.
    let length = vector.length();
    if !(length > 0.0 && length.is_finite()) {
        return DVec2::X;
    }
    vector / length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_next_to_pi_are_told_apart() {
        let a = Angle::of(Vec2::new(-1.0, 1e-12));
        let b = Angle::of(Vec2::new(-1.0, 3e-12));
        // One rounding in each of the two products and in the sum.
        assert!((a.relative_to(b) - 2e-12).abs() < 1e-18);
        assert_eq!(a.radians(), std::f32::consts::PI);
    }

    #[test]
    fn vectors_of_any_length_have_a_direction() {
        for length in [1e-38_f32, 1e-20, 1.0, 1e20, 3e38] {
            let unit = Angle::of(length * Vec2::new(0.6, 0.8)).unit_vector();
            assert!((unit - Vec2::new(0.6, 0.8)).length() < 3e-7, "{length}");
        }
        for nothing in [Vec2::ZERO, Vec2::NAN, Vec2::INFINITY] {
            assert_eq!(Angle::of(nothing).unit(), [1.0, 0.0]);
        }
        assert_eq!(Angle::from_radians(0.0).vector(), [1.0, 0.0]);
    }
}
