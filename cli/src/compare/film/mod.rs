//! Films: whether errors stay where they are while the camera or the lights move, or flicker.
//!
//! A film has shots. In each of them either the camera moves or the lights do, in one of two ways
//! ([`path`]): by small steps, a third of a pixel or half a texel of a shadow map from frame to
//! frame, forth and back through the same places; or by large ones, to places that have nothing
//! to do with each other. Every frame has a converged reference. Each method makes all frames of
//! a shot in order, with one store: things that do not depend on the camera or the lights that
//! move are kept from frame to frame, all others are made anew.
//!
//! [`reference::film`] says what the errors mean.

mod curves;
mod frames;
mod path;
mod show;
mod strip;
mod take;
#[cfg(test)]
mod tests;

use std::sync::atomic::{AtomicBool, Ordering};

use gpu_backend::gpu::Gpu;
use gpu_backend::{Cpu, Download};
use lighting::methods::{Entry, Role, Store, share_tracer};

use super::budget::Budget;
use super::prepare::Prepared;
use super::results::LeftOut;
use super::selection::Candidate;
use super::study::{NO_TIME, Study};
use crate::args::Compare;
use crate::devices::Device;
use crate::failure::Failure;
use crate::format::seconds;
use crate::parse::Size;
use crate::progress;
use frames::Frames;
pub(crate) use show::is_ours;
use take::Take;

/// Name of its CSV file.
pub(crate) const CSV: &str = "film.csv";

/// By how many seconds a comparison is prolonged for each frame of each shot, unless a time was
/// asked for: a frame of forty methods and the reference at 160 × 90.
const SECONDS_PER_FRAME: f64 = 4.0;

/// Share of the asked-for time that a film may take.
const SHARE: f64 = 0.5;

/// Share of the time of a shot that its references may take.
const REFERENCES: f64 = 0.6;

/// Pictures are halved until they have no more pixels than this.
const MOST_PIXELS: usize = 160 * 90;

/// The largest number of pixels of all frames of a shot together, that of the longest film:
/// their references and views take a GiB.
const MOST_IN_ALL: usize = 600 * MOST_PIXELS;

/// A film that was made.
#[derive(Debug)]
pub(crate) struct Film {
    /// Its measurements, as a study.
    pub(crate) study: Study,
    /// Frames of each shot.
    pub(crate) frames: usize,
    pub(crate) size: Size,
}

/// A method at the quality at which it is filmed.
struct Filmed {
    /// Its place among the methods of the report, if it has one.
    slot: Option<usize>,
    entry: Entry,
    title: String,
    quality: u32,
}

/// Seconds for everything, and the share of them that a film takes.
pub(super) fn seconds_and_share(args: &Compare, default: f64) -> (f64, f64) {
    let Some(frames) = args.film else {
        return (args.time_budget.unwrap_or(default), 0.0);
    };
    match args.time_budget {
        Some(seconds) => (seconds, SHARE),
        None => {
            let shots = path::shot_count(args.film_path) as f64;
            let film = SECONDS_PER_FRAME * f64::from(frames) * shots;
            (default + film, film / (default + film))
        }
    }
}

/// The size of a film's pictures: that of the comparison, halved while it is too large,
/// unless everything is to be measured at the size asked for.
fn size(args: &Compare, prepared: &Prepared, frames: usize) -> Result<Size, Failure> {
    let mut size = prepared.size;
    while !args.fixed && size.pixels() > MOST_PIXELS {
        size = size.halved();
    }
    let all = size.pixels() * frames;
    if all > MOST_IN_ALL {
        return Err(Failure::new(format!(
            "--film {frames}: {frames} frames of {size} are {all} pixels, at most {MOST_IN_ALL} are supported"
        )));
    }
    Ok(size)
}

/// Returns an error if the film that was asked for cannot be made.
pub(super) fn check(args: &Compare, prepared: &Prepared) -> Result<(), Failure> {
    match args.film {
        Some(frames) => size(args, prepared, frames as usize).map(|_| ()),
        None => Ok(()),
    }
}

/// Takes a file of the report: its name and its content.
pub(super) type Write<'a> = &'a dyn Fn(&str, &[u8]) -> Result<(), Failure>;

/// Makes the film and writes its frames, if they were asked for. When the time is up or the user
/// stops it, the methods that are complete are reported.
pub(super) fn make(
    args: &Compare,
    prepared: &Prepared,
    budget: Budget,
    stop: &AtomicBool,
    write: Write<'_>,
) -> Result<Option<Film>, Failure> {
    let Some(frames) = args.film else {
        return Ok(None);
    };
    let frames = frames as usize;
    let size = size(args, prepared, frames)?;
    let mut film = Film {
        study: Study::new("a film", CSV, show::columns()),
        frames,
        size,
    };
    let (Some(job), [device, ..]) = (prepared.job(args.quick), &prepared.backends.present[..])
    else {
        film.study.leave_out("", "no light reaches the view");
        return Ok(Some(film));
    };
    let filmed = filmed(args, prepared, device);
    if filmed.is_empty() {
        film.study.leave_out("", "no method runs");
        return Ok(Some(film));
    }
    film.study.introduction = show::introduction(frames, size, &device.label);
    let shots = path::shots(args.film_path, frames, &job, size);
    let number = shots.len();
    for (index, shot) in shots.into_iter().enumerate() {
        let shot = match shot {
            Ok(shot) => shot,
            Err(LeftOut { what, why }) => {
                film.study.leave_out(&what, why);
                continue;
            }
        };
        let limit = Limit {
            budget: budget.share(1.0 / (number - index) as f64),
            stop,
        };
        let made = Frames::new(args, prepared, job, &shot, size, limit)?;
        let frames = match made {
            Ok(frames) => frames,
            Err(why) => {
                film.study.leave_out(&shot.name(), why);
                continue;
            }
        };
        let mut takes = Vec::new();
        let bar = progress::bar("film", (filmed.len() * frames.all.len()) as u64);
        for one in &filmed {
            let tick = || bar.inc(1);
            let name = format!("{}, {}", shot.name(), one.title);
            match filmed_on(device, prepared, &frames, one, limit, &tick)? {
                Ok(take) => {
                    if args.film_frames {
                        show::write(&frames, &shot, Some((one, &take)), write)?;
                    }
                    takes.push(show::Shown::new(one, take, &frames, &shot)?);
                }
                Err(why) => film.study.leave_out(&name, why),
            }
        }
        bar.finish_and_clear();
        if args.film_frames {
            show::write(&frames, &shot, None, write)?;
        }
        show::add(&mut film.study, &shot, &frames, &device.label, takes);
    }
    if !film.study.parts.is_empty() {
        film.study.parts.extend(show::notes(args.film_frames));
    }
    Ok(Some(film))
}

/// How long a shot may go on.
#[derive(Clone, Copy)]
struct Limit<'a> {
    budget: Budget,
    /// Set if the user wants no more.
    stop: &'a AtomicBool,
}

impl Limit<'_> {
    /// The reason not to begin something that takes about `seconds`, if there is one.
    fn reached_after(&self, seconds: f64) -> Option<String> {
        if self.stop.load(Ordering::Relaxed) {
            return Some("interrupted".into());
        }
        let left = self.budget.left();
        match left <= 0.0 || left < seconds {
            true if seconds > 0.0 => Some(format!(
                "{NO_TIME}: it takes about {}",
                self::seconds(seconds)
            )),
            true => Some(NO_TIME.into()),
            false => None,
        }
    }
}

/// Each method once, those of papers and the baseline first.
fn filmed(args: &Compare, prepared: &Prepared, device: &Device) -> Vec<Filmed> {
    let mut all: Vec<&Candidate> = Vec::new();
    for candidate in &prepared.selection.candidates {
        let is_known = all
            .last()
            .is_some_and(|last| last.method == candidate.method);
        if !candidate.refines_map && !is_known && device.why_not(candidate).is_none() {
            all.push(candidate);
        }
    }
    all.sort_by_key(|one| matches!(one.entry.about().role, Role::Engine | Role::Variant));
    let filmed = all.into_iter().map(|candidate| Filmed {
        slot: Some(candidate.method),
        entry: candidate.entry.clone(),
        title: candidate.title.clone(),
        quality: candidate.entry.about().pictured,
    });
    let mut filmed: Vec<Filmed> = filmed.collect();
    if device.context.is_none() && !prepared.sees_media {
        let is_asked = |entry: &Entry| {
            args.methods.is_empty() || args.methods.iter().any(|f| entry.matches(f))
        };
        let curves = match prepared.input.scene.translucent.is_empty() {
            true => Vec::new(),
            false => curves::methods(),
        };
        filmed.extend(curves.into_iter().filter(is_asked).map(|entry| Filmed {
            slot: None,
            title: entry.about().title.into(),
            quality: entry.about().pictured,
            entry,
        }));
    }
    filmed
}

/// All frames of a shot by one method; the inner error says why there are none.
fn filmed_on(
    device: &Device,
    prepared: &Prepared,
    frames: &Frames,
    filmed: &Filmed,
    limit: Limit<'_>,
    tick: &dyn Fn(),
) -> Result<Result<Take, String>, Failure> {
    let host = Store::new();
    share_tracer(&host, &prepared.input.tracer);
    let taken = match &device.context {
        None => {
            let cpu = Cpu::new();
            Take::new(&cpu, &host, &host, prepared, frames, filmed, limit, tick)
        }
        Some(context) => {
            let waited_for = Gpu::new(context.clone());
            let backend = Gpu::new(context.clone());
            let store = Store::waiting(move || waited_for.wait());
            Take::new(
                &backend, &store, &host, prepared, frames, filmed, limit, tick,
            )
        }
    };
    match taken {
        Ok(taken) => Ok(taken),
        Err(error) => {
            if let Some(context) = &device.context {
                context.check_alive()?;
            }
            Ok(Err(Failure::from(error).to_string()))
        }
    }
}
