//! Methods on a part of a picture.

use gpu_backend::{BufferOf, Download, Error};

use super::error::{Estimate, estimate};
use super::interpolate::along_logarithms;
use super::{Forecast, Judged, Known, Prediction, Profile, Sample, Skipped};
use crate::Ray;
use crate::methods::{
    Entry, Frame, FrameInputs, Method, MethodBackend, MethodError, RunOn, Selection, Store,
    Verdict, Work,
};
use crate::scene::trace::Hit;

/// How often a setting is timed with each of the two samples.
const REPETITIONS: usize = 3;

/// The largest share of the budget that one setting may take.
const LARGEST: f64 = 0.25;

/// The least error that is told from others.
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

/// A look at what settings cost and how far off they are.
///
/// Settings of one method stand together, by rising quality.
#[derive(Clone, Copy)]
pub struct Probe<'a> {
    /// The whole picture.
    pub inputs: FrameInputs<'a>,
    /// The pixels that stand for it.
    pub sample: &'a Sample,
    /// The truth about some of them.
    pub judged: &'a Judged,
    /// What the machine is known to cost.
    pub profile: &'a Profile,
    /// Seconds that the probe may take, by counted work and the profile; infinite to probe
    /// everything.
    pub seconds: f64,
    /// Seconds since any moment.
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

/// A setting that was run.
struct Run {
    setting: usize,
    once: f64,
    bytes: u64,
    error: Estimate,
    /// The shortest times with fewer and with more rays.
    times: [f64; 2],
}

/// Rays with what belongs to them.
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

/// The frames that settings are run in.
struct Frames<'a, B: MethodBackend> {
    whole: Frame<'a, B>,
    /// Of fewer and of more pixels; none if the sample is the whole picture.
    parts: Option<[Frame<'a, B>; 2]>,
}

impl Probe<'_> {
    /// What is expected of each setting on a backend, which `label` names.
    ///
    /// # Errors
    /// [`MethodError::Backend`] if the device is lost or cannot hold the rays. What a method
    /// fails for is a reason to skip it.
    ///
    /// # Panics
    /// If the sample is that of a picture of another size.
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
        for setting in chosen(&groups, &costs, self.seconds) {
            match self.first(&mut frames, setting, &settings[setting]) {
                Ok(run) => runs.push(run),
                Err(MethodError::Backend(error @ Error::DeviceLost { .. })) => {
                    return Err(error.into());
                }
                Err(error) => skipped.push(Skipped {
                    setting,
                    what: name(&settings[setting]),
                    why: said(&error),
                }),
            }
        }
        for _ in 0..REPETITIONS {
            for run in &mut runs {
                let times = self.times(&mut frames, &settings[run.setting])?;
                for (shortest, time) in run.times.iter_mut().zip(times) {
                    *shortest = shortest.min(time);
                }
            }
        }
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
                match self.expected(setting, &settings[setting], &works, &own, settings) {
                    Some(row) => forecast.rows.push(Prediction {
                        backend: label.into(),
                        ..row
                    }),
                    None => forecast.skipped.push(Skipped {
                        setting,
                        what: name(&settings[setting]),
                        why: "no quality of it is cheap enough for a probe".into(),
                    }),
                }
            }
        }
        Ok(forecast)
    }

    fn inputs_of(&self, setting: &Setting) -> FrameInputs<'_> {
        FrameInputs {
            map: setting.map,
            ..self.inputs
        }
    }

    fn work(&self, setting: &Setting) -> Work {
        setting
            .entry
            .method()
            .work(&self.inputs_of(setting), setting.quality)
    }

    /// Counted work of a frame of so many rays.
    fn counted(work: &Work, rays: usize) -> f64 {
        (work.per_frame + work.per_ray * rays as f64).max(1.0)
    }

    /// Rays of the runs of a setting: of the fewer and of the more.
    fn rays(&self, setting: &Setting) -> [usize; 2] {
        let more = self.sample.pixels().len();
        match takes_parts(setting) {
            true if !self.sample.is_whole() => [self.sample.smaller().len(), more],
            _ => [self.sample.of(); 2],
        }
    }

    fn cost(&self, label: &str, setting: &Setting, work: &Work) -> Cost {
        let known = self.profile.costs(label, &setting.entry.about().name);
        let [fewer, more] = self.rays(setting).map(|rays| Self::counted(work, rays));
        let repeated = match fewer == more {
            true => more,
            false => fewer + more,
        };
        Cost {
            once: known.once * work.once,
            frames: known.frame * (more + REPETITIONS as f64 * repeated),
        }
    }

    /// What a setting needs, and its error.
    fn first<B: MethodBackend + Download>(
        &self,
        frames: &mut Frames<'_, B>,
        index: usize,
        setting: &Setting,
    ) -> Result<Run, MethodError> {
        let frame = frames.larger(setting);
        frame.store.watch_use();
        self.inputs.host.watch_use();
        on::<B>(setting)?.prepare(frame, setting.quality)?;
        frame.backend.wait()?;
        let radiance = self.radiance(frame, setting)?.1;
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
            times: [f64::INFINITY; 2],
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
        let more = self.radiance(frames.larger(setting), setting)?.0;
        let fewer = match frames.smaller(setting) {
            Some(frame) => self.radiance(frame, setting)?.0,
            None => more,
        };
        Ok([fewer, more])
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

    /// What is expected of a setting by what its method did; the backend is missing.
    fn expected(
        &self,
        index: usize,
        setting: &Setting,
        works: &[Work],
        own: &[&Run],
        settings: &[Setting],
    ) -> Option<Prediction> {
        let about = setting.entry.about();
        let rays = self.sample.of();
        let work = &works[index];
        let row = Prediction {
            setting: index,
            method: about.name.into_owned(),
            backend: String::new(),
            quality: setting.quality,
            unit: about.quality,
            once: 0.0,
            frame: 0.0,
            bytes: 0,
            rmse: 0.0,
            rmse_spread: 0.0,
            known: Known::Probed,
            counted: [work.once, Self::counted(work, rays)],
        };
        if let Some(run) = own.iter().find(|run| run.setting == index) {
            return Some(Prediction {
                once: run.once,
                frame: self.frame_time(setting, run.times),
                bytes: run.bytes,
                rmse: run.error.rmse,
                rmse_spread: run.error.spread,
                ..row
            });
        }
        let line = |x: &dyn Fn(usize) -> f64, y: &dyn Fn(&Run) -> f64| {
            let points = own.iter().map(|run| (x(run.setting), y(run)));
            let mut points: Vec<(f64, f64)> = points.collect();
            // Where counted work is the same, the quality tells settings apart.
            if points.windows(2).any(|pair| !(pair[0].0 < pair[1].0)) {
                for (point, run) in points.iter_mut().zip(own) {
                    point.0 = f64::from(settings[run.setting].quality.max(1));
                }
                return along_logarithms(&points, f64::from(setting.quality.max(1)));
            }
            along_logarithms(&points, x(index))
        };
        let quality = |setting: usize| f64::from(settings[setting].quality.max(1));
        let counted = |setting: usize| Self::counted(&works[setting], rays);
        let made = |setting: usize| works[setting].once.max(1.0);
        let shortest = f64::MIN_POSITIVE;
        let frame = |run: &Run| {
            self.frame_time(&settings[run.setting], run.times)
                .max(shortest)
        };
        let highest = own.last()?;
        let nearest = own
            .iter()
            .min_by_key(|run| run.setting.abs_diff(index))
            .unwrap_or(highest);
        let rmse = line(&quality, &|run| run.error.rmse.max(LEAST_ERROR))?;
        // Errors level out where something else limits them.
        let rmse = match index > highest.setting {
            true => rmse.min(highest.error.rmse),
            false => rmse,
        };
        Some(Prediction {
            once: line(&made, &|run| run.once.max(shortest))?,
            frame: line(&counted, &frame)?,
            bytes: line(&made, &|run| run.bytes.max(1) as f64)? as u64,
            rmse,
            rmse_spread: nearest.error.spread,
            known: Known::Interpolated,
            ..row
        })
    }
}

impl<'a, B: MethodBackend> Frames<'a, B> {
    /// The frame of the larger sample, or the whole one for a method that takes no part.
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

/// Whether a store of a backend is the one on the host.
fn is_same<A, B>(store: &A, host: &B) -> bool {
    std::ptr::addr_eq(store, host)
}

fn name(setting: &Setting) -> String {
    let about = setting.entry.about();
    format!("{} with {} {}", about.name, setting.quality, about.quality)
}

/// An error with its causes.
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

/// Seconds that a probe of a setting takes, by counted work.
#[derive(Debug, Clone, Copy)]
struct Cost {
    once: f64,
    frames: f64,
}

/// The settings of each method, by their places.
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

/// What is run: the ends of each group and one between, then the others, each unless what
/// it takes is too much by itself or with those before.
fn chosen(groups: &[Vec<usize>], costs: &[Cost], seconds: f64) -> Vec<usize> {
    let is_first = |group: &[usize], place: usize| {
        let last = group.len() - 1;
        [0, last / 2, last].contains(&place)
    };
    let mut spent = 0.0;
    let mut chosen = Vec::new();
    // What is made for one quality is often a part of what another needs.
    let mut made = vec![0.0_f64; groups.len()];
    for round in [true, false] {
        for (number, group) in groups.iter().enumerate() {
            for (place, &setting) in group.iter().enumerate() {
                if is_first(group, place) != round {
                    continue;
                }
                let Cost { once, frames } = costs[setting];
                let more = (once - made[number]).max(0.0) + frames;
                let own = once + frames;
                if own <= LARGEST * seconds && spent + more <= seconds {
                    spent += more;
                    made[number] = made[number].max(once);
                    chosen.push(setting);
                }
            }
        }
    }
    chosen.sort_unstable();
    chosen
}
