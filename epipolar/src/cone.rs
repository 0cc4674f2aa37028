//! The angles between an axis and the directions inside a pyramid.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

/// How close to a border of a cone a direction counts as inside, radians: the
/// frame of a space is rounded to f32, which moves it by 1e-7.
const MARGIN: f64 = 1e-6;

/// The directions inside a pyramid of at least three edges, narrower than a
/// half-space.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cone {
    corners: Vec<DVec3>,
    /// Sum of the unit corners.
    middle: DVec3,
    /// Whether all directions inside are less than a right angle from the
    /// middle; wide triangles next to a light are not like this.
    narrow: bool,
    /// Inward normals of the sides, of length 1 or less.
    sides: Vec<DVec3>,
}

/// An interval of angles around an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Arc {
    /// All of them: the axis is inside.
    Full,
    /// The angles from `centre - half` to `centre + half`, `half < π`.
    Part { centre: f64, half: f64 },
}

impl Cone {
    /// `corners` are unit vectors in order around the cone. Degenerate cones are
    /// answered for with bounds that are too wide.
    pub(crate) fn new(corners: Vec<DVec3>) -> Self {
        let middle: DVec3 = corners.iter().sum();
        let next = |i: usize| corners[(i + 1) % corners.len()];
        let sides: Vec<DVec3> = corners
            .iter()
            .enumerate()
            .map(|(i, corner)| {
                let normal = corner.cross(next(i));
                if normal.dot(middle) < 0.0 {
                    -normal
                } else {
                    normal
                }
            })
            .collect();
        Self {
            narrow: corners.iter().all(|corner| corner.dot(middle) > 0.0),
            corners,
            middle,
            sides,
        }
    }

    /// The first corner that is outside of a side or not before the middle,
    /// within rounding.
    pub(crate) fn concave_corner(&self) -> Option<usize> {
        // Side normals of length 1, all turned the same way.
        let normal = |i: usize| {
            let next = self.corners[(i + 1) % self.corners.len()];
            self.corners[i].cross(next).normalize_or_zero()
        };
        let orientation = normal(0).dot(self.middle).signum();
        (0..self.corners.len()).find(|&i| {
            let corner = self.corners[i];
            !(corner.dot(self.middle) > 1e-9
                && normal(i).dot(self.middle) * orientation > 1e-9
                && self
                    .sides
                    .iter()
                    .all(|side| side.dot(corner) >= -1e-9 * side.length()))
        })
    }

    /// Whether a unit vector is inside, or within [`MARGIN`] of it.
    fn contains(&self, direction: DVec3) -> bool {
        // Without the first, the opposite of a cone thinner than the margin
        // would count as well.
        (!self.narrow || direction.dot(self.middle) >= 0.0)
            && self
                .sides
                .iter()
                .all(|side| side.dot(direction) >= -MARGIN * side.length().max(MARGIN))
    }

    /// The smallest and the largest angle between `axis` and a direction
    /// inside.
    pub(crate) fn angles(&self, axis: DVec3) -> [f64; 2] {
        let mut low = PI;
        let mut high = 0.0_f64;
        let mut meet = |angle: f64| {
            low = low.min(angle);
            high = high.max(angle);
        };
        for (i, &corner) in self.corners.iter().enumerate() {
            meet(angle_between(axis, corner));
            // On the great circle of an edge the angle is least where the axis
            // projects to, and largest opposite.
            let next = self.corners[(i + 1) % self.corners.len()];
            let normal = corner.cross(next);
            let Some(unit) = normal.try_normalize() else {
                continue;
            };
            let nearest = axis - unit * unit.dot(axis);
            for extreme in [nearest, -nearest] {
                if corner.cross(extreme).dot(normal) >= 0.0
                    && extreme.cross(next).dot(normal) >= 0.0
                    && extreme != DVec3::ZERO
                {
                    meet(angle_between(axis, extreme));
                }
            }
        }
        if self.contains(axis) {
            low = 0.0;
        }
        if self.contains(-axis) {
            high = PI;
        }
        [low, high]
    }

    /// The angles around an axis, seen along it: θ of the directions inside.
    pub(crate) fn around(&self, [axis, right, up]: [DVec3; 3]) -> Arc {
        if self.contains(axis) || self.contains(-axis) {
            return Arc::Full;
        }
        let flat: Vec<DVec2> = self
            .corners
            .iter()
            .map(|corner| DVec2::new(corner.dot(right), corner.dot(up)))
            .collect();
        Arc::spanned_by(&flat)
    }
}

impl Arc {
    /// The arc that holds a convex figure whose corners are given and which does
    /// not contain the origin; it is narrower than π. Full if they prove
    /// that wrong.
    pub(crate) fn spanned_by(corners: &[DVec2]) -> Self {
        let first = corners[0];
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        for corner in corners {
            let offset = first.perp_dot(*corner).atan2(first.dot(*corner));
            low = low.min(offset);
            high = high.max(offset);
        }
        if high - low >= PI {
            return Self::Full;
        }
        Self::Part {
            centre: first.y.atan2(first.x) + 0.5 * (low + high),
            half: 0.5 * (high - low),
        }
    }

    /// The angles that two arcs have in common; `None` if there are none. If each is at most π
    /// wide, they are one arc.
    pub(crate) fn intersection(self, other: Self) -> Option<Self> {
        let (a, b) = match (self, other) {
            (Self::Full, any) | (any, Self::Full) => return Some(any),
            (Self::Part { centre, half }, Self::Part { centre: c, half: h }) => {
                ((centre, half), (c, h))
            }
        };
        // The other's centre, seen from the first's.
        let shift = (b.0 - a.0 + PI).rem_euclid(2.0 * PI) - PI;
        let low = (-a.1).max(shift - b.1);
        let high = a.1.min(shift + b.1);
        (low <= high).then_some(Self::Part {
            centre: a.0 + 0.5 * (low + high),
            half: 0.5 * (high - low),
        })
    }
}

pub(crate) fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_far_from_the_middle_of_a_wide_triangle_is_inside() {
        // Two corners almost opposite to each other, the third next to one:
        // the lonely one is more than a right angle from the middle.
        let corners = [
            DVec3::new(1.0, 0.1, 0.0),
            DVec3::new(-1.0, 0.1, 0.0),
            DVec3::new(1.0, 0.1, 0.5),
        ]
        .map(DVec3::normalize);
        let inside = (corners[1] + 0.01 * (corners[0] + corners[2])).normalize();
        let cone = Cone::new(corners.to_vec());
        assert!(inside.dot(cone.middle) < 0.0);
        assert_eq!(cone.angles(inside)[0], 0.0);
        assert_eq!(cone.angles(-inside)[1], PI);
    }
}
