//! The comparison: every applicable method at every quality, its error against
//! the converged reference and its time.

mod backends;
pub(crate) mod budget;
mod files;
mod film;
mod flip;
mod floors;
mod json;
pub(crate) mod measure;
mod patience;
pub(crate) mod prepare;
mod records;
pub(crate) mod results;
mod run_facts;
mod schedule;
pub(crate) mod selection;
pub(crate) mod shown;
mod size;
mod slopes;
mod statistics;
pub(crate) mod studies;
pub(crate) mod study;
mod times;
pub(crate) mod truth;

use std::ffi::OsString;
use std::sync::atomic::AtomicBool;

use lighting::methods::Registry;

use crate::args::Compare;
use crate::failure::Failure;
use crate::format::{count, seconds};
use crate::output::PendingFolder;
use crate::picture::Picture;
use crate::print::{complain, note, print, summarise};
use crate::{indirect, interrupt, plan, progress, report, surfaces};
use budget::Budget;
use measure::{Job, Outcome, Truth, measure};
use prepare::Prepared;
use results::{Film, Pictures, ReferenceFacts, Results};
use run_facts::RunFacts;
use selection::{check_names, dropped};
use studies::{Asked, Device, Subject};
use study::{NO_TIME, Study};

/// Share of the time that pictures get; the rest is for studies.
const PICTURES: f64 = 0.75;

/// Share of the time left that a software GPU may take, whose times mean nothing.
const SOFTWARE: f64 = 0.25;

/// Runs `crepuscular compare` with these arguments, which are `command` as a whole.
pub(crate) fn run(methods: &Registry, args: &Compare, command: &[OsString]) -> Result<(), Failure> {
    let default = if args.quick { 14.0 } else { 150.0 };
    let (in_all, of_film) = film::seconds_and_share(args, default);
    let budget = match args.fixed {
        true => Budget::unlimited(),
        false => Budget::new(in_all),
    };
    // The time of a film is not available for larger pictures.
    let of_picture = (1.0 - of_film) * budget.total();
    let facts = RunFacts::now(command);
    check_names(methods, &args.methods)?;
    let asked = Asked::new(&args.studies)?;
    if args.plan {
        let prepared = prepare(methods, args, of_picture)?;
        indirect::check_ambient(&args.ambient, &prepared.input)?;
        film::check(args, &prepared)?;
        return print(&prepared.describe());
    }
    let folder = PendingFolder::create(&args.out, files::is_ours, files::PAGE, report::MARK)?;
    let prepared = prepare(methods, args, of_picture)?;
    indirect::check_ambient(&args.ambient, &prepared.input)?;
    film::check(args, &prepared)?;
    let dropped = dropped(methods, &args.methods, &prepared.selection);
    if !dropped.is_empty() && prepared.selection.candidates.is_empty() {
        return Err(Failure::new(format!(
            "nothing to compare: {}",
            dropped.join("; ")
        )));
    }
    for line in dropped {
        complain(&format!("warning: {line}"));
    }
    if let Some(size) = prepared.size_note() {
        note(&[size]);
    }
    let results = compare(
        methods,
        args,
        &asked,
        &prepared,
        [budget.share(1.0 - of_film), budget],
        facts,
        &folder,
    )?;
    let spinner = progress::spinner("writing the report");
    files::write(&folder, &results)?;
    let place = folder.finish()?;
    spinner.finish_and_clear();
    let page = place.join(files::PAGE);
    note(&prepared.input.notes);
    if args.json {
        print(&json::summary(&results, &place))?;
    } else {
        let mut text = String::new();
        for sentence in report::sentences(&results) {
            text += &format!("{sentence}\n");
        }
        text += &format!(
            "{} and {} left out; {} after {}\n",
            count(results.measurements.len(), "measurement"),
            count(results.left_out.len(), "item"),
            page.display(),
            seconds(budget.elapsed())
        );
        summarise(&text)?;
    }
    if results.measurements.is_empty() {
        return Err(Failure::nothing(format!(
            "nothing was measured: {}; {} lists all that was left out",
            remedy(&results, &prepared),
            page.display()
        )));
    }
    Ok(())
}

/// Everything that is prepared before the long work; with `--auto` only for the candidates that
/// are worth it.
fn prepare(methods: &Registry, args: &Compare, seconds: f64) -> Result<Prepared, Failure> {
    let mut prepared = Prepared::new(methods, args.asked(), seconds)?;
    if args.auto {
        plan::keep_worthwhile(&mut prepared, &args.backend)?;
    }
    Ok(prepared)
}

/// Why nothing was measured, and what to do about it.
fn remedy(results: &Results, prepared: &Prepared) -> String {
    let is_dark = prepared.emitters.is_empty();
    if prepared.medium.is_none() {
        return "the scene has no medium that scatters; give it one with --sigma-s".into();
    }
    if is_dark {
        return "no light reaches what the camera sees; give the scene another light, camera \
                or medium"
            .into();
    }
    let backends = &prepared.backends;
    if let Some(gap) = backends.run_nothing(&prepared.selection.candidates) {
        return format!("{}: {}; see --methods and --backend", gap.what, gap.why);
    }
    let mut reasons = results.left_out.iter();
    if reasons.any(|part| part.why.starts_with(NO_TIME)) {
        return "the time was over before the first picture; give it more with --time-budget, \
                as much as it takes with --fixed, or ask for a smaller picture with --size"
            .into();
    }
    let mut reasons = results.left_out.iter();
    match reasons.find(|part| !part.what.starts_with("study")) {
        Some(part) => format!("{}: {}; see --plan", part.what, part.why),
        None => "no method runs on the backends that are present (--backend)".into(),
    }
}

/// The reference and all measurements.
struct Found {
    facts: ReferenceFacts,
    airlight: Picture,
    outcome: Outcome,
    backends: Vec<String>,
}

fn compare(
    methods: &Registry,
    args: &Compare,
    asked: &Asked<'_>,
    prepared: &Prepared,
    [budget, of_all]: [Budget; 2],
    run: RunFacts,
    folder: &PendingFolder,
) -> Result<Results, Failure> {
    let mut shadow_maps = "none".to_owned();
    let mut found = Found {
        facts: truth::nothing(),
        airlight: Picture::black(prepared.size),
        outcome: Outcome::default(),
        backends: Vec::new(),
    };
    let mut studies = studies::all_blank();
    let mut film = None;
    let is_empty = prepared.selection.candidates.is_empty();
    if let (Some(job), false) = (prepared.job(args.quick), is_empty) {
        shadow_maps = format!("{} texels per side", job.map);
        found = measure_all(args, prepared, job, budget.share(PICTURES))?;
        let stop = interrupt::flag()?;
        studies = study(args, asked, prepared, job, budget, &stop)?;
        film = film::make(args, prepared, of_all, &stop, &|name, file| {
            folder.write(name, file)
        })?;
    }
    let Prepared { input, size, .. } = prepared;
    let map = args.options.map.unwrap_or(512);
    let surfaces = surfaces::radiance(&prepared.view, input, map)?;
    let mut surfaces = Picture::new(*size, &surfaces);
    let mut notes = prepared.notes();
    if let Some(ambient) = indirect::ambient(&args.ambient, input, &prepared.view)? {
        surfaces = surfaces.plus(&Picture::new(*size, &ambient));
        notes.push(
            "surfaces have the ambient light that the fog before them scatters (--ambient); \
             errors are those of the airlight alone"
                .into(),
        );
    }
    let of_film = film.iter().map(|film: &Film| &film.study);
    let of_studies = of_film.chain(&studies).flat_map(|study| &study.left_out);
    let mut left_out: Vec<_> = of_studies.cloned().collect();
    left_out.extend(prepared.selection.left_out.iter().cloned());
    left_out.extend(found.outcome.left_out);
    Ok(Results {
        run,
        scene: input.scene.name.clone(),
        light: input.light_kinds(),
        lights: input.lights(),
        medium: prepared.describe_air(),
        triangles: input.geometry.triangles().len(),
        statistics: statistics::of(input, prepared.emitters.len()),
        size: *size,
        shadow_maps,
        floors: found.outcome.floors,
        notes,
        ran: prepared.passes(),
        left_out,
        machine: machine(),
        backends: found.backends,
        reference: found.facts,
        pictures: Pictures {
            surfaces,
            airlight: found.airlight,
            methods: found.outcome.pictures,
        },
        methods: shown::all(methods)
            .iter()
            .map(shown::Shown::facts)
            .collect(),
        measurements: found.outcome.measurements,
        studies,
        film,
        seconds_total: budget.elapsed(),
    })
}

/// Measures all candidates on all backends, the CPU first. A software GPU gets at most a quarter
/// of the time that is left.
fn measure_all(
    args: &Compare,
    prepared: &Prepared,
    job: Job<'_>,
    budget: Budget,
) -> Result<Found, Failure> {
    let (truth, facts) = truth::converge(&job, prepared.view.rays(), args.tolerance, args.quick);
    let mut found = Found {
        facts,
        airlight: Picture::of_reference(prepared.size, &truth.radiance),
        outcome: Outcome::default(),
        backends: Vec::new(),
    };
    let truth = Truth::new(prepared.size, &truth);
    let candidates = &prepared.selection.candidates;
    let devices = &prepared.backends.present;
    for (index, device) in devices.iter().enumerate() {
        let others = &devices[index + 1..];
        let real = others.iter().filter(|device| device.representative).count();
        let software = others.len() - real;
        // The backends and studies that follow keep their share of the time.
        let share = match (device.representative, real, software) {
            (false, ..) if devices.len() > 1 => 1.0,
            (_, 0, 0) => 1.0,
            (_, 0, _) => 1.0 - SOFTWARE,
            (_, real, _) => 1.0 / (1 + real) as f64,
        };
        let on_cpu = devices[0].context.is_none() && index > 0;
        let on_cpu = on_cpu.then_some(&found.outcome.measurements[..]);
        match measure(device, job, candidates, &truth, budget.share(share), on_cpu) {
            Ok(outcome) => {
                found.backends.push(device.label.clone());
                found.outcome.add(outcome);
            }
            Err(failure) => {
                let left_out = device.excuse(failure)?;
                found.outcome.left_out.push(left_out);
            }
        }
    }
    Ok(found)
}

/// Carries out the studies that were asked for, until the first Ctrl-C: then the finished parts
/// of them are reported.
fn study(
    args: &Compare,
    asked: &Asked<'_>,
    prepared: &Prepared,
    job: Job<'_>,
    budget: Budget,
    stop: &AtomicBool,
) -> Result<Vec<Study>, Failure> {
    let devices = prepared.backends.present.iter().map(|device| Device {
        label: device.label.clone(),
        short: report::short_name(&device.label, device.representative),
        context: device.context.as_ref(),
    });
    let subject = Subject {
        geometry: &job.input.geometry,
        tracer: &job.input.tracer,
        medium: job.medium,
        translucent: &job.input.scene.translucent,
        emitters: job.emitters,
        areas: job.areas,
        camera: job.camera,
        rays: job.view.rays(),
        hits: job.view.hits(),
        size: job.size,
        map: job.map,
        devices: devices.collect(),
        quick: args.quick,
    };
    studies::run_all(asked, &subject, budget, stop)
}

/// The processor, as the system names it, and the threads in use.
fn machine() -> String {
    let threads = count(rayon::current_num_threads(), "thread");
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info
        .lines()
        .find_map(|line| line.strip_prefix("model name"))
        .map(|rest| rest.trim_start_matches([' ', '\t', ':']).trim())
        .filter(|name| !name.is_empty());
    match model {
        Some(name) => format!("{name}, {threads}"),
        None => format!("{} processor, {threads}", std::env::consts::ARCH),
    }
}
