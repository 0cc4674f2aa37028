//! Time and error of every candidate on one backend.

use std::collections::HashMap;
use std::time::Instant;

use gpu_backend::gpu::Gpu;
use gpu_backend::{BufferOf, Cpu, Download, Error};
use indicatif::ProgressBar;
use lighting::methods::{Frame, FrameInputs, MethodBackend, MethodError, Store, Used, Work};
use lighting::scene::view::View;
use lighting::scene::{AreaEmitters, Camera, Medium};
use lighting::{Emitter, Watch};
use reference::metrics::image_error;
use reference::oracle::image::Reference;

use super::budget::Budget;
use super::results::{Errors, LeftOut, Measurement, MethodPicture, Times};
use super::schedule::{Place, order, run_while_there_is_time};
use super::selection::Candidate;
use crate::devices::Device;
use crate::failure::Failure;
use crate::format::{count, seconds};
use crate::input::Input;
use crate::parse::Size;
use crate::picture::Picture;
use crate::progress;

/// What is measured, whatever the backend.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) input: &'a Input,
    pub(crate) camera: &'a Camera,
    pub(crate) view: &'a View,
    pub(crate) size: Size,
    pub(crate) medium: &'a Medium,
    /// Those that the plan keeps.
    pub(crate) emitters: &'a [Emitter],
    /// The area lights among them.
    pub(crate) areas: &'a [AreaEmitters],
    /// Texels per side of a shadow map.
    pub(crate) map: u32,
    /// Parts that the reference cuts rays into behind translucent casters;
    /// `None` if there are none.
    pub(crate) parts: Option<u32>,
}

impl<'a> Job<'a> {
    /// What methods are told of the picture.
    pub(crate) fn inputs(&self, watch: &'a dyn Watch) -> FrameInputs<'a> {
        FrameInputs {
            emitters: self.emitters,
            areas: self.areas,
            medium: self.medium,
            geometry: &self.input.geometry,
            translucent: &self.input.scene.translucent,
            camera: self.camera,
            size: [self.size.width, self.size.height],
            rays: self.view.rays(),
            hits: self.view.hits(),
            map: self.map,
            host: &self.input.host,
            watch,
        }
    }
}

/// What came out on one backend.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) measurements: Vec<Measurement>,
    /// Their indices count from the first of `measurements`.
    pub(crate) pictures: Vec<MethodPicture>,
    pub(crate) left_out: Vec<LeftOut>,
}

impl Outcome {
    /// Appends what came out on another backend.
    pub(crate) fn add(&mut self, other: Self) {
        let offset = self.measurements.len();
        for mut picture in other.pictures {
            picture.measurement += offset;
            self.pictures.push(picture);
        }
        self.measurements.extend(other.measurements);
        self.left_out.extend(other.left_out);
    }
}

/// Rays on which the time of a candidate is estimated.
const PROBE_RAYS: usize = 256;

/// No more repetitions than this: the median has settled.
const MAX_REPETITIONS: usize = 9;

/// Share of the time left that may be spent on what a candidate needs.
const PREPARATION: f64 = 0.3;

/// Measures the candidates that the device runs, as long as `budget` allows.
pub(crate) fn measure(
    device: &Device,
    job: Job<'_>,
    candidates: &[Candidate],
    truth: &Reference,
    budget: Budget,
) -> Result<Outcome, Failure> {
    match &device.context {
        // What is on the host is in the memory of this backend.
        None => {
            On::new(&Cpu::new(), &job.input.host, device, job, truth, budget).measure(candidates)
        }
        Some(context) => {
            let waited_for = Gpu::new(context.clone());
            let backend = Gpu::new(context.clone());
            let store = Store::waiting(move || waited_for.wait());
            On::new(&backend, &store, device, job, truth, budget).measure(candidates)
        }
    }
}

/// A backend on which candidates are measured.
struct On<'a, B: MethodBackend + Download> {
    backend: &'a B,
    store: &'a Store<B::Memory>,
    device: &'a Device,
    job: Job<'a>,
    truth: &'a Reference,
    budget: Budget,
}

/// What is known of the time of a method.
#[derive(Debug, Clone, Copy)]
struct Known {
    seconds: f64,
    work: f64,
}

/// A candidate that has been measured.
struct Run {
    candidate: Candidate,
    times: Vec<f64>,
    measurement: Measurement,
    picture: Picture,
}

impl<'a, B: MethodBackend + Download> On<'a, B> {
    fn new(
        backend: &'a B,
        store: &'a Store<B::Memory>,
        device: &'a Device,
        job: Job<'a>,
        truth: &'a Reference,
        budget: Budget,
    ) -> Self {
        Self {
            backend,
            store,
            device,
            job,
            truth,
            budget,
        }
    }

    fn measure(&self, candidates: &[Candidate]) -> Result<Outcome, Failure> {
        let own: Vec<&Candidate> = candidates
            .iter()
            .filter(|candidate| candidate.entry.on::<B>().is_some())
            .collect();
        let places: Vec<Place> = own.iter().map(|candidate| candidate.place()).collect();
        let bar = progress::bar("measuring", own.len() as u64);
        let mut outcome = Outcome::default();
        let mut runs: Vec<Run> = Vec::new();
        let mut known: HashMap<usize, Known> = HashMap::new();
        let mut failed: HashMap<usize, String> = HashMap::new();
        let turns = order(&places);
        let dropped = {
            let (known, failed) = (std::cell::RefCell::new(&mut known), &mut failed);
            let failed = std::cell::RefCell::new(failed);
            run_while_there_is_time::<Failure>(
                &turns,
                || self.budget.left(),
                |index| {
                    let candidate = own[index];
                    match self.expected(candidate, &mut known.borrow_mut()) {
                        Ok(seconds) => Ok(seconds),
                        Err(error) => {
                            let why = self.reason(error)?;
                            failed.borrow_mut().insert(index, why);
                            Ok(0.0)
                        }
                    }
                },
                |index| {
                    bar.inc(1);
                    if failed.borrow().contains_key(&index) {
                        return Ok(());
                    }
                    let candidate = own[index];
                    match self.first_run(candidate) {
                        Ok(run) => {
                            let work = self.work_of(candidate, self.job.view.rays().len());
                            let seconds = run.times[0];
                            known
                                .borrow_mut()
                                .insert(candidate.method, Known { seconds, work });
                            runs.push(run);
                        }
                        Err(error) => {
                            let why = self.reason(error)?;
                            failed.borrow_mut().insert(index, why);
                        }
                    }
                    Ok(())
                },
            )?
        };
        bar.finish_and_clear();
        let on = |index: usize| format!("{} on {}", own[index].name(), self.device.label);
        for (index, expected) in dropped {
            let frame = match expected {
                0.0 => "no time left".to_owned(),
                _ => format!("no time left for a frame of about {}", seconds(expected)),
            };
            outcome.left_out.push(LeftOut {
                what: on(index),
                why: format!("{frame} (--time-budget)"),
            });
        }
        let mut failed: Vec<(usize, String)> = failed.into_iter().collect();
        failed.sort();
        for (index, why) in failed {
            let what = on(index);
            outcome.left_out.push(LeftOut { what, why });
        }
        self.repeat(&mut runs)?;
        runs.sort_by_key(|run| (run.candidate.method, run.candidate.quality));
        for index in pictured(&runs) {
            let size = self.job.size;
            let airlight = std::mem::replace(&mut runs[index].picture, Picture::black(size));
            outcome.pictures.push(MethodPicture {
                measurement: index,
                airlight,
            });
        }
        let measurements = runs.into_iter().map(|run| Measurement {
            frame: Times::of(&run.times),
            ..run.measurement
        });
        outcome.measurements = measurements.collect();
        Ok(outcome)
    }

    /// Why a candidate is left out; a lost device is the end of all.
    fn reason(&self, error: MethodError) -> Result<String, Failure> {
        match error {
            MethodError::Backend(error @ Error::DeviceLost { .. }) => Err(error.into()),
            MethodError::Stopped { .. } => Ok(format!(
                "no time to prepare the shadows of {} (--time-budget, --lights, --map)",
                count(self.job.emitters.len(), "emitter")
            )),
            error => Ok(Failure::from(error).to_string()),
        }
    }

    /// Counted work of a frame.
    fn work_of(&self, candidate: &Candidate, rays: usize) -> f64 {
        let work = self.work(candidate);
        (work.per_frame + work.per_ray * rays as f64).max(1.0)
    }

    fn work(&self, candidate: &Candidate) -> Work {
        let inputs = self.job.inputs(&());
        candidate.entry.method().work(&inputs, candidate.quality)
    }

    /// Seconds that a frame of the candidate is expected to take: from the last
    /// frame of its method, or from a few rays if there is none.
    fn expected(
        &self,
        candidate: &Candidate,
        known: &mut HashMap<usize, Known>,
    ) -> Result<f64, MethodError> {
        let work = self.work_of(candidate, self.job.view.rays().len());
        if let Some(known) = known.get(&candidate.method) {
            return Ok(known.seconds * (work / known.work).max(1.0));
        }
        let rays = self.job.view.rays();
        // An odd step does not run along the columns of usual widths.
        let step = (rays.len() / PROBE_RAYS).max(1) | 1;
        let few: Vec<_> = rays.iter().step_by(step).copied().collect();
        let hits: Vec<_> = self.job.view.hits().iter().step_by(step).copied().collect();
        let watch = Patience::new(PREPARATION * self.budget.left());
        let inputs = FrameInputs {
            rays: &few,
            hits: &hits,
            ..self.job.inputs(&watch)
        };
        let frame = Frame::new(self.backend, inputs, self.store)?;
        self.prepare(candidate, &frame)?;
        // The first frame of a method builds its pipelines, where there are any.
        if self.device.context.is_some() {
            self.timed(candidate, &frame)?;
        }
        let (seconds, _) = self.timed(candidate, &frame)?;
        Ok(seconds * work / self.work_of(candidate, few.len()))
    }

    fn prepare(&self, candidate: &Candidate, frame: &Frame<'_, B>) -> Result<(), MethodError> {
        let method = candidate.entry.on::<B>();
        let method = method.expect("candidates are those that the backend runs");
        method.prepare(frame, candidate.quality)?;
        self.backend.wait()?;
        Ok(())
    }

    fn timed(
        &self,
        candidate: &Candidate,
        frame: &Frame<'_, B>,
    ) -> Result<(f64, BufferOf<B, [f32; 4]>), MethodError> {
        let method = candidate.entry.on::<B>();
        let method = method.expect("candidates are those that the backend runs");
        let mut radiance = self.backend.zeros(frame.inputs.rays.len())?;
        self.backend.wait()?;
        let clock = Instant::now();
        method.add_radiance(frame, candidate.quality, &mut radiance)?;
        self.backend.wait()?;
        Ok((clock.elapsed().as_secs_f64(), radiance))
    }

    fn first_run(&self, candidate: &Candidate) -> Result<Run, MethodError> {
        self.store.watch_use();
        self.job.input.host.watch_use();
        let watch = Patience::new(PREPARATION * self.budget.left());
        let frame = Frame::new(self.backend, self.job.inputs(&watch), self.store)?;
        self.prepare(candidate, &frame)?;
        let (time, radiance) = self.timed(candidate, &frame)?;
        let mut used = self.store.used();
        if self.device.context.is_some() {
            used.extend(self.job.input.host.used());
        }
        let radiance = self.backend.download(&radiance)?;
        let error = image_error(&radiance, self.truth);
        Ok(Run {
            candidate: candidate.clone(),
            times: vec![time],
            measurement: Measurement {
                method: candidate.method,
                backend: self.device.label.clone(),
                representative: self.device.representative,
                quality: candidate.quality,
                error: Errors {
                    rmse: error.rmse,
                    max: error.max,
                    rel_p99: error.rel_p99,
                },
                seconds_build: used.iter().map(|used: &Used| used.seconds).sum(),
                frame: Times::of(&[time]),
                bytes: used.iter().map(|used| used.bytes).sum(),
            },
            picture: Picture::new(self.job.size, &radiance),
        })
    }

    /// Measures everything again and again until the time is up.
    fn repeat(&self, runs: &mut [Run]) -> Result<(), Failure> {
        let bar = progress::bar("repeating", MAX_REPETITIONS as u64 - 1);
        let frame = Frame::new(self.backend, self.job.inputs(&()), self.store)?;
        for _ in 1..MAX_REPETITIONS {
            for run in runs.iter_mut() {
                if run.times[0] < self.budget.left() {
                    run.times.push(self.timed(&run.candidate, &frame)?.0);
                }
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// For each method the index of the run whose quality is nearest to the one that is
/// pictured.
fn pictured(runs: &[Run]) -> Vec<usize> {
    let mut nearest: Vec<usize> = Vec::new();
    let distance = |index: usize| {
        let Candidate { entry, quality, .. } = &runs[index].candidate;
        quality.abs_diff(entry.about().pictured)
    };
    for index in 0..runs.len() {
        let same =
            |other: &&mut usize| runs[**other].candidate.method == runs[index].candidate.method;
        match nearest.iter_mut().find(same) {
            Some(other) if distance(index) < distance(*other) => *other = index,
            Some(_) => {}
            None => nearest.push(index),
        }
    }
    nearest
}

/// Waits no longer than so many seconds, going by what the first lights took.
struct Patience {
    start: Instant,
    seconds: f64,
    bar: ProgressBar,
}

impl Patience {
    fn new(seconds: f64) -> Self {
        Self {
            start: Instant::now(),
            seconds,
            bar: progress::bar("preparing", 0),
        }
    }
}

impl Watch for Patience {
    fn goes_on(&self, done: usize, total: usize) -> bool {
        self.bar.set_length(total as u64);
        self.bar.set_position(done as u64);
        let so_far = self.start.elapsed().as_secs_f64();
        done == 0 || so_far / done as f64 * total as f64 <= self.seconds
    }
}

impl Drop for Patience {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
