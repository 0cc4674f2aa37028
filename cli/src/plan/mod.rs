//! What each method will cost on a scene, and which one to take.

mod analysis;
mod foresight;
mod json;
mod profile;
mod worth;

use lighting::methods::Registry;
use lighting::prediction::{Forecast, Profile, Target};

use crate::args::Plan;
use crate::compare::prepare::{Asked, Prepared};
use crate::compare::selection::{Candidate, check_names};
use crate::devices::Device;
use crate::failure::Failure;
use crate::format::count;
use crate::print::{note, print, summarise};
use analysis::analyze;
use foresight::{Foresight, SECONDS, foreseen};
use json::Choice;

pub(crate) use foresight::choose;
pub(crate) use worth::keep_worthwhile;

/// Scenes that methods are learned from: a sun, lamps, a spot, hair and smoke.
const LEARNED_FROM: [&str; 5] = ["city", "fence", "coil", "smoke", "translucent"];

/// A device, what may run on it, and what is expected of that.
type Foreseen<'a> = (&'a Device, Vec<&'a Candidate>, Forecast);

/// Runs `crepuscular plan`.
pub(crate) fn run(methods: &Registry, args: &Plan) -> Result<(), Failure> {
    check_names(methods, &args.methods)?;
    if args.calibrate {
        return calibrate(methods, args);
    }
    let [scene] = &args.scene[..] else {
        return Err(Failure::new(
            "one scene at a time; several are those of --calibrate",
        ));
    };
    let profile = profile::read(args.profile.as_deref())?;
    let prepared = prepare(methods, args, scene)?;
    let forecasts = forecasts(&prepared, args, &profile, SECONDS)?;
    let analysis = match (args.analyze, prepared.job(false)) {
        (true, Some(job)) => Some(analyze(job, &forecasts)?),
        _ => None,
    };
    let choice = choice(args, &forecasts);
    note(&prepared.input.notes);
    if args.json {
        let all: Vec<&Forecast> = forecasts.iter().map(|(_, _, forecast)| forecast).collect();
        let value = json::of(&prepared, &all, &choice, analysis.as_ref());
        print(&format!("{value:#}\n"))?;
    } else {
        let mut text = prepared.plan.to_string();
        for (_, _, forecast) in &forecasts {
            text += &format!("\n{forecast}");
        }
        if let Some(analysis) = &analysis {
            text += &analysis.describe();
        }
        if let Some((target, Ok(row))) = &choice {
            text += &format!("\nfor {target}: {row}\n");
        }
        print(&text)?;
    }
    match choice {
        Some((_, Err(unmet))) => Err(Failure::nothing(unmet.to_string())),
        _ => Ok(()),
    }
}

fn prepare(methods: &Registry, args: &Plan, scene: &str) -> Result<Prepared, Failure> {
    let asked = Asked {
        scene,
        size: Some(args.size),
        quick: false,
        methods: &args.methods,
        backend: &args.backend,
        smoke_unseen: false,
        options: &args.options,
    };
    Prepared::new(methods, asked, f64::INFINITY)
}

/// What is foreseen on each device, with what it was foreseen of. Software that plays a GPU is
/// left out unless it was asked for.
fn forecasts<'a>(
    prepared: &'a Prepared,
    args: &Plan,
    profile: &Profile,
    seconds: f64,
) -> Result<Vec<Foreseen<'a>>, Failure> {
    let Some(foresight) = Foresight::new(prepared, profile, seconds) else {
        return Ok(Vec::new());
    };
    let devices = prepared.backends.present.iter();
    let devices = devices.filter(|device| device.representative || !args.backend.is_empty());
    devices
        .map(|device| {
            let candidates = foreseen(prepared, device);
            let forecast = foresight.of(device, &candidates)?;
            Ok((device, candidates, forecast))
        })
        .collect()
}

/// The choice among all devices, if there is a target.
fn choice(args: &Plan, forecasts: &[Foreseen<'_>]) -> Choice {
    let of_error = args.error.map(Target::Error);
    let target = of_error.or(args.time.map(Target::Time))?;
    let frames = args.frames.map_or(f64::INFINITY, f64::from);
    let rows = forecasts.iter().flat_map(|(_, _, forecast)| &forecast.rows);
    let all = Forecast {
        rows: rows.cloned().collect(),
        skipped: Vec::new(),
    };
    Some((target, all.choose(target, frames).cloned()))
}

/// Learns what the methods cost, and writes it down.
fn calibrate(methods: &Registry, args: &Plan) -> Result<(), Failure> {
    let usual = LEARNED_FROM.map(str::to_owned);
    let scenes = match args.scene.is_empty() {
        true => &usual[..],
        false => &args.scene[..],
    };
    let mut all = Vec::new();
    for scene in scenes {
        let prepared = prepare(methods, args, scene)?;
        let found = forecasts(&prepared, args, &Profile::new(), f64::INFINITY)?;
        all.extend(found.into_iter().map(|(_, _, forecast)| forecast));
    }
    let profile = Profile::learned(&all);
    let number = profile.all().count();
    let path = profile::write(args.profile.as_deref(), &profile)?;
    summarise(&format!(
        "{}: {} from {}\n",
        path.display(),
        count(number, "method"),
        count(scenes.len(), "scene")
    ))
}
