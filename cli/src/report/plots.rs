//! The two plots: without and with the time to build.

use std::fmt::Write;

use super::chart::{Curve, Labels, Point, chart, swatch};
use crate::compare::results::{Measurement, Results};
use crate::format::{error, escape, seconds};
use crate::methods::{METHODS, Method};

pub(super) fn write(html: &mut String, results: &Results) {
    if results.measurements.is_empty() {
        return;
    }
    html.push_str("<h2>Error against time</h2>\n");
    legend(html, results);
    let frame = plot(results, "frame time", |_| 0.0);
    let whole = plot(results, "build + frame time", |m| m.seconds_build);
    let (Some(frame), Some(whole)) = (frame, whole) else {
        html.push_str("<p>All errors are 0: there is nothing to plot.</p>\n");
        return;
    };
    let _ = write!(
        html,
        "<div class=\"plots\">\n\
<figure><figcaption><b>Light and scene at rest</b>: time of a frame.</figcaption><div class=\"wide\">{frame}</div></figure>\n\
<figure><figcaption><b>Everything moves</b>: build and frame together.</figcaption><div class=\"wide\">{whole}</div></figure>\n</div>\n"
    );
    html.push_str("<p class=\"soft\">Down and to the left is better. Numbers beside the ends of a curve are its quality: steps, voxels a side, nodes, digits or KiB. A ring marks a setting that no other beats in both time and error; the wide grey line is the front they form.</p>\n");
}

/// Methods and backends in the order of the registry.
pub(super) fn series(results: &Results) -> Vec<(usize, &'static Method, &str)> {
    let mut all = Vec::new();
    for (slot, method) in METHODS.iter().enumerate() {
        for backend in &results.backends {
            let measured =
                |m: &Measurement| std::ptr::eq(m.method, method) && m.backend == *backend;
            if results.measurements.iter().any(measured) {
                all.push((slot, method, backend.as_str()));
            }
        }
    }
    all
}

/// True for all backends but the first.
pub(super) fn is_dashed(results: &Results, backend: &str) -> bool {
    results
        .backends
        .first()
        .is_some_and(|first| first != backend)
}

/// What a backend is called where there is little space; the head of the page
/// has its full name.
pub(super) fn short_name(results: &Results, backend: &str) -> String {
    let kind = backend.split(" (").next().unwrap_or(backend);
    if results.software() == Some(backend) {
        format!("{} (software)", escape(kind))
    } else {
        escape(kind)
    }
}

/// A method's title, with the backend where there are several.
pub(super) fn series_name(results: &Results, method: &Method, backend: &str) -> String {
    if results.backends.len() > 1 {
        format!("{}, {}", method.title, short_name(results, backend))
    } else {
        method.title.into()
    }
}

fn legend(html: &mut String, results: &Results) {
    html.push_str("<ul class=\"legend\">\n");
    for (slot, method, backend) in series(results) {
        let _ = writeln!(
            html,
            "<li>{}<span>{} <span class=\"soft\">{}</span></span></li>",
            swatch(slot, is_dashed(results, backend)),
            series_name(results, method, backend),
            method.name().replace(" x ", " × "),
        );
    }
    html.push_str("</ul>\n");
}

fn plot(results: &Results, time: &str, build: fn(&Measurement) -> f64) -> Option<String> {
    let absolute = results.reference.absolute;
    let point = |m: &Measurement| {
        let extra = build(m);
        Point {
            time: m.frame.median + extra,
            spread: (m.frame.low + extra, m.frame.high + extra),
            error: m.error.rmse,
            label: m.quality.to_string(),
            title: format!(
                "{}, {} {}: {} in {}",
                m.method.title,
                m.quality,
                m.method.quality_name(),
                error(m.error.rmse, absolute),
                seconds(m.frame.median + extra)
            ),
        }
    };
    let curves: Vec<Curve> = series(results)
        .into_iter()
        .map(|(slot, method, backend)| Curve {
            slot,
            dashed: is_dashed(results, backend),
            competes: results.software() != Some(backend),
            points: results
                .measurements
                .iter()
                .filter(|m| std::ptr::eq(m.method, method) && m.backend == backend)
                .map(point)
                .collect(),
        })
        .collect();
    chart(
        &curves,
        &Labels {
            description: &format!("RMSE of the airlight against {time}, both logarithmic"),
            time,
            error: if absolute {
                "RMSE (radiance)"
            } else {
                "RMSE / mean radiance"
            },
            write_time: &seconds,
            write_error: &|value| error(value, absolute),
        },
    )
}
