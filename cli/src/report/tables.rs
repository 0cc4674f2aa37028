//! Times to reach an error, and everything that was measured.

use maud::{Markup, html};

use super::plots::{Line, lines};
use super::section::table;
use super::summary::TARGETS;
use crate::compare::results::{Measurement, Results, fastest_within, pareto};
use crate::compare::study::{Cell, Column, Table, Unit};
use crate::format::{error, seconds};

/// One row per method: the fastest setting within each error.
pub(super) fn targets(results: &Results) -> Markup {
    if results.measurements.is_empty() || results.reference.absolute {
        return Markup::default();
    }
    let mut columns = vec![Column::plain("method")];
    columns.extend(TARGETS.map(|target| Column::new(error(target, false), Unit::Seconds)));
    columns.push(Column::new("best error", Unit::Share));
    let mut rows = Table::new(columns).titled(
        "",
        format!(
            "Fastest measured frame whose RMSE is at most the given share of the mean radiance, and its quality (steps, voxels a side, nodes, digits, KiB); the fastest method of a column is shaded.{}",
            explained(results)
        ),
    );
    for line in lines(results) {
        let own = results.measurements.iter().filter(|m| line.holds(m));
        let mut cells = vec![name(results, line)];
        for target in TARGETS {
            let winner = fastest_within(results.representative(), None, target);
            cells.push(match fastest_within(own.clone(), None, target) {
                Some(m) => Cell {
                    shaded: winner.is_some_and(|winner| std::ptr::eq(winner, m)),
                    mark: mark(m),
                    aside: m.quality.to_string(),
                    ..m.frame.median.into()
                },
                None => Cell {
                    aside: "–".into(),
                    ..Cell::from("")
                },
            });
        }
        let best = own.map(|m| m.error.rmse).fold(f64::INFINITY, f64::min);
        cells.push(best.into());
        rows.push(cells);
    }
    html! {
        h2 { "Time to reach an error" }
        (table(&rows))
    }
}

/// A line's name with its colour and marker.
fn name(results: &Results, line: Line<'_>) -> Cell {
    Cell::keyed(line.name(results), line.key(results))
}

/// What stands behind a time that is not representative.
fn mark(m: &Measurement) -> &'static str {
    if m.representative { "" } else { "*" }
}

/// What the mark means, if it is used.
fn explained(results: &Results) -> &'static str {
    if results.software().is_some() {
        " Times with an asterisk are those of a software adapter and not representative."
    } else {
        ""
    }
}

/// One row per measurement.
pub(super) fn measurements(results: &Results) -> Markup {
    if results.measurements.is_empty() {
        return Markup::default();
    }
    let unit = if results.reference.absolute {
        Unit::Number
    } else {
        Unit::Share
    };
    let mut rows = Table::new(vec![
        Column::plain("method"),
        Column::plain("quality"),
        Column::new("RMSE", unit),
        Column::new("max", unit),
        Column::new("p99", unit),
        Column::new("build", Unit::Seconds),
        Column::new("frame", Unit::Seconds),
        Column {
            soft: true,
            ..Column::plain("fastest – slowest")
        },
        Column::new("memory", Unit::Bytes),
    ]);
    rows.grouped = true;
    let points: Vec<Option<(f64, f64)>> = results
        .measurements
        .iter()
        .map(|m| m.representative.then_some((m.frame.median, m.error.rmse)))
        .collect();
    let front = pareto(&points);
    for line in lines(results) {
        for (m, best) in results.measurements.iter().zip(&front) {
            if !line.holds(m) {
                continue;
            }
            let marked = |time: f64| Cell {
                mark: if time > 0.0 { mark(m) } else { "" },
                ..time.into()
            };
            let cells = vec![
                name(results, line),
                format!("{} {}", m.quality, results.methods[m.method].quality).into(),
                m.error.rmse.into(),
                m.error.max.into(),
                m.error.rel_p99.into(),
                marked(m.seconds_build),
                marked(m.frame.median),
                format!("{} – {}", seconds(m.frame.low), seconds(m.frame.high)).into(),
                m.bytes.into(),
            ];
            rows.push_row(cells, *best);
        }
    }
    html! {
        h2 { "All measurements" }
        p.soft {
            "The same as in " code { "results.csv" } ". Shaded rows are on the front of error against frame time."
            (explained(results))
        }
        (table(&rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::example;

    #[test]
    fn each_method_is_named_once_in_the_table_of_measurements() {
        let results = example();
        let html = measurements(&results).into_string();
        let methods = results.methods.len();
        assert_eq!(html.matches("class=\"first").count(), methods);
        assert_eq!(html.matches("<tr").count(), 1 + results.measurements.len());
    }
}
