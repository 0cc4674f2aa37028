//! Evaluators of airlight without a scene: error against time per evaluation,
//! over ordinary and over stiff segments.

mod frames;
mod lists;

use std::time::Instant;

use airlight::{Evaluator, Exact, PhaseFunction, Quadrature, SunTable, Table};
use lighting::Emitter;

use super::{Kind, Limit, Subject};
use crate::compare::study::{
    Axis, Cell, Chart, Charts, Column, Key, Part, Point, Scale, Series, Shape, Study, Unit,
};
use crate::failure::Failure;
use crate::format::{seconds, significant};
use crate::input::describe_phase;
use crate::progress;
use frames::Frames;
use lists::{List, Measurement, WORST};

pub(super) const KIND: Kind = Kind {
    title: "evaluators of airlight",
    csv: "airlight.csv",
    columns,
    seconds: None,
    in_fog: true,
    pointless,
    run,
};

/// A kind of evaluator, in the order of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Family {
    Double,
    Table,
    Frame,
    Tolerance,
    Nodes,
    Published,
}

impl Family {
    const ALL: [Self; 6] = [
        Self::Double,
        Self::Table,
        Self::Frame,
        Self::Tolerance,
        Self::Nodes,
        Self::Published,
    ];

    /// Its name in the report.
    fn title(self) -> &'static str {
        match self {
            Self::Double => "exact, in double precision",
            Self::Table => "table of the scaled tail",
            Self::Frame => "table of a frame",
            Self::Tolerance => "quadrature to a tolerance",
            Self::Nodes => "quadrature with fixed nodes per piece",
            Self::Published => "table of Sun et al. as published",
        }
    }

    /// Its colour and marker.
    fn key(self) -> Key {
        let place = Self::ALL.into_iter().position(|other| other == self);
        Key::new(place.unwrap_or(0))
    }
}

/// An evaluator at a setting, before it is made.
struct Entry {
    family: Family,
    setting: String,
    make: Box<dyn Fn() -> Result<Made, airlight::Error>>,
}

/// An evaluator, the memory of one of its tables, and the number of these.
type Made = (Box<dyn Evaluator>, usize, usize);

/// Sizes of tables in KiB, rows of those of a frame, decimal digits of tolerances, nodes per piece.
struct Settings {
    kibibytes: &'static [u32],
    rows: &'static [u32],
    digits: &'static [i32],
    nodes: &'static [u32],
}

const ALL: Settings = Settings {
    kibibytes: &[8, 16, 32, 64],
    rows: &[64, 128, 256],
    digits: &[2, 3, 4, 5, 6],
    nodes: &[2, 3, 4, 6, 8],
};
const QUICK: Settings = Settings {
    kibibytes: &[16, 64],
    rows: &[128],
    digits: &[3, 5],
    nodes: &[3, 6],
};

/// `frames` holds the extinctions and distances for which there are tables of a frame.
fn entries(phase: PhaseFunction, settings: &Settings, frames: &[[f32; 2]]) -> Vec<Entry> {
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
        Box::new(move || Ok((Box::new(Exact::new(phase)?), 0, 1))),
    );
    for size in settings.kibibytes.iter().copied() {
        let make = move || {
            let table = Table::new(&phase, size)?;
            let bytes = table.bytes();
            Ok((Box::new(table) as Box<dyn Evaluator>, bytes, 1))
        };
        add(Family::Table, format!("{size} KiB"), Box::new(make));
    }
    for rows in settings.rows.iter().copied() {
        let frames = frames.to_vec();
        let make = move || {
            let tables = Frames::new(phase, &frames, rows)?;
            let bytes = tables.bytes();
            Ok((
                Box::new(tables) as Box<dyn Evaluator>,
                bytes,
                frames.len().max(1),
            ))
        };
        add(Family::Frame, format!("{rows} rows"), Box::new(make));
    }
    for digits in settings.digits.iter().copied() {
        let make = move || {
            let rule = Quadrature::with_tolerance(phase, 10_f32.powi(-digits))?;
            Ok((Box::new(rule) as Box<dyn Evaluator>, 0, 1))
        };
        add(Family::Tolerance, format!("1e-{digits}"), Box::new(make));
    }
    for nodes in settings.nodes.iter().copied() {
        let make = move || {
            let rule = Quadrature::fixed(phase, nodes)?;
            Ok((Box::new(rule) as Box<dyn Evaluator>, 0, 1))
        };
        add(Family::Nodes, nodes.to_string(), Box::new(make));
    }
    if phase == PhaseFunction::Isotropic {
        let make = || {
            let table = SunTable::new();
            let bytes = table.bytes();
            Ok((Box::new(table) as Box<dyn Evaluator>, bytes, 1))
        };
        add(Family::Published, "512²".into(), Box::new(make));
    }
    entries
}

fn pointless(subject: &Subject<'_>) -> Option<&'static str> {
    let is_point = |emitter: &Emitter| matches!(emitter, Emitter::Point(_));
    let has_point = subject.emitters.iter().any(is_point);
    (!has_point).then_some("no light at a point; that of a sun has a closed form")
}

fn columns() -> Vec<Column> {
    let mut columns = vec![Column::plain("evaluator"), Column::plain("setting")];
    for list in ["stiff", "ordinary", "steps"] {
        columns.extend([
            Column::new(format!("{list}_worst"), Unit::Below(WORST)),
            Column::new(format!("{list}_median"), Unit::Below(WORST)),
            Column::new(format!("{list}_seconds"), Unit::Seconds),
        ]);
    }
    columns.extend([
        Column::new("bytes", Unit::Bytes),
        Column::new("seconds_build", Unit::Seconds),
    ]);
    columns
}

/// Every evaluator at every setting, on all lists; a quick study looks at few
/// settings and for less long.
fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let phase = subject.medium.phase();
    if let Some(why) = limit.reached() {
        study.leave_out("", why);
        return Ok(study);
    }
    let (easy, stiff) = (List::easy(phase), List::stiff(phase));
    let (steps, marched) = (List::steps(phase), List::marched(phase));
    let frames = [marched.frames(), stiff.frames()].concat();
    let (entries, seconds) = if subject.quick {
        (entries(phase, &QUICK, &frames), 0.01)
    } else {
        (entries(phase, &ALL, &frames), 0.05)
    };
    let bar = progress::bar("evaluators of airlight", entries.len() as u64);
    let mut rows = Vec::new();
    for Entry {
        family,
        setting,
        make,
    } in entries
    {
        if let Some(why) = limit.reached() {
            study.leave_out("the other settings", why);
            break;
        }
        let clock = Instant::now();
        let (evaluator, bytes, tables) = make()?;
        let seconds_build = clock.elapsed().as_secs_f64() / tables as f64;
        let easy = match family {
            Family::Frame => &marched,
            _ => &easy,
        };
        rows.push(Measured {
            family,
            setting,
            bytes: bytes as u64,
            seconds_build,
            easy: easy.measure(evaluator.as_ref(), seconds),
            stiff: stiff.measure(evaluator.as_ref(), seconds),
            steps: steps.measure(evaluator.as_ref(), seconds),
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    describe(&mut study, &describe_phase(phase), &rows);
    Ok(study)
}

/// Puts the measurements into words, charts and tables.
fn describe(study: &mut Study, phase: &str, rows: &[Measured]) {
    if rows.is_empty() {
        return;
    }
    study.introduction = format!(
        "Every evaluator of the light from a part of a ray, without a scene, for this scene's phase function ({phase}): \
the largest relative error over a list of segments against the time of one evaluation, in batches on one thread. \
The stiff list holds rays towards the light, past it and away from it, exactly and nearly, vacuum and optical depths of 80, \
parts from a billionth of the distance to infinity, and distances from a micrometre to a thousand kilometres; \
the ordinary one holds rays from the eye on at optical distances of 0.1 to 2, and the steps are a hundred of equal length of each of 60 of these. \
Tables of a frame are made for the distance between the eye and the light of each ray (of these 60 only, of the ordinary ones), which is what the build takes; \
what they do not know is integrated to 1e-5."
    );
    for row in rows {
        let mut cells = vec![
            Cell::keyed(row.family.title(), row.family.key()),
            row.setting.as_str().into(),
        ];
        for Measurement {
            worst,
            median,
            time,
        } in [row.stiff, row.easy, row.steps]
        {
            cells.extend([worst.into(), median.into(), time.median.into()]);
        }
        cells.extend([row.bytes.into(), row.seconds_build.into()]);
        study.records.push(cells);
    }
    study.parts.push(Part::Charts(Charts {
        share_legend: true,
        all: vec![
            chart("Stiff segments", rows, |row| row.stiff),
            chart("Ordinary segments", rows, |row| row.easy),
            chart("Steps of a march", rows, |row| row.steps),
        ],
    }));
    let headings = [
        ("evaluator", "evaluator"),
        ("setting", "setting"),
        ("stiff_worst", "stiff: worst"),
        ("stiff_median", "median"),
        ("stiff_seconds", "time"),
        ("ordinary_worst", "ordinary: worst"),
        ("ordinary_median", "median"),
        ("ordinary_seconds", "time"),
        ("steps_worst", "steps: worst"),
        ("steps_median", "median"),
        ("steps_seconds", "time"),
        ("bytes", "tables"),
        ("seconds_build", "build"),
    ];
    let caption = "Errors are relative, of results that f32 can hold.";
    let mut table = study.records.view(&headings, |_| true).titled("", caption);
    table.grouped = true;
    study.parts.push(Part::Table(table));
}

fn chart(title: &str, rows: &[Measured], of: fn(&Measured) -> Measurement) -> Chart {
    let point = |row: &Measured| {
        let Measurement { worst, time, .. } = of(row);
        let error = if worst >= WORST {
            format!("≥ {}", significant(WORST))
        } else {
            significant(worst)
        };
        let (family, setting) = (row.family.title(), &row.setting);
        Point {
            x: time.median,
            y: worst,
            spread: [time.low, time.high],
            label: setting.clone(),
            title: format!("{family}, {setting}: {error} in {}", seconds(time.median)),
        }
    };
    let series = |family: Family| Series {
        name: family.title().into(),
        aside: String::new(),
        key: family.key(),
        competes: true,
        shape: Shape::Points,
        points: rows
            .iter()
            .filter(|row| row.family == family)
            .map(point)
            .collect(),
    };
    Chart {
        title: title.into(),
        caption: "the worst of them".into(),
        description: "largest relative error against the time of one evaluation, both logarithmic"
            .into(),
        x: Axis {
            label: "time of one evaluation".into(),
            scale: Scale::Log,
            unit: Unit::Seconds,
        },
        y: Axis {
            label: "largest relative error".into(),
            scale: Scale::Log,
            unit: Unit::Below(WORST),
        },
        front: true,
        series: Family::ALL
            .into_iter()
            .map(series)
            .filter(|series| !series.points.is_empty())
            .collect(),
    }
}

/// One evaluator at one setting.
#[derive(Debug)]
struct Measured {
    family: Family,
    /// A number of nodes, the size of a table.
    setting: String,
    /// Memory of its tables.
    bytes: u64,
    /// Time to make it.
    seconds_build: f64,
    easy: Measurement,
    stiff: Measurement,
    steps: Measurement,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::times::Times;

    #[test]
    fn what_was_measured_is_recorded_drawn_and_tabled() {
        let measurement = |worst: f64| Measurement {
            worst,
            median: 1e-6,
            time: Times::of(&[1e-8, 2e-8]),
        };
        let rows = [
            (Family::Table, "64 KiB", 1e-4),
            (Family::Published, "512²", WORST),
        ]
        .map(|(family, setting, worst)| Measured {
            family,
            setting: setting.into(),
            bytes: 1 << 16,
            seconds_build: 0.2,
            easy: measurement(1e-5),
            stiff: measurement(worst),
            steps: measurement(1e-5),
        });
        let mut study = KIND.blank();
        describe(&mut study, "isotropic", &rows);
        assert_eq!(study.records.rows().len(), 2);
        let worst: Vec<_> = study.records.rows().iter().map(|r| &r.cells[2]).collect();
        assert_eq!(worst, [&Cell::from(1e-4), &Cell::from(WORST)]);
        let [Part::Charts(charts), Part::Table(table)] = &study.parts[..] else {
            panic!("charts and a table: {:?}", study.parts);
        };
        assert!(charts.all.iter().all(|chart| chart.series.len() == 2));
        assert!(charts.all[0].series[1].points[0].title.contains("≥ 10 in"));
        assert_eq!(table.rows().len(), 2);
        assert!(study.introduction.contains("(isotropic)"));
    }
}
