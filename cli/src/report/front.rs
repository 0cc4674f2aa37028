//! The large plot of error against time, with the Pareto front labelled on the
//! curve itself. It is drawn twice, for wide and for narrow screens.

use std::collections::BTreeSet;
use std::fmt::Write;

use maud::{Markup, html};

use super::axis::{Ruler, Tick};
use super::chart::marker;
use super::labels::{Labels, Placed, Rect, Wanted, anchored, width};
use super::numbers::written;
use crate::compare::results::pareto;
use crate::compare::study::{Key, Scale, Unit};

/// One method on one backend, as the plot knows it.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    pub(super) name: String,
    pub(super) key: Key,
    /// Others are compared with it: it is drawn in its colour and labelled even
    /// where the front passes it by.
    pub(super) is_baseline: bool,
    pub(super) points: Vec<Setting>,
}

/// One quality of it.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    pub(super) seconds: f64,
    pub(super) error: f64,
    /// The fastest and the slowest of several frames.
    pub(super) spread: [f64; 2],
    pub(super) quality: String,
    /// Shown while a pointer rests on it.
    pub(super) title: String,
}

impl Setting {
    /// True if it has a place on logarithmic axes.
    fn is_shown(&self) -> bool {
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        is_positive(self.seconds) && is_positive(self.error)
    }
}

/// The data of the plot.
#[derive(Debug, Clone)]
pub(super) struct Plot {
    pub(super) time: &'static str,
    pub(super) error: &'static str,
    pub(super) unit: Unit,
    pub(super) floor: Option<Floor>,
    pub(super) curves: Vec<Curve>,
}

/// An error at which some of the methods level out.
#[derive(Debug, Clone)]
pub(super) struct Floor {
    pub(super) error: f64,
    pub(super) name: String,
    /// The same where there is less room.
    pub(super) short: String,
}

/// Size and margins of a picture; letters are of a size that is read where a
/// picture of that width is shown.
#[derive(Debug, Clone, Copy)]
struct Format {
    class: &'static str,
    width: f64,
    height: f64,
    letters: f64,
    /// How far a name may be from its point.
    reach: f64,
}

const WIDE: Format = Format {
    class: "chart front-plot on-wide",
    width: 1080.0,
    height: 540.0,
    letters: 15.0,
    reach: 280.0,
};

const NARROW: Format = Format {
    class: "chart front-plot on-narrow",
    width: 400.0,
    height: 560.0,
    letters: 13.0,
    reach: 280.0,
};

/// Room above the plot for the name of the axis of errors, beside it for half of
/// the last tick's number, below it for numbers and the name of the axis of times.
const TOP: f64 = 32.0;
const RIGHT: f64 = 22.0;
const BOTTOM: f64 = 52.0;

/// Room between the numbers of the axis of errors and the plot.
const GAP: f64 = 8.0;

/// Half the side of a marker with a little room.
const MARKER: f64 = 6.5;
const SMALL_MARKER: f64 = 3.5;

/// The plot for both kinds of screen; `None` if no error is positive and finite.
pub(super) fn front(plot: &Plot) -> Option<Markup> {
    let [wide, narrow] = [WIDE, NARROW].map(|format| Drawing::new(plot, format));
    let (wide, narrow) = (wide?, narrow?);
    Some(html! {
        (wide.draw())
        (narrow.draw())
    })
}

/// A plot in a format.
struct Drawing<'a> {
    plot: &'a Plot,
    format: Format,
    area: Rect,
    x: Ruler,
    y: Ruler,
    /// Per curve, per point: no other point is as fast and better, or as good and
    /// faster.
    on_front: Vec<Vec<bool>>,
}

impl<'a> Drawing<'a> {
    fn new(plot: &'a Plot, format: Format) -> Option<Self> {
        let all = || plot.curves.iter().flat_map(|curve| &curve.points);
        let shown = || all().filter(|p| p.is_shown());
        let across = shown().flat_map(|p| [p.seconds, p.spread[0], p.spread[1]]);
        let (right, bottom) = (format.width - RIGHT, format.height - BOTTOM);
        let floor = plot.floor.as_ref().map(|floor| floor.error);
        let up = shown().map(|p| p.error).chain(floor);
        let y = Ruler::new(Scale::Log, up, (bottom, TOP), 4)?;
        // The numbers of the ticks stand in front of the plot.
        let width = |tick: Tick| width(&written(tick.value, plot.unit), format.letters);
        let labelled = y.ticks().into_iter().filter(|tick| tick.labelled);
        let area = Rect {
            left: labelled.map(width).fold(0.0, f64::max) + GAP,
            top: TOP,
            right,
            bottom,
        };
        let x = Ruler::new(Scale::Log, across, (area.left, area.right), 6)?;
        let points: Vec<Option<(f64, f64)>> = all()
            .map(|p| p.is_shown().then_some((p.seconds, p.error)))
            .collect();
        let mut flags = pareto(&points);
        let mut on_front = Vec::new();
        for curve in &plot.curves {
            let rest = flags.split_off(curve.points.len());
            on_front.push(std::mem::replace(&mut flags, rest));
        }
        Some(Self {
            plot,
            format,
            area,
            x,
            y,
            on_front,
        })
    }

    fn at(&self, point: &Setting) -> (f64, f64) {
        (self.x.position(point.seconds), self.y.position(point.error))
    }

    /// True if the curve is drawn in its own colour.
    fn stands_out(&self, curve: usize) -> bool {
        self.plot.curves[curve].is_baseline || self.on_front[curve].contains(&true)
    }

    fn draw(&self) -> Markup {
        let Format {
            class,
            width,
            height,
            ..
        } = self.format;
        let curves = || self.plot.curves.iter().enumerate();
        let front = self.members();
        html! {
            svg class=(class) viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=(self.description(&front)) {
                (self.grid())
                path.front d=(self.staircase(&front)) {}
                @if let Some(floor) = self.floor() {
                    path.floor d={ "M" (self.area.left) " " (pixels(self.y.position(floor.error))) "H" (self.area.right) } {}
                }
                @for (index, curve) in curves().filter(|(index, _)| !self.stands_out(*index)) {
                    (self.curve(index, curve))
                }
                @for (index, curve) in curves().filter(|(index, _)| self.stands_out(*index)) {
                    (self.curve(index, curve))
                }
                (self.labels(&front))
            }
        }
    }

    /// The floor, if it has a place on a logarithmic axis.
    fn floor(&self) -> Option<&Floor> {
        let floor = self.plot.floor.as_ref();
        floor.filter(|floor| floor.error > 0.0 && floor.error.is_finite())
    }

    /// The name of the floor, above or below its line, at its right or left end.
    fn name_of_floor(&self, labels: &mut Labels) -> Option<(Rect, &str)> {
        let floor = self.floor()?;
        let letters = self.format.letters;
        let y = self.y.position(floor.error);
        let height = 1.25 * letters;
        for text in [&floor.name, &floor.short] {
            let width = width(text, letters);
            for top in [y - height - 2.0, y + 2.0] {
                for left in [self.area.right - width, self.area.left + 6.0] {
                    let rect = Rect {
                        left,
                        top,
                        right: left + width,
                        bottom: top + height,
                    };
                    if labels.take(rect) {
                        return Some((rect, text));
                    }
                }
            }
        }
        None
    }

    /// Curve and point of everything on the front, from the fastest on.
    fn members(&self) -> Vec<(usize, usize)> {
        let mut all: Vec<(usize, usize)> = Vec::new();
        for (curve, flags) in self.on_front.iter().enumerate() {
            let points = flags.iter().enumerate().filter(|(_, is_on)| **is_on);
            all.extend(points.map(|(point, _)| (curve, point)));
        }
        let seconds = |at: &(usize, usize)| self.setting(*at).seconds;
        all.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
        all
    }

    fn setting(&self, (curve, point): (usize, usize)) -> &Setting {
        &self.plot.curves[curve].points[point]
    }

    /// The front in words.
    fn description(&self, front: &[(usize, usize)]) -> String {
        let mut text = format!(
            "{} against {}, both logarithmic. The front, from fast to exact: ",
            self.plot.error, self.plot.time
        );
        let titles: Vec<&str> = front
            .iter()
            .map(|at| self.setting(*at).title.as_str())
            .collect();
        text += &titles.join("; ");
        text + "."
    }

    fn grid(&self) -> Markup {
        let Rect {
            left,
            top,
            right,
            bottom,
        } = self.area;
        let class = |tick: &Tick| if tick.labelled { "grid major" } else { "grid" };
        let (across, up) = (self.x.ticks(), self.y.ticks());
        let across = self.readable(across);
        html! {
            @for tick in &across {
                path class=(class(tick)) d={ "M" (pixels(tick.position)) " " (top) "V" (bottom) } {}
                @if tick.labelled {
                    text.tick x=(pixels(tick.position)) y=(bottom + 20.0) text-anchor="middle" { (written(tick.value, Unit::Seconds)) }
                }
            }
            @for tick in &up {
                path class=(class(tick)) d={ "M" (left) " " (pixels(tick.position)) "H" (right) } {}
                @if tick.labelled {
                    text.tick x=(pixels(left - GAP)) y=(pixels(tick.position + 5.0)) text-anchor="end" { (written(tick.value, self.plot.unit)) }
                }
            }
            text.axis x="0" y="16" { (self.plot.error) }
            text.axis x=(right) y=(self.format.height - 8.0) text-anchor="end" { (self.plot.time) " →" }
        }
    }

    /// The ticks without numbers that would run into the one before.
    fn readable(&self, mut ticks: Vec<Tick>) -> Vec<Tick> {
        let mut free = f64::NEG_INFINITY;
        for tick in ticks.iter_mut().filter(|tick| tick.labelled) {
            let text = written(tick.value, Unit::Seconds);
            let half = 0.5 * width(&text, self.format.letters);
            tick.labelled = tick.position - half > free;
            if tick.labelled {
                free = tick.position + half + 4.0;
            }
        }
        ticks
    }

    /// The least error within a time, as a staircase.
    fn staircase(&self, front: &[(usize, usize)]) -> String {
        let mut path = String::new();
        for (index, at) in front.iter().enumerate() {
            let (x, y) = self.at(self.setting(*at));
            // Writing to a string cannot fail.
            let _ = match index {
                0 => write!(path, "M{x:.1} {}V{y:.1}", self.area.top),
                _ => write!(path, "H{x:.1}V{y:.1}"),
            };
        }
        if !path.is_empty() {
            let _ = write!(path, "H{}", self.area.right);
        }
        path
    }

    /// The points of a method, joined; those on the front have its marker and
    /// their spread.
    fn curve(&self, index: usize, curve: &Curve) -> Markup {
        let slot = curve.key.slot;
        let mut path = String::new();
        for (number, point) in curve.points.iter().filter(|p| p.is_shown()).enumerate() {
            let (x, y) = self.at(point);
            let _ = write!(path, "{}{x:.1} {y:.1}", if number == 0 { 'M' } else { 'L' });
        }
        let colour = if self.stands_out(index) {
            format!("m{slot}")
        } else {
            "other".into()
        };
        let dash = if curve.key.dashed { " dashed" } else { "" };
        let points = || curve.points.iter().zip(&self.on_front[index]);
        html! {
            path class={ "line " (colour) (dash) } d=(path) {}
            @for (point, is_on) in points().filter(|(point, _)| point.is_shown()) {
                @let (x, y) = self.at(point);
                @if *is_on {
                    @let [low, high] = point.spread.map(|x| self.x.position(x));
                    @if high - low > 1.0 {
                        path class={ "spread " (colour) } d={ "M" (pixels(low)) " " (pixels(y)) "H" (pixels(high)) } {}
                    }
                    (marker(slot, (x, y), &point.title))
                } @else {
                    circle class={ "dot " (colour) } cx=(pixels(x)) cy=(pixels(y)) r="3" {
                        title { (point.title) }
                    }
                }
            }
        }
    }

    /// Names along the front, of the baseline, and of the others where there is
    /// room. Neighbours of one method share its name: the others have their quality
    /// alone.
    fn labels(&self, front: &[(usize, usize)]) -> Markup {
        let letters = self.format.letters;
        let mut labels = Labels::new(self.area, letters);
        for (curve, method) in self.plot.curves.iter().enumerate() {
            let points = method.points.iter().zip(&self.on_front[curve]);
            let points: Vec<_> = points.filter(|(point, _)| point.is_shown()).collect();
            for (point, is_on) in &points {
                let half = if **is_on { MARKER } else { SMALL_MARKER };
                labels.keep_off(Rect::around(self.at(point), half));
            }
            for pair in points.windows(2) {
                labels.avoid([self.at(pair[0].0), self.at(pair[1].0)]);
            }
        }
        let floor = self.name_of_floor(&mut labels);
        let mut texts = Vec::new();
        let mut previous = None;
        let (mut names, mut numbers) = (Vec::new(), Vec::new());
        for &at in front {
            let Curve { name, .. } = &self.plot.curves[at.0];
            let quality = &self.setting(at).quality;
            if previous.replace(at.0) == Some(at.0) {
                numbers.push((at, quality.clone(), 40.0));
            } else {
                names.push((at, format!("{name}, {quality}"), self.format.reach));
            }
        }
        for (curve, method) in self.plot.curves.iter().enumerate() {
            let passed_by = !self.on_front[curve].contains(&true);
            if method.is_baseline && passed_by && method.points.iter().any(Setting::is_shown) {
                names.push(self.end(curve, self.format.reach));
            }
        }
        let wanted = |(at, text, reach): &((usize, usize), String, f64)| Wanted {
            point: self.at(self.setting(*at)),
            text: text.clone(),
            reach: *reach,
        };
        let mut named = BTreeSet::new();
        // Names first: a number more or less does not matter, but it needs the name.
        for (is_name, group) in [(true, names), (false, numbers)] {
            let group = group.into_iter();
            let group = group.filter(|((curve, _), ..)| is_name || named.contains(curve));
            let group: Vec<_> = group.collect();
            let all: Vec<Wanted> = group.iter().map(wanted).collect();
            for (((curve, _), text, _), (want, placed)) in group
                .into_iter()
                .zip(all.iter().zip(labels.place_all(&all)))
            {
                if let Some(placed) = placed {
                    named.insert(curve);
                    let slot = self.plot.curves[curve].key.slot;
                    texts.push((want.point, placed, format!("name m{slot}"), text));
                }
            }
        }
        for curve in 0..self.plot.curves.len() {
            let is_empty = !self.plot.curves[curve].points.iter().any(Setting::is_shown);
            if self.stands_out(curve) || is_empty {
                continue;
            }
            let ((curve, point), text, reach) = self.end(curve, 29.0);
            let at = self.at(self.setting((curve, point)));
            if let Some(placed) = labels.place(at, &text, reach) {
                texts.push((at, placed, "name other".into(), text));
            }
        }
        html! {
            @if let Some((rect, text)) = floor {
                text.name.other x=(pixels(0.5 * (rect.left + rect.right))) y=(pixels(rect.bottom - 0.33 * letters)) text-anchor="middle" { (text) }
            }
            @for (at, Placed { rect, leader }, class, text) in texts {
                @if let Some([from, to]) = leader {
                    path.leader d={ "M" (pixels(from.0)) " " (pixels(from.1)) "L" (pixels(to.0)) " " (pixels(to.1)) } {}
                }
                @let (x, anchor) = anchored(rect, at);
                text class=(class) x=(pixels(x)) y=(pixels(rect.bottom - 0.33 * letters)) text-anchor=(anchor) { (text) }
            }
        }
    }

    /// The label of a whole curve at its best point.
    fn end(&self, curve: usize, reach: f64) -> ((usize, usize), String, f64) {
        let method = &self.plot.curves[curve];
        let shown = method
            .points
            .iter()
            .enumerate()
            .filter(|(_, p)| p.is_shown());
        let error = |(_, p): &(usize, &Setting)| p.error;
        let best = shown.min_by(|a, b| error(a).total_cmp(&error(b)));
        let point = best.map_or(0, |(point, _)| point);
        ((curve, point), method.name.clone(), reach)
    }
}

/// A coordinate as it is written.
fn pixels(value: f64) -> String {
    format!("{value:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(slot: usize, is_baseline: bool, points: &[(f64, f64)]) -> Curve {
        let setting = |&(seconds, error): &(f64, f64)| Setting {
            seconds,
            error,
            spread: [0.95 * seconds, 1.1 * seconds],
            quality: (seconds * 1e3).round().to_string(),
            title: format!("<{slot}>"),
        };
        Curve {
            name: format!("method <{slot}>"),
            key: Key::new(slot),
            is_baseline,
            points: points.iter().map(setting).collect(),
        }
    }

    fn svg(curves: Vec<Curve>) -> Option<String> {
        let plot = Plot {
            time: "time of a frame",
            error: "error & mean",
            unit: Unit::Share,
            floor: Some(Floor {
                error: 0.02,
                name: "least error of <maps>".into(),
                short: "<maps>".into(),
            }),
            curves,
        };
        front(&plot).map(Markup::into_string)
    }

    /// Two methods on the front, one beaten everywhere, and a baseline.
    fn some() -> Vec<Curve> {
        vec![
            curve(0, false, &[(1e-3, 0.5), (4e-3, 0.1)]),
            curve(1, false, &[(2e-3, 0.3), (3e-3, 0.2), (9e-3, 0.01)]),
            curve(2, false, &[(5e-3, 0.6), (20e-3, 0.5)]),
            curve(3, true, &[(6e-3, 0.4), (30e-3, 0.08)]),
        ]
    }

    #[test]
    fn the_front_is_named_on_the_curve_and_the_baseline_beside_it() {
        let svg = svg(some()).unwrap();
        let [wide, narrow] = svg.split_once("on-narrow").map(|(a, b)| [a, b]).unwrap();
        for svg in [wide, narrow] {
            for name in [
                ">method &lt;0&gt;, 1</text>",
                ">method &lt;1&gt;, 2</text>",
                ">3</text>",
                ">method &lt;3&gt;</text>",
            ] {
                assert_eq!(svg.matches(name).count(), 1, "{name}: {svg}");
            }
            assert!(svg.contains("class=\"line other\""), "beaten everywhere");
            assert!(svg.contains("error &amp; mean"));
            assert_eq!(svg.matches("class=\"floor\"").count(), 1);
            assert!(svg.contains("&lt;maps&gt;</text>"), "{svg}");
        }
        assert!(
            svg.contains("from fast to exact: &lt;0&gt;; &lt;1&gt;"),
            "{svg}"
        );
    }

    #[test]
    fn every_name_of_a_long_front_is_there() {
        let point = |i: i32| (1e-3 * 1.3_f64.powi(i), 0.7_f64.powi(i));
        let curves = (0..10).map(|i| curve(i as usize, false, &[point(i)]));
        let svg = svg(curves.collect()).unwrap();
        assert_eq!(svg.matches("class=\"name m").count(), 20, "{svg}");
    }

    #[test]
    fn what_has_no_place_on_the_axes_is_left_out() {
        let odd = [
            (1e-3, 0.0),
            (2e-3, f64::NAN),
            (3e-3, f64::INFINITY),
            (f64::NAN, 0.1),
        ];
        assert!(svg(vec![curve(0, true, &odd)]).is_none());
        assert!(svg(vec![]).is_none());
        let mut curves = some();
        curves.push(curve(4, true, &odd));
        let svg = svg(curves).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
