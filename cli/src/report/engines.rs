//! Methods of game engines, beside other methods on the same kind of maps.

use maud::{Markup, html};

use super::names::short_title;
use super::plots::{Line, representative};
use super::section::table;
use crate::compare::results::{Measurement, Results};
use crate::compare::study::{Cell, Column, Table, Unit};
use crate::format::significant;

/// Nothing if no such method was measured.
pub(super) fn section(results: &Results) -> Markup {
    html! {
        @if let Some(rows) = rows(results, &representative(results)) {
            h2 { "Methods of game engines" }
            (table(&rows))
        }
    }
}

/// A row for each measurement of a method of engines.
fn rows(results: &Results, lines: &[Line<'_>]) -> Option<Table> {
    if results.reference.absolute {
        return None;
    }
    let mut rows = Table::new(vec![
        Column::plain("method"),
        Column::plain("quality"),
        Column::new("RMSE", Unit::Share),
        Column::new("map", Unit::Share),
        Column::new("frame", Unit::Seconds),
        Column::new("in its time", Unit::Share),
        Column::plain("better"),
        Column::new("to its error", Unit::Seconds),
        Column::plain("faster"),
    ])
    .titled(
        "",
        "Map: the error of the exact lit runs of its shadow map. In its time: the smallest error of the other methods that use shadow maps, among frames that take no longer. To its error: the fastest frame of these methods among those whose error is no larger.",
    );
    rows.grouped = true;
    let of_engines = |line: &&Line<'_>| results.methods[line.method].is_of_engines;
    for line in lines.iter().filter(of_engines) {
        for m in line.of(results) {
            let others = || {
                let own = results.representative();
                own.filter(|other| other.backend == m.backend && is_rival(results, other))
            };
            let in_time = others()
                .filter(|other| other.frame.median <= m.frame.median)
                .min_by(|a, b| a.error.rmse.total_cmp(&b.error.rmse));
            let to_error = others()
                .filter(|other| other.error.rmse <= m.error.rmse)
                .min_by(|a, b| a.frame.median.total_cmp(&b.frame.median));
            let rival = |other: Option<&Measurement>, value: fn(&Measurement) -> f64| match other {
                Some(other) => [
                    Cell {
                        aside: setting(results, other),
                        ..value(other).into()
                    },
                    times(value(m) / value(other)).into(),
                ],
                None => [Cell::from("–"), Cell::from("–")],
            };
            let mut cells = vec![
                Cell::keyed(line.name(results), line.key(results)),
                m.quality.into(),
                m.error.rmse.into(),
                results.floor(m).map_or_else(|| Cell::from("–"), Cell::from),
                m.frame.median.into(),
            ];
            cells.extend(rival(in_time, |m| m.error.rmse));
            cells.extend(rival(to_error, |m| m.frame.median));
            rows.push(cells);
        }
    }
    (!rows.rows().is_empty()).then_some(rows)
}

/// Whether it looks into shadow maps, and not as engines do.
fn is_rival(results: &Results, m: &Measurement) -> bool {
    let method = &results.methods[m.method];
    method.samples_shadow_map && !method.is_of_engines
}

/// A method at a quality, in few letters.
fn setting(results: &Results, m: &Measurement) -> String {
    let title = short_title(&results.methods[m.method].title);
    format!("{title}, {}", m.quality)
}

fn times(ratio: f64) -> String {
    format!("{}×", significant(ratio))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::example;

    #[test]
    fn what_engines_do_is_beside_the_best_in_its_time_and_the_fastest_to_its_error() {
        let mut results = example();
        assert!(rows(&results, &representative(&results)).is_none());
        let march = results.methods.iter().position(|m| m.is_baseline).unwrap();
        results.methods[march].is_of_engines = true;
        let table = rows(&results, &representative(&results)).unwrap();
        let steps = results.measurements.iter().filter(|m| m.method == march);
        assert_eq!(table.rows().len(), steps.count());
        // Errors are 0.5 / n of n steps, for the equi-angular ones 0.5 / n²; n steps take
        // n ms of either. Nothing is faster than four steps.
        for (row, better, faster) in [(0, "4×", "1×"), (2, "16×", "4×"), (6, "256×", "16×")] {
            let cells = &table.rows()[row].cells;
            assert_eq!(cells[6].text(), Some(better), "{row}");
            assert_eq!(cells[8].text(), Some(faster), "{row}");
        }
        let html = section(&results).into_string();
        assert!(html.contains("Methods of game engines") && html.contains("equi-angular steps"));
    }
}
