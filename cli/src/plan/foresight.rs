//! The probe of a picture that a comparison or a render is about to make.

use std::convert::Infallible;
use std::time::Instant;

use gpu_backend::gpu::Gpu;
use gpu_backend::{Cpu, Download, Host};
use lighting::methods::{
    FrameInputs, MethodBackend, MethodError, Registry, Store, share_cover, share_tracer,
};
use lighting::prediction::{
    Forecast, Judged, Prediction, Probe, Profile, Sample, Setting, SlowStart, Target,
};

use crate::compare::measure::Job;
use crate::compare::prepare::{Asked, Prepared};
use crate::compare::results::LeftOut;
use crate::compare::selection::Candidate;
use crate::compare::truth;
use crate::devices::{self, Device};
use crate::failure::Failure;
use crate::format::seconds;
use crate::progress;

/// Pixels that methods are run on.
const PIXELS: usize = 4096;

/// How many pixels are run beside them: those of the picture whose rays come nearest to lights.
const NEAREST: usize = 256;

/// Seconds of counted work of a probe, beside the truth.
pub(crate) const SECONDS: f64 = 5.0;

/// Seconds for frames of settings of which it is in doubt whether they are within a time.
const TRIALS: f64 = 1.0;

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
    /// Whether the start of a backend counts.
    starts: bool,
    /// What a choice is made for, and for how many frames.
    target: Option<(Target, f64)>,
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
            starts: true,
            target: None,
        })
    }

    /// The same for a choice among so many frames: settings of which it is in doubt whether they
    /// meet the target are measured.
    pub(crate) fn for_target(self, target: Option<(Target, f64)>) -> Self {
        Self { target, ..self }
    }

    /// The same for a backend that is started in any case.
    fn without_start(self) -> Self {
        Self {
            starts: false,
            ..self
        }
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
        let named = (device.label.as_str(), device.start.filter(|_| self.starts));
        let forecast = match &device.context {
            None => self.on(&Cpu::new(), named, &host, &host, &settings),
            Some(context) => {
                let waited_for = Gpu::new(context.clone());
                let gpu = Gpu::new(context.clone());
                let store = Store::waiting(move || waited_for.wait());
                self.on(&gpu, named, &host, &store, &settings)
            }
        };
        spinner.finish_and_clear();
        Ok(forecast?)
    }

    fn on<B: MethodBackend + Download>(
        &self,
        backend: &B,
        (label, start): (&str, Option<f64>),
        host: &Store<Host>,
        store: &Store<B::Memory>,
        settings: &[Setting],
    ) -> Result<Forecast, MethodError> {
        let clock = Instant::now();
        let probe = Probe {
            inputs: FrameInputs {
                host,
                ..self.job.inputs(&())
            },
            sample: &self.sample,
            judged: &self.judged,
            profile: self.profile,
            seconds: self.seconds,
            start,
            clock: &|| clock.elapsed().as_secs_f64(),
        };
        let mut forecast = probe.run(backend, label, store, settings)?;
        if let Some((target, frames)) = self.target {
            forecast.settle(target, frames, TRIALS, |row| {
                match probe.frame_seconds(backend, store, &settings[row.setting]) {
                    Ok(seconds) => Ok(Some(seconds)),
                    Err(_) => backend.check_alive().map(|()| None),
                }
            })?;
        }
        Ok(forecast)
    }
}

/// Candidates that can be foreseen on a device.
pub(crate) fn foreseen<'a>(prepared: &'a Prepared, device: &Device) -> Vec<&'a Candidate> {
    let all = prepared.selection.candidates.iter();
    all.filter(|candidate| !candidate.refines_map && device.why_not(candidate).is_none())
        .collect()
}

/// The setting that is chosen for one picture.
pub(crate) struct Found {
    pub(crate) candidate: Candidate,
    pub(crate) row: Prediction,
    /// Where it runs.
    pub(crate) device: Device,
    /// Why there is no other backend, if one was looked for.
    pub(crate) note: Option<String>,
}

/// The method and quality for one picture, on the backend that was asked for or, if it
/// `may_start` one, on a GPU. A GPU whose start alone takes longer than the choice on the CPU
/// stays off.
pub(crate) fn choose(
    methods: &Registry,
    asked: Asked<'_>,
    target: Target,
    may_start: bool,
) -> Result<Found, Failure> {
    let mut prepared = Prepared::new(methods, asked, f64::INFINITY)?;
    let mut devices = std::mem::take(&mut prepared.backends.present);
    let profile = super::profile::read(None)?;
    let nothing =
        || Failure::new("no light reaches the view through the air, so there is nothing to choose");
    let foresight = Foresight::new(&prepared, &profile, SECONDS).ok_or_else(nothing)?;
    let foresight = foresight.for_target(Some((target, 1.0)));
    let foresight = match may_start {
        true => foresight,
        false => foresight.without_start(),
    };
    let mut all = Forecast::default();
    let add = |device: &Device, all: &mut Forecast| -> Result<(), Failure> {
        let forecast = foresight.of(device, &foreseen(&prepared, device))?;
        all.rows.extend(forecast.rows);
        Ok(())
    };
    for device in &devices {
        add(device, &mut all)?;
    }
    let mut note = None;
    if may_start {
        let first = all.choose(target, 1.0).ok();
        note = why_not_start(&profile, target, first);
        if note.is_none() {
            let (present, missing) = devices::find(&[])?;
            for gpu in present
                .into_iter()
                .filter(|device| device.context.is_some())
            {
                if gpu.representative || profile.starts().any(|(name, _)| name == gpu.label) {
                    add(&gpu, &mut all)?;
                    devices.push(gpu);
                } else {
                    note = Some(format!("left out: {} (no GPU)", gpu.label));
                }
            }
            note = note.or(missing.map(|why| format!("left out: the GPU ({why})")));
        }
    }
    let row = all
        .choose(target, 1.0)
        .map_err(|unmet| Failure::nothing(unmet.to_string()))?;
    if let Some(slow) = all.slow_starts(1.0).first() {
        let LeftOut { what, why } = left_out(slow);
        note = Some(format!("left out: {what} ({why})"));
    }
    let is_it = |device: &Device| device.label == row.backend;
    let place = devices.iter().position(is_it).unwrap_or(0);
    let device = devices.swap_remove(place);
    let candidate = foreseen(&prepared, &device)[row.setting].clone();
    Ok(Found {
        candidate,
        row: row.clone(),
        device,
        note,
    })
}

/// Why a GPU need not be started to look for something better than the choice on the CPU, by
/// what is known of its start.
fn why_not_start(profile: &Profile, target: Target, first: Option<&Prediction>) -> Option<String> {
    let (name, start) = profile.starts().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (limit, of) = match target {
        Target::Error(_) => (first?.seconds(1.0), "all of the picture takes on the CPU"),
        Target::Time(limit) => (limit, "it may take"),
    };
    (start >= limit).then(|| {
        format!(
            "left out: {name} (starting it takes {}, and {of} {})",
            seconds(start),
            seconds(limit)
        )
    })
}

/// A backend that is not worth its start, in the words of a plan.
pub(super) fn left_out(slow: &SlowStart) -> LeftOut {
    let frames = match slow.pays_from.is_finite() {
        true => format!("fewer than {} frames", slow.pays_from),
        false => "any number of frames".into(),
    };
    LeftOut {
        what: format!("{} for {frames}", slow.backend),
        why: format!(
            "it takes {} to start, which faster frames do not make up for; saves {}",
            seconds(slow.start),
            seconds(slow.saving)
        ),
    }
}
