//! Which parts of a ray see a light, exactly.
//!
//! Light reaches a ray within a planar region: the triangle between eye, end
//! of the ray and light, or for the sun the strip from the ray towards it. A
//! triangle of the scene cuts the plane of that region in a segment; seen from
//! the light the segment covers one interval of the ray. What no segment covers
//! is lit.
//!
//! # Conventions at the edges
//!
//! A corner exactly in the plane counts as lying on its positive side, for
//! every triangle alike. So a triangle that lies in the plane as a whole casts
//! no shadow of its own, its neighbours in a closed mesh do, and no light leaks
//! through an edge that two triangles share. The same holds along the ray if
//! the light is on its line: the region is then only the line itself, the
//! light is seen up to the first hit on either side of it.
//!
//! A blocker counts if it is strictly between the ray and the light, at
//! whatever distance from either.

use glam::{DVec2, DVec3};
use scene::{Caster, Geometry, Ray};

use super::blockers::Tree;
use super::span::Dark;
use super::{Lamp, Line, Span};

/// Less than this, relative to the size of the numbers at hand, is rounding.
const ROUNDING: f64 = 1e-12;

/// The triangles of a scene, ready to be asked for shadows.
#[derive(Debug)]
pub struct Blockers {
    triangles: Vec<[DVec3; 3]>,
    tree: Tree,
}

/// How candidates for blockers are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Search {
    /// By a bounding volume hierarchy.
    Tree,
    /// All triangles, one after the other.
    BruteForce,
}

impl Blockers {
    /// The solid triangles of a scene; the others are the affair of
    /// [`Coats`](super::coats::Coats).
    pub fn new(geometry: &Geometry) -> Self {
        let triangles = geometry.triangles().iter().enumerate();
        let is_solid = |index: usize| geometry.caster(index) == Caster::Solid;
        Self::from_triangles(
            triangles
                .filter(|(index, _)| is_solid(*index))
                .map(|(_, corners)| corners.map(|corner| corner.as_dvec3()))
                .collect(),
        )
    }

    /// Builds the hierarchy over triangles with coordinates of at most 1e30.
    pub fn from_triangles(triangles: Vec<[DVec3; 3]>) -> Self {
        Self {
            tree: Tree::new(&triangles),
            triangles,
        }
    }

    /// The triangles.
    pub fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// Appends the parts of `span` of `line` that see `lamp`, in order.
    pub fn lit(&self, line: &Line, lamp: &Lamp, span: Span, search: Search, lit: &mut Vec<Span>) {
        let region = Region::new(line, lamp, span);
        let mut dark = Dark::default();
        let visit = |dark: &mut Dark, index: usize| {
            if let Some(shadow) = region.shadow(&self.triangles[index]) {
                dark.add(shadow);
            }
            // Nothing more to learn once all of the span is dark.
            dark.contains(span)
        };
        match search {
            Search::Tree if self.triangles.is_empty() => {}
            Search::Tree => self.tree.search(&region, &mut dark, visit),
            Search::BruteForce => {
                for index in 0..self.triangles.len() {
                    visit(&mut dark, index);
                }
            }
        }
        let end = if span.end.is_finite() { span.end } else { 0.0 };
        let scale = line.origin.abs().max_element() + end.max(span.start).max(region.foot.abs());
        dark.leave(span, ROUNDING * scale, lit);
    }

    /// The lit parts of the whole ray, whatever the light's emission and range.
    pub fn lit_parts(&self, ray: &Ray, lamp: &Lamp, search: Search) -> Vec<Span> {
        let line = Line::new(ray);
        let mut lit = Vec::new();
        if line.length > 0.0 {
            self.lit(&line, lamp, Span::new(0.0, line.length), search, &mut lit);
        }
        lit
    }
}

/// The planar region between a part of a line and a light. In the plane, `u`
/// runs along the line and `v` from the line towards the light.
#[derive(Debug)]
pub(super) struct Region {
    origin: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    span: Span,
    /// `u` of the light, 0 for the sun.
    foot: f64,
    light: Place,
}

#[derive(Debug, Clone, Copy)]
enum Place {
    /// Above the foot point at this height `v`.
    Height(f64),
    /// At infinity: what is at height `v` casts its shadow `v × slant` behind.
    Slant(f64),
    /// On the line itself, at the foot point.
    OnLine,
    /// At infinity along the line: +1 ahead, −1 behind the eye.
    AlongLine(f64),
}

/// A half-space `normal · (p − origin) ≤ limit` that contains the region.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfSpace {
    pub(super) normal: DVec3,
    pub(super) limit: f64,
}

impl Region {
    pub(super) fn new(line: &Line, lamp: &Lamp, span: Span) -> Self {
        let w = line.direction;
        let (foot, height, light) = match lamp {
            Lamp::Point(point) => {
                let (foot, offset) = line.nearest(point.position);
                let h = offset.length();
                let scale = (point.position - line.origin).length();
                let light = if h > ROUNDING * scale {
                    Place::Height(h)
                } else {
                    Place::OnLine
                };
                (foot, -offset, light)
            }
            Lamp::Sun(sun) => {
                let along = sun.toward.dot(w);
                let across = w.cross(sun.toward.cross(w));
                let sine = across.length();
                let light = if sine > ROUNDING {
                    Place::Slant(along / sine)
                } else {
                    Place::AlongLine(along.signum())
                };
                (0.0, across, light)
            }
        };
        let v = match light {
            Place::Height(_) | Place::Slant(_) => height.normalize(),
            Place::OnLine | Place::AlongLine(_) => w.any_orthonormal_vector(),
        };
        Self {
            origin: line.origin,
            u: w,
            v,
            normal: w.cross(v),
            span,
            foot,
            light,
        }
    }

    /// The interval of the line that the triangle hides from the light.
    pub(super) fn shadow(&self, triangle: &[DVec3; 3]) -> Option<Span> {
        let [p, q] = self.cut(triangle)?;
        let x = match self.light {
            Place::Height(h) => {
                let [p, q] = clip(p, q, h)?;
                match (self.cast_from(p, h), self.cast_from(q, h)) {
                    (Some(a), Some(b)) => [a, b],
                    // A segment towards the light hides a single point.
                    (Some(a), None) | (None, Some(a)) => [a, a],
                    (None, None) => return None,
                }
            }
            Place::Slant(slant) => {
                let [p, q] = clip(p, q, f64::INFINITY)?;
                [p, q].map(|[u, v]| u - v * slant)
            }
            Place::OnLine => {
                let hit = crossing(p, q)?;
                if hit < self.foot {
                    [f64::NEG_INFINITY, hit]
                } else {
                    [hit, f64::INFINITY]
                }
            }
            Place::AlongLine(ahead) => {
                let hit = crossing(p, q)?;
                if ahead > 0.0 {
                    [f64::NEG_INFINITY, hit]
                } else {
                    [hit, f64::INFINITY]
                }
            }
        };
        let shadow = Span::new(x[0].min(x[1]), x[0].max(x[1]));
        (shadow.start < self.span.end && shadow.end > self.span.start).then_some(shadow)
    }

    /// Where the light casts the point (`u`, `v`), 0 ≤ v ≤ h, on the line;
    /// `None` for the light itself.
    fn cast_from(&self, [u, v]: [f64; 2], h: f64) -> Option<f64> {
        let aside = u - self.foot;
        let rounding = ROUNDING * (h + self.foot.abs());
        if h - v <= rounding && aside.abs() <= rounding {
            None
        } else if v < h {
            Some(u + aside * (v / (h - v)))
        } else {
            Some(aside * f64::INFINITY)
        }
    }

    /// The segment in which the triangle cuts the plane, as (u, v).
    fn cut(&self, triangle: &[DVec3; 3]) -> Option<[[f64; 2]; 2]> {
        let corners = triangle.map(|corner| corner - self.origin);
        let sides = corners.map(|corner| self.normal.dot(corner));
        let above = sides.map(|side| side >= 0.0);
        if above == [true; 3] || above == [false; 3] {
            return None;
        }
        let point = |i: usize| [self.u.dot(corners[i]), self.v.dot(corners[i])];
        let mut ends = [[0.0; 2]; 2];
        let mut count = 0;
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if above[i] == above[j] {
                continue;
            }
            // From the negative to the positive corner, so that a neighbour
            // that shares the edge computes the same bits.
            let (low, high) = if above[j] { (i, j) } else { (j, i) };
            let t = sides[low] / (sides[low] - sides[high]);
            let (a, b) = (point(low), point(high));
            ends[count] = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
            count += 1;
        }
        Some(ends)
    }

    /// Half-spaces whose intersection contains the region, up to six of them:
    /// the two sides of the plane, the line, the light, the two ends.
    pub(super) fn half_spaces(&self) -> Vec<HalfSpace> {
        let mut all = Vec::with_capacity(8);
        let mut add = |normal: DVec3, limit: f64| all.push(HalfSpace { normal, limit });
        add(self.normal, 0.0);
        add(-self.normal, 0.0);
        add(-self.v, 0.0);
        // In the plane, the unit vector from the point `x` of the line to the light.
        let toward = |x: f64| match self.light {
            Place::Height(h) => DVec2::new(self.foot - x, h).normalize(),
            Place::Slant(slant) => DVec2::new(slant, 1.0).normalize(),
            Place::OnLine | Place::AlongLine(_) => DVec2::Y,
        };
        let (mut low, mut high) = (self.span.start, self.span.end);
        match self.light {
            Place::Height(h) => add(self.v, h),
            Place::Slant(_) => {}
            Place::OnLine => {
                add(self.v, 0.0);
                (low, high) = (low.min(self.foot), high.max(self.foot));
            }
            Place::AlongLine(ahead) => {
                add(self.v, 0.0);
                let light = ahead * f64::INFINITY;
                (low, high) = (low.min(light), high.max(light));
            }
        }
        if low.is_finite() {
            let t = toward(low);
            add(t.x * self.v - t.y * self.u, -t.y * low);
        }
        if high.is_finite() {
            let t = toward(high);
            add(t.y * self.u - t.x * self.v, t.y * high);
        }
        all
    }

    /// A part of the span that holds the shadow of whatever is in the box of
    /// this centre and half extent, if the box stays below the light.
    pub(super) fn shadow_of_box(&self, centre: DVec3, half: DVec3) -> Option<Span> {
        let offset = centre - self.origin;
        let extent = |axis: DVec3| {
            let (middle, reach) = (axis.dot(offset), axis.abs().dot(half));
            let slack = 1e-9 * (offset.length() + half.length());
            [middle - reach - slack, middle + reach + slack]
        };
        let (u, v) = (extent(self.u), extent(self.v).map(|v| v.max(0.0)));
        let cast = |u: f64, v: f64| match self.light {
            Place::Height(h) if v < h * (1.0 - 1e-9) => Some(u + (u - self.foot) * (v / (h - v))),
            Place::Slant(slant) => Some(u - v * slant),
            _ => None,
        };
        // Monotone in u and in v, so that the corners are the extremes.
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (u, v) in [(u[0], v[0]), (u[0], v[1]), (u[1], v[0]), (u[1], v[1])] {
            let x = cast(u, v)?;
            (low, high) = (low.min(x), high.max(x));
        }
        let slack = 1e-9 * low.abs().max(high.abs());
        Some(Span::new(
            (low - slack).max(self.span.start),
            (high + slack).min(self.span.end),
        ))
    }

    /// How far a point is from the light; for a sun, from any plane across it.
    pub(super) fn depth(&self, point: DVec3) -> f64 {
        let offset = point - self.origin;
        match self.light {
            Place::Height(h) => (offset - self.foot * self.u - h * self.v).length_squared(),
            Place::Slant(slant) => -offset.dot(slant * self.u + self.v),
            Place::OnLine | Place::AlongLine(_) => 0.0,
        }
    }

    pub(super) fn origin(&self) -> DVec3 {
        self.origin
    }
}

/// The part of the segment with 0 ≤ v ≤ `top`; `None` if it has no length
/// above 0 or touches only.
fn clip(p: [f64; 2], q: [f64; 2], top: f64) -> Option<[[f64; 2]; 2]> {
    let ([mut low, mut high], flipped) = if p[1] <= q[1] {
        ([p, q], false)
    } else {
        ([q, p], true)
    };
    if high[1] <= 0.0 || low[1] >= top {
        return None;
    }
    let ([u0, v0], [u1, v1]) = (low, high);
    let at = |v: f64| u0 + (u1 - u0) * ((v - v0) / (v1 - v0));
    if v0 < 0.0 {
        low = [at(0.0), 0.0];
    }
    if v1 > top {
        high = [at(top), top];
    }
    Some(if flipped { [high, low] } else { [low, high] })
}

/// `u` at which the segment crosses the line v = 0.
fn crossing(p: [f64; 2], q: [f64; 2]) -> Option<f64> {
    let (low, high) = match (p[1] >= 0.0, q[1] >= 0.0) {
        (false, true) => (p, q),
        (true, false) => (q, p),
        _ => return None,
    };
    Some(low[0] + (high[0] - low[0]) * (low[1] / (low[1] - high[1])))
}
