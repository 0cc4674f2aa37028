//! Which light rays a triangle can block.

use std::f64::consts::PI;
use std::ops::Range;

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::cone::{Arc, Cone};
use crate::{Angle, Lattice, Phi};

/// A box of voxels along θ and φ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Footprint {
    /// The planes θ, counted onwards from one; modulo their number if the
    /// range of θ wraps.
    pub planes: Range<u32>,
    /// The bits.
    pub bits: Range<u32>,
}

impl Lattice {
    /// The voxels along θ and φ whose light rays can meet a triangle, or more;
    /// `None` if a corner is not finite.
    pub fn footprint<V: Copy + Into<[f32; 3]>>(&self, triangle: &[V; 3]) -> Option<Footprint> {
        Footprint::new(self, &triangle.map(|corner| Vec3::from(corner.into())))
    }
}

impl Footprint {
    fn new(lattice: &Lattice, triangle: &[Vec3; 3]) -> Option<Self> {
        if !triangle.iter().all(|corner| corner.is_finite()) {
            return None;
        }
        let space = lattice.space();
        let [axis, right, up] = space.frame64();
        // Seen from where light rays begin: the frame is rounded, and the light
        // is not exactly on the axis through the eye.
        let light = space.light().at();
        let origin = light.unwrap_or(space.eye_point()).as_dvec3();
        let corners = triangle.map(|corner| corner.as_dvec3() - origin);
        let flat = corners.map(|v| DVec2::new(v.dot(right), v.dot(up)));
        let nearest = distance_of_origin(&flat);
        let longest = |lengths: [f64; 3]| lengths.into_iter().fold(0.0, f64::max);
        // Light rays are off by 16 roundings of their length; next to the axis
        // that is more than the voxel that is allowed for.
        let size = longest(corners.map(DVec3::length));
        let voxels_per_radian =
            f64::from(lattice.resolution().theta()) / lattice.ranges().theta_extent();
        let around = if nearest <= 1e-6 * size * voxels_per_radian {
            Arc::Full
        } else {
            Arc::spanned_by(&flat)
        };
        let phi = if light.is_none() {
            [nearest, longest(flat.map(DVec2::length))]
                .map(|distance| Vec2::new(1.0, distance as f32))
        } else {
            let directions = corners.map(DVec3::try_normalize);
            match directions.into_iter().collect::<Option<Vec<DVec3>>>() {
                Some(directions) => Cone::new(directions)
                    .angles(-axis)
                    .map(|phi| DVec2::new(phi.cos(), phi.sin().max(0.0)).as_vec2()),
                // The light is at a corner.
                None => [Vec2::X, Vec2::NEG_X],
            }
        };
        let bits = lattice.resolution().bits();
        // One voxel more on each side for rounding.
        let [low, high] = phi.map(|pair| lattice.phi_position(Phi::of(pair)));
        let first = (low as u32).saturating_sub(1);
        let end = (high as u32 + 2).min(bits);
        Some(Self {
            planes: planes(lattice, around),
            bits: first..end,
        })
    }
}

fn planes(lattice: &Lattice, around: Arc) -> Range<u32> {
    let count = lattice.resolution().theta();
    let Arc::Part { centre, half } = around else {
        return 0..count;
    };
    let scale = f64::from(count) / lattice.ranges().theta_extent();
    let middle = f64::from(lattice.theta_position(Angle::from_radians(centre)));
    let reach = half * scale;
    let (low, high) = (middle - reach, middle + reach);
    if lattice.ranges().wraps() {
        let turn = f64::from(count);
        let low = low.floor() - 1.0;
        let length = (high.floor() + 2.0 - low).min(turn);
        let first = low.rem_euclid(turn) as u32 % count;
        return first..first + length as u32;
    }
    // The part of the arc that lies in the range may begin a turn earlier.
    let turn = 2.0 * PI * scale;
    let reaches = |shift: f64| {
        let low = (low + shift).floor() - 1.0;
        let high = (high + shift).floor() + 2.0;
        let (low, high) = (low.max(0.0), high.min(f64::from(count)));
        (low < high).then_some((low as u32, high as u32))
    };
    [-turn, 0.0, turn]
        .into_iter()
        .filter_map(reaches)
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        .map_or(0..0, |(first, end)| first..end)
}

/// The distance between the origin and a triangle in the plane.
fn distance_of_origin(corners: &[DVec2; 3]) -> f64 {
    let edge = |i: usize| (corners[i], corners[(i + 1) % 3]);
    let turns = [0, 1, 2].map(|i| edge(i).0.perp_dot(edge(i).1));
    if turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0) {
        // Inside, or on the line of a degenerate triangle: too near is safe.
        return 0.0;
    }
    (0..3)
        .map(|i| {
            let (a, b) = edge(i);
            let along = b - a;
            let length2 = along.length_squared();
            let t = if length2 > 0.0 {
                (-a.dot(along) / length2).clamp(0.0, 1.0)
            } else {
                0.0
            };
            (a + t * along).length()
        })
        .fold(f64::INFINITY, f64::min)
}
