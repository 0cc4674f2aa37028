//! Lit intervals whose ends are computed, not sampled.

#[cfg(test)]
mod caster_tests;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
mod neighbours;
#[cfg(test)]
mod neighbours_tests;
#[cfg(feature = "methods")]
mod pair;
#[cfg(all(feature = "methods", feature = "wgpu"))]
mod pair_gpu;
mod plane;
mod shadow;
#[cfg(test)]
mod tests;

#[cfg(feature = "methods")]
pub(super) use method::methods;

#[cfg(feature = "wgpu")]
pub use gpu::{UploadTracerError, UploadedTracer};

use std::borrow::Borrow;
use std::cell::RefCell;

use glam::{DVec3, Vec3};

use crate::scene::Caster;
use crate::scene::trace::{Line, Tracer};
use crate::visibility::{LitInterval, LitOfEach, VisibilitySource};
use crate::{Emitter, LightPath, Ray};
use plane::Plane;
use shadow::Shadow;

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
/// Cost: it grows with the number of blockers, not with a number of samples. A ray by
/// itself walks the hierarchy along the whole planar triangle; a gather asks 64
/// [neighbours](VisibilitySource::neighbours) from one eye in one walk, in two fifths to a
/// quarter of the time for the same bits. Parts of the hierarchy whose whole shadow is
/// already known to be dark are skipped. A triangle whose plane contains the light is seen
/// edge-on and blocks nothing. Masks and see-through triangles cost in proportion to the
/// texels that the plane crosses.
///
/// On GPUs (feature `wgpu`) it is an `UploadedTracer` that is asked, with the same lit parts in
/// f32.
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
        let mut shadow = Shadow::new(path);
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
                let (a, b) = plane.shadow_of_box(centre - plane.eye(), half)?;
                let (a, b) = shadow.borrow().clip(a, b)?;
                Some((b - a, [a, b]))
            },
            |(_, [a, b])| {
                let shadow = shadow.borrow();
                shadow.covers(a, b) || is_enough(&shadow)
            },
            |triangle, index| {
                let corners = plane.seen(triangle);
                darken(
                    &mut shadow.borrow_mut(),
                    &plane,
                    &corners,
                    coatings.caster(index),
                );
            },
        );
        shadow.into_inner()
    }

    /// The light lies on the line of the ray: the planar triangle is a line.
    fn collinear(&self, path: &LightPath<'_>, shadow: &mut Shadow) {
        let line = Line::new(path.ray().origin(), path.ray().direction());
        // The position of the light on the line: a distance from the eye, or infinitely far
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
        let tracer = self.tracer.borrow();
        let mut met = Vec::new();
        tracer.walk(
            |centre, half| line.touches(centre, half).then_some(0.0),
            |_| false,
            |triangle, index| {
                let caster = tracer.coatings().caster(index);
                if caster != Caster::Absent
                    && let Some((t, u, v)) = line.meets(triangle)
                {
                    let transmittance = caster.transmittance_at(u, v);
                    // A line that goes through the common edge of two triangles meets both at
                    // the same distance, and only one of them may filter its light.
                    let is_on_edge = u.min(v).min(1.0 - u - v) <= 1e-9;
                    if is_on_edge && transmittance != Vec3::ZERO {
                        let is_known = |known: &f64| (known - t).abs() <= 1e-9 * t.abs();
                        if met.iter().any(is_known) {
                            return;
                        }
                        met.push(t);
                    }
                    // The line is dark on the far side of the blocker, as seen from the
                    // light.
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

/// Adds what a caster takes from the path of a plane; its corners are relative to the eye.
fn darken(shadow: &mut Shadow, plane: &Plane, corners: &[DVec3; 3], caster: Caster<'_>) {
    match caster {
        Caster::Solid => {
            if let Some((a, b)) = plane.shadow_of_triangle(corners) {
                shadow.insert(a, b);
            }
        }
        Caster::Masked(coating) | Caster::SeeThrough(coating) => {
            let Some([p, q]) = plane.cut(corners) else {
                return;
            };
            let at = |t: f64| {
                let (p, q) = (p.in_plane, q.in_plane);
                (p.0 + t * (q.0 - p.0), p.1 + t * (q.1 - p.1))
            };
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
    }
}

/// Whether something in a box may be between a part of the path and its light.
#[cfg(feature = "methods")]
pub(crate) fn may_shadow(bounds: crate::scene::Bounds, path: &LightPath<'_>) -> bool {
    let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
    let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
    match Plane::new(path) {
        Some(plane) => {
            let shadow = plane.shadow_of_box(centre - plane.eye(), half);
            shadow.is_some_and(|(a, b)| Shadow::new(path).clip(a, b).is_some())
        }
        None => Line::new(path.ray().origin(), path.ray().direction()).touches(centre, half),
    }
}

impl<T: Borrow<Tracer> + Sync> VisibilitySource for Exact<T> {
    type Share = Vec3;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<Vec3>>) {
        self.shadow(path).lit(lit);
    }

    fn neighbours(&self, rays: &[Ray], emitter: &Emitter) -> Option<Vec<u32>> {
        neighbours::in_order(rays, emitter)
    }

    fn lit_of_neighbours(&self, paths: &[LightPath<'_>], each: &mut LitOfEach<'_, Vec3>) {
        let mut lit = Vec::new();
        self.shadows_together(paths, |path, shadow| {
            lit.clear();
            shadow.lit(&mut lit);
            each(path, &mut lit);
        });
    }
}
