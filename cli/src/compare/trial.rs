//! The reference and the measurements, on a picture that fits the time.

use std::time::Instant;

use crepuscular_tests::oracle::image::{Options, Reference, reference};
use gpu_backend::Cpu;
use lighting::Ray;
use lighting::scene::Medium;

use super::budget::{Budget, affordable_size};
use super::measure::{Job, Measure, Outcome, Session};
use super::prepare::{Prepared, backends};
use super::results::ReferenceFacts;
use super::selection::Candidate;
use crate::args::{BackendName, Compare};
use crate::failure::Failure;
use crate::picture::Picture;
use crate::progress;

/// Rays on which the time of everything is estimated.
const PROBE_RAYS: usize = 512;

/// With more emitters than this there are fewer such rays, but not fewer than
/// [`LEAST_PROBE_RAYS`].
const PROBE_EMITTERS: usize = 64;
const LEAST_PROBE_RAYS: usize = 16;

/// Share of the time left that the reference and one round of all methods may
/// take; the rest is for repetitions and for what the estimate gets wrong.
const FIRST_ROUND: f64 = 0.5;

/// The reference and all measurements.
pub(crate) struct Found {
    pub(crate) facts: ReferenceFacts,
    pub(crate) airlight: Picture,
    pub(crate) outcome: Outcome,
    pub(crate) backends: Vec<String>,
}

impl Found {
    /// What there is to find without a method: the airlight is black.
    pub(crate) fn nothing(prepared: &Prepared) -> Self {
        Self {
            facts: ReferenceFacts {
                seconds: 0.0,
                tolerance: 0.0,
                bound: 0.0,
                mean: 0.0,
                absolute: true,
            },
            airlight: Picture::black(prepared.frame.size),
            outcome: Outcome::default(),
            backends: Vec::new(),
        }
    }

    fn add(&mut self, outcome: Outcome) {
        let offset = self.outcome.measurements.len();
        for mut picture in outcome.pictures {
            picture.measurement += offset;
            self.outcome.pictures.push(picture);
        }
        self.outcome.measurements.extend(outcome.measurements);
        self.outcome.left_out.extend(outcome.left_out);
    }
}

/// Measures all candidates, after reducing the picture to what the time
/// allows unless that is `fitted` already. `None` if the reduced picture needs
/// emitters that the plan had dropped: try again.
pub(crate) fn try_out(
    args: &Compare,
    prepared: &mut Prepared,
    medium: &Medium,
    map: u32,
    budget: Budget,
    fitted: bool,
) -> Result<Option<Found>, Failure> {
    let emitters = prepared.emitters();
    let Prepared {
        input,
        camera,
        frame,
        selection,
    } = prepared;
    let candidates = &selection.candidates;
    let job = Job {
        geometry: &input.geometry,
        tracer: &input.tracer,
        seconds_tracer: input.seconds_tracer,
        medium,
        emitters: &emitters,
        map,
        budget,
    };
    let sessions = sessions(args, job, candidates)?;

    let few = every_so_often(frame.view.rays(), emitters.len());
    let mut estimates = Vec::new();
    for session in &sessions {
        estimates.push(session.probe(&few, candidates)?);
    }
    if !fitted {
        let truth = reference_per_ray(&job, &few, args.tolerance);
        let per_ray = truth + estimates.iter().flatten().sum::<f64>();
        let size = affordable_size(frame.size, per_ray, FIRST_ROUND * budget.left());
        if size != frame.size && frame.shrink(input, camera, size)? {
            return Ok(None);
        }
    }

    let (truth, facts) = converge(&job, frame.view.rays(), args.tolerance);
    let mut found = Found {
        facts,
        airlight: Picture::of_reference(frame.size, &truth.radiance),
        outcome: Outcome::default(),
        backends: Vec::new(),
    };
    let backends_left = (1..=sessions.len()).rev();
    for ((session, per_ray), sharing) in sessions.iter().zip(&estimates).zip(backends_left) {
        let view = (frame.view.rays(), frame.size);
        let share = budget.share(sharing);
        let outcome = session.measure(view, candidates, per_ray, &truth, share)?;
        found.backends.push(session.backend().into());
        found.add(outcome);
    }
    Ok(Some(found))
}

/// One session per backend.
fn sessions<'a>(
    args: &Compare,
    job: Job<'a>,
    candidates: &[Candidate],
) -> Result<Vec<Box<dyn Measure + 'a>>, Failure> {
    let mut sessions: Vec<Box<dyn Measure + 'a>> = Vec::new();
    for name in backends(args) {
        sessions.push(match name {
            BackendName::Cpu => Box::new(Session::new(Cpu::new(), job, candidates)?),
        });
    }
    Ok(sessions)
}

/// About [`PROBE_RAYS`] of the rays, or fewer if there are many emitters,
/// spread over all of them.
fn every_so_often(rays: &[Ray], emitters: usize) -> Vec<Ray> {
    let wanted = PROBE_RAYS * PROBE_EMITTERS / emitters.max(PROBE_EMITTERS);
    let wanted = wanted.max(LEAST_PROBE_RAYS);
    // An odd step does not run along the columns of usual widths.
    let step = (rays.len() / wanted).max(1) | 1;
    rays.iter().step_by(step).copied().collect()
}

/// Seconds that the reference takes per ray, without what it takes to start.
fn reference_per_ray(job: &Job<'_>, rays: &[Ray], tolerance: f64) -> f64 {
    let seconds = |rays: &[Ray]| {
        let clock = Instant::now();
        let options = Options {
            tolerance,
            ..Options::default()
        };
        reference(rays, job.emitters, job.medium, job.geometry, options);
        clock.elapsed().as_secs_f64()
    };
    let start = seconds(&rays[..rays.len().min(1)]);
    (seconds(rays) - start).max(0.0) / rays.len().max(1) as f64
}

fn converge(job: &Job<'_>, rays: &[Ray], tolerance: f64) -> (Reference, ReferenceFacts) {
    let bar = progress::bar("reference", rays.len() as u64);
    let clock = Instant::now();
    let options = Options {
        tolerance,
        progress: &|rays| bar.inc(rays as u64),
        ..Options::default()
    };
    let truth = reference(rays, job.emitters, job.medium, job.geometry, options);
    bar.finish_and_clear();
    let mean = truth.mean();
    let absolute = !(mean > 0.0);
    let facts = ReferenceFacts {
        seconds: clock.elapsed().as_secs_f64(),
        tolerance,
        bound: truth.max_bound() / if absolute { 1.0 } else { mean },
        mean,
        absolute,
    };
    (truth, facts)
}
