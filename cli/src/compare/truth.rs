//! The reference that everything is compared with.

use std::time::Instant;

use lighting::Ray;
use reference::oracle::image::{Options, Reference, reference};
use reference::oracle::media::Air;
use reference::oracle::{area, media_image, translucent};

use super::measure::Job;
use super::results::ReferenceFacts;
use crate::progress;

/// The smallest tolerance with area lights: each step beyond it costs many times as much as the
/// last one, and methods whose points stand for a light are farther off.
const AREA_TOLERANCE: f64 = 2e-3;

/// The same in a quick comparison.
const QUICK_AREA_TOLERANCE: f64 = 1e-2;

/// The smallest tolerance where smoke or uneven fog is seen: extinction towards light and eye has
/// a kink at each cell, so that each step beyond costs twice as much as the last one.
const MEDIA_TOLERANCE: f64 = 1e-3;

/// The same in a quick comparison.
const QUICK_MEDIA_TOLERANCE: f64 = 5e-3;

/// The reference of a picture, behind translucent casters too if there are any, and with the
/// media among them if these are seen. It integrates over area lights, and does not take the
/// points that stand for them, unless there are such casters or media.
pub(crate) fn converge(
    job: &Job<'_>,
    rays: &[Ray],
    tolerance: f64,
    quick: bool,
) -> (Reference, ReferenceFacts) {
    let tolerance = self::tolerance(job, tolerance, quick);
    let bar = progress::bar("reference", rays.len() as u64);
    let clock = Instant::now();
    let truth = refine(job, rays, tolerance, &|rays| bar.inc(rays as u64));
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
        has_areas: has_areas(job),
        sees_media: job.sees_media,
    };
    (truth, facts)
}

/// Whether the reference integrates over area lights.
fn has_areas(job: &Job<'_>) -> bool {
    !job.sees_media && job.parts.is_none() && !job.areas.is_empty()
}

/// The tolerance of a picture for which this one was asked.
pub(crate) fn tolerance(job: &Job<'_>, asked: f64, quick: bool) -> f64 {
    let least = match (job.sees_media, has_areas(job), quick) {
        (true, _, true) => QUICK_MEDIA_TOLERANCE,
        (true, _, false) => MEDIA_TOLERANCE,
        (_, true, true) => QUICK_AREA_TOLERANCE,
        (_, true, false) => AREA_TOLERANCE,
        _ => 0.0,
    };
    asked.max(least)
}

/// The reference of some rays; `progress` is told how many are ready.
pub(crate) fn refine(
    job: &Job<'_>,
    rays: &[Ray],
    tolerance: f64,
    progress: &(dyn Fn(usize) + Sync),
) -> Reference {
    match job.parts {
        _ if job.sees_media => {
            let scene = &job.input.scene;
            let air = Air {
                medium: Some(job.medium),
                height_fog: scene.height_fog.as_ref(),
                translucent: &scene.translucent,
            };
            let options = Options {
                tolerance,
                progress,
                ..Options::default()
            };
            media_image::reference(rays, air, job.emitters, &job.input.geometry, options)
        }
        Some(parts) => translucent::reference(
            rays,
            job.emitters,
            job.medium,
            &job.input.geometry,
            &job.input.scene.translucent,
            parts,
            progress,
        ),
        None if has_areas(job) => {
            let options = Options {
                tolerance,
                progress,
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
                progress,
                ..Options::default()
            };
            reference(rays, job.emitters, job.medium, &job.input.geometry, options)
        }
    }
}

/// The reference of a picture without airlight.
pub(crate) fn nothing() -> ReferenceFacts {
    ReferenceFacts {
        seconds: 0.0,
        tolerance: 0.0,
        bound: 0.0,
        mean: 0.0,
        absolute: true,
        parts: None,
        has_areas: false,
        sees_media: false,
    }
}
