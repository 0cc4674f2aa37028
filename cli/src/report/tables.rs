//! Times to reach an error, and everything that was measured.

use maud::{Markup, html};

use super::plots::{Line, of_software, representative, software};
use super::section::table;
use super::summary::TARGETS;
use crate::compare::results::{Results, fastest_within, pareto, slopes};
use crate::compare::study::{Cell, Column, Table, Unit};
use crate::format::{error, seconds};

/// The tables of the measurements that compete.
pub(super) fn section(results: &Results) -> Markup {
    let lines = representative(results);
    html! {
        @if let Some(rows) = targets(results, &lines) {
            h2 { "Time to reach an error" }
            (table(&rows))
        }
        @if let Some(rows) = measurements(results, &lines) {
            details {
                summary { "Table: all " (rows.rows().len()) " measurements" }
                p.soft.above {
                    "The same data as in " code { "results.csv" } ". Shaded rows are on the front of error against the time of a frame. Map: texels per side of the shadow maps."
                }
                (table(&rows))
            }
        }
    }
}

/// The measurements on a software GPU, folded: its times mean nothing.
pub(super) fn on_software(results: &Results) -> Markup {
    let (Some(backend), lines) = (results.software(), software(results)) else {
        return Markup::default();
    };
    html! {
        details {
            summary { "Software GPU: times that are not representative" }
            p {
                "On " (backend) " the CPU emulates the GPU. Its errors are those of a GPU; its times are not used elsewhere on this page."
            }
            (of_software(results, &lines))
            @for rows in [targets(results, &lines), measurements(results, &lines)].iter().flatten() {
                (table(rows))
            }
        }
    }
}

/// One row per method: the fastest setting within each error that is reached.
fn targets(results: &Results, lines: &[Line<'_>]) -> Option<Table> {
    if lines.is_empty() || results.reference.absolute {
        return None;
    }
    let all = || lines.iter().flat_map(|line| line.of(results));
    let reached = |target: &f64| fastest_within(all(), None, *target).is_some();
    let targets: Vec<f64> = TARGETS.into_iter().filter(reached).collect();
    let mut columns = vec![Column::plain("method")];
    let headed = |target: &f64| Column::new(format!("≤ {}", error(*target, false)), Unit::Seconds);
    columns.extend(targets.iter().map(headed));
    columns.push(Column::new("best error", Unit::Share));
    columns.push(Column::plain("slope"));
    let mut rows = Table::new(columns).titled(
        "",
        "The fastest frame of each method whose error (RMSE ÷ mean radiance) is at most that of the column; below it, its number of steps, voxels per axis, Gauss nodes, digits or KiB. Shaded: the fastest of a column, and those whose times overlap with the fastest. Slope: that of log error over log time; −1 halves the error in twice the time.",
    );
    let slopes = slopes(&results.measurements);
    for line in lines {
        let own = line.of(results);
        let mut cells = vec![name(results, *line)];
        for target in &targets {
            let best = fastest_within(all(), None, *target);
            cells.push(match fastest_within(own.clone(), None, *target) {
                Some(m) => Cell {
                    shaded: best.is_some_and(|best| best.frame.overlaps(&m.frame)),
                    aside: m.quality.to_string(),
                    ..m.frame.median.into()
                },
                None => Cell::from("–"),
            });
        }
        let best = own.map(|m| m.error.rmse).fold(f64::INFINITY, f64::min);
        cells.push(best.into());
        let mut slopes = slopes.iter();
        let slope = slopes.find(|s| (s.method, &*s.backend) == (line.method, line.backend));
        cells.push(match slope.and_then(|slope| slope.over_time) {
            Some(slope) => rounded(slope).into(),
            None => Cell::from("–"),
        });
        rows.push(cells);
    }
    Some(rows)
}

/// A line's name with its colour and marker.
fn name(results: &Results, line: Line<'_>) -> Cell {
    Cell::keyed(line.name(results), line.key(results))
}

/// One row per measurement.
fn measurements(results: &Results, lines: &[Line<'_>]) -> Option<Table> {
    if lines.is_empty() {
        return None;
    }
    let unit = if results.reference.absolute {
        Unit::Number
    } else {
        Unit::Share
    };
    let mut rows = Table::new(vec![
        Column::plain("method"),
        Column::plain("quality"),
        Column::plain("map"),
        Column::new("RMSE", unit),
        Column::plain("relMSE"),
        Column::plain("FLIP"),
        Column::new("max", unit),
        Column::new("p99", Unit::Share),
        Column::new("build", Unit::Seconds),
        Column::new("frame", Unit::Seconds),
        Column {
            soft: true,
            ..Column::plain("min – max")
        },
        Column {
            soft: true,
            ..Column::plain("runs")
        },
        Column::new("memory", Unit::Bytes),
    ]);
    rows.grouped = true;
    let all = || {
        lines
            .iter()
            .flat_map(|line| line.of(results).map(move |m| (*line, m)))
    };
    let points: Vec<Option<(f64, f64)>> = all()
        .map(|(_, m)| Some((m.frame.median, m.error.rmse)))
        .collect();
    for ((line, m), best) in all().zip(pareto(&points)) {
        let cells = vec![
            Cell {
                aside: results.methods[m.method].quality.clone(),
                ..name(results, line)
            },
            m.quality.into(),
            m.map.map_or_else(|| Cell::from("–"), Cell::from),
            m.error.rmse.into(),
            m.error.rel_mse.into(),
            m.error.flip.map_or_else(|| Cell::from("–"), Cell::from),
            m.error.max.into(),
            m.error.rel_p99.into(),
            m.seconds_build.into(),
            m.frame.median.into(),
            range(m.frame.low, m.frame.high).into(),
            m.frame.repetitions.into(),
            m.bytes.into(),
        ];
        rows.push_row(cells, best);
    }
    Some(rows)
}

/// A number with one decimal, a minus sign that is as wide as a digit, and no −0.
fn rounded(number: f64) -> String {
    let tenths = (10.0 * number).round() / 10.0;
    // Adding 0 takes the sign off −0.
    format!("{:.1}", tenths + 0.0).replace('-', "−")
}

/// Two durations, with one unit if they share it: `1.2 – 1.5 ms`.
fn range(low: f64, high: f64) -> String {
    let (low, high) = (seconds(low), seconds(high));
    match (low.split_once(' '), high.split_once(' ')) {
        (Some((number, a)), Some((_, b))) if a == b => format!("{number} – {high}"),
        _ => format!("{low} – {high}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};

    #[test]
    fn each_method_is_named_once_in_the_table_of_measurements() {
        let results = example();
        let rows = measurements(&results, &representative(&results)).unwrap();
        let html = table(&rows).into_string();
        let methods = results.methods.len();
        assert_eq!(html.matches("<tbody class=\"group").count(), methods);
        assert_eq!(html.matches("<th scope=\"row").count(), methods);
        assert_eq!(html.matches("<tr").count(), 1 + results.measurements.len());
    }

    #[test]
    fn what_a_software_adapter_took_is_folded_away() {
        let results = example_with_software();
        let html = section(&results).into_string();
        assert!(!html.contains("software"), "{html}");
        let folded = on_software(&results).into_string();
        assert!(folded.starts_with("<details><summary>Software GPU"));
        assert!(folded.contains("gpu (a, &quot;b&quot;, software)"));
        assert_eq!(folded.matches("<table").count(), 2);
        assert_eq!(on_software(&example()).into_string(), "");
    }

    #[test]
    fn errors_that_nobody_reaches_have_no_column() {
        let mut results = example();
        for m in &mut results.measurements {
            m.error.rmse = m.error.rmse.max(0.03);
        }
        let rows = targets(&results, &representative(&results)).unwrap();
        let names: Vec<&str> = rows.columns.iter().map(|c| c.name.as_str()).collect();
        let reached = ["≤ 50 %", "≤ 20 %", "≤ 10 %", "≤ 5 %"];
        assert_eq!(names[1..5], reached);
        assert_eq!(names[5..], ["best error", "slope"]);
    }

    #[test]
    fn times_that_overlap_with_the_fastest_are_shaded_too() {
        let mut results = example();
        for m in &mut results.measurements {
            m.frame = crate::compare::results::Times::of(&[1.0, 2.0]);
        }
        let rows = targets(&results, &representative(&results)).unwrap();
        let shaded = |column: usize| {
            rows.rows()
                .iter()
                .filter(|r| r.cells[column].shaded)
                .count()
        };
        assert_eq!(shaded(1), results.methods.len(), "all reach half the mean");
        assert_eq!(shaded(rows.columns.len() - 1), 0);
        let rounded = [-0.04, 0.0, -1.26, 2.0].map(rounded);
        assert_eq!(rounded, ["0.0", "0.0", "−1.3", "2.0"]);
        assert_eq!(range(1.2e-3, 1.5e-3), "1.2 – 1.5 ms");
        assert_eq!(range(0.9e-3, 1.5e-3), "900 µs – 1.5 ms");
        assert_eq!(range(0.0, 1.0), "0 – 1 s");
    }
}
