//! The reference image: exact lit intervals times error-bounded quadrature,
//! summed over the lights.

use glam::DVec3;
use rayon::prelude::*;
use scene::{Emitter, Geometry, Medium, Ray};

use super::airlight::{Airlight, Estimate, Tolerance, reach};
use super::coats::{Coats, Shared};
use super::visibility::{Blockers, Search};
use super::{Fog, Lamp, Line};

pub use crate::metrics::{DARKEST, Reference};

/// How to compute a reference.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Allowed error relative to the brightest channel of a pixel, or of
    /// [`DARKEST`] of the mean of the image for pixels darker than that.
    pub tolerance: f64,
    /// Called from any thread with the number of rays that were finished since
    /// the last call.
    pub progress: &'a (dyn Fn(usize) + Sync),
    /// How blockers are found.
    pub search: Search,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            progress: &|_| {},
            search: Search::Tree,
        }
    }
}

impl std::fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("tolerance", &self.tolerance)
            .field("search", &self.search)
            .finish_non_exhaustive()
    }
}

/// The light that `medium` scatters along each ray into its origin, from all
/// `emitters`, with the shadows of `geometry`.
///
/// # Rays through a light
/// Along a ray through a point light the airlight is infinite. If the foot
/// point of the light lies in the part of the ray that the light could reach
/// without blockers, its distance `h` from the ray counts as at least 1e-4 of
/// the distance between eye and light, and as 1e-12 m at an eye at the light.
///
/// # Masks and what is see-through
/// What is not solid is asked point by point, see [`Coats::parts`]: the bound leaves
/// out that a share which varies is that of the middle of parts of a thousandth.
///
/// The result does not depend on the number of threads.
pub fn reference(
    rays: &[Ray],
    emitters: &[Emitter],
    medium: &Medium,
    geometry: &Geometry,
    options: Options<'_>,
) -> Reference {
    let world = World::new(emitters, medium, geometry, options.search);
    refined(rays, options, 500, |ray, tolerance| {
        world.light(ray, tolerance)
    })
}

/// A picture of what `light` gives along each ray within a tolerance: that of the options, for
/// dark pixels relative to the mean of the picture without refinement, from at most about
/// `sample` rays. The same on any number of threads.
pub(super) fn refined(
    rays: &[Ray],
    options: Options<'_>,
    sample: usize,
    light: impl Fn(&Ray, Tolerance) -> Estimate + Sync,
) -> Reference {
    let unrefined = Tolerance::relative(f64::INFINITY);
    let stride = rays.len().div_ceil(sample).max(1);
    let rough: Vec<f64> = rays
        .par_iter()
        .step_by(stride)
        .map(|ray| light(ray, unrefined).value.element_sum() / 3.0)
        .collect();
    let mean = rough.iter().sum::<f64>() / rough.len().max(1) as f64;
    let tolerance = Tolerance {
        relative: options.tolerance,
        absolute: options.tolerance * DARKEST * mean,
    };
    let estimates: Vec<Estimate> = rays
        .par_chunks(8)
        .flat_map_iter(|chunk| {
            let estimates: Vec<_> = chunk.iter().map(|ray| light(ray, tolerance)).collect();
            (options.progress)(chunk.len());
            estimates
        })
        .collect();
    Reference {
        radiance: estimates.iter().map(|e| e.value.to_array()).collect(),
        bound: estimates.iter().map(|e| e.bound).collect(),
    }
}

pub(super) struct World<'a> {
    lamps: Vec<Lamp>,
    fog: Fog,
    blockers: Blockers,
    /// What is not solid.
    coats: Option<Coats<'a>>,
    search: Search,
}

impl<'a> World<'a> {
    pub(super) fn new(
        emitters: &[Emitter],
        medium: &Medium,
        geometry: &'a Geometry,
        search: Search,
    ) -> Self {
        Self {
            lamps: emitters.iter().map(Lamp::new).collect(),
            fog: Fog::new(medium),
            blockers: Blockers::new(geometry),
            coats: Coats::new(geometry),
            search,
        }
    }

    /// The light of the world's own lamps.
    pub(super) fn light(&self, ray: &Ray, tolerance: Tolerance) -> Estimate {
        self.light_of(&self.lamps, &Line::new(ray), tolerance)
    }

    /// That of any lamps.
    pub(super) fn light_of(&self, lamps: &[Lamp], line: &Line, tolerance: Tolerance) -> Estimate {
        if self.fog.sigma_s == DVec3::ZERO {
            return Estimate::default();
        }
        if let Some(coats) = &self.coats {
            return self.light_past(coats, lamps, line, tolerance);
        }
        let mut airlight = Airlight::new(line, &self.fog);
        let mut lit = Vec::new();
        for lamp in lamps {
            if let Some(reach) = reach(line, lamp, &self.fog) {
                lit.clear();
                self.blockers.lit(line, lamp, reach, self.search, &mut lit);
                airlight.add_off_the_light(lamp, reach, &lit);
            }
        }
        airlight.total(tolerance)
    }

    /// The same where not all is solid: the sum over parts of the light of each
    /// times its share.
    fn light_past(
        &self,
        coats: &Coats<'_>,
        lamps: &[Lamp],
        line: &Line,
        tolerance: Tolerance,
    ) -> Estimate {
        let mut sum = Estimate::default();
        let mut lit = Vec::new();
        for lamp in lamps {
            let Some(reach) = reach(line, lamp, &self.fog) else {
                continue;
            };
            lit.clear();
            self.blockers.lit(line, lamp, reach, self.search, &mut lit);
            let mut parts: Vec<_> = lit
                .iter()
                .flat_map(|span| coats.parts(line, lamp, *span))
                .collect();
            // Parts of the same share are integrated together.
            while let Some(first) = parts.first().map(|part| part.share) {
                let is_same = |part: &Shared| (part.share - first).abs().max_element() < 1e-12;
                let (same, others): (Vec<_>, Vec<_>) = parts.into_iter().partition(is_same);
                parts = others;
                let spans: Vec<_> = same.iter().map(|part| part.span).collect();
                let mut airlight = Airlight::new(line, &self.fog);
                airlight.add_off_the_light(lamp, reach, &spans);
                let light = airlight.total(tolerance);
                sum.value += first * light.value;
                sum.bound += light.bound;
            }
        }
        sum
    }
}
