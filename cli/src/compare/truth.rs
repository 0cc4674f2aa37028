//! The reference that everything is compared with.

use std::time::Instant;

use lighting::Ray;
use reference::oracle::image::{Options, Reference, reference};
use reference::oracle::translucent;

use super::measure::Job;
use super::results::ReferenceFacts;
use crate::progress;

/// The reference of a picture, behind translucent casters too if there are any.
pub(crate) fn converge(job: &Job<'_>, rays: &[Ray], tolerance: f64) -> (Reference, ReferenceFacts) {
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
    }
}
