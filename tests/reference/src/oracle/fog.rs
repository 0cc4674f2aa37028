//! The medium in f64, and the way of light through its box.

use glam::DVec3;
use scene::Medium;

use super::{Line, Phase, Span};

/// A homogeneous medium.
#[derive(Debug, Clone, Copy)]
pub struct Fog {
    /// Scattering, 1/m.
    pub sigma_s: DVec3,
    /// Extinction, 1/m.
    pub sigma_t: DVec3,
    phase: Phase,
    /// Least and greatest corner, `None` if it is everywhere.
    corners: Option<[DVec3; 2]>,
}

impl Fog {
    /// Reads a medium.
    pub fn new(medium: &Medium) -> Self {
        let sigma_s = medium.sigma_s().as_dvec3();
        Self {
            sigma_s,
            sigma_t: sigma_s + medium.sigma_a().as_dvec3(),
            phase: medium.phase().into(),
            corners: medium
                .bounds()
                .map(|bounds| [bounds.min().as_dvec3(), bounds.max().as_dvec3()]),
        }
    }

    /// The medium's phase function, as [`Phase::at`] has it.
    pub fn phase(&self, sin2: f64, cos2: f64) -> f64 {
        self.phase.at(sin2, cos2)
    }

    /// The part of `line` inside the medium, `None` if they miss each other.
    pub fn inside(&self, line: &Line) -> Option<Span> {
        let mut part = Span::new(0.0, line.length);
        let Some([low, high]) = self.corners else {
            return (part.start < part.end).then_some(part);
        };
        for axis in 0..3 {
            let slope = line.direction[axis];
            let (to_low, to_high) = (
                low[axis] - line.origin[axis],
                high[axis] - line.origin[axis],
            );
            if slope == 0.0 {
                if to_low > 0.0 || to_high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (to_low / slope, to_high / slope);
            part = part.intersect(Span::new(a.min(b), a.max(b)))?;
        }
        Some(part)
    }

    /// Whether a point lies in the medium.
    pub fn contains(&self, point: DVec3) -> bool {
        self.corners
            .is_none_or(|[low, high]| point.cmpge(low).all() && point.cmple(high).all())
    }

    /// How much of the way from a light at `from` to the point `to`, which
    /// lies in the medium, runs through it: between 0 and 1.
    pub fn share_inside(&self, from: DVec3, to: DVec3) -> f64 {
        let Some(corners) = self.corners else {
            return 1.0;
        };
        let mut entry = 0.0_f64;
        for axis in 0..3 {
            if let Some(face) = face_between(corners, from, axis) {
                let way = to[axis] - from[axis];
                if way != 0.0 {
                    entry = entry.max((face - from[axis]) / way);
                }
            }
        }
        1.0 - entry.clamp(0.0, 1.0)
    }

    /// How far light from the direction `toward` has come inside the medium to
    /// the point `to` in it; 0 in an unbounded medium.
    pub fn sunlight_inside(&self, toward: DVec3, to: DVec3) -> f64 {
        let Some([low, high]) = self.corners else {
            return 0.0;
        };
        let mut way = f64::INFINITY;
        for axis in 0..3 {
            let slope = toward[axis];
            if slope != 0.0 {
                let face = if slope > 0.0 { high[axis] } else { low[axis] };
                way = way.min((face - to[axis]) / slope);
            }
        }
        way.max(0.0)
    }

    /// Appends where along `line` the light from a point at `from` changes the
    /// face through which it enters the box.
    pub fn point_edges(&self, line: &Line, from: DVec3, edges: &mut Vec<f64>) {
        let Some(corners) = self.corners else {
            return;
        };
        let to_origin = line.origin - from;
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (Some(a), Some(b)) = (
                face_between(corners, from, i),
                face_between(corners, from, j),
            ) else {
                continue;
            };
            // (a − P_i) / (X_i − P_i) = (b − P_j) / (X_j − P_j), linear in x.
            let (a, b) = (a - from[i], b - from[j]);
            let slope = a * line.direction[j] - b * line.direction[i];
            let root = (b * to_origin[i] - a * to_origin[j]) / slope;
            if root.is_finite() {
                edges.push(root);
            }
        }
    }

    /// The same for light from the direction `toward`.
    pub fn sun_edges(&self, line: &Line, toward: DVec3, edges: &mut Vec<f64>) {
        let Some([low, high]) = self.corners else {
            return;
        };
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let face = |axis: usize| if toward[axis] > 0.0 { high } else { low }[axis];
            // (face_i − X_i) / t_i = (face_j − X_j) / t_j, linear in x.
            let slope = toward[j] * line.direction[i] - toward[i] * line.direction[j];
            let value =
                toward[j] * (face(i) - line.origin[i]) - toward[i] * (face(j) - line.origin[j]);
            let root = value / slope;
            if root.is_finite() {
                edges.push(root);
            }
        }
    }
}

/// The coordinate of the face that separates `point` from the box on one axis,
/// `None` if the point is not outside on that axis.
fn face_between([low, high]: [DVec3; 2], point: DVec3, axis: usize) -> Option<f64> {
    if point[axis] < low[axis] {
        Some(low[axis])
    } else if point[axis] > high[axis] {
        Some(high[axis])
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use scene::{Bounds, PhaseFunction};

    use super::*;

    fn unit_box() -> Fog {
        let bounds = Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap();
        let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        Fog::new(&medium.within(bounds))
    }

    #[test]
    fn light_from_outside_is_only_dimmed_in_the_box() {
        let fog = unit_box();
        let to = DVec3::new(0.5, 0.75, 0.5);
        let share = fog.share_inside(DVec3::new(0.5, 3.0, 0.5), to);
        assert!((share - 0.25 / 2.25).abs() < 1e-15);
        assert_eq!(fog.share_inside(DVec3::splat(0.2), to), 1.0);
        assert_eq!(fog.sunlight_inside(DVec3::Y, to), 0.25);
        let slanted = DVec3::new(1.0, 1.0, 0.0).normalize();
        assert!((fog.sunlight_inside(slanted, to) - 0.25 * 2.0_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn the_entry_changes_its_face_at_the_edge() {
        let fog = unit_box();
        let line = Line {
            origin: DVec3::new(-1.0, 0.5, 0.5),
            direction: DVec3::X,
            length: 3.0,
        };
        let mut edges = Vec::new();
        let toward = DVec3::new(1.0, 1.0, 0.0).normalize();
        fog.sun_edges(&line, toward, &mut edges);
        assert!(
            edges.iter().any(|edge| (edge - 1.5).abs() < 1e-12),
            "{edges:?}"
        );
        edges.clear();
        fog.point_edges(&line, DVec3::new(3.0, 3.0, 0.5), &mut edges);
        // Through the box's edge at (1, 1) and on to (½, ½).
        assert_eq!(edges.len(), 1);
        assert!((edges[0] - 1.5).abs() < 1e-12, "{edges:?}");
    }
}
