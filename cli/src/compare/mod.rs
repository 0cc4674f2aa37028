//! The comparison: every applicable method at every quality, its error against
//! the converged reference and its time.

pub(crate) mod alone;
mod backends;
mod baked;
mod budget;
mod csv;
pub(crate) mod curves;
pub(crate) mod dag;
mod measure;
mod prepare;
pub(crate) mod results;
mod selection;
mod trial;
pub(crate) mod voxels;

use lighting::Emitter;

use crate::args::Compare;
use crate::engine::affordable_resolution;
use crate::failure::Failure;
use crate::format::{count, seconds};
use crate::input::{describe_medium, describe_phase};
use crate::output::PendingFolder;
use crate::picture::Picture;
use crate::print::{complain, print};
use crate::{progress, report, veils};
use budget::Budget;
use curves::Curves;
use dag::Dag;
use prepare::Prepared;
use results::{LeftOut, Pictures, Results};
use selection::{check_names, dropped};
use trial::{Found, try_out};
use voxels::Voxels;

/// The files of a report; the first one carries the mark.
const FILES: [&str; 6] = [
    "index.html",
    "results.csv",
    "airlight.csv",
    "curves.csv",
    "voxels.csv",
    "shadows.csv",
];

/// Share of the time that pictures get; the rest is for what is judged by itself.
const PICTURES: f64 = 0.75;

/// Seconds that voxels by themselves may take, in a quick comparison and in a full
/// one.
const VOXEL_SECONDS: [f64; 2] = [1.5, 15.0];

/// Seconds that baked shadows by themselves may take: of a quick comparison,
/// and of another.
const DAG_SECONDS: [f64; 2] = [1.2, 25.0];

/// Runs `crepuscular compare`.
pub(crate) fn run(args: &Compare) -> Result<(), Failure> {
    let default = if args.quick { 14.0 } else { 150.0 };
    let budget = Budget::new(args.time_budget.unwrap_or(default));
    check_names(&args.methods)?;
    if args.plan {
        return print(&Prepared::new(args)?.describe());
    }
    let folder = PendingFolder::create(&args.out, &FILES, report::MARK)?;
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
    folder.write(FILES[0], report::page(&results)?.as_bytes())?;
    folder.write(FILES[1], csv::write(&results).as_bytes())?;
    folder.write(FILES[2], alone::csv(&results.alone).as_bytes())?;
    folder.write(FILES[3], curves::csv(&results.curves).as_bytes())?;
    folder.write(FILES[4], voxels::csv(&results.voxels).as_bytes())?;
    folder.write(FILES[5], dag::csv(&results.dag).as_bytes())?;
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
        place.join(FILES[0]).display(),
        seconds(budget.elapsed())
    );
    print(&text)
}

fn compare(args: &Compare, mut prepared: Prepared, budget: Budget) -> Result<Results, Failure> {
    let candidates = prepared.selection.candidates.clone();
    let mut notes = Vec::new();
    let mut shadow_maps = "none".to_owned();
    let mut found = Found::nothing(&prepared);
    let mut alone = Vec::new();
    let mut curves = Curves::default();
    let mut voxels = Voxels::default();
    let mut dag = Dag::default();
    let mut left_out = Vec::new();
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
        if prepared.emitters().iter().any(is_point) {
            alone = alone::judge_all(medium.phase(), args.quick)?;
        } else {
            left_out.push(LeftOut {
                what: "airlight alone".into(),
                why: "no light at a point; that of a sun has a closed form".into(),
            });
        }
        let translucent = &prepared.input.scene.translucent;
        let without;
        (curves, without) = curves::judge_all(translucent, &prepared.emitters(), args.quick)?;
        left_out.extend(without);
        match prepared.voxel_scene(&medium, map) {
            Ok(scene) => {
                let seconds = VOXEL_SECONDS[usize::from(!args.quick)];
                voxels = voxels::judge(scene, args.quick, seconds.min(budget.left()))?;
                left_out.append(&mut voxels.left_out);
                for backend in &prepared.backends.present {
                    let steps = match budget.left() > 0.0 {
                        true => backend.time_voxels(scene, args.quick),
                        false => Err(Failure::new("no time left (--time-budget)")),
                    };
                    match steps {
                        Ok(steps) => voxels.steps.extend(steps),
                        // Its pictures stand.
                        Err(failure) => left_out.push(LeftOut {
                            what: format!("steps of voxels on {}", backend.label),
                            why: failure.to_string(),
                        }),
                    }
                }
            }
            Err(why) => left_out.push(LeftOut {
                what: "voxels alone".into(),
                why,
            }),
        }
        let Prepared { input, camera, .. } = &prepared;
        dag = dag::judge(
            (&input.geometry, &input.tracer, camera),
            &prepared.emitters(),
            args.quick,
            DAG_SECONDS[usize::from(!args.quick)].min(budget.left()),
        )?;
        left_out.extend(dag.left_out.iter().map(|what| LeftOut {
            what: (*what).into(),
            why: "no time left (--time-budget)".into(),
        }));
    }
    let Prepared { input, frame, .. } = &prepared;
    let size = frame.size;
    let map = args.options.map.unwrap_or(512);
    let surfaces = veils::surfaces(&frame.view, input, map)?;
    left_out.extend(prepared.selection.left_out.iter().cloned());
    left_out.extend(found.outcome.left_out);
    Ok(Results {
        scene: input.scene.name.clone(),
        light: input.light_kinds(),
        lights: input.lights(),
        medium: describe_medium(input.scene.medium.as_ref()),
        phase: input
            .scene
            .medium
            .map_or_else(String::new, |medium| describe_phase(medium.phase())),
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
        measurements: found.outcome.measurements,
        alone,
        curves,
        voxels,
        dag,
        seconds_total: budget.elapsed(),
    })
}

fn is_point(emitter: &Emitter) -> bool {
    matches!(emitter, Emitter::Point(_))
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
