//! Evaluators of airlight by themselves, without a scene: error against time
//! per evaluation, over ordinary and over stiff segments.

use std::fmt::Write;
use std::time::Instant;

use airlight::{Evaluator, Exact, PhaseFunction, Quadrature, Segment, SunTable, Table};
use reference::segments::{Case, easy, stiff};

use super::results::Times;
use crate::failure::Failure;
use crate::progress;

/// Ordinary segments in the list; as many as the stiff list has, about.
const EASY: usize = 6000;

/// Errors beyond this are all alike.
pub(crate) const WORST: f64 = 10.0;

/// A kind of evaluator, in the order of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    Double,
    Table,
    Tolerance,
    Nodes,
    Published,
}

impl Family {
    pub(crate) const ALL: [Self; 5] = [
        Self::Double,
        Self::Table,
        Self::Tolerance,
        Self::Nodes,
        Self::Published,
    ];

    /// What it is called.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Double => "exact, in double precision",
            Self::Table => "table of the scaled tail",
            Self::Tolerance => "quadrature to a tolerance",
            Self::Nodes => "quadrature with fixed nodes per piece",
            Self::Published => "table of Sun et al. as published",
        }
    }
}

/// What there is to judge.
struct Entry {
    family: Family,
    setting: String,
    make: Box<dyn Fn() -> Result<Made, airlight::Error>>,
}

/// An evaluator and the memory of its tables.
type Made = (Box<dyn Evaluator>, usize);

/// Sizes of tables in KiB, decimal digits of tolerances, nodes per piece.
struct Settings {
    kibibytes: &'static [u32],
    digits: &'static [i32],
    nodes: &'static [u32],
}

const ALL: Settings = Settings {
    kibibytes: &[8, 16, 32, 64],
    digits: &[2, 3, 4, 5, 6],
    nodes: &[2, 3, 4, 6, 8],
};
const QUICK: Settings = Settings {
    kibibytes: &[16, 64],
    digits: &[3, 5],
    nodes: &[3, 6],
};

fn entries(phase: PhaseFunction, settings: &Settings) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut add =
        |family, setting: String, make: Box<dyn Fn() -> Result<Made, airlight::Error>>| {
            entries.push(Entry {
                family,
                setting,
                make,
            });
        };
    add(
        Family::Double,
        "f64".into(),
        Box::new(move || Ok((Box::new(Exact::new(phase)?), 0))),
    );
    for size in settings.kibibytes.iter().copied() {
        let make = move || {
            let table = Table::new(&phase, size)?;
            let bytes = table.bytes();
            Ok((Box::new(table) as Box<dyn Evaluator>, bytes))
        };
        add(Family::Table, format!("{size} KiB"), Box::new(make));
    }
    for digits in settings.digits.iter().copied() {
        let make = move || {
            let rule = Quadrature::with_tolerance(phase, 10_f32.powi(-digits))?;
            Ok((Box::new(rule) as Box<dyn Evaluator>, 0))
        };
        add(Family::Tolerance, format!("1e-{digits}"), Box::new(make));
    }
    for nodes in settings.nodes.iter().copied() {
        let make = move || {
            let rule = Quadrature::fixed(phase, nodes)?;
            Ok((Box::new(rule) as Box<dyn Evaluator>, 0))
        };
        add(Family::Nodes, nodes.to_string(), Box::new(make));
    }
    if phase == PhaseFunction::Isotropic {
        let make = || {
            let table = SunTable::new();
            let bytes = table.bytes();
            Ok((Box::new(table) as Box<dyn Evaluator>, bytes))
        };
        add(Family::Published, "512²".into(), Box::new(make));
    }
    entries
}

/// Every evaluator at every setting, on both lists; a quick one looks at few
/// settings and for less long.
pub(crate) fn judge_all(phase: PhaseFunction, quick: bool) -> Result<Vec<Alone>, Failure> {
    let (easy, stiff) = (List::easy(phase), List::stiff(phase));
    let (entries, seconds) = if quick {
        (entries(phase, &QUICK), 0.01)
    } else {
        (entries(phase, &ALL), 0.05)
    };
    let bar = progress::bar("airlight alone", entries.len() as u64);
    let mut all = Vec::new();
    for Entry {
        family,
        setting,
        make,
    } in entries
    {
        let clock = Instant::now();
        let (evaluator, bytes) = make()?;
        let seconds_build = clock.elapsed().as_secs_f64();
        all.push(Alone {
            family,
            setting,
            bytes: bytes as u64,
            seconds_build,
            easy: easy.judge(evaluator.as_ref(), seconds),
            stiff: stiff.judge(evaluator.as_ref(), seconds),
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

/// `airlight.csv`: one line per evaluator and setting.
pub(crate) fn csv(all: &[Alone]) -> String {
    let mut out = "evaluator,setting,stiff_worst,stiff_median,stiff_seconds,ordinary_worst,ordinary_median,ordinary_seconds,bytes,seconds_build\n".to_owned();
    for alone in all {
        // Writing to a string cannot fail.
        let _ = write!(out, "\"{}\",{}", alone.family.title(), alone.setting);
        for judgement in [&alone.stiff, &alone.easy] {
            let _ = write!(
                out,
                ",{:e},{:e},{:e}",
                judgement.worst, judgement.median, judgement.time.median
            );
        }
        let _ = writeln!(out, ",{},{:e}", alone.bytes, alone.seconds_build);
    }
    out
}

/// Segments by extinction, as batches want them, with their truths.
#[derive(Debug)]
pub(crate) struct List {
    batches: Vec<Batch>,
    count: usize,
}

#[derive(Debug)]
struct Batch {
    sigma_t: f32,
    segments: Vec<Segment>,
    truths: Vec<f64>,
}

/// What a list says of an evaluator.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judgement {
    /// Largest and middle relative error of results that are normal f32;
    /// values that are not finite count as [`WORST`].
    pub(crate) worst: f64,
    pub(crate) median: f64,
    /// Seconds per evaluation on one thread.
    pub(crate) time: Times,
}

/// One evaluator at one setting.
#[derive(Debug, Clone)]
pub(crate) struct Alone {
    pub(crate) family: Family,
    /// Its setting: a number of nodes, the size of a table.
    pub(crate) setting: String,
    /// Memory of its tables.
    pub(crate) bytes: u64,
    /// Time to make it.
    pub(crate) seconds_build: f64,
    pub(crate) easy: Judgement,
    pub(crate) stiff: Judgement,
}

impl List {
    /// Ordinary segments.
    pub(crate) fn easy(phase: PhaseFunction) -> Self {
        Self::of(&easy(phase, EASY))
    }

    /// Those at which evaluators break.
    pub(crate) fn stiff(phase: PhaseFunction) -> Self {
        Self::of(&stiff(phase))
    }

    fn of(cases: &[Case]) -> Self {
        let mut batches: Vec<Batch> = Vec::new();
        for case in cases {
            let index = batches
                .iter()
                .position(|batch| batch.sigma_t == case.sigma_t)
                .unwrap_or_else(|| {
                    batches.push(Batch {
                        sigma_t: case.sigma_t,
                        segments: Vec::new(),
                        truths: Vec::new(),
                    });
                    batches.len() - 1
                });
            batches[index].segments.push(case.part.into());
            batches[index].truths.push(case.truth);
        }
        Self {
            batches,
            count: cases.len(),
        }
    }

    /// Errors and time of an evaluator; `seconds` is about how long it takes.
    pub(crate) fn judge(&self, evaluator: &dyn Evaluator, seconds: f64) -> Judgement {
        let mut values: Vec<Vec<f32>> = self
            .batches
            .iter()
            .map(|batch| vec![0.0; batch.segments.len()])
            .collect();
        let mut times = Vec::new();
        let clock = Instant::now();
        while times.len() < 3 || clock.elapsed().as_secs_f64() < seconds && times.len() < 1000 {
            let round = Instant::now();
            for (batch, values) in self.batches.iter().zip(&mut values) {
                evaluator.airlight_batch(batch.sigma_t, &batch.segments, values);
            }
            times.push(round.elapsed().as_secs_f64() / self.count as f64);
        }
        let mut errors: Vec<f64> = self
            .batches
            .iter()
            .zip(&values)
            .flat_map(|(batch, values)| batch.truths.iter().zip(values))
            .map(|(truth, value)| relative_error(f64::from(*value), *truth))
            .collect();
        errors.sort_by(f64::total_cmp);
        Judgement {
            worst: errors.last().copied().unwrap_or(0.0),
            median: errors.get(errors.len() / 2).copied().unwrap_or(0.0),
            time: Times::of(&times),
        }
    }
}

/// Relative where the truth is a normal f32; what lies below may be anything
/// down there.
fn relative_error(value: f64, truth: f64) -> f64 {
    let smallest = f64::from(f32::MIN_POSITIVE);
    let error = (value - truth).abs() / truth.max(smallest);
    if !value.is_finite() {
        WORST
    } else if truth < smallest && error <= 1.0 {
        0.0
    } else {
        error.min(WORST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Says what it is told, in order.
    struct Constant(f32);

    impl Evaluator for Constant {
        fn airlight(&self, _: f32, _: &Segment) -> f32 {
            self.0
        }
    }

    #[test]
    fn errors_are_relative_and_never_hide_what_is_not_finite() {
        assert_eq!(relative_error(f64::NAN, 1.0), WORST);
        assert_eq!(relative_error(f64::INFINITY, 1.0), WORST);
        assert_eq!(relative_error(1.5, 1.0), 0.5);
        assert_eq!(relative_error(1e30, 1.0), WORST);
        assert_eq!(relative_error(0.0, 1e-45), 0.0);
        assert!(relative_error(1e-30, 1e-45) > 1.0);
        let list = List::easy(PhaseFunction::Isotropic);
        assert_eq!(list.count, EASY);
        let dark = list.judge(&Constant(0.0), 0.0);
        assert_eq!((dark.worst, dark.median), (1.0, 1.0));
        assert!(dark.time.repetitions == 3 && dark.time.median > 0.0);
        assert_eq!(list.judge(&Constant(f32::NAN), 0.0).median, WORST);
    }
}
