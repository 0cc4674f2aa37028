//! Times to reach an error, and everything that was measured.

use std::fmt::Write;

use super::chart::swatch;
use super::plots::{is_dashed, series, series_name};
use super::summary::TARGETS;
use crate::compare::results::{Measurement, Results, fastest_within, pareto};
use crate::format::{bytes, error, escape, seconds};

/// One row per method: the fastest setting within each error.
pub(super) fn write_targets(html: &mut String, results: &Results) {
    if results.measurements.is_empty() || results.reference.absolute {
        return;
    }
    let _ = write!(
        html,
        "<h2>Time to reach an error</h2>\n<p class=\"soft\">Fastest measured frame whose RMSE is at most the given share of the mean radiance, and its quality (steps, voxels a side, nodes, digits, KiB); the fastest method of a column is shaded.{}</p>\n<div class=\"wide\"><table>\n<tr><th>method</th>",
        explained(results)
    );
    for target in TARGETS {
        let _ = write!(html, "<th>{}</th>", error(target, false));
    }
    html.push_str("<th>best error</th></tr>\n");
    for (slot, method, backend) in series(results) {
        let own = results
            .measurements
            .iter()
            .filter(|m| std::ptr::eq(m.method, method) && m.backend == backend);
        let _ = write!(
            html,
            "<tr><td><span class=\"name\">{} {}</span></td>",
            swatch(slot, is_dashed(results, backend)),
            series_name(results, method, backend)
        );
        for target in TARGETS {
            let winner = fastest_within(results.representative(), None, target);
            let Some(m) = fastest_within(own.clone(), None, target) else {
                html.push_str("<td class=\"soft\">–</td>");
                continue;
            };
            let won = winner.is_some_and(|w| std::ptr::eq(w, m));
            let class = if won { " class=\"won\"" } else { "" };
            let _ = write!(
                html,
                "<td{class}>{}{} <span class=\"soft\">{}</span></td>",
                seconds(m.frame.median),
                mark(m),
                m.quality
            );
        }
        let best = own.map(|m| m.error.rmse).fold(f64::INFINITY, f64::min);
        let _ = writeln!(html, "<td>{}</td></tr>", error(best, false));
    }
    html.push_str("</table></div>\n");
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
pub(super) fn write_measurements(html: &mut String, results: &Results) {
    if results.measurements.is_empty() {
        return;
    }
    let absolute = results.reference.absolute;
    let _ = write!(
        html,
        "<h2>All measurements</h2>\n<p class=\"soft\">The same as in <code>results.csv</code>. Shaded rows are on the front of error against frame time.{}</p>\n<div class=\"wide\"><table>\n<tr><th>method</th><th>quality</th><th>RMSE</th><th>max</th><th>p99</th><th>build</th><th>frame</th><th>fastest – slowest</th><th>memory</th></tr>\n",
        explained(results)
    );
    let points: Vec<Option<(f64, f64)>> = results
        .measurements
        .iter()
        .map(|m| m.representative.then_some((m.frame.median, m.error.rmse)))
        .collect();
    let front = pareto(&points);
    for (slot, method, backend) in series(results) {
        let mut first = true;
        for (m, best) in results.measurements.iter().zip(&front) {
            if !std::ptr::eq(m.method, method) || m.backend != backend {
                continue;
            }
            let class = match (first, *best) {
                (true, true) => " class=\"first best\"",
                (true, false) => " class=\"first\"",
                (false, true) => " class=\"best\"",
                (false, false) => "",
            };
            let name = if first {
                format!(
                    "<span class=\"name\">{} {}</span>",
                    swatch(slot, is_dashed(results, backend)),
                    series_name(results, method, backend)
                )
            } else {
                String::new()
            };
            first = false;
            let _ = writeln!(
                html,
                "<tr{class}><td>{name}</td><td>{} {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}{}</td><td>{}{}</td><td class=\"soft\">{} – {}</td><td>{}</td></tr>",
                m.quality,
                escape(m.method.quality_name()),
                error(m.error.rmse, absolute),
                error(m.error.max, absolute),
                error(m.error.rel_p99, absolute),
                seconds(m.seconds_build),
                if m.seconds_build > 0.0 { mark(m) } else { "" },
                seconds(m.frame.median),
                mark(m),
                seconds(m.frame.low),
                seconds(m.frame.high),
                bytes(m.bytes),
            );
        }
    }
    html.push_str("</table></div>\n");
}
