//! Time and error of every candidate on one backend.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::time::Instant;

use gpu_backend::gpu::Gpu;
use gpu_backend::{BufferOf, Cpu, Download};
use lighting::methods::{
    Frame, FrameInputs, MethodBackend, MethodError, Selection, Store, Used, Work,
};
use lighting::scene::view::View;
use lighting::scene::{AreaEmitters, Camera, Medium};
use lighting::{Emitter, Watch};
use reference::metrics::image_error;
use reference::oracle::image::Reference;

use super::budget::Budget;
use super::flip::Flip;
use super::floors::floors;
use super::patience::Patience;
use super::results::{Errors, LeftOut, MapFloor, Measurement, MethodPicture, Times};
use super::schedule::{Place, order, run_while_there_is_time};
use super::selection::Candidate;
use super::study::NO_TIME;
use crate::devices::Device;
use crate::failure::Failure;
use crate::format::{count, seconds};
use crate::input::Input;
use crate::parse::Size;
use crate::picture::Picture;
use crate::progress;

/// A picture on which methods are measured, whatever the backend.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) input: &'a Input,
    pub(crate) camera: &'a Camera,
    pub(crate) view: &'a View,
    pub(crate) size: Size,
    pub(crate) medium: &'a Medium,
    /// The emitters that the plan keeps.
    pub(crate) emitters: &'a [Emitter],
    /// The area lights among them.
    pub(crate) areas: &'a [AreaEmitters],
    /// Texels per side of a shadow map.
    pub(crate) map: u32,
    /// The number of parts into which the reference cuts rays behind translucent casters that
    /// are not seen themselves; `None` if there are no such casters.
    pub(crate) parts: Option<u32>,
    /// Whether smoke and fog that thins out are seen.
    pub(crate) sees_media: bool,
}

impl<'a> Job<'a> {
    /// The inputs of a frame of methods.
    pub(crate) fn inputs(&self, watch: &'a dyn Watch) -> FrameInputs<'a> {
        FrameInputs {
            emitters: self.emitters,
            areas: self.areas,
            medium: self.medium,
            height_fog: self.input.scene.height_fog.as_ref(),
            geometry: &self.input.geometry,
            translucent: &self.input.scene.translucent,
            camera: self.camera,
            size: [self.size.width, self.size.height],
            rays: self.view.rays(),
            hits: self.view.hits(),
            map: self.map,
            host: &self.input.host,
            selection: Selection::default(),
            watch,
        }
    }
}

/// The measurements on one backend.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) measurements: Vec<Measurement>,
    /// Pictures of some of `measurements`, by their indices in these.
    pub(crate) pictures: Vec<MethodPicture>,
    pub(crate) left_out: Vec<LeftOut>,
    /// The errors that shadow maps have by themselves.
    pub(crate) floors: Vec<MapFloor>,
}

impl Outcome {
    /// Appends the measurements on another backend.
    pub(crate) fn add(&mut self, other: Self) {
        let offset = self.measurements.len();
        for mut picture in other.pictures {
            picture.measurement += offset;
            self.pictures.push(picture);
        }
        self.measurements.extend(other.measurements);
        self.left_out.extend(other.left_out);
        self.floors.extend(other.floors);
    }
}

/// Rays on which the time of a candidate is estimated.
const PROBE_RAYS: usize = 256;

/// The largest number of repetitions: by then the median has settled.
const MAX_REPETITIONS: usize = 9;

/// Seconds that a software GPU may take to compile the shaders of a method; nothing can
/// stop it.
const PIPELINES: f64 = 4.0;

/// How many times as long as on the CPU a frame of a software GPU is expected to take. Tuned
/// on a city of 165 spotlights with a budget of 150 s: with 1 it took 174 s, and with 4 136 s.
const SLOWER: f64 = 4.0;

/// Share of the remaining time that may be spent on the preparations of a candidate.
const PREPARATION: f64 = 0.3;

/// Measures the candidates that the device runs, as long as `budget` allows.
///
/// `on_cpu` holds the measurements on the CPU, if there are any. A software GPU is not faster
/// than the processor that runs it, and nothing that it has begun can be stopped. So it begins no
/// candidate for which the CPU had no time or needed too much of it.
pub(crate) fn measure(
    device: &Device,
    job: Job<'_>,
    candidates: &[Candidate],
    truth: &Truth<'_>,
    budget: Budget,
    on_cpu: Option<&[Measurement]>,
) -> Result<Outcome, Failure> {
    let known_from = on_cpu.filter(|_| !device.representative && budget.total().is_finite());
    match &device.context {
        // The store of the host is also the store of this backend.
        None => {
            let cpu = Cpu::new();
            let on = On::new(
                &cpu,
                &job.input.host,
                device,
                job,
                truth,
                budget,
                known_from,
            );
            let floors = |maps: &[u32]| Ok(floors(&job, truth.reference, maps, budget)?);
            on.measure(candidates, floors)
        }
        Some(context) => {
            let waited_for = Gpu::new(context.clone());
            let backend = Gpu::new(context.clone());
            let store = Store::waiting(move || waited_for.wait());
            let on = On::new(&backend, &store, device, job, truth, budget, known_from);
            // The errors of shadow maps that the CPU finds hold for the GPU, too.
            on.measure(candidates, |_| Ok(Vec::new()))
        }
    }
}

/// The reference that errors are measured against.
pub(crate) struct Truth<'a> {
    pub(crate) reference: &'a Reference,
    pub(crate) flip: Flip,
}

impl<'a> Truth<'a> {
    /// The truth of a picture of that size.
    pub(crate) fn new(size: Size, reference: &'a Reference) -> Self {
        Self {
            reference,
            flip: Flip::new(size, reference),
        }
    }
}

/// A backend on which candidates are measured.
struct On<'a, B: MethodBackend + Download> {
    backend: &'a B,
    store: &'a Store<B::Memory>,
    device: &'a Device,
    job: Job<'a>,
    truth: &'a Truth<'a>,
    budget: Budget,
    /// The measurements on the CPU, where they decide what is not begun.
    on_cpu: Option<&'a [Measurement]>,
}

/// How long a method took for some counted work.
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
        truth: &'a Truth<'a>,
        budget: Budget,
        on_cpu: Option<&'a [Measurement]>,
    ) -> Self {
        Self {
            backend,
            store,
            device,
            job,
            truth,
            budget,
            on_cpu,
        }
    }

    /// Runs every candidate once, as long as there is time; then measures how much of its error a
    /// viewer sees, and how much comes from the map; then repeats the frames.
    fn measure(
        &self,
        candidates: &[Candidate],
        floors: impl FnOnce(&[u32]) -> Result<Vec<MapFloor>, Failure>,
    ) -> Result<Outcome, Failure> {
        let own: Vec<&Candidate> = candidates
            .iter()
            .filter(|candidate| self.device.why_not(candidate).is_none())
            .collect();
        let mut outcome = Outcome::default();
        let mut runs = self.first_runs(&own, &mut outcome.left_out)?;
        self.measure_flip(&mut runs, &mut outcome.left_out);
        outcome.floors = floors(&maps(&runs))?;
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

    /// One frame of each candidate that there is time for.
    fn first_runs(
        &self,
        own: &[&Candidate],
        left_out: &mut Vec<LeftOut>,
    ) -> Result<Vec<Run>, Failure> {
        let places: Vec<Place> = own.iter().map(|candidate| candidate.place()).collect();
        let bar = progress::bar("measuring", own.len() as u64);
        let mut runs: Vec<Run> = Vec::new();
        let known: RefCell<HashMap<usize, Known>> = RefCell::default();
        let failed: RefCell<BTreeMap<usize, String>> = RefCell::default();
        let fails = |index: usize, error: MethodError| -> Result<(), Failure> {
            let why = self.reason(error)?;
            failed.borrow_mut().insert(index, why);
            Ok(())
        };
        let dropped = run_while_there_is_time::<Failure>(
            &order(&places),
            || self.budget.left(),
            |index| match self.expected(own[index], &mut known.borrow_mut()) {
                Ok(seconds) => Ok(seconds),
                Err(error) => fails(index, error).map(|()| 0.0),
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
                        let now = Known { seconds, work };
                        known.borrow_mut().insert(candidate.method, now);
                        runs.push(run);
                        Ok(())
                    }
                    Err(error) => fails(index, error),
                }
            },
        )?;
        bar.finish_and_clear();
        let on = |index: usize| format!("{} on {}", own[index].name(), self.device.label);
        for (index, expected) in dropped {
            let frame = match expected {
                0.0 | f64::INFINITY => String::new(),
                _ => format!(" (it takes about {})", seconds(expected)),
            };
            left_out.push(LeftOut {
                what: on(index) + &frame,
                why: NO_TIME.into(),
            });
        }
        for (index, why) in failed.into_inner() {
            let what = on(index);
            left_out.push(LeftOut { what, why });
        }
        Ok(runs)
    }

    /// Computes HDR-FLIP of the pictures, as long as there is time.
    fn measure_flip(&self, runs: &mut [Run], left_out: &mut Vec<LeftOut>) {
        let bar = progress::bar("comparing pictures", runs.len() as u64);
        let mut last = 0.0;
        let mut missing = 0;
        for run in runs.iter_mut() {
            if self.budget.left() <= last {
                missing += 1;
                continue;
            }
            let clock = Instant::now();
            let error = self.truth.flip.error(run.picture.pixels.iter().copied());
            run.measurement.error.flip = Some(error);
            last = clock.elapsed().as_secs_f64();
            bar.inc(1);
        }
        bar.finish_and_clear();
        if missing > 0 {
            left_out.push(LeftOut {
                what: format!(
                    "HDR-FLIP of {} on {}",
                    count(missing, "row"),
                    self.device.label
                ),
                why: NO_TIME.into(),
            });
        }
    }

    /// The reason why a candidate is left out; a lost device ends the comparison.
    fn reason(&self, error: MethodError) -> Result<String, Failure> {
        self.backend.check_alive()?;
        match error {
            MethodError::Stopped { .. } => Ok(format!(
                "{NO_TIME}: it went into the shadows of {} (--lights, --map)",
                count(self.job.emitters.len(), "emitter")
            )),
            error => Ok(Failure::from(error).to_string()),
        }
    }

    /// The inputs of a frame of a candidate.
    fn inputs(&self, candidate: &Candidate, watch: &'a dyn Watch) -> FrameInputs<'a> {
        FrameInputs {
            map: candidate.map,
            ..self.job.inputs(watch)
        }
    }

    /// Counted work of a frame.
    fn work_of(&self, candidate: &Candidate, rays: usize) -> f64 {
        let work = self.work(candidate);
        (work.per_frame + work.per_ray * rays as f64).max(1.0)
    }

    fn work(&self, candidate: &Candidate) -> Work {
        let inputs = self.inputs(candidate, &());
        candidate.entry.method().work(&inputs, candidate.quality)
    }

    /// Seconds that a software GPU takes to measure the candidate, going by the CPU: the time of
    /// the build, of the pipelines unless they exist, of two frames of a few rays and of one of
    /// all.
    fn least(&self, candidate: &Candidate, has_pipelines: bool) -> f64 {
        let Some(on_cpu) = self.on_cpu else {
            return 0.0;
        };
        let is_it =
            |m: &&Measurement| (m.method, m.quality) == (candidate.method, candidate.quality);
        let found = on_cpu.iter().find(is_it);
        let pipelines = if has_pipelines { 0.0 } else { PIPELINES };
        found.map_or(f64::INFINITY, |m| {
            pipelines + m.seconds_build + 3.0 * SLOWER * m.frame.low
        })
    }

    /// Seconds that a frame of the candidate is expected to take: from the last
    /// frame of its method, or from a few rays if there is none.
    fn expected(
        &self,
        candidate: &Candidate,
        known: &mut HashMap<usize, Known>,
    ) -> Result<f64, MethodError> {
        let least = self.least(candidate, known.contains_key(&candidate.method));
        if least > self.budget.left() {
            return Ok(least);
        }
        let work = self.work_of(candidate, self.job.view.rays().len());
        if let Some(known) = known.get(&candidate.method) {
            return Ok(known.seconds * (work / known.work).max(1.0));
        }
        let rays = self.job.view.rays();
        // An odd step does not run along the columns of usual widths.
        let step = (rays.len() / PROBE_RAYS).max(1) | 1;
        let few: Vec<_> = rays.iter().step_by(step).copied().collect();
        let hits: Vec<_> = self.job.view.hits().iter().step_by(step).copied().collect();
        let pixels: Vec<u32> = (0..rays.len() as u32).step_by(step).collect();
        let watch = Patience::new(PREPARATION * self.budget.left());
        let inputs = FrameInputs {
            rays: &few,
            hits: &hits,
            selection: Selection {
                pixels: Some(&pixels),
                ..Selection::default()
            },
            map: candidate.map,
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
        let inputs = FrameInputs {
            map: candidate.map,
            ..self.job.inputs(&watch)
        };
        let frame = Frame::new(self.backend, inputs, self.store)?;
        self.prepare(candidate, &frame)?;
        let (time, radiance) = self.timed(candidate, &frame)?;
        let mut used = self.store.used();
        if self.device.context.is_some() {
            used.extend(self.job.input.host.used());
        }
        let radiance = self.backend.download(&radiance)?;
        let error = image_error(&radiance, self.truth.reference);
        Ok(Run {
            candidate: candidate.clone(),
            times: vec![time],
            measurement: Measurement {
                method: candidate.method,
                backend: self.device.label.clone(),
                representative: self.device.representative,
                quality: candidate.quality,
                map: candidate.map_in_use(),
                error: Errors {
                    rmse: error.rmse,
                    max: error.max,
                    rel_p99: error.rel_p99,
                    rel_mse: error.rel_mse,
                    flip: None,
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
        let mut frame = Frame::new(self.backend, self.job.inputs(&()), self.store)?;
        for _ in 1..MAX_REPETITIONS {
            for run in runs.iter_mut() {
                if run.times[0] < self.budget.left() {
                    frame.inputs.map = run.candidate.map;
                    run.times.push(self.timed(&run.candidate, &frame)?.0);
                }
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// The shadow maps that runs look into, that of most of them first.
fn maps(runs: &[Run]) -> Vec<u32> {
    let mut used: BTreeMap<u32, usize> = BTreeMap::new();
    for map in runs.iter().filter_map(|run| run.measurement.map) {
        *used.entry(map).or_default() += 1;
    }
    let mut maps: Vec<(usize, u32)> = used.into_iter().map(|(map, n)| (n, map)).collect();
    maps.sort_by_key(|&(number, map)| (std::cmp::Reverse(number), map));
    maps.into_iter().map(|(_, map)| map).collect()
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
        if runs[index].candidate.refines_map {
            continue;
        }
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

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use lighting::methods::Registry;

    use super::super::prepare::Prepared;
    use super::super::{shown, truth};
    use super::*;
    use crate::args::{Arguments, Command};

    #[test]
    fn refined_maps_let_errors_fall_where_the_map_would_stop_them() {
        let methods = Registry::standard();
        const MARCH: &str = "march x midpoint";
        const BY_ANGLE: &str = "equi-angular-merged x gauss-8";
        let line = "crepuscular compare fence --size 32x18 --map 64 --backend cpu --methods";
        let names = format!("{MARCH},{BY_ANGLE},march quarter,march 2x2");
        let arguments = line.split(' ').chain([&*names]).map(OsString::from);
        let Ok(Command::Compare(args)) = Arguments::read(&methods, arguments).map(|a| a.command)
        else {
            panic!("a comparison is asked for");
        };
        let prepared = Prepared::new(&methods, args.asked(), f64::INFINITY).unwrap();
        let job = prepared.job(false).unwrap();
        let (reference, _) = truth::converge(&job, prepared.view.rays(), 1e-6, false);
        let truth = Truth::new(prepared.size, &reference);
        let measured = |budget: Budget| {
            let candidates = &prepared.selection.candidates;
            measure(
                &prepared.backends.present[0],
                job,
                candidates,
                &truth,
                budget,
                None,
            )
            .unwrap()
        };
        let outcome = measured(Budget::unlimited());
        assert!(outcome.left_out.is_empty(), "{:?}", outcome.left_out);
        let lines = shown::all(&methods);
        let find = |name: &str, refines: bool, quality: u32| {
            let is_it = |m: &&Measurement| {
                let line = &lines[m.method];
                let is_named = line.entry.about().name == name;
                is_named && line.refines_map == refines && m.quality == quality
            };
            outcome.measurements.iter().find(is_it).unwrap()
        };
        let row = |refines: bool, quality: u32| find(MARCH, refines, quality);
        // The same at the usual quality, and as coarse or as fine as that beside it.
        assert_eq!(row(true, 64).map, Some(64));
        assert_eq!(row(true, 64).error, row(false, 64).error);
        assert_eq!([16, 256].map(|q| row(true, q).map), [Some(16), Some(256)]);
        assert!(row(true, 256).error.rmse < row(false, 256).error.rmse);
        assert!(row(true, 256).error.rmse < 0.5 * row(true, 64).error.rmse);
        for m in &outcome.measurements {
            assert_eq!(m.frame.repetitions, MAX_REPETITIONS);
            assert!(m.error.flip.is_some_and(|flip| flip > 0.0 && flip < 1.0));
            assert!(m.error.rel_mse > 0.0);
        }
        // Finer maps are better by themselves, and methods level out at what theirs is.
        let floor = |map: u32| outcome.floors.iter().find(|f| f.map == map).unwrap().rmse;
        assert!(floor(256) < floor(64) && floor(64) < floor(16));
        let ratio = find(BY_ANGLE, false, 256).error.rmse / floor(64);
        assert!((0.95..1.1).contains(&ratio), "{ratio}");
        // No refined picture beside that of the map of all.
        assert!(outcome.pictures.len() < lines.len());
        for shown in &outcome.pictures {
            assert!(!lines[outcome.measurements[shown.measurement].method].refines_map);
        }
        // Without any time nothing is measured, and all of it is left out.
        let nothing = measured(Budget::new(0.0));
        assert!(nothing.measurements.is_empty());
        assert_eq!(nothing.left_out.len(), prepared.selection.candidates.len());
    }
}
