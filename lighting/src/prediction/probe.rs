//! The probe, which runs methods on a part of a picture.

use gpu_backend::{Backend, BufferOf, Download};

use super::error::{Estimate, estimate};
use super::interpolate::along_logarithms;
use super::profile::{self, counted};
use super::{Forecast, Judged, Known, Prediction, Profile, Sample, Skipped, settle};
use crate::Ray;
use crate::methods::{
    Entry, Frame, FrameInputs, Method, MethodBackend, MethodError, RunOn, Selection, Store,
    Verdict, Work,
};
use crate::scene::trace::Hit;

/// How many times a setting is timed with each of the two samples.
const REPETITIONS: usize = 5;

/// The largest share of the budget that a single setting may take.
const LARGEST: f64 = 0.25;

/// Smaller errors count as this.
const LEAST_ERROR: f64 = 1e-7;

/// A method at a quality.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The method.
    pub entry: Entry,
    /// Its quality.
    pub quality: u32,
    /// Texels per side of the shadow maps that it may look into.
    pub map: u32,
}

/// A probe of the times and errors of settings. Settings of one method must follow each other,
/// in order of rising quality.
#[derive(Clone, Copy)]
pub struct Probe<'a> {
    /// The whole picture.
    pub inputs: FrameInputs<'a>,
    /// The pixels that represent it.
    pub sample: &'a Sample,
    /// The reference for some of these pixels.
    pub judged: &'a Judged,
    /// The known costs of the machine.
    pub profile: &'a Profile,
    /// Seconds that the probe may take, estimated from counted work and the profile; infinity
    /// probes everything.
    pub seconds: f64,
    /// Seconds until the device of the backend was ready; `None` if the start of the backend is
    /// not to be counted, or if it has none, as the CPU.
    pub start: Option<f64>,
    /// A clock: seconds since any fixed moment.
    pub clock: &'a dyn Fn() -> f64,
}

impl std::fmt::Debug for Probe<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Probe")
            .field("sample", &self.sample.pixels().len())
            .field("judged", &self.judged.number())
            .field("seconds", &self.seconds)
            .finish_non_exhaustive()
    }
}

/// A setting that has run.
struct Run {
    setting: usize,
    once: f64,
    bytes: u64,
    error: Estimate,
    /// The time of the first frame with more rays.
    first: f64,
    /// If it was timed, the shortest times with fewer and with more rays.
    times: Option<[f64; 2]>,
}

/// Some rays, with the inputs that belong to them.
struct Part {
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    pixels: Vec<u32>,
}

impl Part {
    fn of(inputs: &FrameInputs<'_>, pixels: Vec<u32>) -> Self {
        Self {
            rays: pixels
                .iter()
                .map(|pixel| inputs.rays[*pixel as usize])
                .collect(),
            hits: pixels
                .iter()
                .map(|pixel| inputs.hits[*pixel as usize])
                .collect(),
            pixels,
        }
    }

    fn inputs<'a>(&'a self, inputs: &FrameInputs<'a>) -> FrameInputs<'a> {
        FrameInputs {
            rays: &self.rays,
            hits: &self.hits,
            selection: Selection {
                pixels: Some(&self.pixels),
                ..inputs.selection
            },
            ..*inputs
        }
    }
}

/// The frames in which settings run.
struct Frames<'a, B: MethodBackend> {
    whole: Frame<'a, B>,
    /// Frames of fewer and of more pixels; none if the sample is the whole picture.
    parts: Option<[Frame<'a, B>; 2]>,
}

impl Probe<'_> {
    /// The forecast for each setting on a backend, which `label` names.
    ///
    /// # Errors
    /// [`MethodError::Backend`] if the device is lost or cannot hold the rays. Other failures
    /// of a method are a reason to skip it.
    ///
    /// # Panics
    /// If the sample was made for a picture of another size.
    pub fn run<B: MethodBackend + Download>(
        &self,
        backend: &B,
        label: &str,
        store: &Store<B::Memory>,
        settings: &[Setting],
    ) -> Result<Forecast, MethodError> {
        assert_eq!(
            self.sample.of(),
            self.inputs.rays.len(),
            "rays of the sample's picture"
        );
        let works: Vec<Work> = settings.iter().map(|setting| self.work(setting)).collect();
        let costs: Vec<Cost> = settings
            .iter()
            .zip(&works)
            .map(|(setting, work)| self.cost(label, setting, work))
            .collect();
        let groups = groups(settings);
        let mut skipped = Vec::new();
        let [fewer, more] = [self.sample.smaller(), self.sample.pixels().to_vec()]
            .map(|pixels| Part::of(&self.inputs, pixels));
        let mut frames = Frames {
            whole: Frame::new(backend, self.inputs, store)?,
            parts: match self.sample.is_whole() {
                true => None,
                false => Some([
                    Frame::new(backend, fewer.inputs(&self.inputs), store)?,
                    Frame::new(backend, more.inputs(&self.inputs), store)?,
                ]),
            },
        };
        let mut runs: Vec<Run> = Vec::new();
        for (setting, is_timed) in chosen(&groups, &costs, self.seconds) {
            match self.first(&mut frames, (setting, is_timed), &settings[setting]) {
                Ok(run) => runs.push(run),
                Err(error) => skipped.push(skip(backend, setting, settings, &error)?),
            }
        }
        for _ in 0..REPETITIONS {
            for run in &mut runs {
                let Some(shortest) = &mut run.times else {
                    continue;
                };
                match self.times(&mut frames, &settings[run.setting]) {
                    Ok(times) => {
                        for (shortest, time) in shortest.iter_mut().zip(times) {
                            *shortest = shortest.min(time);
                        }
                    }
                    Err(error) => {
                        run.times = None;
                        skipped.push(skip(backend, run.setting, settings, &error)?);
                    }
                }
            }
        }
        // A run that failed later tells nothing about other qualities either.
        runs.retain(|run| !skipped.iter().any(|other| other.setting == run.setting));
        let mut forecast = Forecast {
            rows: Vec::new(),
            skipped,
        };
        for group in &groups {
            let own: Vec<&Run> = group
                .iter()
                .filter_map(|setting| runs.iter().find(|run| run.setting == *setting))
                .collect();
            for &setting in group {
                if forecast
                    .skipped
                    .iter()
                    .any(|other| other.setting == setting)
                {
                    continue;
                }
                match self.expected(setting, settings, &works, &own) {
                    Some(row) => forecast.rows.push(Prediction {
                        backend: label.into(),
                        ..row
                    }),
                    None => forecast.skipped.push(Skipped {
                        setting,
                        what: name(&settings[setting]),
                        why: "it is too expensive for a probe, and not between qualities that are not".into(),
                    }),
                }
            }
        }
        Ok(forecast)
    }

    /// The shortest time of a few frames of the whole picture, s, not counting what is made before
    /// the first one.
    ///
    /// # Errors
    /// Those of the method.
    pub fn frame_seconds<B: MethodBackend + Download>(
        &self,
        backend: &B,
        store: &Store<B::Memory>,
        setting: &Setting,
    ) -> Result<f64, MethodError> {
        let frame = Frame::new(backend, self.inputs_of(setting), store)?;
        on::<B>(setting)?.prepare(&frame, setting.quality)?;
        backend.wait()?;
        let mut shortest = f64::INFINITY;
        for _ in 0..settle::FRAMES {
            shortest = shortest.min(self.radiance(&frame, setting)?.0);
        }
        Ok(shortest)
    }

    fn inputs_of(&self, setting: &Setting) -> FrameInputs<'_> {
        FrameInputs {
            map: setting.map,
            ..self.inputs
        }
    }

    /// Seconds until a backend has started and compiled what a method needs, of whose settings
    /// the first one that ran waited for that.
    fn start(&self, own: &[&Run]) -> f64 {
        let Some(device) = self.start else {
            return 0.0;
        };
        let longer = own.iter().filter_map(|run| Some(run.first - run.times?[1]));
        device + longer.fold(0.0, f64::max)
    }

    fn work(&self, setting: &Setting) -> Work {
        setting
            .entry
            .method()
            .work(&self.inputs_of(setting), setting.quality)
    }

    /// The numbers of rays in the two runs of a setting.
    fn rays(&self, setting: &Setting) -> [usize; 2] {
        let more = self.sample.pixels().len();
        match takes_parts(setting) {
            true if !self.sample.is_whole() => [self.sample.smaller().len(), more],
            _ => [self.sample.of(); 2],
        }
    }

    fn cost(&self, label: &str, setting: &Setting, work: &Work) -> Cost {
        let known = self.profile.costs(label, &setting.entry.about().name);
        let [fewer, more] = self.rays(setting).map(|rays| counted(work, rays));
        let repeated = match fewer == more {
            true => more,
            false => fewer + more,
        };
        Cost {
            once: known.once * work.once,
            error: known.frame * more,
            time: known.frame * REPETITIONS as f64 * repeated,
        }
    }

    /// Runs a setting for the first time, which tells what it needs and its error.
    fn first<B: MethodBackend + Download>(
        &self,
        frames: &mut Frames<'_, B>,
        (index, is_timed): (usize, bool),
        setting: &Setting,
    ) -> Result<Run, MethodError> {
        let frame = frames.larger(setting);
        frame.store.watch_use();
        self.inputs.host.watch_use();
        on::<B>(setting)?.prepare(frame, setting.quality)?;
        frame.backend.wait()?;
        let (first, radiance) = self.radiance(frame, setting)?;
        let mut used = frame.store.used();
        if !is_same(frame.store, self.inputs.host) {
            used.extend(self.inputs.host.used());
        }
        let light = frame.backend.download(&radiance)?;
        let light = match takes_parts(setting) {
            true => light,
            false => {
                let pixels = self.sample.pixels().iter();
                pixels.map(|pixel| light[*pixel as usize]).collect()
            }
        };
        Ok(Run {
            setting: index,
            once: used.iter().map(|used| used.seconds).sum(),
            bytes: used.iter().map(|used| used.bytes).sum(),
            error: estimate(&light, self.judged),
            first,
            times: is_timed.then_some([f64::INFINITY; 2]),
        })
    }

    fn radiance<B: MethodBackend + Download>(
        &self,
        frame: &Frame<'_, B>,
        setting: &Setting,
    ) -> Result<(f64, BufferOf<B, [f32; 4]>), MethodError> {
        let mut radiance = frame.backend.zeros::<[f32; 4]>(frame.inputs.rays.len())?;
        frame.backend.wait()?;
        let start = (self.clock)();
        on::<B>(setting)?.add_radiance(frame, setting.quality, &mut radiance)?;
        frame.backend.wait()?;
        Ok(((self.clock)() - start, radiance))
    }

    fn times<B: MethodBackend + Download>(
        &self,
        frames: &mut Frames<'_, B>,
        setting: &Setting,
    ) -> Result<[f64; 2], MethodError> {
        // Its rays are among those of the larger one, after which it would find all that it
        // reads in the caches.
        let fewer = match frames.smaller(setting) {
            Some(frame) => Some(self.radiance(frame, setting)?.0),
            None => None,
        };
        let more = self.radiance(frames.larger(setting), setting)?.0;
        Ok([fewer.unwrap_or(more), more])
    }

    /// The time of a frame of the whole picture.
    fn frame_time(&self, setting: &Setting, [fewer, more]: [f64; 2]) -> f64 {
        let [n1, n2] = self.rays(setting);
        let beyond = (self.sample.of() - n2) as f64;
        let per_ray = match n1 == n2 {
            true => 0.0,
            false => ((more - fewer) / (n2 - n1) as f64).max(0.0),
        };
        more + per_ray * beyond
    }

    /// The forecast of a setting from the runs of its method, without the backend; `None` if
    /// too little is known.
    fn expected(
        &self,
        index: usize,
        settings: &[Setting],
        works: &[Work],
        own: &[&Run],
    ) -> Option<Prediction> {
        let setting = &settings[index];
        let about = setting.entry.about();
        let rays = self.sample.of();
        let counted = |index: usize| profile::counted(&works[index], rays);
        let quality = |index: usize| f64::from(settings[index].quality.max(1));
        let timed = own.iter().filter_map(|run| {
            let time = self.frame_time(&settings[run.setting], run.times?);
            Some((run.setting, time.max(f64::MIN_POSITIVE)))
        });
        let timed: Vec<(usize, f64)> = timed.collect();
        let it = own.iter().find(|run| run.setting == index);
        let frame = match timed.iter().find(|(setting, _)| *setting == index) {
            Some((_, time)) => *time,
            None => over(&timed, counted, index).or_else(|| over(&timed, quality, index))?,
        };
        let error = match it {
            Some(run) => run.error,
            None => error_between(own, quality, index)?,
        };
        let made: Vec<(usize, f64)> = (own.iter())
            .map(|run| (run.setting, run.once.max(f64::MIN_POSITIVE)))
            .collect();
        let stored: Vec<(usize, f64)> = (own.iter())
            .map(|run| (run.setting, run.bytes.max(1) as f64))
            .collect();
        let work = |index: usize| works[index].once.max(1.0);
        let nearest = own.iter().min_by_key(|run| run.setting.abs_diff(index))?;
        Some(Prediction {
            setting: index,
            method: about.name.into_owned(),
            backend: String::new(),
            quality: setting.quality,
            unit: about.quality,
            start: self.start(own),
            once: it.map_or_else(
                || over(&made, work, index).unwrap_or(nearest.once),
                |run| run.once,
            ),
            frame,
            bytes: it.map_or_else(
                || over(&stored, work, index).map_or(nearest.bytes, |bytes| bytes as u64),
                |run| run.bytes,
            ),
            rmse: error.rmse,
            rmse_spread: error.spread,
            known: match (it, it.and_then(|run| run.times)) {
                (Some(_), Some(_)) => Known::Probed,
                (Some(_), None) => Known::Tried,
                (None, _) => Known::Interpolated,
            },
            counted: [works[index].once, counted(index)],
        })
    }
}

/// The value of a setting on lines through the logarithms of other settings' values over `x`,
/// which rises with quality; `None` if `x` is the same for all of them. If only one is known,
/// the value is proportional to `x`.
fn over(known: &[(usize, f64)], x: impl Fn(usize) -> f64, index: usize) -> Option<f64> {
    let points: Vec<(f64, f64)> = known.iter().map(|(i, y)| (x(*i), *y)).collect();
    if let [(only, y)] = points[..] {
        return Some(y * x(index) / only);
    }
    let is_rising = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
    is_rising.then(|| along_logarithms(&points, x(index)))?
}

/// The error of a setting between two whose errors are known. It is not extrapolated, because
/// errors level out where something else limits them.
fn error_between(own: &[&Run], quality: impl Fn(usize) -> f64, index: usize) -> Option<Estimate> {
    let after = own.iter().position(|run| run.setting > index)?;
    let pair = [own[after.checked_sub(1)?], own[after]];
    let points = pair.map(|run| (quality(run.setting), run.error.rmse.max(LEAST_ERROR)));
    Some(Estimate {
        rmse: along_logarithms(&points, quality(index))?,
        spread: pair[0].error.spread.max(pair[1].error.spread),
    })
}

impl<'a, B: MethodBackend> Frames<'a, B> {
    /// The frame of the larger sample; for a method that cannot take some of the pixels, the
    /// whole frame.
    fn larger(&mut self, setting: &Setting) -> &Frame<'a, B> {
        let frame = match &mut self.parts {
            Some([_, larger]) if takes_parts(setting) => larger,
            _ => &mut self.whole,
        };
        frame.inputs.map = setting.map;
        frame
    }

    fn smaller(&mut self, setting: &Setting) -> Option<&Frame<'a, B>> {
        let [smaller, _] = self.parts.as_mut().filter(|_| takes_parts(setting))?;
        smaller.inputs.map = setting.map;
        Some(smaller)
    }
}

/// Why a setting that failed is skipped; a lost device is an error for all settings.
fn skip<B: Backend>(
    backend: &B,
    setting: usize,
    settings: &[Setting],
    error: &MethodError,
) -> Result<Skipped, MethodError> {
    backend.check_alive()?;
    Ok(Skipped {
        setting,
        what: name(&settings[setting]),
        why: said(error),
    })
}

fn takes_parts(setting: &Setting) -> bool {
    setting.entry.takes_some_pixels() == Verdict::Applies
}

fn on<B: MethodBackend>(setting: &Setting) -> Result<&dyn RunOn<B>, MethodError> {
    setting
        .entry
        .on()
        .ok_or_else(|| MethodError::UnsupportedBackend {
            name: setting.entry.about().name.into_owned(),
        })
}

/// Whether the store of a backend is the store on the host.
fn is_same<A, B>(store: &A, host: &B) -> bool {
    std::ptr::addr_eq(store, host)
}

fn name(setting: &Setting) -> String {
    let about = setting.entry.about();
    format!("{} with {} {}", about.name, setting.quality, about.quality)
}

/// An error with its causes, as one line.
fn said(error: &MethodError) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        if !text.contains(&error.to_string()) {
            text = format!("{text}: {error}");
        }
        cause = error.source();
    }
    text
}

/// Seconds that probing a setting takes, estimated from counted work.
#[derive(Debug, Clone, Copy)]
struct Cost {
    /// For what has to be made.
    once: f64,
    /// For the run that gives the error.
    error: f64,
    /// For the runs that give the time.
    time: f64,
}

/// For each method, the indices of its settings.
fn groups(settings: &[Setting]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let name = |index: usize| settings[index].entry.about().name;
    for index in 0..settings.len() {
        match groups.last_mut() {
            Some(group) if name(group[0]) == name(index) => group.push(index),
            _ => groups.push(vec![index]),
        }
    }
    groups
}

/// The settings that run, and whether each is timed too: first the ends and the middle of each
/// group, timed; then others for their errors alone. A setting that would take too long, by
/// itself or after those before it, is left out.
fn chosen(groups: &[Vec<usize>], costs: &[Cost], seconds: f64) -> Vec<(usize, bool)> {
    let is_timed = |group: &[usize], place: usize| {
        let last = group.len() - 1;
        [0, last / 2, last].contains(&place)
    };
    let mut spent = 0.0;
    let mut chosen = Vec::new();
    // What is made for one quality is often part of what another quality needs.
    let mut made = vec![0.0_f64; groups.len()];
    for timed in [true, false] {
        for (number, group) in groups.iter().enumerate() {
            for (place, &setting) in group.iter().enumerate() {
                if is_timed(group, place) != timed {
                    continue;
                }
                let Cost { once, error, time } = costs[setting];
                let frames = if timed { error + time } else { error };
                let more = (once - made[number]).max(0.0) + frames;
                if once + frames <= LARGEST * seconds && spent + more <= seconds {
                    spent += more;
                    made[number] = made[number].max(once);
                    chosen.push((setting, timed));
                }
            }
        }
    }
    chosen.sort_unstable();
    chosen
}
