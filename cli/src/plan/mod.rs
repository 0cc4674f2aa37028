//! The cost of each method on a scene, and the choice of one.

mod analysis;
mod foresight;
mod json;
mod profile;
mod worth;

use lighting::methods::Registry;
use lighting::plan::Pass;
use lighting::prediction::{Forecast, Profile, Target};

use crate::args::Plan;
use crate::compare::prepare::{Asked, Prepared};
use crate::compare::results::LeftOut;
use crate::compare::selection::{Candidate, check_names, dropped};
use crate::compare::study::described;
use crate::devices::{BackendName, Device};
use crate::failure::Failure;
use crate::format::count;
use crate::print::{complain, note, print, summarise};
use analysis::analyze;
use foresight::{Foresight, SECONDS, foreseen};

pub(crate) use foresight::choose;
pub(crate) use worth::keep_worthwhile;

/// Scenes that methods are learned from: a sun, lamps, a spot, hair and smoke.
const LEARNED_FROM: [&str; 5] = ["city", "fence", "coil", "smoke", "translucent"];

/// What the methods cost on this machine, as far as it is known.
pub(crate) fn known_costs() -> Result<Profile, Failure> {
    profile::read(None)
}

/// A device, the candidates that may run on it, and their forecast.
type Foreseen<'a> = (&'a Device, Vec<&'a Candidate>, Forecast);

/// Runs `crepuscular plan`.
pub(crate) fn run(methods: &Registry, args: &Plan) -> Result<(), Failure> {
    check_names(methods, &args.methods)?;
    if args.calibrate {
        return calibrate(methods, args);
    }
    let [scene] = &args.scene[..] else {
        return Err(Failure::new(
            "expected one scene; only --calibrate takes several",
        ));
    };
    let profile = profile::read(args.profile.as_deref())?;
    let prepared = prepare(methods, args, scene)?;
    for line in dropped(methods, &args.methods, &prepared.selection) {
        complain(&format!("warning: {line}"));
    }
    let (forecasts, failed) = forecasts(&prepared, &args.backend, &profile, SECONDS, target(args))?;
    let all = together(&forecasts);
    let slow = all.slow_starts(args.frames.map_or(1.0, f64::from));
    let slow: Vec<LeftOut> = slow.iter().map(foresight::left_out).collect();
    let of_scene = prepared.selection.left_out.iter();
    let left_out: Vec<&LeftOut> = of_scene.chain(&failed).chain(&slow).collect();
    let job = prepared.job(false);
    let passes: Vec<String> = (prepared.plan.passes().iter())
        .map(Pass::to_string)
        .collect();
    let analysis = match (args.analyze, job) {
        (true, Some(job)) => Some(analyze(job, &forecasts)?),
        _ => None,
    };
    let choice = target(args).map(|(target, frames)| (target, all.choose(target, frames).cloned()));
    note(&prepared.input.notes);
    if args.json {
        let known = json::Known {
            prepared: &prepared,
            passes: &passes,
            left_out: &left_out,
        };
        let value = json::of(known, &all, &choice, analysis.as_ref());
        print(&format!("{value:#}\n"))?;
    } else {
        let mut text = String::new();
        for pass in &passes {
            text += &format!("runs: {pass}\n");
        }
        text += &described(left_out.iter().copied());
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

/// The forecast of each device with its candidates, settled for a choice if one is made, and the
/// devices that failed though nobody asked for them. A software GPU is no device unless it was
/// `asked` for.
fn forecasts<'a>(
    prepared: &'a Prepared,
    asked: &[BackendName],
    profile: &Profile,
    seconds: f64,
    target: Option<(Target, f64)>,
) -> Result<(Vec<Foreseen<'a>>, Vec<LeftOut>), Failure> {
    let (mut all, mut failed) = (Vec::new(), Vec::new());
    let Some(foresight) = Foresight::new(prepared, profile, seconds) else {
        return Ok((all, failed));
    };
    let foresight = foresight.for_target(target);
    for device in &prepared.backends.present {
        if !device.representative && asked.is_empty() {
            continue;
        }
        let candidates = foreseen(prepared, device);
        match foresight.of(device, &candidates) {
            Ok(forecast) => all.push((device, candidates, forecast)),
            Err(failure) => failed.push(device.excuse(failure)?),
        }
    }
    Ok((all, failed))
}

/// The forecasts of all devices as one.
fn together(forecasts: &[Foreseen<'_>]) -> Forecast {
    let all = forecasts.iter().map(|(_, _, forecast)| forecast);
    Forecast {
        rows: all.clone().flat_map(|all| &all.rows).cloned().collect(),
        skipped: all.flat_map(|all| &all.skipped).cloned().collect(),
    }
}

/// What is asked of a picture, and how many frames share what is made before the first.
fn target(args: &Plan) -> Option<(Target, f64)> {
    let of_error = args.error.map(Target::Error);
    let target = of_error.or(args.time.map(Target::Time))?;
    Some((target, args.frames.map_or(f64::INFINITY, f64::from)))
}

/// Learns what the methods cost, and writes it down.
fn calibrate(methods: &Registry, args: &Plan) -> Result<(), Failure> {
    let usual = LEARNED_FROM.map(str::to_owned);
    let scenes = match args.scene.is_empty() {
        true => &usual[..],
        false => &args.scene[..],
    };
    let file = profile::open(args.profile.as_deref())?;
    let mut all = Vec::new();
    for scene in scenes {
        let prepared = prepare(methods, args, scene)?;
        let (found, _) = forecasts(
            &prepared,
            &args.backend,
            &Profile::new(),
            f64::INFINITY,
            None,
        )?;
        all.extend(found.into_iter().map(|(_, _, forecast)| forecast));
    }
    let profile = Profile::learned(&all);
    let number = profile.all().count();
    let path = file.write(&profile)?;
    summarise(&format!(
        "{}: {} from {}\n",
        path.display(),
        count(number, "method"),
        count(scenes.len(), "scene")
    ))
}
