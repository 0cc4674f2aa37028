//! Strands as a light sees them.
//!
//! The outline of a piece of strand is a quadrilateral in the picture. Its area
//! within a texel, over that of the texel, is the share of the texel's light
//! that meets the piece: the coverage `c`, exact by clipping. With the opacity
//! `α`, the texel's light is reduced to `1 − c α` over the depths that the
//! piece has there. The mean over texels is exact for one strand of any width;
//! strands that cover the same texel count as independent of each other.

use glam::{DVec2, DVec3};
use transmittance::BlockerSegment;

#[cfg(feature = "wgpu")]
use super::candidates::{CandidateRecord, STRAND};
use super::view::{Texels, View};
use crate::scene::Piece;

/// A piece of a strand in the picture of a light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outline {
    corners: [DVec2; 4],
    /// The ends of the axis in local coordinates and in the picture.
    ends: [DVec3; 2],
    axis: [DVec2; 2],
    radius: f64,
    opacity: f64,
    /// The ends of the whole piece, part of which may be behind the origin.
    #[cfg(feature = "trace")]
    whole: [DVec3; 2],
}

/// The part of a pixel that a piece covers.
#[cfg(feature = "trace")]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Covered {
    /// Share of the pixel.
    pub(crate) coverage: f64,
    /// Position of the covered part's middle on the axis of the piece, as a share of its
    /// length.
    pub(crate) share: f64,
    /// Distance of that position from the origin, m.
    pub(crate) distance: f64,
}

impl Outline {
    /// `None` if the piece has no area in the picture: if it has no thickness or no length
    /// across the light, or is not in front of the light. The part that is nearer to the origin
    /// of central rays than its own radius is left out; if the origin is an eye, the part
    /// nearer than its thickness.
    pub(crate) fn new(view: &View, piece: &Piece) -> Option<Self> {
        let radius = f64::from(piece.radius);
        let whole = piece.axis.map(|point| view.local(point));
        let mut ends = whole;
        if !view.is_parallel() {
            let least = (view.nearest * radius).max(1e-6 * ends[0].z.max(ends[1].z));
            ends = in_front(ends, least)?;
        }
        let along = ends[1] - ends[0];
        // Light rays in this direction from the axis touch the cylinder.
        let towards = if view.is_parallel() {
            DVec3::Z
        } else {
            ends[0]
        };
        let side = radius * along.cross(towards).try_normalize()?;
        if radius == 0.0 || piece.opacity == 0.0 {
            return None;
        }
        let corners = [
            ends[0] + side,
            ends[1] + side,
            ends[1] - side,
            ends[0] - side,
        ];
        if !view.is_parallel() && corners.iter().any(|corner| corner.z <= 0.0) {
            return None;
        }
        Some(Self {
            corners: corners.map(|corner| view.texel(corner)),
            ends,
            axis: ends.map(|end| view.texel(end)),
            radius,
            opacity: piece.opacity.into(),
            #[cfg(feature = "trace")]
            whole,
        })
    }

    /// The texels that it may cover.
    pub(crate) fn texels(&self, view: &View) -> Option<Texels> {
        let min = self.corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
        let max = self
            .corners
            .into_iter()
            .fold(DVec2::NEG_INFINITY, DVec2::max);
        view.between(min, max)
    }

    /// Makes a candidate for shaders of it, in a face whose rows begin at `row`. The outline is
    /// shortened to what may be in the picture, and the axis to the part beside that outline.
    /// `None` if nothing of it is in the picture.
    #[cfg(feature = "wgpu")]
    pub(super) fn candidate(&self, view: &View, row: u32) -> Option<CandidateRecord> {
        let texels = self.texels(view)?;
        let low = DVec2::new(texels.x[0].into(), texels.y[0].into());
        let high = DVec2::new(texels.x[1].into(), texels.y[1].into());
        let [a, b, c, d] = shortened(self.corners, low, high)?;
        let [b, c, d, a] = shortened([b, c, d, a], low, high)?;
        let corners = [a, b, c, d];
        let (start, along) = (self.axis[0], self.axis[1] - self.axis[0]);
        if along == DVec2::ZERO {
            return None;
        }
        let shares = corners.map(|corner| (corner - start).dot(along) / along.length_squared());
        let (mut least, mut most) = (1.0_f64, 0.0_f64);
        for share in shares {
            (least, most) = (least.min(share.max(0.0)), most.max(share.min(1.0)));
        }
        // If the outline is beside one end of the axis only, any part of the axis with this end
        // gives the same depth, and the whole axis is such a part.
        if !(least < most) {
            (least, most) = (0.0, 1.0);
        }
        let [from, to] = self.ends;
        let end = |share: f64| {
            let share = if view.is_parallel() {
                share
            } else {
                self.share(share)
            };
            (from + (to - from) * share).as_vec3().to_array()
        };
        let corner = |index: usize| {
            let position = (corners[index] - low).as_vec2();
            let share = (shares[index] - least) / (most - least);
            [position.x, position.y, share as f32]
        };
        Some(CandidateRecord {
            a: end(least),
            radius: self.radius as f32,
            b: end(most),
            opacity: self.opacity as f32,
            corners: [0, 1, 2, 3].map(corner),
            ..CandidateRecord::new(STRAND, texels, row)
        })
    }

    /// Calls `put` with what it takes from each texel.
    pub(super) fn segments(
        &self,
        view: &View,
        texels: Texels,
        put: &mut dyn FnMut([usize; 2], BlockerSegment),
    ) {
        self.parts(texels, |[x, y], part, coverage| {
            if let Some(segment) = self.segment(view, part, coverage) {
                put([x as usize, y as usize], segment);
            }
        });
    }

    /// Calls `put` with what it covers of each pixel.
    #[cfg(feature = "trace")]
    pub(crate) fn covered(&self, texels: Texels, mut put: impl FnMut([u32; 2], Covered)) {
        let (start, along) = (self.axis[0], self.axis[1] - self.axis[0]);
        let [a, b] = self.ends;
        let axis = self.whole[1] - self.whole[0];
        self.parts(texels, |texel, part, coverage| {
            let share = (part.centroid() - start).dot(along) / along.length_squared();
            // This fails where the axis has no length in the picture.
            if share.is_finite() {
                let at = a + (b - a) * self.share(share.clamp(0.0, 1.0));
                put(
                    texel,
                    Covered {
                        coverage,
                        share: (at - self.whole[0]).dot(axis) / axis.length_squared(),
                        distance: at.length(),
                    },
                );
            }
        });
    }

    /// Calls `put` with its part in each texel, and the share of the texel that this covers.
    fn parts(&self, texels: Texels, mut put: impl FnMut([u32; 2], &Polygon, f64)) {
        let outline = Polygon::new(self.corners);
        for y in texels.y[0]..texels.y[1] {
            let row = f64::from(y);
            let strip = outline.clipped(1, row, row + 1.0);
            let Some([left, right]) = strip.extent() else {
                continue;
            };
            let first = (left.floor().max(0.0) as u32).max(texels.x[0]);
            let end = ((right.floor() + 1.0).max(0.0) as u32).min(texels.x[1]);
            for x in first..end {
                let column = f64::from(x);
                let part = strip.clipped(0, column, column + 1.0);
                let coverage = part.area().min(1.0);
                if coverage > 0.0 {
                    put([x, y], &part, coverage);
                }
            }
        }
    }

    /// What the part of the outline in one texel takes from it.
    fn segment(&self, view: &View, part: &Polygon, coverage: f64) -> Option<BlockerSegment> {
        let (start, along) = (self.axis[0], self.axis[1] - self.axis[0]);
        let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
        for &corner in part.corners() {
            let share = (corner - start).dot(along) / along.length_squared();
            let depth = self.depth(view, share.clamp(0.0, 1.0));
            (near, far) = (near.min(depth), far.max(depth));
        }
        let (entry, exit) = ((near - self.radius) as f32, (far + self.radius) as f32);
        let passed = 1.0 - coverage * self.opacity;
        // This fails only if the axis has no length in the picture.
        BlockerSegment::from_transmittance(entry, exit, passed.max(0.0) as f32).ok()
    }

    /// Depth of the axis at a position in the picture, given as a share of its length there.
    fn depth(&self, view: &View, share: f64) -> f64 {
        let [a, b] = self.ends;
        let share = if view.is_parallel() {
            share
        } else {
            self.share(share)
        };
        view.depth(a + (b - a) * share)
    }

    /// The position on the axis for a position in a picture of central rays, both as shares of
    /// the length.
    fn share(&self, share: f64) -> f64 {
        let [a, b] = self.ends;
        let (near, far) = ((1.0 - share) / a.z, share / b.z);
        far / (near + far)
    }
}

/// Shortens a quadrilateral at both ends, as far as these are sure to be outside of a
/// rectangle. Its long sides run from the first corner to the second and from the fourth to the
/// third, and are cut at the same shares of their lengths. `None` if nothing is left.
#[cfg(feature = "wgpu")]
fn shortened(corners: [DVec2; 4], low: DVec2, high: DVec2) -> Option<[DVec2; 4]> {
    let [a, b, c, d] = corners;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (axis, sign, limit) in [
        (0, 1.0, low.x),
        (1, 1.0, low.y),
        (0, -1.0, high.x),
        (1, -1.0, high.y),
    ] {
        // Where either side is within the limit: a cross-section with both ends beyond it is
        // beyond it as a whole.
        let (mut from, mut to) = (1.0_f64, 0.0_f64);
        for [start, end] in [[a, b], [d, c]] {
            let [here, there] = [start, end].map(|corner| sign * (corner[axis] - limit));
            let crossing = (here / (here - there)).clamp(0.0, 1.0);
            if here >= 0.0 {
                from = 0.0;
                to = to.max(if there >= 0.0 { 1.0 } else { crossing });
            }
            if there >= 0.0 {
                to = 1.0;
                from = from.min(if here >= 0.0 { 0.0 } else { crossing });
            }
        }
        first = first.max(from);
        last = last.min(to);
    }
    if !(first < last) {
        return None;
    }
    let at = |start: DVec2, end: DVec2, share: f64| match share {
        0.0 => start,
        1.0 => end,
        share => start + (end - start) * share,
    };
    Some([
        at(a, b, first),
        at(a, b, last),
        at(d, c, last),
        at(d, c, first),
    ])
}

/// The part of an axis with `z ≥ least`.
fn in_front(ends: [DVec3; 2], least: f64) -> Option<[DVec3; 2]> {
    let [a, b] = ends;
    let cut = |from: DVec3, to: DVec3| {
        if from.z >= least {
            from
        } else {
            from + (to - from) * ((least - from.z) / (to.z - from.z))
        }
    };
    (a.z.max(b.z) > least).then(|| [cut(a, b), cut(b, a)])
}

/// A convex polygon of at most eight corners: a quadrilateral cut four times.
#[derive(Debug, Clone, Copy)]
struct Polygon {
    corners: [DVec2; 8],
    len: usize,
}

impl Polygon {
    fn new(corners: [DVec2; 4]) -> Self {
        let mut polygon = Self {
            corners: [DVec2::ZERO; 8],
            len: 4,
        };
        polygon.corners[..4].copy_from_slice(&corners);
        polygon
    }

    fn corners(&self) -> &[DVec2] {
        &self.corners[..self.len]
    }

    /// The part between two values of a coordinate.
    fn clipped(&self, axis: usize, low: f64, high: f64) -> Self {
        self.cut(axis, 1.0, low).cut(axis, -1.0, high)
    }

    /// The part with `sign × coordinate ≥ sign × limit`.
    fn cut(&self, axis: usize, sign: f64, limit: f64) -> Self {
        let mut part = Self {
            corners: [DVec2::ZERO; 8],
            len: 0,
        };
        let mut push = |corner: DVec2| {
            // Rounding may add a ninth corner, which is dropped.
            if part.len < 8 {
                part.corners[part.len] = corner;
                part.len += 1;
            }
        };
        let corners = self.corners();
        for (index, &from) in corners.iter().enumerate() {
            let to = corners[(index + 1) % corners.len()];
            let (a, b) = (sign * (from[axis] - limit), sign * (to[axis] - limit));
            if a >= 0.0 {
                push(from);
            }
            if (a < 0.0) != (b < 0.0) {
                let mut corner = from + (to - from) * (a / (a - b));
                corner[axis] = limit;
                push(corner);
            }
        }
        part
    }

    /// Smallest and largest column; `None` if it is empty.
    fn extent(&self) -> Option<[f64; 2]> {
        let columns = || self.corners().iter().map(|corner| corner.x);
        (self.len > 0).then(|| {
            [
                columns().fold(f64::INFINITY, f64::min),
                columns().fold(f64::NEG_INFINITY, f64::max),
            ]
        })
    }

    /// Its centroid; the mean of its corners if it has no area.
    #[cfg(feature = "trace")]
    fn centroid(&self) -> DVec2 {
        let corners = self.corners();
        let first = corners[0];
        let (mut area, mut moment, mut sum) = (0.0, DVec2::ZERO, DVec2::ZERO);
        for pair in corners.windows(2) {
            let (a, b) = (pair[0] - first, pair[1] - first);
            let twice = a.perp_dot(b);
            area += twice;
            moment += twice * (a + b) / 3.0;
            sum += b;
        }
        match area {
            0.0 => first + sum / corners.len() as f64,
            area => first + moment / area,
        }
    }

    fn area(&self) -> f64 {
        let Some((&first, rest)) = self.corners().split_first() else {
            return 0.0;
        };
        let twice: f64 = rest
            .windows(2)
            .map(|pair| (pair[0] - first).perp_dot(pair[1] - first))
            .sum();
        0.5 * twice.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_polygon_add_up_to_it() {
        let corners = [(0.3, -2.0), (7.4, 3.1), (6.9, 4.2), (-0.4, -1.2)];
        let whole = Polygon::new(corners.map(DVec2::from));
        let mut sum = 0.0;
        for y in -3..6 {
            for x in -2..9 {
                let (x, y) = (f64::from(x), f64::from(y));
                let part = whole.clipped(1, y, y + 1.0).clipped(0, x, x + 1.0);
                assert!(part.area() <= 1.0 + 1e-12);
                sum += part.area();
            }
        }
        assert!((sum - whole.area()).abs() < 1e-12, "{sum}");
    }

    #[cfg(feature = "wgpu")]
    #[test]
    fn a_quadrilateral_is_cut_at_a_rectangle_and_nothing_is_left_beside_it() {
        let (low, high) = (DVec2::ZERO, DVec2::splat(10.0));
        let along = |from: (f64, f64), to: (f64, f64)| {
            let (from, to) = (DVec2::from(from), DVec2::from(to));
            [from, to, to + DVec2::Y, from + DVec2::Y]
        };
        let cut = shortened(along((-5.0, 4.0), (15.0, 4.0)), low, high);
        assert_eq!(cut, Some(along((0.0, 4.0), (10.0, 4.0))));
        // The box around it meets the rectangle, but it passes by a corner.
        let beside = along((-8.0, 4.0), (2.0, -6.0));
        assert_eq!(shortened(beside, low, high), None);
    }
}
