//! The plots of the main results: one large plot of error against frame time, and
//! others on demand.

use maud::{Markup, html};

use super::front::{Curve, Floor, Plot, Setting, front};
use super::names::short_title;
use super::section::charts;
use crate::compare::results::{Measurement, Results};
use crate::compare::study::{Axis, Chart, Charts, Key, Point, Scale, Series, Shape, Unit};
use crate::format::{error, seconds};

/// The plot of the first screen.
pub(super) fn first(results: &Results) -> Markup {
    if results.measurements.is_empty() {
        return Markup::default();
    }
    let Some(plot) = front(&plot(results, AT_REST)) else {
        return html! {
            p { "All errors are 0 or not finite: there is nothing to plot." }
        };
    };
    html! {
        figure #plot {
            figcaption {
                b { "Error against the time of a frame." }
                " Down and to the left is better. In colour: plain ray marching, and methods that at some setting no other method beats in both; the wide line is the front that they form. In grey: the others. Numbers are steps, voxels per axis, Gauss nodes, digits or KiB."
            }
            (plot)
        }
    }
}

/// The other plots, folded.
pub(super) fn others(results: &Results) -> Markup {
    let representative: Vec<Line<'_>> = representative(results);
    if representative.is_empty() {
        return Markup::default();
    }
    html! {
        @if let Some(plot) = front(&plot(results, MOVING)) {
            details {
                summary { "Plot: everything moves (build and frame together)" }
                figure {
                    figcaption { "The time for what has to be built first, a BVH or shadow maps, is added to every frame." }
                    (plot)
                }
            }
        }
        details {
            summary { "Plot: every method in its colour" }
            (charts(&Charts {
                share_legend: true,
                all: vec![chart(results, &representative)],
            }))
        }
    }
}

/// The chart of the methods on a software GPU.
pub(super) fn of_software(results: &Results, lines: &[Line<'_>]) -> Markup {
    charts(&Charts {
        share_legend: true,
        all: vec![chart(results, lines)],
    })
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

impl<'a> Line<'a> {
    pub(super) fn holds(&self, m: &Measurement) -> bool {
        m.method == self.method && m.backend == self.backend
    }

    /// Its measurements, in rising quality.
    pub(super) fn of<'r>(
        self,
        results: &'r Results,
    ) -> impl Iterator<Item = &'r Measurement> + Clone + use<'r, 'a> {
        results.measurements.iter().filter(move |m| self.holds(m))
    }

    /// Its colour and marker: second and further backends are dashed, and so is a
    /// method whose maps are refined, which has the colour of the same with one map.
    pub(super) fn key(&self, results: &Results) -> Key {
        let own = &results.methods[self.method];
        let first = results.backends.first();
        let mut all = results.methods.iter();
        let plain = all.position(|method| method.name == own.name);
        Key {
            slot: plain.unwrap_or(self.method) % COLOURS,
            dashed: own.refines_map || first.is_some_and(|first| first != self.backend),
        }
    }

    /// The method's short name, with the backend where several compete.
    pub(super) fn name(&self, results: &Results) -> String {
        let title = short_title(&results.methods[self.method].title);
        let software = results.software() == Some(self.backend);
        if results.several_compete() && !software {
            format!("{title}, {}", short_name(self.backend, true))
        } else {
            title
        }
    }
}

/// All measurements, method by method and backend by backend, in the order of
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

/// The name of a backend where there is little space; the head of the page has its full name.
pub(crate) fn short_name(backend: &str, representative: bool) -> String {
    let kind = backend.split(" (").next().unwrap_or(backend);
    if representative {
        kind.into()
    } else {
        format!("{kind} (software)")
    }
}

/// The lines whose times mean something.
pub(super) fn representative(results: &Results) -> Vec<Line<'_>> {
    let software = results.software();
    let mut all = lines(results);
    all.retain(|line| software != Some(line.backend));
    all
}

/// The lines of a software GPU.
pub(super) fn software(results: &Results) -> Vec<Line<'_>> {
    let software = results.software();
    let mut all = lines(results);
    all.retain(|line| software == Some(line.backend));
    all
}

/// The time that counts for a setting.
#[derive(Clone, Copy)]
struct Clock {
    label: &'static str,
    /// The time that is added to that of the frame.
    extra: fn(&Measurement) -> f64,
}

const AT_REST: Clock = Clock {
    label: "time of a frame",
    extra: |_| 0.0,
};

const MOVING: Clock = Clock {
    label: "time of build and frame",
    extra: |m| m.seconds_build,
};

/// The name of errors along an axis.
fn error_axis(results: &Results) -> (&'static str, Unit) {
    if results.reference.absolute {
        ("error: RMSE, in units of radiance", Unit::Number)
    } else {
        ("error: RMSE ÷ mean radiance", Unit::Share)
    }
}

/// A setting in words, with its error and its time.
fn told(results: &Results, m: &Measurement, time: f64) -> String {
    format!(
        "{}: {} in {}",
        results.methods[m.method].setting(m.quality),
        error(m.error.rmse, results.reference.absolute),
        seconds(time)
    )
}

fn plot(results: &Results, clock: Clock) -> Plot {
    let setting = |m: &Measurement| {
        let extra = (clock.extra)(m);
        Setting {
            seconds: m.frame.median + extra,
            error: m.error.rmse,
            spread: [m.frame.low + extra, m.frame.high + extra],
            quality: m.quality.to_string(),
            title: told(results, m, m.frame.median + extra),
        }
    };
    let curve = |line: Line<'_>| Curve {
        name: line.name(results),
        key: line.key(results),
        is_baseline: results.methods[line.method].is_baseline,
        points: line.of(results).map(setting).collect(),
    };
    let (error, unit) = error_axis(results);
    Plot {
        time: clock.label,
        error,
        unit,
        floor: results.floors.first().map(|floor| Floor {
            error: floor.rmse,
            name: format!("exact lit runs of {0} × {0} shadow maps", floor.map),
            short: format!("{0} × {0} shadow maps", floor.map),
        }),
        curves: representative(results).into_iter().map(curve).collect(),
    }
}

/// The lines as a chart with a legend.
fn chart(results: &Results, lines: &[Line<'_>]) -> Chart {
    let point = |m: &Measurement| Point {
        x: m.frame.median,
        y: m.error.rmse,
        spread: [m.frame.low, m.frame.high],
        label: m.quality.to_string(),
        title: told(results, m, m.frame.median),
    };
    let series = |line: &Line<'_>| Series {
        name: line.name(results),
        aside: results.methods[line.method].name.replace(" x ", " × "),
        key: line.key(results),
        competes: true,
        shape: Shape::Points,
        points: line.of(results).map(point).collect(),
    };
    let (error, unit) = error_axis(results);
    Chart {
        title: String::new(),
        caption: String::new(),
        description: "RMSE of the airlight against the time of a frame, both logarithmic".into(),
        x: Axis {
            label: AT_REST.label.into(),
            scale: Scale::Log,
            unit: Unit::Seconds,
        },
        y: Axis {
            label: error.into(),
            scale: Scale::Log,
            unit,
        },
        front: true,
        series: lines.iter().map(series).collect(),
    }
}
