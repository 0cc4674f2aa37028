//! The reference that everything is compared with.

use std::time::Instant;

use lighting::Ray;
use reference::oracle::image::{Options, Reference, reference};
use reference::oracle::{area, translucent};

use super::measure::Job;
use super::results::ReferenceFacts;
use crate::progress;

/// The tolerance with area lights, at least: each step beyond it costs many times
/// the last one, and points that stand for a light are farther off.
const AREA_TOLERANCE: f64 = 2e-3;

/// The same in a quick comparison.
const QUICK_AREA_TOLERANCE: f64 = 1e-2;

/// The reference of a picture, behind translucent casters too if there are any.
/// Area lights are what they are, and not the points that stand for them, unless there
/// are such casters.
pub(crate) fn converge(
    job: &Job<'_>,
    rays: &[Ray],
    tolerance: f64,
    quick: bool,
) -> (Reference, ReferenceFacts) {
    let with_areas = job.parts.is_none() && !job.areas.is_empty();
    let tolerance = if with_areas {
        tolerance.max(if quick {
            QUICK_AREA_TOLERANCE
        } else {
            AREA_TOLERANCE
        })
    } else {
        tolerance
    };
    let bar = progress::bar("reference", rays.len() as u64);
    let clock = Instant::now();
    let progress = |rays: usize| bar.inc(rays as u64);
    let truth = match job.parts {
        Some(parts) => translucent::reference(
            rays,
            job.emitters,
            job.medium,
            &job.input.geometry,
            &job.input.scene.translucent,
            parts,
            &progress,
        ),
        None if with_areas => {
            let options = Options {
                tolerance,
                progress: &progress,
                ..Options::default()
            };
            let stands_for_area =
                |index: &usize| job.areas.iter().any(|area| area.emitters.contains(index));
            let others: Vec<_> = (job.emitters.iter().enumerate())
                .filter(|(index, _)| !stands_for_area(index))
                .map(|(_, emitter)| emitter.clone())
                .collect();
            let areas: Vec<_> = job.areas.iter().map(|area| area.light.clone()).collect();
            area::reference(
                rays,
                &others,
                &areas,
                job.medium,
                &job.input.geometry,
                options,
            )
        }
        None => {
            let options = Options {
                tolerance,
                progress: &progress,
                ..Options::default()
            };
            reference(rays, job.emitters, job.medium, &job.input.geometry, options)
        }
    };
    bar.finish_and_clear();
    let mean = truth.mean();
    let absolute = !(mean > 0.0);
    let facts = ReferenceFacts {
        seconds: clock.elapsed().as_secs_f64(),
        tolerance,
        bound: truth.max_bound() / if absolute { 1.0 } else { mean },
        mean,
        absolute,
        parts: job.parts,
        has_areas: with_areas,
    };
    (truth, facts)
}

/// That of a picture without airlight.
pub(crate) fn nothing() -> ReferenceFacts {
    ReferenceFacts {
        seconds: 0.0,
        tolerance: 0.0,
        bound: 0.0,
        mean: 0.0,
        absolute: true,
        parts: None,
        has_areas: false,
    }
}
