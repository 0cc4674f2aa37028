//! The gather of one light along a bundle of rays through media.

use std::cell::Cell;

use glam::{DVec3, Vec3};
use gpu_backend::{Backend, BufferOf, Cpu, Error, Host};

use super::memory::{MediaMemory, MediaOf};
use super::steps::{Arriving, Limits, Line, Steps, exp, is_gentle};
use crate::eye_panes::{Behind, seen_along};
use crate::gather::{check_lengths, in_bundles};
use crate::scene::{Bounds, Emitter, Media, Medium, ScatteringAngle};
use crate::visibility::{PointVisibility, VisibilitySource, join_touching};
use crate::{EyePanes, Interval, LightPath, Ray, Watch};

/// The rays of a gather through media, with the light and the media.
#[derive(Debug)]
pub struct MediaRays<'a, 'm, M: MediaMemory> {
    /// The rays, in the memory of the backend.
    pub rays: &'a M::Buffer<Ray>,
    /// The light.
    pub emitter: &'a Emitter,
    /// The media, in the memory of the backend.
    pub media: &'a MediaOf<'m, M>,
    /// Number of steps for each ray, at least 1.
    pub steps: u32,
    /// See-through surfaces and hair in front of the ends of the rays, by the number of each
    /// ray; `None` if there are none. Steps end where a ray meets one.
    pub panes: Option<&'a EyePanes>,
    /// Told of progress.
    pub watch: &'a dyn Watch,
}

/// The step that gathers the light of one lamp that media scatter towards the eye. `V` tells
/// which share of it arrives at a point.
pub trait GatherMedia<V>: Backend<Memory: MediaMemory> {
    /// Adds to the first three components of `radiance[i]` what media scatter along
    /// `lit.rays[i]`, as the page of [this module](super) says, times what the
    /// [panes](MediaRays::panes) in front let through.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length; nothing is written
    /// then. On GPUs also those of a dispatch.
    fn gather_media(
        &self,
        lit: &MediaRays<'_, '_, Self::Memory>,
        visibility: &V,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

/// Rays per unit of work.
const RAYS: usize = 16;

impl<V: PointVisibility> GatherMedia<V> for Cpu {
    fn gather_media(
        &self,
        lit: &MediaRays<'_, '_, Self::Memory>,
        visibility: &V,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(lit.rays.len(), radiance.len())?;
        self.for_each_chunk(radiance, RAYS, |first, chunk| {
            for (i, (sum, ray)) in chunk.iter_mut().zip(&lit.rays[first..]).enumerate() {
                if let Some(lit_ray) = LitRay::new(ray, lit) {
                    // Rays beyond those that a u32 counts have no panes.
                    let panes = lit.panes_of((first + i) as u32);
                    lit_ray.add_radiance(panes, lit, visibility, sum);
                }
            }
            lit.watch.gathered(chunk.len());
        });
        Ok(())
    }
}

/// Visibility past two kinds of casters: some cast shadows whose ends on a ray are known, and
/// the others are asked about at points.
///
/// Steps end where lit parts do, and nothing is asked where it is dark.
#[derive(Debug, Clone, Copy)]
pub struct PartsAndPoints<S, P> {
    /// Gives the lit parts of rays.
    pub parts: S,
    /// Gives the share of the light at points within them.
    pub points: P,
}

impl<S: VisibilitySource, P: PointVisibility> GatherMedia<PartsAndPoints<S, P>> for Cpu {
    fn gather_media(
        &self,
        lit: &MediaRays<'_, '_, Self::Memory>,
        visibility: &PartsAndPoints<S, P>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(lit.rays.len(), radiance.len())?;
        let order = visibility.parts.neighbours(lit.rays, lit.emitter);
        in_bundles(self, order.as_deref(), radiance, |rays, sums| {
            let (mut numbers, mut lit_rays, mut paths) = (Vec::new(), Vec::new(), Vec::new());
            for (number, ray) in rays.iter().enumerate() {
                if let Some(lit_ray) = LitRay::new(&lit.rays[*ray as usize], lit) {
                    numbers.push(number);
                    paths.push(lit_ray.path.with_index(*ray));
                    lit_rays.push(lit_ray);
                }
            }
            let mut seen = Vec::new();
            (visibility.parts).lit_of_neighbours(&paths, &mut |index, parts| {
                join_touching(parts, 0);
                seen_along(lit.panes_of(paths[index].index()), parts, &mut seen);
                let sum = &mut sums[numbers[index]];
                lit_rays[index].add_radiance(&seen, lit, &visibility.points, sum);
            });
            lit.watch.gathered(sums.len());
        });
        Ok(())
    }
}

impl<M: MediaMemory> MediaRays<'_, '_, M> {
    fn panes_of(&self, ray: u32) -> &[Behind] {
        self.panes.map_or(&[], |all| all.of(ray))
    }
}

/// A ray on whose way there are media within the reach of the light.
struct LitRay<'a> {
    /// The part of the ray that the light reaches, whatever the media.
    path: LightPath<'a>,
    line: Line,
    limits: Limits,
}

impl<'a> LitRay<'a> {
    fn new(ray: &'a Ray, lit: &MediaRays<'a, '_, Host>) -> Option<Self> {
        let path = LightPath::new(ray, lit.emitter, &Medium::VACUUM)?.off_the_light();
        let span = span_of(&path);
        let lengths = lengths_within(lit.media, line_of(ray), span);
        if lengths == [0.0; 2] {
            return None;
        }
        let mut rims = [f32::INFINITY; 2];
        for (rim, kink) in rims.iter_mut().zip(path.kinks()) {
            *rim = kink;
        }
        let line = Line {
            lamp: match lit.emitter {
                Emitter::Directional(_) => None,
                Emitter::Point(_) => Some([path.foot().into(), path.h().into()]),
            },
            rims: rims.map(f64::from),
            is_gentle: (lit.media.medium()).is_some_and(|fog| is_gentle(fog, lit.emitter)),
        };
        let [start, end] = span;
        let limits = Limits::new(lit.steps, lengths, line.angle(start, end));
        Some(Self { path, line, limits })
    }

    /// Adds the light that arrives at the eye, of which it sees this share behind each of these
    /// places.
    fn add_radiance<V: PointVisibility>(
        &self,
        mut panes: &[Behind],
        lit: &MediaRays<'_, '_, Host>,
        visibility: &V,
        radiance: &mut [f32; 4],
    ) {
        let ray = self.path.ray();
        let [start, end] = span_of(&self.path);
        let mut sum = DVec3::ZERO;
        // The share that is seen of a step.
        let seen = Cell::new(Vec3::ONE);
        let arriving = |x: f64| arriving(&self.path, lit.media, x);
        let mut steps = Steps::new(self.line, self.limits, arriving, |x: f64, light: DVec3| {
            let share = visibility.visibility(ray.at(x as f32)) * Vec3::ONE;
            sum += (seen.get().as_dvec3() * share.as_dvec3()) * light;
        });
        let [origin, direction] = line_of(ray);
        let mut pieces = lit.media.along(origin, direction, 0.0, end);
        'pieces: while let Some(piece) = pieces.advance() {
            let (mut from, to) = (piece.start().max(start), piece.end());
            if piece.is_empty() {
                continue;
            }
            while from < to {
                while let Some((pane, others)) = panes.split_first()
                    && f64::from(pane.from) <= from
                {
                    steps.finish();
                    seen.set(pane.share);
                    panes = others;
                }
                let next = panes
                    .first()
                    .map_or(to, |pane| f64::from(pane.from).min(to));
                let is_dark = seen.get() == Vec3::ZERO;
                if is_dark && panes.is_empty() {
                    break 'pieces;
                }
                if !is_dark && !steps.add(&piece, [from, next]) {
                    break 'pieces;
                }
                from = next;
            }
        }
        steps.finish();
        for (radiance, light) in radiance.iter_mut().zip(sum.to_array()) {
            *radiance += light as f32;
        }
    }
}

/// The part of a ray that a light reaches.
fn span_of(path: &LightPath<'_>) -> [f64; 2] {
    let Interval { start, end } = path.span();
    [start, end].map(f64::from)
}

/// The origin and the direction of a ray.
fn line_of(ray: &Ray) -> [DVec3; 2] {
    let direction = ray.direction().as_dvec3().normalize();
    [ray.origin().as_dvec3(), direction]
}

/// Roughly the length of a line within smoke, and within fog, from which the length of steps
/// follows. Of several fogs the one in which sight is shortest counts.
fn lengths_within(
    media: &Media<'_>,
    [origin, direction]: [DVec3; 2],
    [start, end]: [f64; 2],
) -> [f64; 2] {
    /// In mean free paths.
    const SEEN: f64 = 10.0;
    let inside = |bounds: Bounds| {
        let interval = Interval::new(start as f32, end as f32);
        bounds
            .clip(origin.as_vec3(), direction.as_vec3(), interval)
            .map_or(0.0, |inside| f64::from(inside.length()))
    };
    let smoke = media.smoke_boxes().map(inside).sum();
    let seen = |sigma: Vec3| match sigma.max_element() {
        0.0 => 0.0,
        sigma => SEEN / f64::from(sigma),
    };
    let mut fogs = [0.0; 2];
    if let Some(medium) = media.medium() {
        fogs[0] = match medium.bounds() {
            Some(bounds) => inside(bounds),
            None => (end - start).min(seen(medium.sigma_t())),
        };
    }
    if let Some(fog) = media.height_fog() {
        let y = origin.y + start * direction.y;
        let sigma = fog.sigma_t() * (fog.density(y) as f32).max(f32::MIN_POSITIVE);
        let rise = SEEN * f64::from(fog.scale_height()) / direction.y.abs();
        fogs[1] = (end - start).min(rise.min(seen(sigma)));
    }
    let [a, b] = fogs;
    [smoke, if a > 0.0 && b > 0.0 { a.min(b) } else { a + b }]
}

/// The light that arrives at a point of a ray, attenuated by fog in closed form.
fn arriving(path: &LightPath<'_>, media: &Media<'_>, x: f64) -> Arriving {
    let ray = path.ray();
    let at = ray.origin().as_dvec3() + x * ray.direction().as_dvec3().normalize();
    let (to_light, distance, light, angle) = match path.emitter() {
        Emitter::Directional(sun) => {
            let angle = path.sun_angle(sun);
            (-sun.direction(), f32::INFINITY, sun.irradiance(), angle)
        }
        Emitter::Point(point) => {
            let s = (x - f64::from(path.foot())) as f32;
            let (direction, d) = path.from_light(s);
            let mut light = path.intensity(point, direction);
            if point.fades() {
                light *= point.window_inside(d);
            }
            (
                -direction,
                d,
                light,
                ScatteringAngle::from_foot(s, path.h()),
            )
        }
    };
    let leg = even_depth(media, at, to_light, distance);
    Arriving {
        light: light.as_dvec3() * exp(-leg),
        angle,
    }
}

/// The optical depth of homogeneous fog and of fog that thins out, from a point towards a
/// light.
pub(super) fn even_depth(media: &Media<'_>, at: DVec3, to_light: Vec3, distance: f32) -> DVec3 {
    let mut depth = DVec3::ZERO;
    if let Some(medium) = media.medium() {
        // Where fog without bounds is everywhere, the irradiance of a sun is the one that
        // arrives.
        if medium.bounds().is_some() || distance.is_finite() {
            let inside = medium.length_inside(at.as_vec3(), to_light, distance);
            depth += medium.sigma_t().as_dvec3() * f64::from(inside);
        }
    }
    if let Some(fog) = media.height_fog() {
        depth += fog.depth_towards(at.y, to_light.y.into(), distance.into());
    }
    depth
}
