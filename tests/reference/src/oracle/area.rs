//! The reference image of area lights: the airlight of a point of the light, which
//! is exact, integrated over the light.
//!
//! ```text
//! L(ray) = ∫_A L_e(y) l(ray, y) dA(y)
//! ```
//!
//! where `l` is the airlight of a point at `y` with a cosine emission and all
//! shadows. It is continuous in `y` and has kinks where an edge of a blocker
//! crosses the ray, so the light is divided into four again and again where the
//! rule of 3 × 3 Gauss points of a part differs most from the sum of its quarters.

use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use scene::{AreaLight, AreaShape, Emitter, Geometry, Medium, Ray};

use super::airlight::{Estimate, Tolerance};
use super::image::{Options, Reference, World};
use super::lamp::texel;
use super::{Lamp, Line, PointLamp};

/// Errors of pixels that are darker than this share of the image's mean are relative
/// to it.
pub const DARKEST: f64 = 0.1;

/// Parts of a light, at most.
const MOST_PARTS: usize = 1500;

/// Each side of a light is divided into so many parts to begin with.
const FIRST_PARTS: u32 = 2;

/// Nodes and weights of the Gauss–Legendre rule of three points on [0, 1].
const NODES: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// The light that `medium` scatters along each ray into its origin, from all
/// `emitters` and all area lights, with the shadows of `geometry`.
///
/// Area lights float in front of their place by 1e-3 of their shorter edge, as the
/// points do that stand for them elsewhere. The error of a pixel is estimated to
/// be below `options.tolerance` of its brightest channel, or of [`DARKEST`] of the
/// mean of the image; where a light in 1500 parts does not reach that,
/// [`Reference::bound`] says so. The result does not depend on the number of threads.
pub fn reference(
    rays: &[Ray],
    emitters: &[Emitter],
    areas: &[AreaLight],
    medium: &Medium,
    geometry: &Geometry,
    options: Options<'_>,
) -> Reference {
    let world = World::new(emitters, medium, geometry, options.search);
    let panels: Vec<Panel<'_>> = areas.iter().map(Panel::new).collect();
    let unrefined = Tolerance {
        relative: 1e-3,
        absolute: f64::INFINITY,
    };
    let stride = rays.len().div_ceil(200).max(1);
    let sample: Vec<f64> = rays
        .par_iter()
        .step_by(stride)
        .map(|ray| light(&world, &panels, ray, unrefined).value.element_sum() / 3.0)
        .collect();
    let mean = sample.iter().sum::<f64>() / sample.len().max(1) as f64;
    let tolerance = Tolerance {
        relative: options.tolerance,
        absolute: options.tolerance * DARKEST * mean,
    };
    let estimates: Vec<Estimate> = rays
        .par_chunks(8)
        .flat_map_iter(|chunk| {
            let each = chunk.iter();
            let estimates: Vec<_> = each
                .map(|ray| light(&world, &panels, ray, tolerance))
                .collect();
            (options.progress)(chunk.len());
            estimates
        })
        .collect();
    Reference {
        radiance: estimates.iter().map(|e| e.value.to_array()).collect(),
        bound: estimates.iter().map(|e| e.bound).collect(),
    }
}

/// All lights of a ray.
fn light(world: &World<'_>, panels: &[Panel<'_>], ray: &Ray, tolerance: Tolerance) -> Estimate {
    let line = Line::new(ray);
    let mut sum = world.light(ray, tolerance);
    for panel in panels {
        let of_panel = panel.light(world, &line, tolerance);
        sum.value += of_panel.value;
        sum.bound += of_panel.bound;
    }
    sum
}

/// An area light in f64.
struct Panel<'a> {
    light: &'a AreaLight,
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    area: f64,
}

/// A part of a light.
struct Part {
    low: DVec2,
    size: f64,
    value: DVec3,
    /// The error of the points themselves.
    bound: f64,
    /// How far the value may be off.
    error: f64,
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Part {}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// By error, then by place, so that there is one order.
impl Ord for Part {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let place = |part: &Self| [part.low.x, part.low.y];
        let [a, b] = [place(self), place(other)];
        (self.error.total_cmp(&other.error))
            .then(a[0].total_cmp(&b[0]))
            .then(a[1].total_cmp(&b[1]))
    }
}

impl<'a> Panel<'a> {
    fn new(light: &'a AreaLight) -> Self {
        let edges = light.edges.map(|edge| edge.as_dvec3());
        let across = edges[0].cross(edges[1]);
        let normal = across.normalize();
        let lift = 1e-3 * edges[0].length().min(edges[1].length());
        let full = match light.shape {
            AreaShape::Rectangle => 1.0,
            AreaShape::Disk => 0.25 * std::f64::consts::PI,
        };
        Self {
            light,
            corner: light.corner.as_dvec3() + lift * normal,
            edges,
            normal,
            area: full * across.length(),
        }
    }

    /// The point that stands for all of the light if it is one: equal areas of the
    /// unit square are equal areas of the light.
    fn lamp(&self, at: DVec2) -> Lamp {
        let place = match self.light.shape {
            AreaShape::Rectangle => at,
            AreaShape::Disk => {
                let around = DVec2::from_angle(std::f64::consts::TAU * at.y);
                0.5 + 0.5 * at.x.sqrt() * around
            }
        };
        let colour = match &self.light.texture {
            Some(texture) => texel(texture, place),
            None => DVec3::ONE,
        };
        let position = self.corner + place.x * self.edges[0] + place.y * self.edges[1];
        let intensity = self.area * self.light.radiance.as_dvec3() * colour;
        Lamp::Point(PointLamp::cosine(position, intensity, self.normal))
    }

    fn part(
        &self,
        world: &World<'_>,
        line: &Line,
        low: DVec2,
        size: f64,
        inner: Tolerance,
    ) -> Part {
        let mut value = DVec3::ZERO;
        let mut bound = 0.0;
        for (x, wx) in NODES.into_iter().zip(WEIGHTS) {
            for (y, wy) in NODES.into_iter().zip(WEIGHTS) {
                let lamp = self.lamp(low + size * DVec2::new(x, y));
                let weight = wx * wy * size * size;
                let light = world.light_of(&[lamp], line, inner);
                value += weight * light.value;
                bound += weight * light.bound;
            }
        }
        Part {
            low,
            size,
            value,
            bound,
            error: 0.0,
        }
    }

    /// The four quarters of a part, with what they differ from it by.
    fn quarters(&self, world: &World<'_>, line: &Line, part: &Part, inner: Tolerance) -> [Part; 4] {
        let half = 0.5 * part.size;
        let mut quarters = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
            let low = part.low + half * DVec2::new(x, y);
            self.part(world, line, low, half, inner)
        });
        let sum: DVec3 = quarters.iter().map(|quarter| quarter.value).sum();
        let error = (sum - part.value).abs().max_element();
        for quarter in &mut quarters {
            quarter.error = 0.25 * error;
        }
        quarters
    }

    fn light(&self, world: &World<'_>, line: &Line, tolerance: Tolerance) -> Estimate {
        let inner = Tolerance {
            relative: 0.05 * tolerance.relative,
            absolute: 0.05 * tolerance.absolute,
        };
        let n = FIRST_PARTS;
        let mut parts = BinaryHeap::new();
        for i in 0..n * n {
            let size = 1.0 / f64::from(n);
            let low = size * DVec2::new(f64::from(i % n), f64::from(i / n));
            let whole = self.part(world, line, low, size, inner);
            parts.extend(self.quarters(world, line, &whole, inner));
        }
        loop {
            let value: DVec3 = parts.iter().map(|part: &Part| part.value).sum();
            let error: f64 = parts.iter().map(|part| part.error).sum();
            let bound: f64 = parts.iter().map(|part| part.bound).sum();
            let allowed = (tolerance.relative * value.max_element()).max(tolerance.absolute);
            if error <= allowed || parts.len() >= MOST_PARTS {
                return Estimate {
                    value,
                    bound: error + bound,
                };
            }
            if let Some(worst) = parts.pop() {
                parts.extend(self.quarters(world, line, &worst, inner));
            }
        }
    }
}
