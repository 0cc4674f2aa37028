//! Time and error of every candidate on one backend.

use std::time::Instant;

use crepuscular_tests::metrics::image_error;
use crepuscular_tests::oracle::image::Reference;
use gpu_backend::gpu::Gpu;
use gpu_backend::{BufferOf, Cpu};
use lighting::scene::{Camera, Geometry, Medium};
use lighting::shadow_map::{Casters, ShadowMap};
use lighting::trace::Tracer;
use lighting::voxels::Eye;
use lighting::{Emitter, Ray};

use super::backends::Present;
use super::baked::Baked;
use super::budget::Budget;
use super::results::{Errors, LeftOut, Measurement, MethodPicture, Times};
use super::selection::Candidate;
use crate::engine::{Held, Renderer, Stage, Tables, Voxels, shadow_maps};
use crate::failure::Failure;
use crate::input::Input;
use crate::methods::{METHODS, Method, Visibility};
use crate::parse::Size;
use crate::picture::Picture;
use crate::{progress, veils};

/// What is measured, whatever the backend.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) input: &'a Input,
    pub(crate) geometry: &'a Geometry,
    pub(crate) tracer: &'a Tracer,
    pub(crate) seconds_tracer: f64,
    pub(crate) medium: &'a Medium,
    /// Those that the plan keeps.
    pub(crate) emitters: &'a [Emitter],
    /// Texels per side of a shadow map.
    pub(crate) map: u32,
    /// Parts that the reference cuts rays into behind translucent casters;
    /// `None` if there are none.
    pub(crate) parts: Option<u32>,
    /// Tables of airlight that the candidates need.
    pub(crate) tables: &'a Tables,
    /// By resolution; those for which there was time.
    pub(crate) baked: &'a [Baked],
    pub(crate) budget: Budget,
}

/// What came out on one backend.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) measurements: Vec<Measurement>,
    /// Their indices count from the first of `measurements`.
    pub(crate) pictures: Vec<MethodPicture>,
    pub(crate) left_out: Vec<LeftOut>,
}

/// An estimate of the seconds that a candidate takes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cost {
    /// Whatever the number of rays.
    pub(crate) start: f64,
    pub(crate) per_ray: f64,
}

impl Cost {
    fn of(&self, rays: usize) -> f64 {
        self.start + self.per_ray * rays as f64
    }
}

/// A backend with its shadow maps, whichever it is.
pub(crate) trait Measure {
    /// What it runs on.
    fn backend(&self) -> &Present;

    /// What each of its candidates takes, from a few rays of a picture.
    fn probe(&self, view: (&[Ray], Size)) -> Result<Vec<Cost>, Failure>;

    /// Runs the candidates in turns, all of them once and then again as long
    /// as `budget` allows. `costs` is what [`Measure::probe`] returned.
    fn measure(
        &self,
        view: (&[Ray], Size),
        costs: &[Cost],
        reference: &Reference,
        budget: Budget,
    ) -> Result<Outcome, Failure>;
}

/// Gets a backend ready for those of the candidates that it runs.
pub(crate) fn session<'a>(
    present: &'a Present,
    job: Job<'a>,
    candidates: &[Candidate],
) -> Result<Box<dyn Measure + 'a>, Failure> {
    let mut own = candidates.to_vec();
    own.retain(|candidate| present.runs(candidate.method));
    Ok(match present.context() {
        None => Box::new(Session::new(Cpu::new(), present, job, own)?),
        Some(context) => Box::new(Session::new(Gpu::new(context.clone()), present, job, own)?),
    })
}

/// A backend with what has to exist before a frame.
pub(crate) struct Session<'a, B: Renderer> {
    backend: B,
    present: &'a Present,
    job: Job<'a>,
    /// Those that the backend runs.
    candidates: Vec<Candidate>,
    /// None if they would take too long.
    maps: Option<Vec<ShadowMap<B::Memory>>>,
    seconds_maps: f64,
    /// Maps of transmittance, if a candidate needs them.
    veils: Vec<B::Veil>,
    /// Why the backend cannot hold them.
    no_veils: Option<Failure>,
    bytes_veils: u64,
    seconds_veils: f64,
    voxels: Voxels<B>,
    held: Vec<Held<B>>,
    /// Resolutions whose shadows the backend cannot hold, and why.
    not_held: Vec<(u32, Failure)>,
}

/// Emitters on which the time of all shadow maps is estimated.
const PROBE_MAPS: usize = 4;

/// Emitters on which the time of voxels is estimated.
const PROBE_VOXELS: usize = 2;

/// Share of the time left that all shadow maps may take.
const MAPS_SHARE: f64 = 0.5;

/// No more repetitions than this: the median has settled.
const MAX_REPETITIONS: usize = 9;

impl<'a, B: Renderer> Session<'a, B> {
    /// Renders the shadow maps if a candidate needs them and time allows; if
    /// that is quick, three times for the median of its time.
    pub(crate) fn new(
        backend: B,
        present: &'a Present,
        job: Job<'a>,
        candidates: Vec<Candidate>,
    ) -> Result<Self, Failure> {
        let mut maps = Some(Vec::new());
        let mut seconds = Vec::new();
        let needed = candidates
            .iter()
            .any(|c| c.method.visibility.needs_shadow_map());
        if needed {
            // Pipelines are built at their first use, which is not timed.
            let casters = Casters::upload(&backend, job.geometry)?;
            let first = &job.emitters[..job.emitters.len().min(1)];
            shadow_maps(&backend, &casters, first, 1, || ())?;
            backend.wait()?;
        }
        if needed && !affordable_maps(&backend, job)? {
            maps = None;
        } else if needed {
            let bar = progress::bar("shadow maps", job.emitters.len() as u64);
            while seconds.is_empty() || (seconds.len() < 3 && seconds[0] < 0.02 * job.budget.left())
            {
                let clock = Instant::now();
                let casters = Casters::upload(&backend, job.geometry)?;
                bar.set_position(0);
                let all = shadow_maps(&backend, &casters, job.emitters, job.map, || bar.inc(1))?;
                maps = Some(all);
                backend.wait()?;
                seconds.push(clock.elapsed().as_secs_f64());
            }
            bar.finish_and_clear();
        }
        let seconds_maps = if seconds.is_empty() {
            0.0
        } else {
            Times::of(&seconds).median
        };
        let (mut held, mut not_held) = (Vec::new(), Vec::new());
        for baked in job.baked {
            match Held::new(&backend, baked.resolution, &baked.shadows) {
                Ok(shadows) => held.push(shadows),
                Err(failure) => not_held.push((baked.resolution, failure)),
            }
        }
        let (mut veils, mut bytes_veils, mut no_veils) = (Vec::new(), 0, None);
        let clock = Instant::now();
        let needed = candidates
            .iter()
            .any(|c| c.method.visibility == Visibility::Translucent);
        if needed {
            let side = veils::resolution(job.map, job.emitters);
            for map in veils::veils(job.input, Some(job.geometry), job.emitters, side)? {
                bytes_veils += map.bytes();
                match backend.veil(map) {
                    Ok(veil) => veils.push(veil),
                    Err(failure) => no_veils = Some(failure),
                }
            }
            backend.wait()?;
        }
        let seconds_veils = clock.elapsed().as_secs_f64();
        Ok(Self {
            held,
            not_held,
            backend,
            present,
            job,
            candidates,
            maps,
            seconds_maps,
            veils,
            no_veils,
            bytes_veils,
            seconds_veils,
            voxels: Voxels::default(),
        })
    }

    /// Everything that frames of these rays of a picture need, on the backend.
    fn stage(&self, rays: &[Ray], size: Size) -> Result<Stage<'_, B>, Failure> {
        let uploaded = self.backend.upload(rays)?;
        self.backend.wait()?;
        Ok(Stage {
            backend: &self.backend,
            tracer: self.job.tracer,
            medium: self.job.medium,
            emitters: self.job.emitters,
            maps: self.maps.as_deref().unwrap_or_default(),
            veils: &self.veils,
            tables: self.job.tables,
            eye: Eye::of_camera(
                self.job.camera,
                [size.width, size.height],
                rays,
                self.job.medium,
            ),
            voxels: &self.voxels,
            baked: &self.held,
            rays: uploaded,
            count: rays.len(),
        })
    }

    /// Indices of the candidates, those whose picture is shown first: if the
    /// time is short, every method has one.
    fn most_telling_first(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.candidates.len()).collect();
        order.sort_by_key(|index| !self.is_pictured(&self.candidates[*index]));
        order
    }

    fn is_pictured(&self, candidate: &Candidate) -> bool {
        candidate.quality == pictured(candidate.method, &self.candidates)
    }

    /// Why it cannot run: there was no time or no room for what it needs.
    fn lacks(&self, candidate: &Candidate) -> Option<String> {
        let visibility = candidate.method.visibility;
        let lights = || crate::format::count(self.job.emitters.len(), "emitter");
        if self.maps.is_none() && visibility.needs_shadow_map() {
            return Some(format!(
                "no time for the shadow maps of {} (--time-budget, --lights, --map)",
                lights()
            ));
        }
        if let (Visibility::Translucent, Some(failure)) = (visibility, &self.no_veils) {
            return Some(failure.to_string());
        }
        let resolution = candidate.setting().samples;
        let held = self.held.iter().any(|held| held.resolution == resolution);
        if visibility != Visibility::Dag || held {
            return None;
        }
        let mut not_held = self.not_held.iter();
        Some(match not_held.find(|not_held| not_held.0 == resolution) {
            Some((_, failure)) => failure.to_string(),
            None => format!(
                "no time to bake the shadows of {} (--time-budget)",
                lights()
            ),
        })
    }

    /// A measurement of one frame that took `time`.
    fn measurement(
        &self,
        candidate: &Candidate,
        time: f64,
        radiance: &[[f32; 4]],
        reference: &Reference,
    ) -> Measurement {
        let error = image_error(radiance, reference);
        let (seconds_build, bytes) = match candidate.method.visibility {
            Visibility::None => (0.0, 0),
            Visibility::Exact => (self.job.seconds_tracer, self.job.tracer.bytes() as u64),
            Visibility::Dag => {
                let resolution = candidate.setting().samples;
                let mut baked = self.job.baked.iter();
                let baked = baked.find(|baked| baked.resolution == resolution);
                baked.map_or((0.0, 0), |baked| (baked.seconds, baked.bytes()))
            }
            Visibility::Translucent => (self.seconds_veils, self.bytes_veils),
            _ => (
                self.seconds_maps,
                self.maps.iter().flatten().map(ShadowMap::bytes).sum(),
            ),
        };
        let (seconds_table, bytes_table) = self.job.tables.cost(candidate.setting());
        Measurement {
            method: candidate.method.place(),
            backend: self.present.label.clone(),
            representative: self.present.representative,
            quality: candidate.quality,
            error: Errors {
                rmse: error.rmse,
                max: error.max,
                rel_p99: error.rel_p99,
            },
            seconds_build: seconds_build + seconds_table,
            frame: Times::of(&[time]),
            bytes: bytes + bytes_table + self.voxels.bytes(candidate.setting()),
        }
    }
}

impl<B: Renderer> Measure for Session<'_, B> {
    fn backend(&self) -> &Present {
        self.present
    }

    fn probe(&self, (rays, size): (&[Ray], Size)) -> Result<Vec<Cost>, Failure> {
        let mut one = self.stage(&rays[..rays.len().min(1)], size)?;
        let mut all = self.stage(rays, size)?;
        let mut costs = Vec::with_capacity(self.candidates.len());
        let mut warm: Option<&Method> = None;
        for candidate in &self.candidates {
            if self.lacks(candidate).is_some() {
                costs.push(Cost::default());
                continue;
            }
            // Voxels of all lights of a city would take most of the time.
            let every = self.job.emitters;
            let few = match candidate.method.visibility.voxel_detail() {
                Some(_) => &every[..every.len().min(PROBE_VOXELS)],
                None => every,
            };
            (one.emitters, all.emitters) = (few, few);
            let scale = every.len() as f64 / few.len().max(1) as f64;
            // The first run of a method builds its pipelines.
            if !warm.is_some_and(|method| std::ptr::eq(method, candidate.method)) {
                timed(&one, candidate)?;
                warm = Some(candidate.method);
            }
            let (start, _) = timed(&one, candidate)?;
            let (seconds, _) = timed(&all, candidate)?;
            let more = rays.len().saturating_sub(1).max(1);
            costs.push(Cost {
                start: scale * start,
                per_ray: scale * (seconds - start).max(0.0) / more as f64,
            });
        }
        Ok(costs)
    }

    fn measure(
        &self,
        (rays, size): (&[Ray], Size),
        costs: &[Cost],
        reference: &Reference,
        budget: Budget,
    ) -> Result<Outcome, Failure> {
        let stage = self.stage(rays, size)?;
        let mut outcome = Outcome::default();
        let mut runs: Vec<Option<Run>> = self.candidates.iter().map(|_| None).collect();
        let bar = progress::bar("measuring", self.candidates.len() as u64);
        for index in self.most_telling_first() {
            let candidate = &self.candidates[index];
            let expected = costs[index].of(rays.len());
            if let Some(why) = self.lacks(candidate) {
                outcome.left_out.push(LeftOut {
                    what: format!("{} on {}", candidate.name(), self.present.label),
                    why,
                });
            } else if expected > budget.left() {
                outcome.left_out.push(LeftOut {
                    what: format!("{} on {}", candidate.name(), self.present.label),
                    why: format!(
                        "no time left for a frame of about {} (--time-budget)",
                        crate::format::seconds(expected)
                    ),
                });
            } else {
                let (time, radiance) = timed(&stage, candidate)?;
                let radiance = self.backend.download(&radiance)?;
                runs[index] = Some(Run {
                    time,
                    measurement: self.measurement(candidate, time, &radiance, reference),
                    picture: self
                        .is_pictured(candidate)
                        .then(|| Picture::new(size, &radiance)),
                });
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        let mut seconds = Vec::new();
        for run in runs.into_iter().flatten() {
            if let Some(airlight) = run.picture {
                outcome.pictures.push(MethodPicture {
                    measurement: outcome.measurements.len(),
                    airlight,
                });
            }
            outcome.measurements.push(run.measurement);
            seconds.push(vec![run.time]);
        }
        repeat(&stage, budget, &mut outcome.measurements, &mut seconds)?;
        Ok(outcome)
    }
}

/// The first run of a candidate.
struct Run {
    time: f64,
    measurement: Measurement,
    picture: Option<Picture>,
}

/// True if the shadow maps of all emitters will be done in their share of the
/// time, going by the first few.
fn affordable_maps<B: Renderer>(backend: &B, job: Job<'_>) -> Result<bool, Failure> {
    if job.emitters.len() <= PROBE_MAPS {
        return Ok(true);
    }
    let casters = Casters::upload(backend, job.geometry)?;
    let clock = Instant::now();
    shadow_maps(
        backend,
        &casters,
        &job.emitters[..PROBE_MAPS],
        job.map,
        || (),
    )?;
    backend.wait()?;
    let each = clock.elapsed().as_secs_f64() / PROBE_MAPS as f64;
    Ok(each * job.emitters.len() as f64 <= MAPS_SHARE * job.budget.left())
}

/// Measures everything again and again until the time is up.
fn repeat<B: Renderer>(
    stage: &Stage<'_, B>,
    budget: Budget,
    measurements: &mut [Measurement],
    seconds: &mut [Vec<f64>],
) -> Result<(), Failure> {
    let bar = progress::bar("repeating", MAX_REPETITIONS as u64 - 1);
    for _ in 1..MAX_REPETITIONS {
        for (measurement, seconds) in measurements.iter().zip(seconds.iter_mut()) {
            if seconds[0] < budget.left() {
                let candidate = Candidate {
                    method: &METHODS[measurement.method],
                    quality: measurement.quality,
                };
                seconds.push(timed(stage, &candidate)?.0);
            }
        }
        bar.inc(1);
    }
    for (measurement, seconds) in measurements.iter_mut().zip(seconds) {
        measurement.frame = Times::of(seconds);
    }
    bar.finish_and_clear();
    Ok(())
}

/// The quality of `method` whose picture is shown, of those that are measured.
fn pictured(method: &Method, candidates: &[Candidate]) -> u32 {
    let own = candidates
        .iter()
        .filter(|c| std::ptr::eq(c.method, method))
        .map(|c| c.quality);
    own.min_by_key(|quality| quality.abs_diff(method.pictured))
        .unwrap_or(method.pictured)
}

type Radiance<B> = BufferOf<B, [f32; 4]>;

fn timed<B: Renderer>(
    stage: &Stage<'_, B>,
    candidate: &Candidate,
) -> Result<(f64, Radiance<B>), Failure> {
    let clock = Instant::now();
    let radiance = stage.airlight(candidate.setting())?;
    Ok((clock.elapsed().as_secs_f64(), radiance))
}
