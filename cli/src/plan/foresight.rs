//! The probe of a picture that a comparison or a render is about to make.

use std::convert::Infallible;
use std::time::Instant;

use gpu_backend::gpu::Gpu;
use gpu_backend::{Cpu, Download, Host};
use lighting::methods::{
    FrameInputs, MethodBackend, MethodError, Registry, Store, share_cover, share_tracer,
};
use lighting::prediction::{Forecast, Judged, Prediction, Probe, Profile, Sample, Setting, Target};

use crate::compare::measure::Job;
use crate::compare::prepare::{Asked, Prepared};
use crate::compare::selection::Candidate;
use crate::compare::truth;
use crate::devices::Device;
use crate::failure::Failure;
use crate::progress;

/// Pixels that methods are run on.
const PIXELS: usize = 4096;

/// How many pixels are run beside them: those of the picture whose rays come nearest to lights.
const NEAREST: usize = 256;

/// Seconds of counted work of a probe, beside the truth.
pub(crate) const SECONDS: f64 = 5.0;

/// Units of work for the truth about some of the pixels; see [`Prepared::per_pixel`].
const TRUTH: f64 = 5e5;

/// The smallest number of pixels whose truth is known: fewer tell nothing.
const LEAST_JUDGED: f64 = 128.0;

/// The tolerance of the truth, far below the errors that are told apart.
const TOLERANCE: f64 = 1e-6;

/// A picture of which everything can be foreseen.
pub(crate) struct Foresight<'a> {
    job: Job<'a>,
    sample: Sample,
    judged: Judged,
    profile: &'a Profile,
    seconds: f64,
}

impl<'a> Foresight<'a> {
    /// Finds the truth about some pixels; nothing if there is no airlight.
    pub(crate) fn new(prepared: &'a Prepared, profile: &'a Profile, seconds: f64) -> Option<Self> {
        let job = prepared.job(false)?;
        let most = (TRUTH / prepared.per_pixel).max(LEAST_JUDGED) as usize;
        let sample = Sample::new([job.size.width, job.size.height], PIXELS);
        let nearest = NEAREST.min(most / 2);
        let sample = sample.with_nearest(job.view.rays(), job.emitters, nearest);
        let Ok(judged) = Judged::new::<Infallible>(&sample, most, |pixels| {
            let rays = job.view.rays();
            let rays: Vec<_> = pixels.iter().map(|pixel| rays[*pixel as usize]).collect();
            let (truth, _) = truth::converge(&job, &rays, TOLERANCE, false);
            Ok(truth.radiance)
        });
        Some(Self {
            judged,
            job,
            sample,
            profile,
            seconds,
        })
    }

    /// The forecast of candidates on a device.
    pub(crate) fn of(
        &self,
        device: &Device,
        candidates: &[&Candidate],
    ) -> Result<Forecast, Failure> {
        let settings: Vec<Setting> = candidates
            .iter()
            .map(|candidate| Setting {
                entry: candidate.entry.clone(),
                quality: candidate.quality,
                map: candidate.map,
            })
            .collect();
        // The probe has a store of its own, so that methods make everything anew when they are
        // measured.
        let host = Store::new();
        share_tracer(&host, &self.job.input.tracer);
        share_cover(&host, self.job.view.cover());
        let spinner = progress::spinner("probing methods");
        let label = &device.label;
        let forecast = match &device.context {
            None => self.on(&Cpu::new(), label, &host, &host, &settings),
            Some(context) => {
                let waited_for = Gpu::new(context.clone());
                let gpu = Gpu::new(context.clone());
                let store = Store::waiting(move || waited_for.wait());
                self.on(&gpu, label, &host, &store, &settings)
            }
        };
        spinner.finish_and_clear();
        Ok(forecast?)
    }

    fn on<B: MethodBackend + Download>(
        &self,
        backend: &B,
        label: &str,
        host: &Store<Host>,
        store: &Store<B::Memory>,
        settings: &[Setting],
    ) -> Result<Forecast, MethodError> {
        let start = Instant::now();
        let probe = Probe {
            inputs: FrameInputs {
                host,
                ..self.job.inputs(&())
            },
            sample: &self.sample,
            judged: &self.judged,
            profile: self.profile,
            seconds: self.seconds,
            clock: &|| start.elapsed().as_secs_f64(),
        };
        probe.run(backend, label, store, settings)
    }
}

/// Candidates that can be foreseen on a device.
pub(crate) fn foreseen<'a>(prepared: &'a Prepared, device: &Device) -> Vec<&'a Candidate> {
    let all = prepared.selection.candidates.iter();
    all.filter(|candidate| !candidate.refines_map && device.why_not(candidate).is_none())
        .collect()
}

/// The method and quality for one picture.
pub(crate) fn choose(
    methods: &Registry,
    asked: Asked<'_>,
    target: Target,
) -> Result<(Candidate, Prediction), Failure> {
    let prepared = Prepared::new(methods, asked, f64::INFINITY)?;
    let profile = super::profile::read(None)?;
    let nothing =
        || Failure::new("no light reaches the view through the air, so there is nothing to choose");
    let foresight = Foresight::new(&prepared, &profile, SECONDS).ok_or_else(nothing)?;
    let device = &prepared.backends.present[0];
    let candidates = foreseen(&prepared, device);
    let forecast = foresight.of(device, &candidates)?;
    let row = forecast
        .choose(target, 1.0)
        .map_err(|unmet| Failure::nothing(unmet.to_string()))?;
    Ok((candidates[row.setting].clone(), row.clone()))
}
