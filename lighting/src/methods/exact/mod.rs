//! Lit intervals whose ends are computed, not sampled.

#[cfg(test)]
mod caster_tests;
#[cfg(feature = "methods")]
mod method;

#[cfg(feature = "methods")]
pub(super) use method::methods;

use std::borrow::Borrow;
use std::cell::RefCell;

use glam::{DVec2, DVec3, Vec3};

use crate::scene::Caster;
use crate::scene::trace::{Line, Tracer};
use crate::visibility::{LitInterval, Share, VisibilitySource};
use crate::{Emitter, Interval, LightPath};

/// Computes the lit intervals of a ray from the triangles of the scene.
///
/// The blockers of a ray are the triangles that meet the planar triangle
/// (eye, end of the ray, light) — for a sun the strip from the ray towards
/// it. Each cuts the plane in a segment, and the segment, seen from the light,
/// shadows one interval of the ray. The union of those intervals is the
/// shadow. All of it is computed in f64, so ends are right to the rounding of
/// an f32 distance.
///
/// Where a triangle is masked, the segment is walked texel by texel and shadows
/// what its covered parts do, with ends as exact. A see-through triangle
/// multiplies the share of the light behind each part of its segment by what
/// passes there, as [`Coating::along`] cuts it. What is see-through between the
/// eye and a part of the ray is the gather's business, see
/// [`EyePanes`](crate::EyePanes). Triangles that cast no shadow are left out.
///
/// Cost: one walk of the hierarchy per ray, along the whole planar triangle;
/// it grows with the number of blockers, not with a number of samples. Parts of
/// the hierarchy whose whole shadow is already known to be dark are skipped. A
/// triangle whose plane contains the light is seen edge-on and blocks nothing.
/// Masks and see-through triangles cost in proportion to the texels that the
/// plane crosses.
///
/// [`Coating::along`]: crate::scene::Coating::along
#[derive(Debug, Clone, Copy)]
pub struct Exact<T> {
    tracer: T,
}

impl<T: Borrow<Tracer>> Exact<T> {
    /// Visibility among the triangles of `tracer`.
    pub fn new(tracer: T) -> Self {
        Self { tracer }
    }

    /// Whether no triangle takes anything of the light of any part of the path:
    /// [`lit_intervals`](VisibilitySource::lit_intervals) are then its whole span as it is.
    ///
    /// The first shadow that is found ends the walk.
    pub fn is_wholly_lit(&self, path: &LightPath<'_>) -> bool {
        !self.shadow_until(path, Shadow::darkens).darkens()
    }

    fn shadow(&self, path: &LightPath<'_>) -> Shadow {
        self.shadow_until(path, |_| false)
    }

    /// The shadow, or as much of it as is found until `is_enough`.
    fn shadow_until(&self, path: &LightPath<'_>, is_enough: impl Fn(&Shadow) -> bool) -> Shadow {
        let mut shadow = Shadow::new(path.span());
        let tracer = self.tracer.borrow();
        let coatings = tracer.coatings();
        let Some(plane) = Plane::new(path) else {
            self.collinear(path, &mut shadow);
            return shadow;
        };
        // The closures of the walk share the shadow found so far.
        let shadow = RefCell::new(shadow);
        tracer.walk(
            |centre, half| {
                let (a, b) = plane.shadow_of_box(centre, half)?;
                shadow.borrow().clip(a, b)
            },
            |(a, b)| {
                let shadow = shadow.borrow();
                shadow.covers(a, b) || is_enough(&shadow)
            },
            |triangle, index| match coatings.caster(index) {
                Caster::Solid => {
                    if let Some((a, b)) = plane.shadow_of_triangle(triangle) {
                        shadow.borrow_mut().insert(a, b);
                    }
                }
                Caster::Masked(coating) | Caster::SeeThrough(coating) => {
                    let Some([p, q]) = plane.cut(triangle) else {
                        return;
                    };
                    let at = |t: f64| {
                        let (p, q) = (p.in_plane, q.in_plane);
                        (p.0 + t * (q.0 - p.0), p.1 + t * (q.1 - p.1))
                    };
                    let mut shadow = shadow.borrow_mut();
                    let whole = plane.project(p.in_plane, q.in_plane);
                    if whole.is_none_or(|(a, b)| shadow.clip(a, b).is_none()) {
                        return;
                    }
                    coating.along(p.in_triangle(), q.in_triangle(), |part| {
                        if part.transmittance != Vec3::ONE
                            && let Some((a, b)) = plane.project(at(part.from), at(part.to))
                        {
                            shadow.filter(a, b, part.transmittance);
                        }
                    });
                }
                _ => {}
            },
        );
        shadow.into_inner()
    }

    /// The light lies on the line of the ray: the planar triangle is a line.
    fn collinear(&self, path: &LightPath<'_>, shadow: &mut Shadow) {
        let line = Line::new(path.ray().origin(), path.ray().direction());
        // Where the light is on the line: at a distance, or infinitely far
        // ahead or behind.
        let light = match path.emitter() {
            Emitter::Point(_) => f64::from(path.foot()),
            Emitter::Directional(sun) => {
                if sun.direction().dot(path.ray().direction()) < 0.0 {
                    f64::INFINITY
                } else {
                    f64::NEG_INFINITY
                }
            }
        };
        let everything = (f64::NEG_INFINITY, f64::INFINITY);
        let tracer = self.tracer.borrow();
        let mut met = Vec::new();
        tracer.walk(
            |centre, half| line.touches(centre, half).then_some(everything),
            |_| false,
            |triangle, index| {
                let caster = tracer.coatings().caster(index);
                if caster != Caster::Absent
                    && let Some((t, u, v)) = line.meets(triangle)
                {
                    let transmittance = caster.transmittance_at(u, v);
                    // Neighbours meet the line in their common edge: once is enough.
                    let is_on_edge = u.min(v).min(1.0 - u - v) <= 1e-9;
                    if is_on_edge && transmittance != Vec3::ZERO {
                        let is_known = |known: &f64| (known - t).abs() <= 1e-9 * t.abs();
                        if met.iter().any(is_known) {
                            return;
                        }
                        met.push(t);
                    }
                    // What is on the far side of the blocker, as the light
                    // sees it, is dark.
                    if t < light {
                        shadow.filter(f64::NEG_INFINITY, t, transmittance);
                    } else {
                        shadow.filter(t, f64::INFINITY, transmittance);
                    }
                }
            },
        );
    }
}

/// Whether something in a box may be between a part of the path and its light.
#[cfg(feature = "methods")]
pub(crate) fn may_shadow(bounds: crate::scene::Bounds, path: &LightPath<'_>) -> bool {
    let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
    let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
    match Plane::new(path) {
        Some(plane) => {
            let shadow = plane.shadow_of_box(centre, half);
            shadow.is_some_and(|(a, b)| Shadow::new(path.span()).clip(a, b).is_some())
        }
        None => Line::new(path.ray().origin(), path.ray().direction()).touches(centre, half),
    }
}

impl<T: Borrow<Tracer> + Sync> VisibilitySource for Exact<T> {
    type Share = Vec3;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<Vec3>>) {
        let Interval { start, end } = path.span();
        let Shadow {
            intervals, filters, ..
        } = self.shadow(path);
        let mut filters = Filters::new(filters);
        let mut put = |start: f32, end: f32| {
            if start < end {
                filters.split(start, end, lit);
            }
        };
        let mut lit_from = start;
        for (a, b) in intervals {
            let dark_from = (a as f32).min(end);
            put(lit_from, dark_from);
            lit_from = lit_from.max(b as f32);
        }
        put(lit_from, end);
    }
}

/// A part of the ray's line behind something see-through.
#[derive(Debug, Clone, Copy)]
struct Filter {
    start: f32,
    end: f32,
    transmittance: Vec3,
}

/// Filters that are passed in order.
struct Filters {
    /// By their starts.
    all: Vec<Filter>,
    /// Starts and ends of all, in order.
    changes: Vec<f32>,
    /// Changes that lie behind.
    passed: usize,
    /// How many of them have begun.
    begun: usize,
    /// Those that have begun and not yet ended.
    active: Vec<Filter>,
}

impl Filters {
    fn new(mut all: Vec<Filter>) -> Self {
        all.sort_by(|a, b| a.start.total_cmp(&b.start));
        let mut changes: Vec<f32> = all.iter().flat_map(|f| [f.start, f.end]).collect();
        changes.sort_unstable_by(f32::total_cmp);
        changes.dedup();
        Self {
            all,
            changes,
            passed: 0,
            begun: 0,
            active: Vec::new(),
        }
    }

    /// Appends the part from `start` to `end`, cut where filters begin and end;
    /// calls must come in order.
    fn split(&mut self, start: f32, end: f32, lit: &mut Vec<LitInterval<Vec3>>) {
        let mut from = start;
        while from < end {
            while self.changes.get(self.passed).is_some_and(|at| *at <= from) {
                self.passed += 1;
            }
            let to = self.changes.get(self.passed).map_or(end, |at| at.min(end));
            while let Some(next) = self.all.get(self.begun)
                && next.start <= from
            {
                self.active.push(*next);
                self.begun += 1;
            }
            self.active.retain(|filter| from < filter.end);
            let shares = self.active.iter().map(|filter| filter.transmittance);
            let visibility: Vec3 = shares.product();
            if !visibility.is_dark() {
                lit.push(LitInterval {
                    interval: Interval::new(from, to),
                    visibility,
                });
            }
            from = to;
        }
    }
}

/// The dark part of a span, intervals in order that do not touch, and what is
/// seen through something.
struct Shadow {
    start: f64,
    end: f64,
    intervals: Vec<(f64, f64)>,
    filters: Vec<Filter>,
}

impl Shadow {
    fn new(span: Interval) -> Self {
        Self {
            start: f64::from(span.start),
            end: f64::from(span.end),
            intervals: Vec::new(),
            filters: Vec::new(),
        }
    }

    /// Takes away from `[a, b]` what does not pass.
    fn filter(&mut self, a: f64, b: f64, transmittance: Vec3) {
        if transmittance.is_dark() {
            self.insert(a, b);
        } else if transmittance != Vec3::ONE
            && let Some((a, b)) = self.clip(a, b)
        {
            let (start, end) = (a as f32, b as f32);
            if start < end {
                self.filters.push(Filter {
                    start,
                    end,
                    transmittance,
                });
            }
        }
    }

    /// The part of `[a, b]` in the span.
    fn clip(&self, a: f64, b: f64) -> Option<(f64, f64)> {
        let (a, b) = (a.max(self.start), b.min(self.end));
        (a < b).then_some((a, b))
    }

    /// Whether any of the span is dark or filtered, to the rounding of its ends.
    fn darkens(&self) -> bool {
        let (start, end) = (self.start as f32, self.end as f32);
        let is_inside = |&(a, b): &(f64, f64)| (a as f32) < end && start < b as f32;
        !self.filters.is_empty() || self.intervals.iter().any(is_inside)
    }

    /// True if all of `[a, b]`, a part of the span, is dark.
    fn covers(&self, a: f64, b: f64) -> bool {
        let next = self.intervals.partition_point(|dark| dark.1 < a);
        self.intervals
            .get(next)
            .is_some_and(|dark| dark.0 <= a && b <= dark.1)
    }

    fn insert(&mut self, a: f64, b: f64) {
        let Some((mut a, mut b)) = self.clip(a, b) else {
            return;
        };
        let first = self.intervals.partition_point(|dark| dark.1 < a);
        let after = self.intervals.partition_point(|dark| dark.0 <= b);
        if first < after {
            a = a.min(self.intervals[first].0);
            b = b.max(self.intervals[after - 1].1);
        }
        self.intervals.splice(first..after, [(a, b)]);
    }
}

/// The plane of a ray and a light, with coordinates: `u` along the ray, `v`
/// towards the light.
struct Plane {
    eye: DVec3,
    normal: DVec3,
    along: DVec3,
    up: DVec3,
    light: PlaneLight,
}

/// An end of the segment in which a triangle cuts a plane.
#[derive(Debug, Clone, Copy, Default)]
struct End {
    /// Along `u` and `v`.
    in_plane: (f64, f64),
    /// The corners of the edge that is cut, and where: 0 at the first, 1 at the
    /// second.
    edge: (usize, usize),
    at: f64,
}

impl End {
    /// Barycentric coordinates of the second and the third corner.
    fn in_triangle(&self) -> DVec2 {
        const CORNERS: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let (from, to) = (CORNERS[self.edge.0], CORNERS[self.edge.1]);
        from + self.at * (to - from)
    }
}

enum PlaneLight {
    /// At (foot, h).
    Point { foot: f64, h: f64 },
    /// Towards (slope, 1), far away.
    Sun { slope: f64 },
}

impl Plane {
    /// `None` if the ray points at the light or away from it, to f64 precision.
    fn new(path: &LightPath<'_>) -> Option<Self> {
        let eye = path.ray().origin().as_dvec3();
        let along = path.ray().direction().as_dvec3().normalize();
        let to_light = match path.emitter() {
            Emitter::Point(point) => point.position().as_dvec3() - eye,
            Emitter::Directional(sun) => -sun.direction().as_dvec3().normalize(),
        };
        let foot = to_light.dot(along);
        let normal = along.cross(to_light);
        let h = normal.length();
        if h <= 1e-12 * to_light.length() {
            return None;
        }
        let normal = normal / h;
        Some(Self {
            eye,
            normal,
            along,
            up: normal.cross(along),
            light: match path.emitter() {
                Emitter::Point(_) => PlaneLight::Point { foot, h },
                Emitter::Directional(_) => PlaneLight::Sun { slope: foot / h },
            },
        })
    }

    /// An interval of the ray's line that contains everything the box (centre
    /// and half extent) can hide from the light; `None` if it hides nothing.
    fn shadow_of_box(&self, centre: DVec3, half: DVec3) -> Option<(f64, f64)> {
        let offset = centre - self.eye;
        // How far the box reaches from its centre along an axis.
        let margin = 1e-12 * (offset.abs().max_element() + half.max_element());
        let reach = |axis: DVec3| axis.abs().dot(half) + margin;
        if self.normal.dot(offset).abs() > reach(self.normal) {
            return None;
        }
        let (u, v) = (self.along.dot(offset), self.up.dot(offset));
        let (reach_u, reach_v) = (reach(self.along), reach(self.up));
        let high = v + reach_v;
        if high < 0.0 {
            return None;
        }
        let low = (v - reach_v).max(0.0);
        // The box lies in a rectangle of the plane, whose shadow is that of its
        // corners; where it reaches the light's height the shadow is unbounded.
        let (left, right) = (u - reach_u, u + reach_u);
        match self.light {
            PlaneLight::Sun { slope } => {
                let (near, far) = (slope * low, slope * high);
                Some((left - near.max(far), right - near.min(far)))
            }
            PlaneLight::Point { foot, h } => {
                if low >= h {
                    return None;
                }
                let near = h / (h - low);
                let far = if high < h {
                    h / (h - high)
                } else {
                    f64::INFINITY
                };
                let (left, right) = (left - foot, right - foot);
                let a = left * if left < 0.0 { far } else { near };
                let b = right * if right > 0.0 { far } else { near };
                // 0 · ∞: the edge of the box is straight below the light.
                let a = if a.is_nan() { 0.0 } else { a };
                let b = if b.is_nan() { 0.0 } else { b };
                Some((foot + a, foot + b))
            }
        }
    }

    /// The interval of the ray's line that the triangle hides from the light.
    fn shadow_of_triangle(&self, triangle: &[Vec3; 3]) -> Option<(f64, f64)> {
        let [a, b] = self.cut(triangle)?;
        self.project(a.in_plane, b.in_plane)
    }

    /// The ends of the segment in which the triangle cuts the plane.
    #[inline]
    fn cut(&self, triangle: &[Vec3; 3]) -> Option<[End; 2]> {
        let corners = triangle.map(|corner| corner.as_dvec3() - self.eye);
        let side = corners.map(|corner| self.normal.dot(corner));
        let above = side.map(|distance| distance >= 0.0);
        if above[0] == above[1] && above[1] == above[2] {
            return None;
        }
        let mut ends = [End::default(); 2];
        let mut count = 0;
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if above[i] != above[j] {
                let t = side[i] / (side[i] - side[j]);
                let point = corners[i] + t * (corners[j] - corners[i]);
                ends[count] = End {
                    in_plane: (self.along.dot(point), self.up.dot(point)),
                    edge: (i, j),
                    at: t,
                };
                count += 1;
            }
        }
        Some(ends)
    }

    /// Projects a segment of the plane from the light onto the ray.
    fn project(&self, a: (f64, f64), b: (f64, f64)) -> Option<(f64, f64)> {
        let (a, b) = if a.1 <= b.1 { (a, b) } else { (b, a) };
        if b.1 <= 0.0 {
            return None;
        }
        let at_height = |v: f64| {
            let t = (v - a.1) / (b.1 - a.1);
            (a.0 + t * (b.0 - a.0), v)
        };
        // The part between ray and light; beyond the ray nothing is shadowed.
        let low = if a.1 < 0.0 { at_height(0.0) } else { a };
        let (x_low, x_high) = match self.light {
            PlaneLight::Sun { slope } => (low.0 - slope * low.1, b.0 - slope * b.1),
            PlaneLight::Point { foot, h } => {
                // What touches the light lies on a line through it and hides a single
                // point, wherever rounding has put it.
                let rounding = 1e-12 * (h + foot.abs());
                let is_at_light = |point: (f64, f64)| {
                    (h - point.1).abs() <= rounding && (point.0 - foot).abs() <= rounding
                };
                if low.1 >= h || is_at_light(low) || is_at_light(b) {
                    return None;
                }
                let from_light = |point: (f64, f64)| foot + (point.0 - foot) * (h / (h - point.1));
                let x_high = if b.1 < h {
                    from_light(b)
                } else {
                    // The segment reaches the light's height: its shadow has
                    // no end on the side where it does.
                    let aside = at_height(h).0 - foot;
                    if aside.abs() <= rounding {
                        // A surface through the light hides a single point.
                        return None;
                    }
                    aside * f64::INFINITY
                };
                (from_light(low), x_high)
            }
        };
        Some((x_low.min(x_high), x_low.max(x_high)))
    }
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;
    use crate::Ray;
    use crate::scene::{Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};

    fn tracer(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Tracer {
        let scene = Scene::from(Mesh {
            positions,
            triangles,
            ..Mesh::default()
        });
        Tracer::new(&Geometry::new(&scene).unwrap())
    }

    /// A square of side 2 in the plane y = `height`, centred over the origin.
    fn plate(height: f32) -> Tracer {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        tracer(
            corners.map(|(x, z)| Vec3::new(x, height, z)).into(),
            vec![[0, 1, 2], [0, 2, 3]],
        )
    }

    fn lit(tracer: &Tracer, light: &Emitter, ray: Ray) -> Vec<(f32, f32)> {
        let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let Some(path) = LightPath::new(&ray, light, &medium) else {
            return Vec::new();
        };
        let mut lit = Vec::new();
        Exact::new(tracer).lit_intervals(&path, &mut lit);
        lit.iter()
            .map(|part| (part.interval.start, part.interval.end))
            .collect()
    }

    /// Walls that meet in a lamp, whose corners rounding puts to either side of it.
    #[test]
    fn a_light_in_a_corner_of_walls_lights_what_is_between_them() {
        let corner = Vec3::new(3.0, -1.5, -4.0);
        let (x, y, z) = (-6.0 * Vec3::X, 4.0 * Vec3::Y, 5.0 * Vec3::Z);
        let positions = vec![
            corner,
            corner + x,
            corner + x + y,
            corner + y,
            corner + z,
            corner + x + z,
        ];
        let walls = tracer(positions, vec![[0, 2, 1], [0, 3, 2], [0, 5, 4], [0, 1, 5]]);
        let light = point(corner.x, corner.y, corner.z);
        let eye = Vec3::new(-0.3, 0.4, 2.5);
        for step in 0..50 {
            let turn = 0.01 * (step - 25) as f32;
            let ray = Ray::new(eye, Vec3::new(turn, 0.3 * turn, -1.0).normalize(), 5.0).unwrap();
            let parts = lit(&walls, &light, ray);
            assert_eq!(parts.len(), 1, "{step}: {parts:?}");
            assert_eq!(parts[0].0, 0.0, "{step}: {parts:?}");
        }
    }

    fn point(x: f32, y: f32, z: f32) -> Emitter {
        let position = Vec3::new(x, y, z);
        Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
    }

    fn close(found: &[(f32, f32)], expected: &[(f32, f32)]) {
        let same = |a: f32, b: f32| a == b || (a - b).abs() < 1e-5;
        assert!(
            found.len() == expected.len()
                && found
                    .iter()
                    .zip(expected)
                    .all(|(f, e)| same(f.0, e.0) && same(f.1, e.1)),
            "{found:?} instead of {expected:?}"
        );
    }

    const INF: f32 = f32::INFINITY;

    #[test]
    fn a_plate_casts_the_shadow_of_similar_triangles() {
        let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.1), Vec3::X, 10.0).unwrap();
        // Halfway between ray and light, so the shadow is twice as wide.
        close(
            &lit(&plate(1.0), &point(0.0, 2.0, 0.1), ray),
            &[(0.0, 3.0), (7.0, 10.0)],
        );
        close(
            &lit(&plate(3.0), &point(0.0, 2.0, 0.1), ray),
            &[(0.0, 10.0)],
        );
        close(
            &lit(&plate(-1.0), &point(0.0, 2.0, 0.1), ray),
            &[(0.0, 10.0)],
        );
        // A light in the plane of the plate is not blocked by it.
        close(
            &lit(&plate(1.0), &point(5.0, 1.0, 0.1), ray),
            &[(0.0, 10.0)],
        );
        let sun = Emitter::directional(Vec3::new(1.0, -1.0, 0.0), Vec3::ONE).unwrap();
        close(&lit(&plate(1.0), &sun, ray), &[(0.0, 5.0), (7.0, 10.0)]);
    }

    #[test]
    fn shadows_reach_the_horizon() {
        let sky = Ray::new(Vec3::new(-5.0, 0.0, 0.1), Vec3::X, INF).unwrap();
        close(
            &lit(&plate(1.0), &point(0.0, 2.0, 0.1), sky),
            &[(0.0, 3.0), (7.0, INF)],
        );
        // What rises above the light shadows all that follows.
        let wall = [(1.0, 0.5, -9.0), (1.0, 0.5, 9.0), (1.0, 100.0, 0.1)];
        let tracer = tracer(wall.map(Vec3::from).into(), vec![[0, 1, 2]]);
        let end = 5.0 + 4.0 / 3.0;
        close(&lit(&tracer, &point(0.0, 2.0, 0.1), sky), &[(0.0, end)]);
    }

    #[test]
    fn on_the_line_of_the_light_blockers_decide_by_distance() {
        let tracer = plate(1.0);
        let down = Ray::new(Vec3::new(0.1, 3.0, 0.2), Vec3::NEG_Y, 8.0).unwrap();
        close(&lit(&tracer, &point(0.1, 4.0, 0.2), down), &[(0.0, 2.0)]);
        close(&lit(&tracer, &point(0.1, 2.5, 0.2), down), &[(0.0, 2.0)]);
        close(&lit(&tracer, &point(0.1, 0.0, 0.2), down), &[(2.0, 8.0)]);
        close(&lit(&tracer, &point(0.1, -9.0, 0.2), down), &[(2.0, 8.0)]);
        let sun = |y: f32| Emitter::directional(Vec3::Y * y, Vec3::ONE).unwrap();
        close(&lit(&tracer, &sun(-1.0), down), &[(0.0, 2.0)]);
        close(&lit(&tracer, &sun(1.0), down), &[(2.0, 8.0)]);
    }

    #[test]
    fn lit_points_are_those_with_a_free_line_to_the_light() {
        let mut random = Random::new(7);
        let mut next = || random.unit() - 0.5;
        let mut vector = |scale: f32| Vec3::new(next(), next(), next()) * scale;
        let mut positions = Vec::new();
        for _ in 0..40 {
            let centre = vector(8.0);
            positions.extend([0; 3].map(|_| centre + vector(3.0)));
        }
        let triangles = (0..40).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let tracer = tracer(positions, triangles);
        let mut seen = [0; 2];
        for round in 0..200 {
            let (origin, direction) = (vector(12.0), vector(1.0));
            let ray = Ray::new(origin, direction, 15.0).unwrap();
            let position = vector(10.0);
            let light = if round % 2 == 0 {
                point(position.x, position.y, position.z)
            } else {
                Emitter::directional(position, Vec3::ONE).unwrap()
            };
            let found = lit(&tracer, &light, ray);
            for k in 0..100 {
                let x = 15.0 * (k as f32 + 0.5) / 100.0;
                let near_end = found
                    .iter()
                    .any(|&(a, b)| (x - a).abs() < 1e-3 || (x - b).abs() < 1e-3);
                if near_end {
                    continue;
                }
                let here = ray.at(x);
                let (to_light, distance) = match &light {
                    Emitter::Point(_) => (position - here, (position - here).length()),
                    Emitter::Directional(sun) => (-sun.direction(), INF),
                };
                let free = !tracer.occluded(here, to_light.normalize(), 0.0, distance);
                let claimed = found.iter().any(|&(a, b)| a < x && x < b);
                assert_eq!(free, claimed, "round {round}, x = {x}, {found:?}");
                seen[usize::from(free)] += 1;
            }
        }
        assert!(seen[0] > 1000 && seen[1] > 1000, "{seen:?}");
    }
}
