//! An eye ray in f64.

use glam::DVec3;

/// The points `origin + x direction`, `0 ≤ x ≤ length`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// The eye.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Distance to the first surface; may be infinite.
    pub length: f64,
}

impl Line {
    /// The line of a ray; its direction is made a unit vector again in f64.
    pub fn new(ray: &scene::Ray) -> Self {
        Self {
            origin: ray.origin().as_dvec3(),
            direction: ray.direction().as_dvec3().normalize(),
            length: f64::from(ray.length()),
        }
    }

    /// The point at the finite distance `x`.
    pub fn at(&self, x: f64) -> DVec3 {
        self.origin + x * self.direction
    }

    /// Distance along the line of the point nearest to `point`, and the vector
    /// from `point` to it.
    pub fn nearest(&self, point: DVec3) -> (f64, DVec3) {
        let to_origin = self.origin - point;
        let foot = -to_origin.dot(self.direction);
        // ω × (v × ω) = v − (v·ω) ω, but next to the axis the cross product
        // keeps the digits that the difference would lose.
        let offset = self.direction.cross(to_origin.cross(self.direction));
        (foot, offset)
    }
}
