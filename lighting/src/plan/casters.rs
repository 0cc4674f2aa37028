//! Finds the lights that nothing blocks.
//!
//! A light is unshadowed in a view if no caster meets the triangle of eye, end of a ray and
//! light for any ray, as far as the ray is within the light's range, its cone and the medium.
//! [`Exact`] finds this out for one ray; here it is found out for many at once:
//!
//! 1. The rays of a sample are tested one by one. If one of them is shadowed the question is
//!    answered, as it is for most lights.
//! 2. The rays that the light may reach are divided into parts of neighbours. For each part,
//!    triangles are looked up in the convex [hull](super::hull) of the light and of the lit
//!    spans of these rays. A triangle does not count if the light and all spans are on one side
//!    of it, which is so for the floors and walls that rays end on.
//! 3. If a triangle counts, the part is divided into four. A part of few rays is tested ray by
//!    ray.
//!
//! The same is done for an area light, whose hull has the corners of its rectangle, so that
//! the answer holds for every point of it and not only for those that represent it. Its last
//! step is that of single rays, because a ray and an area are not tested exactly.
//!
//! So a light is never called unshadowed if exact visibility finds a shadow of it. It may be
//! called shadowed though it is not: in a scene with hair or smoke, if the box around these is
//! in the way; and where the question would take more than [`BOXES_PER_RAY`] boxes of the BVH
//! per ray, which bounds its cost whatever the number of casters.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec2, DVec3, Vec3};
use gpu_backend::Cpu;

use super::hull::{Span, hull, is_behind_all};
use crate::culling::RayTiles;
use crate::hull::{MARGIN, Place};
use crate::methods::{FrameInputs, MethodError};
use crate::scene::trace::Tracer;
use crate::scene::{
    AreaLight, AreaShape, AreaSurface, Bounds, Caster, Emission, Emitter, Interval, Medium,
    SceneError,
};
use crate::visibility::{Exact, may_shadow};
use crate::{LightPath, Ray};

/// Number of rays in the sample.
const SAMPLE: usize = 64;

/// Rays in a part at first: 64 × 16 pixels.
const PART: usize = 1024;

/// Parts of no more rays than this are tested ray by ray.
const FEW: usize = 16;

/// Boxes of the BVH that may be visited for each ray of a light; if that is not enough, the
/// light counts as shadowed.
const BOXES_PER_RAY: usize = 16;

/// The cost of a ray that is tested by itself, in boxes.
const BOXES_OF_A_RAY: usize = 64;

/// The number of spans that are compared with a triangle in the time that a box takes.
const SPANS_PER_BOX: usize = 16;

/// What may block the lights of a frame.
pub(super) struct Search<'a> {
    inputs: &'a FrameInputs<'a>,
    tracer: Arc<Tracer>,
    exact: Exact<Arc<Tracer>>,
    /// Boxes around hair and smoke.
    boxes: Vec<Bounds>,
    tiles: Option<RayTiles>,
}

/// A light, as casters are looked for in its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a> {
    /// What the light is the convex hull of: itself, or the corners of an area.
    corners: &'a [Emitter],
    /// Points whose shadows are looked for to begin with.
    points: &'a [Emitter],
}

impl<'a> Source<'a> {
    /// A light without an area.
    pub(super) fn new(emitter: &'a Emitter) -> Self {
        let one = std::slice::from_ref(emitter);
        Self {
            corners: one,
            points: one,
        }
    }

    /// An area light, given by its [corners] and by some of its points, at least one.
    pub(super) fn area(corners: &'a [Emitter; 4], points: &'a [Emitter]) -> Self {
        Self { corners, points }
    }

    fn is_area(&self) -> bool {
        self.corners.len() > 1
    }

    /// What the light can reach of a ray.
    fn span(&self, ray: &Ray, medium: &Medium) -> Option<Interval> {
        let paths = self.corners.iter();
        let spans = paths.filter_map(|corner| Some(LightPath::new(ray, corner, medium)?.span()));
        let all = spans.reduce(|a, b| Interval::new(a.start.min(b.start), a.end.max(b.end)))?;
        if !self.is_area() {
            return Some(all);
        }
        // Points between the corners may reach a little more, because of rounding.
        let more = |x: f32| 1e-5 * x.min(f32::MAX);
        let start = (all.start - more(all.start)).max(0.0);
        Some(Interval::new(
            start,
            (all.end + more(all.end)).min(ray.length()),
        ))
    }
}

/// The corners of an area light in order around it, as points that emit like it.
///
/// # Errors
/// Those of [`AreaSurface::new`] and [`Emitter::point`].
pub(super) fn corners(light: &AreaLight) -> Result<[Emitter; 4], SceneError> {
    // The surface of an ellipse touches the edges of its rectangle.
    let rectangle = AreaLight {
        shape: AreaShape::Rectangle,
        texture: None,
        ..light.clone()
    };
    let surface = AreaSurface::new(&rectangle)?;
    let corner = |x: f64, y: f64| {
        let (position, _) = surface.point(DVec2::new(x, y));
        let emission = Emission::Cosine {
            normal: surface.normal(),
        };
        Emitter::point(position, Vec3::ONE, f32::INFINITY, emission)
    };
    Ok([
        corner(0.0, 0.0)?,
        corner(1.0, 0.0)?,
        corner(1.0, 1.0)?,
        corner(0.0, 1.0)?,
    ])
}

/// Rays that the light may reach, with the lit span of each.
struct Part<'a> {
    rays: &'a [u32],
    spans: &'a [Span],
}

impl<'a> Search<'a> {
    pub(super) fn new(inputs: &'a FrameInputs<'a>) -> Result<Self, MethodError> {
        let tracer = inputs.tracer()?;
        let boxes = inputs.translucent.iter();
        Ok(Self {
            inputs,
            exact: Exact::new(tracer.clone()),
            tracer,
            boxes: boxes.filter_map(|caster| caster.bounds()).collect(),
            tiles: None,
        })
    }

    /// Whether everything in the view that the light reaches is wholly lit.
    pub(super) fn is_unshadowed(&mut self, source: Source<'_>) -> bool {
        let count = self.inputs.rays.len();
        if count == 0 || !self.sample_is_lit(source, count, |index| index) {
            return false;
        }
        if self.tiles.is_none() {
            let FrameInputs { size, rays, .. } = *self.inputs;
            let pixels = self.inputs.selection.pixels;
            self.tiles = RayTiles::new(&Cpu::new(), rays, size[0], pixels);
        }
        let Some(tiles) = &self.tiles else {
            return false;
        };
        let reached = match source.is_area() {
            true => None,
            false => tiles.reached(&source.corners[0]),
        };
        let rays = reached.as_deref().unwrap_or(tiles.order());
        if !self.sample_is_lit(source, rays.len(), |index| rays[index] as usize) {
            return false;
        }
        let is_over = AtomicBool::new(false);
        let parts = rays.chunks(PART).collect::<Vec<_>>();
        let lit = Cpu::new().map(parts.len(), |part| {
            let is_lit = !is_over.load(Ordering::Relaxed) && self.part_is_lit(source, parts[part]);
            if !is_lit {
                is_over.store(true, Ordering::Relaxed);
            }
            is_lit
        });
        lit.into_iter().all(|is_lit| is_lit)
    }

    fn sample_is_lit(
        &self,
        source: Source<'_>,
        count: usize,
        ray: impl Fn(usize) -> usize,
    ) -> bool {
        let sample = SAMPLE.min(count);
        let points = source.points;
        (0..sample).all(|i| {
            let ray = &self.inputs.rays[ray(i * count / sample)];
            self.ray_is_lit(&points[i % points.len()], ray)
        })
    }

    fn ray_is_lit(&self, emitter: &Emitter, ray: &Ray) -> bool {
        let Some(path) = LightPath::new(ray, emitter, self.inputs.medium) else {
            return true;
        };
        let path = path.off_the_light();
        let is_clear = |bounds: &Bounds| !may_shadow(*bounds, &path);
        self.boxes.iter().all(is_clear) && self.exact.is_wholly_lit(&path)
    }

    fn part_is_lit(&self, source: Source<'_>, rays: &[u32]) -> bool {
        let span = |ray: &u32| {
            let whole = &self.inputs.rays[*ray as usize];
            let span = Span {
                direction: whole.direction().as_dvec3().normalize(),
                lit: source.span(whole, self.inputs.medium)?,
            };
            Some((*ray, span))
        };
        let (rays, spans): (Vec<u32>, Vec<Span>) = rays.iter().filter_map(span).unzip();
        let part = Part {
            rays: &rays,
            spans: &spans,
        };
        let mut boxes = BOXES_PER_RAY * rays.len();
        self.is_lit(source, part, &mut boxes)
    }

    /// Whether a part is wholly lit. At most `boxes` may still be visited; the number is
    /// reduced by those that are.
    fn is_lit(&self, source: Source<'_>, part: Part<'_>, boxes: &mut usize) -> bool {
        let count = part.rays.len();
        if count == 0 || self.hull_is_clear(source, &part, boxes) {
            return true;
        }
        if source.is_area() && (count == 1 || *boxes == 0) {
            return false;
        }
        if count <= FEW && !source.is_area() {
            return part.rays.iter().all(|ray| {
                let Some(left) = boxes.checked_sub(BOXES_OF_A_RAY) else {
                    return false;
                };
                *boxes = left;
                self.ray_is_lit(&source.corners[0], &self.inputs.rays[*ray as usize])
            });
        }
        let quarter = count.div_ceil(4);
        let quarters = part.rays.chunks(quarter).zip(part.spans.chunks(quarter));
        quarters.into_iter().all(|(rays, spans)| {
            let part = Part { rays, spans };
            self.is_lit(source, part, boxes)
        })
    }

    /// Whether nothing that may cast a shadow lies between the light and the spans of a part.
    fn hull_is_clear(&self, source: Source<'_>, part: &Part<'_>, boxes: &mut usize) -> bool {
        let eye = self.inputs.rays[part.rays[0] as usize].origin().as_dvec3();
        let corners = source.corners.iter();
        let light: Vec<Place> = corners.map(|corner| Place::of(corner, eye)).collect();
        let Some(hull) = hull(part.spans, &light) else {
            return false;
        };
        let may_meet = |bounds: &Bounds| {
            let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
            hull.may_meet_box(0.5 * (min + max) - eye, 0.5 * (max - min))
        };
        if self.boxes.iter().any(may_meet) {
            return false;
        }
        let is_clear = Cell::new(true);
        let asked = Cell::new(0_usize);
        let coatings = self.tracer.coatings();
        self.tracer.walk(
            |centre, half| {
                asked.set(asked.get() + 1);
                hull.may_meet_box(centre - eye, half).then_some(0.0)
            },
            |_| !is_clear.get() || asked.get() > *boxes,
            |triangle, index| {
                if !is_clear.get() || coatings.caster(index) == Caster::Absent {
                    return;
                }
                let corners = triangle.map(|corner| corner.as_dvec3() - eye);
                if !hull.may_meet_triangle(&corners) {
                    return;
                }
                asked.set(asked.get() + part.spans.len() / SPANS_PER_BOX);
                let is_end = |span: usize| self.ends_on(part.rays[span], index);
                if !is_behind_all(&corners, &light, part.spans, is_end) {
                    is_clear.set(false);
                }
            },
        );
        let is_whole = asked.get() <= *boxes;
        *boxes = boxes.saturating_sub(asked.get());
        is_clear.get() && is_whole
    }

    /// Whether a ray ends on a triangle or in its plane. Such a triangle does not block the
    /// ray's light.
    fn ends_on(&self, ray: u32, triangle: usize) -> bool {
        let hit = self.inputs.hits.get(ray as usize).copied().flatten();
        let length = self.inputs.rays[ray as usize].length();
        hit.is_some_and(|hit| {
            let end = hit.triangle as usize;
            length <= hit.distance && (end == triangle || self.are_coplanar(end, triangle))
        })
    }

    /// Whether two triangles are in one plane, up to [`MARGIN`], as those of a flat wall are.
    fn are_coplanar(&self, a: usize, b: usize) -> bool {
        let all = self.inputs.geometry.triangles();
        let (Some(a), Some(b)) = (all.get(a), all.get(b)) else {
            return false;
        };
        let [a, b] = [a, b].map(|triangle| triangle.map(|corner| corner.as_dvec3()));
        let Some(normal) = (a[1] - a[0]).cross(a[2] - a[0]).try_normalize() else {
            return false;
        };
        let is_on = |corner: DVec3| {
            let scale = a[0].abs().max_element() + corner.abs().max_element();
            normal.dot(corner - a[0]).abs() <= MARGIN * scale
        };
        b.into_iter().all(is_on)
    }
}
