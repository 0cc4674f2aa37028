//! The two plots of the main results: without and with the time to build.

use maud::{Markup, html};

use super::section::charts;
use crate::compare::results::{Measurement, Results};
use crate::compare::study::{Axis, Chart, Charts, Key, Point, Scale, Series, Shape, Unit};
use crate::format::{error, seconds};

pub(super) fn section(results: &Results) -> Markup {
    let plots = Charts {
        share_legend: true,
        all: vec![
            Chart {
                title: "Light and scene at rest".into(),
                caption: "time of a frame".into(),
                ..plot(results, "frame time", |_| 0.0)
            },
            Chart {
                title: "Everything moves".into(),
                caption: "build and frame together".into(),
                ..plot(results, "build + frame time", |m| m.seconds_build)
            },
        ],
    };
    let is_shown = |m: &Measurement| m.error.rmse > 0.0 && m.error.rmse.is_finite();
    let any = results.measurements.iter().any(is_shown);
    html! {
        @if !results.measurements.is_empty() {
            h2 { "Error against time" }
            (charts(&plots))
            @if any {
                p.soft { "Down and to the left is better. Numbers beside the ends of a curve are its quality: steps, voxels a side, nodes, digits or KiB. A ring marks a setting that no other beats in both time and error; the wide grey line is the front they form." }
            } @else {
                p { "All errors are 0 or not finite: there is nothing to plot." }
            }
        }
    }
}

/// Colours of the style sheet. Methods beyond share one, with another marker.
pub(super) const COLOURS: usize = 20;

/// The measurements of one method on one backend.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    /// Index into [`Results::methods`], which is also its colour, as far as they go.
    pub(super) method: usize,
    pub(super) backend: &'a str,
}

impl Line<'_> {
    pub(super) fn holds(&self, m: &Measurement) -> bool {
        m.method == self.method && m.backend == self.backend
    }

    /// Its colour and marker: second and further backends are dashed.
    pub(super) fn key(&self, results: &Results) -> Key {
        let first = results.backends.first();
        Key {
            slot: self.method % COLOURS,
            dashed: first.is_some_and(|first| first != self.backend),
        }
    }

    /// The method's title, with the backend where there are several.
    pub(super) fn name(&self, results: &Results) -> String {
        let title = &results.methods[self.method].title;
        if results.backends.len() > 1 {
            let representative = results.software() != Some(self.backend);
            format!("{title}, {}", short_name(self.backend, representative))
        } else {
            title.clone()
        }
    }
}

/// What was measured, method by method and backend by backend, in the order of
/// [`Results::methods`].
pub(super) fn lines(results: &Results) -> Vec<Line<'_>> {
    let mut all = Vec::new();
    for method in 0..results.methods.len() {
        for backend in &results.backends {
            let line = Line { method, backend };
            if results.measurements.iter().any(|m| line.holds(m)) {
                all.push(line);
            }
        }
    }
    all
}

/// What a backend is called where there is little space; the head of the page
/// has its full name.
pub(crate) fn short_name(backend: &str, representative: bool) -> String {
    let kind = backend.split(" (").next().unwrap_or(backend);
    if representative {
        kind.into()
    } else {
        format!("{kind} (software)")
    }
}

fn plot(results: &Results, time: &str, build: fn(&Measurement) -> f64) -> Chart {
    let absolute = results.reference.absolute;
    let point = |m: &Measurement| {
        let extra = build(m);
        let method = &results.methods[m.method];
        Point {
            x: m.frame.median + extra,
            y: m.error.rmse,
            spread: [m.frame.low + extra, m.frame.high + extra],
            label: m.quality.to_string(),
            title: format!(
                "{}, {} {}: {} in {}",
                method.title,
                m.quality,
                method.quality,
                error(m.error.rmse, absolute),
                seconds(m.frame.median + extra)
            ),
        }
    };
    let series = |line: Line<'_>| Series {
        name: line.name(results),
        aside: results.methods[line.method].name.replace(" x ", " × "),
        key: line.key(results),
        competes: results.software() != Some(line.backend),
        shape: Shape::Points,
        points: results
            .measurements
            .iter()
            .filter(|m| line.holds(m))
            .map(point)
            .collect(),
    };
    Chart {
        title: String::new(),
        caption: String::new(),
        description: format!("RMSE of the airlight against {time}, both logarithmic"),
        x: Axis {
            label: time.into(),
            scale: Scale::Log,
            unit: Unit::Seconds,
        },
        y: Axis {
            label: if absolute {
                "RMSE (radiance)".into()
            } else {
                "RMSE / mean radiance".into()
            },
            scale: Scale::Log,
            unit: if absolute { Unit::Number } else { Unit::Share },
        },
        front: true,
        series: lines(results).into_iter().map(series).collect(),
    }
}
