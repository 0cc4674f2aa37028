//! Every method in every hard picture: which pixels are not numbers, which errors miss their
//! bounds, and where the backends differ.

mod case;
mod check;
mod table;

use std::sync::atomic::Ordering;

use gpu_backend::Cpu;
use gpu_backend::gpu::{Gpu, Queued};
use lighting::methods::{Entry, Registry};
use reference::hard_cases::{FrameCase, LargeCase, frame_cases, large_frame_cases};

use crate::args::Stress;
use crate::devices;
use crate::failure::Failure;
use crate::print::{note, print};
use crate::{interrupt, progress};
use case::Case;
use check::Finding;

/// A case, whose scene is made when its turn comes if it is large.
struct Named {
    name: &'static str,
    make: Box<dyn FnOnce() -> FrameCase>,
}

impl Named {
    fn small(case: FrameCase) -> Self {
        Self {
            name: case.name,
            make: Box::new(move || case),
        }
    }

    fn large(case: LargeCase) -> Self {
        Self {
            name: case.name,
            make: Box::new(move || case.make()),
        }
    }
}

/// Runs `crepuscular stress`.
pub(crate) fn run(methods: &Registry, args: &Stress) -> Result<(), Failure> {
    let cases: Vec<Named> = match args.large {
        false => frame_cases().into_iter().map(Named::small).collect(),
        true => large_frame_cases().into_iter().map(Named::large).collect(),
    };
    let cases = chosen(
        cases.into_iter(),
        &args.cases,
        |case: &Named, part| case.name.contains(part),
        "--cases",
    )?;
    let entries = chosen(
        methods.compared(),
        &args.methods,
        |entry: &&Entry, filter| entry.matches(filter),
        "--methods",
    )?;
    let (devices, _) = devices::find(&args.backend)?;
    let stop = interrupt::flag()?;
    let bar = progress::bar("hard cases", cases.len() as u64);
    let mut findings: Vec<Finding> = Vec::new();
    let mut done = 0;
    for case in cases {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let case = Case::new((case.make)(), args.map);
        for device in &devices {
            match &device.context {
                None => {
                    let cpu = Cpu::new();
                    findings.extend(case.run(&cpu, &device.label, &entries, &stop)?);
                }
                Some(context) => {
                    let gpu: Gpu<Queued> = Gpu::new(context.clone());
                    findings.extend(case.run(&gpu, &device.label, &entries, &stop)?);
                }
            }
        }
        done += 1;
        bar.inc(1);
    }
    bar.finish_and_clear();
    check::compare_backends(&mut findings);
    let text = match args.json {
        true => format!("{:#}\n", table::json(&findings, done)),
        false => table::text(&findings, done),
    };
    print(&text)?;
    let is_interrupted = stop.load(Ordering::Relaxed);
    if is_interrupted {
        note(&["interrupted: the remaining cases were not run".into()]);
    }
    match findings
        .iter()
        .filter(|finding| finding.is_violation())
        .count()
    {
        0 if findings.is_empty() && !is_interrupted => {
            Err(Failure::nothing("no method applies to these cases"))
        }
        0 => Ok(()),
        _ => Err(Failure::nothing(
            "violations were found; they are listed above",
        )),
    }
}

/// The entries of a list that match any of the filters, or all without a filter. A filter that
/// matches none is an error.
fn chosen<T>(
    all: impl Iterator<Item = T>,
    filters: &[String],
    means: impl Fn(&T, &str) -> bool,
    option: &str,
) -> Result<Vec<T>, Failure> {
    let all: Vec<T> = all.collect();
    for filter in filters {
        if !all.iter().any(|item| means(item, filter)) {
            return Err(Failure::new(format!(
                "{option} {filter}: nothing has this name"
            )));
        }
    }
    let is_meant = |item: &T| filters.is_empty() || filters.iter().any(|f| means(item, f));
    Ok(all.into_iter().filter(is_meant).collect())
}
