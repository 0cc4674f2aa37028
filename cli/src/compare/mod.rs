//! The comparison: every applicable method at every quality, its error against
//! the converged reference and its time.

mod backends;
mod baked;
mod budget;
mod measure;
mod prepare;
pub(crate) mod results;
mod selection;
pub(crate) mod studies;
pub(crate) mod study;
mod times;
mod trial;

use lighting::scene::Medium;

use crate::args::Compare;
use crate::engine::affordable_resolution;
use crate::failure::Failure;
use crate::format::{count, seconds};
use crate::input::describe_medium;
use crate::methods::{Airlight, METHODS, Method, Visibility};
use crate::output::PendingFolder;
use crate::picture::Picture;
use crate::print::{complain, print};
use crate::{interrupt, progress, report, veils};
use budget::Budget;
use prepare::Prepared;
use results::{MethodFacts, Pictures, Results};
use selection::{check_names, dropped};
use studies::{Device, STUDIES, Subject};
use study::Study;
use trial::{Found, try_out};

/// The page, which carries the mark of a report, and the main results.
const PAGE: &str = "index.html";
const RESULTS: &str = "results.csv";

/// Share of the time that pictures get; the rest is for studies.
const PICTURES: f64 = 0.75;

/// Runs `crepuscular compare`.
pub(crate) fn run(args: &Compare) -> Result<(), Failure> {
    let default = if args.quick { 14.0 } else { 150.0 };
    let budget = Budget::new(args.time_budget.unwrap_or(default));
    check_names(&args.methods)?;
    if args.plan {
        return print(&Prepared::new(args)?.describe());
    }
    let files = [PAGE, RESULTS].into_iter();
    let files = files.chain(STUDIES.iter().map(|study| study.csv)).collect();
    let folder = PendingFolder::create(&args.out, files, report::MARK)?;
    let prepared = Prepared::new(args)?;
    let dropped = dropped(&args.methods, &prepared.selection);
    if !dropped.is_empty() && prepared.selection.candidates.is_empty() {
        return Err(Failure::new(format!(
            "nothing to compare: {}",
            dropped.join("; ")
        )));
    }
    for line in dropped {
        complain(&format!("warning: {line}"));
    }
    let results = compare(args, prepared, budget)?;
    let spinner = progress::spinner("writing the report");
    folder.write(PAGE, report::page(&results)?.as_bytes())?;
    folder.write(RESULTS, &report::csv(&report::records(&results))?)?;
    for study in &results.studies {
        folder.write(study.csv, &report::csv(&study.records)?)?;
    }
    let place = folder.finish()?;
    spinner.finish_and_clear();
    let mut text = String::new();
    for note in &results.notes {
        text += &format!("note: {note}\n");
    }
    for sentence in report::sentences(&results) {
        text += &format!("{sentence}\n");
    }
    text += &format!(
        "{} and {} left out; {} after {}\n",
        count(results.measurements.len(), "measurement"),
        count(results.left_out.len(), "item"),
        place.join(PAGE).display(),
        seconds(budget.elapsed())
    );
    print(&text)
}

fn compare(args: &Compare, mut prepared: Prepared, budget: Budget) -> Result<Results, Failure> {
    let candidates = prepared.selection.candidates.clone();
    let mut notes = Vec::new();
    let mut shadow_maps = "none".to_owned();
    let mut found = Found::nothing(&prepared);
    let mut studies = studies::all_blank();
    if let (Some(medium), false) = (prepared.input.scene.medium, candidates.is_empty()) {
        let map = map_resolution(args, &prepared, &mut notes);
        shadow_maps = format!("{map} texels per side");
        let asked = prepared.frame.size;
        // The estimate of the first pass may reduce the picture; the second
        // pass takes it as it is.
        let mut fitted = false;
        let pictures = budget.share(PICTURES);
        found = loop {
            match try_out(args, &mut prepared, &medium, map, pictures, fitted)? {
                Some(found) => break found,
                None => fitted = true,
            }
        };
        if prepared.frame.size != asked {
            notes.push(format!(
                "the picture is {} instead of {asked}, so that everything fits into {} (--time-budget)",
                prepared.frame.size,
                seconds(budget.total())
            ));
        }
        studies = study(args, &prepared, &medium, map, budget)?;
    }
    let Prepared { input, frame, .. } = &prepared;
    let size = frame.size;
    let map = args.options.map.unwrap_or(512);
    let surfaces = veils::surfaces(&frame.view, input, map)?;
    let of_studies = studies.iter().flat_map(|study| &study.left_out);
    let mut left_out: Vec<_> = of_studies.cloned().collect();
    left_out.extend(prepared.selection.left_out.iter().cloned());
    left_out.extend(found.outcome.left_out);
    Ok(Results {
        scene: input.scene.name.clone(),
        light: input.light_kinds(),
        lights: input.lights(),
        medium: describe_medium(input.scene.medium.as_ref()),
        triangles: input.geometry.triangles().len(),
        size,
        shadow_maps,
        notes: input.notes.iter().cloned().chain(notes).collect(),
        ran: prepared.passes(),
        left_out,
        machine: machine(),
        backends: found.backends,
        reference: found.facts,
        pictures: Pictures {
            surfaces: Picture::new(size, &surfaces),
            airlight: found.airlight,
            methods: found.outcome.pictures,
        },
        methods: method_facts(),
        measurements: found.outcome.measurements,
        studies,
        seconds_total: budget.elapsed(),
    })
}

/// Carries out the studies, until the first Ctrl-C: what there is of them then
/// is reported.
fn study(
    args: &Compare,
    prepared: &Prepared,
    medium: &Medium,
    map: u32,
    budget: Budget,
) -> Result<Vec<Study>, Failure> {
    let Prepared {
        input,
        camera,
        frame,
        backends,
        ..
    } = prepared;
    let short = |label: &str, representative| report::short_name(label, representative);
    let devices = backends.present.iter().map(|backend| Device {
        label: backend.label.clone(),
        short: short(&backend.label, backend.representative),
        context: backend.context(),
    });
    let subject = Subject {
        geometry: &input.geometry,
        tracer: &input.tracer,
        medium,
        translucent: &input.scene.translucent,
        emitters: &prepared.emitters(),
        camera,
        rays: frame.view.rays(),
        size: frame.size,
        map,
        devices: devices.collect(),
        quick: args.quick,
    };
    studies::run_all(&subject, budget, &*interrupt::flag()?)
}

/// All methods in the order of the registry, as reports know them.
pub(crate) fn method_facts() -> Vec<MethodFacts> {
    let facts = |method: &Method| MethodFacts {
        name: method.name(),
        title: method.title.into(),
        quality: method.quality_name().into(),
        visibility: method.visibility.name().into(),
        airlight: method.airlight_name(),
        has_shadows: method.visibility != Visibility::None,
        is_baseline: method.visibility == Visibility::March
            && method.airlight == Airlight::Midpoint,
        samples_shadow_map: method.visibility.needs_shadow_map(),
    };
    METHODS.iter().map(facts).collect()
}

/// Texels per side of the shadow maps, reduced if there are many lights.
fn map_resolution(args: &Compare, prepared: &Prepared, notes: &mut Vec<String>) -> u32 {
    let asked = args
        .options
        .map
        .unwrap_or(if args.quick { 512 } else { 1024 });
    let emitters = prepared.emitters();
    let map = affordable_resolution(asked, &prepared.input.geometry, &emitters);
    if map < asked {
        notes.push(format!(
            "shadow maps have {map} texels per side instead of {asked}, so that those of {} fit into 512 MiB",
            count(emitters.len(), "emitter")
        ));
    }
    map
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
