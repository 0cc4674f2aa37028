//! The reference and the measurements, on a picture that fits the time.

use std::time::Instant;

use crepuscular_tests::oracle::image::{Options, Reference, reference};
use crepuscular_tests::oracle::translucent;
use lighting::Ray;
use lighting::scene::Medium;

use super::baked::bake_all;
use super::budget::{Budget, affordable_size};
use super::measure::{Cost, Job, Measure, Outcome, session};
use super::prepare::Prepared;
use super::results::ReferenceFacts;
use super::selection::Candidate;
use crate::args::Compare;
use crate::engine::Tables;
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

/// Parts of the time that a backend gets whose times mean something, and one
/// whose times do not.
const PARTS: [f64; 2] = [3.0, 1.0];

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
                parts: None,
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
        backends,
    } = prepared;
    let candidates = &selection.candidates;
    let settings = candidates.iter().map(Candidate::setting);
    let tables = Tables::new(medium.phase(), settings)?;
    let baked = bake_all(candidates, &input.geometry, &emitters, budget)?;
    let job = Job {
        camera,
        input,
        geometry: &input.geometry,
        tracer: &input.tracer,
        seconds_tracer: input.seconds_tracer,
        medium,
        emitters: &emitters,
        map,
        parts: (!input.scene.translucent.is_empty()).then_some(if args.quick { 48 } else { 128 }),
        tables: &tables,
        baked: &baked,
        budget,
    };
    let few = every_so_often(frame.view.rays(), emitters.len());
    let mut outcome = Outcome::default();
    let mut sessions: Vec<(Box<dyn Measure + '_>, Vec<Cost>)> = Vec::new();
    for backend in &backends.present {
        let probed = session(backend, job, candidates).and_then(|session| {
            let costs = session.probe((&few, frame.size))?;
            Ok((session, costs))
        });
        match probed {
            Ok(probed) => sessions.push(probed),
            Err(failure) => outcome.left_out.push(backend.excuse(failure)?),
        }
    }
    if !fitted {
        let truth = reference_per_ray(&job, &few, args.tolerance);
        // A picture is not made smaller for times that mean nothing.
        let costs = sessions
            .iter()
            .filter(|(session, _)| session.backend().representative || sessions.len() == 1)
            .flat_map(|(_, costs)| costs);
        let (start, per_ray) = costs.fold((0.0, truth), |(start, per_ray), cost| {
            (start + cost.start, per_ray + cost.per_ray)
        });
        let seconds = (FIRST_ROUND * budget.left() - start).max(0.0);
        let size = affordable_size(frame.size, per_ray, seconds);
        if size != frame.size && frame.shrink(input, camera, size)? {
            return Ok(None);
        }
    }

    let (truth, facts) = converge(&job, frame.view.rays(), args.tolerance);
    let mut found = Found {
        facts,
        airlight: Picture::of_reference(frame.size, &truth.radiance),
        outcome,
        backends: Vec::new(),
    };
    let view = (frame.view.rays(), frame.size);
    let parts = |session: &dyn Measure| PARTS[usize::from(!session.backend().representative)];
    let mut parts_left: f64 = sessions.iter().map(|(s, _)| parts(s.as_ref())).sum();
    for (session, costs) in &sessions {
        let own = parts(session.as_ref());
        let share = budget.share(own / parts_left);
        parts_left -= own;
        match session.measure(view, costs, &truth, share) {
            Ok(outcome) => {
                found.backends.push(session.backend().label.clone());
                found.add(outcome);
            }
            Err(failure) => {
                let left_out = session.backend().excuse(failure)?;
                found.outcome.left_out.push(left_out);
            }
        }
    }
    Ok(Some(found))
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
        truth_of(job, rays, tolerance, &|_| {});
        clock.elapsed().as_secs_f64()
    };
    let start = seconds(&rays[..rays.len().min(1)]);
    (seconds(rays) - start).max(0.0) / rays.len().max(1) as f64
}

/// The reference, behind translucent casters too if there are any.
fn truth_of(
    job: &Job<'_>,
    rays: &[Ray],
    tolerance: f64,
    progress: &(dyn Fn(usize) + Sync),
) -> Reference {
    match job.parts {
        Some(parts) => translucent::reference(
            rays,
            job.emitters,
            job.medium,
            job.geometry,
            &job.input.scene.translucent,
            parts,
            progress,
        ),
        None => {
            let options = Options {
                tolerance,
                progress,
                ..Options::default()
            };
            reference(rays, job.emitters, job.medium, job.geometry, options)
        }
    }
}

fn converge(job: &Job<'_>, rays: &[Ray], tolerance: f64) -> (Reference, ReferenceFacts) {
    let bar = progress::bar("reference", rays.len() as u64);
    let clock = Instant::now();
    let truth = truth_of(job, rays, tolerance, &|rays| bar.inc(rays as u64));
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
