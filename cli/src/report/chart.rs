//! Charts as inline SVG.

use std::fmt::Write;

use maud::{Markup, html};

use super::axis::{Ruler, Tick};
use super::labels::{Labels, Placed, Rect, anchored};
use super::numbers::written;
use crate::compare::results::pareto;
use crate::compare::study::{Axis, Chart, Key, Point, Scale, Series, Shape};
use crate::format::significant;

/// The area between the axes, within a picture of some size.
#[derive(Debug, Clone, Copy)]
struct Frame {
    width: f64,
    height: f64,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// Room for errors beside the plot; half of the label of a tick at the very end
/// fits beside it, too.
const LOG: Frame = Frame {
    width: 720.0,
    height: 470.0,
    left: 92.0,
    right: 686.0,
    top: 14.0,
    bottom: 418.0,
};

/// Numbers along an even axis are short.
const EVEN: Frame = Frame {
    width: 720.0,
    height: 400.0,
    left: 62.0,
    right: 700.0,
    top: 14.0,
    bottom: 348.0,
};

/// Parts between the ticks of even axes, about.
const PARTS: [u32; 2] = [6, 4];

/// Points of a line from one marker to the next; lines start apart, so that
/// markers do not cover each other.
const BETWEEN_MARKERS: usize = 84;
const APART: usize = 12;

/// Height of the letters of a label, on a phone, and how far it may be from its point.
const LETTERS: f64 = 15.0;
const NEAR: f64 = 14.0;

/// The chart as a picture; `None` if its points leave nothing to show: on a
/// logarithmic axis, if none of them is positive. Points that are not finite
/// are left out; errors of exactly 0 sit on the lower edge of such an axis.
pub(super) fn chart(chart: &Chart) -> Option<Markup> {
    let series: Vec<Series> = chart.series.iter().map(finite).collect();
    let all = || series.iter().flat_map(|series| &series.points);
    let frame = match chart.y.scale {
        Scale::Log => LOG,
        _ => EVEN,
    };
    let across = all().flat_map(|p| [p.x, p.spread[0], p.spread[1]]);
    let x = Ruler::new(chart.x.scale, across, (frame.left, frame.right), PARTS[0])?;
    let up = all().map(|p| p.y);
    let y = Ruler::new(chart.y.scale, up, (frame.bottom, frame.top), PARTS[1])?;
    let plot = Plot { frame, x, y };
    let front = if chart.front {
        plot.front(&series)
    } else {
        Front::default()
    };
    let mut labels = plot.room(&series);
    Some(html! {
        svg.chart viewBox={ "0 0 " (frame.width) " " (frame.height) } role="img" aria-label=(chart.description) {
            (plot.grid(&chart.x, &chart.y))
            @if chart.front {
                path.front d=(front.path) {}
            }
            @for series in &series {
                (plot.line(series))
            }
            @for (index, series) in series.iter().enumerate() {
                (plot.markers(series, front.members.get(index)))
            }
            @for series in &series {
                (plot.ends(series, &mut labels))
            }
        }
    })
}

/// The marker of a series on its own, for legends and tables.
pub(super) fn swatch(key: Key) -> Markup {
    html! {
        svg.swatch viewBox="0 0 30 14" aria-hidden="true" {
            path class={ "line m" (key.slot) (dash(key)) } d="M0 7H30" {}
            (marker(key.slot, (15.0, 7.0), ""))
        }
    }
}

fn dash(key: Key) -> &'static str {
    if key.dashed { " dashed" } else { "" }
}

/// The series without the points that are not finite.
fn finite(series: &Series) -> Series {
    let mut series = series.clone();
    series
        .points
        .retain(|point| point.x.is_finite() && point.y.is_finite());
    series
}

/// A coordinate as it is written.
fn pixels(value: f64) -> String {
    format!("{value:.1}")
}

#[derive(Debug, Default)]
struct Front {
    path: String,
    /// Per series, per point.
    members: Vec<Vec<bool>>,
}

/// Where things are.
struct Plot {
    frame: Frame,
    x: Ruler,
    y: Ruler,
}

impl Plot {
    fn at(&self, point: &Point) -> (f64, f64) {
        (self.x.position(point.x), self.y.position(point.y))
    }

    fn grid(&self, across: &Axis, up: &Axis) -> Markup {
        let Frame {
            height,
            left,
            right,
            top,
            bottom,
            ..
        } = self.frame;
        let class = |tick: &Tick| if tick.labelled { "grid major" } else { "grid" };
        html! {
            @for tick in self.x.ticks() {
                @let at = pixels(tick.position);
                path class=(class(&tick)) d={ "M" (at) " " (top) "V" (bottom) } {}
                @if tick.labelled {
                    text.tick x=(at) y=(bottom + 18.0) text-anchor="middle" { (written(tick.value, across.unit)) }
                }
            }
            @for tick in self.y.ticks() {
                path class=(class(&tick)) d={ "M" (left) " " (pixels(tick.position)) "H" (right) } {}
                @if tick.labelled {
                    text.tick x=(left - 8.0) y=(pixels(tick.position + 4.5)) text-anchor="end" { (written(tick.value, up.unit)) }
                }
            }
            text.axis x=(0.5 * (left + right)) y=(height - 10.0) text-anchor="middle" { (across.label) }
            text.axis transform={ "translate(15 " (0.5 * (top + bottom)) ") rotate(-90)" } text-anchor="middle" { (up.label) }
        }
    }

    /// The staircase of the best errors within a time.
    fn front(&self, all: &[Series]) -> Front {
        let points: Vec<Option<(f64, f64)>> = all
            .iter()
            .flat_map(|series| {
                let point = |p: &Point| series.competes.then_some((p.x, p.y));
                series.points.iter().map(point)
            })
            .collect();
        let mut flags = pareto(&points);
        let mut steps: Vec<(f64, f64)> = points
            .iter()
            .zip(&flags)
            .filter_map(|(point, on_front)| point.filter(|_| *on_front))
            .collect();
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut path = String::new();
        for (index, (x, y)) in steps.iter().enumerate() {
            let (px, py) = (self.x.position(*x), self.y.position(*y));
            // Writing to a string cannot fail.
            let _ = if index == 0 {
                write!(path, "M{px:.1} {}V{py:.1}", self.frame.top)
            } else {
                write!(path, "H{px:.1}V{py:.1}")
            };
        }
        if !path.is_empty() {
            let _ = write!(path, "H{}", self.frame.right);
        }
        let mut members = Vec::new();
        for series in all {
            let rest = flags.split_off(series.points.len());
            members.push(std::mem::replace(&mut flags, rest));
        }
        Front { path, members }
    }

    /// The points joined, and bars where they scatter.
    fn line(&self, series: &Series) -> Markup {
        let mut path = String::new();
        for (index, point) in series.points.iter().enumerate() {
            let (px, py) = self.at(point);
            let command = if index == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{px:.1} {py:.1}");
        }
        let slot = series.key.slot;
        html! {
            @for point in &series.points {
                @let (low, high) = (self.x.position(point.spread[0]), self.x.position(point.spread[1]));
                @if high - low > 1.0 {
                    path class={ "spread m" (slot) } d={ "M" (pixels(low)) " " (pixels(self.y.position(point.y))) "H" (pixels(high)) } {}
                }
            }
            path class={ "line m" (slot) (dash(series.key)) } d=(path) {}
        }
    }

    /// A marker per point, with a ring around those on the front; a few of them
    /// on a line.
    fn markers(&self, series: &Series, on_front: Option<&Vec<bool>>) -> Markup {
        let slot = series.key.slot;
        let points = series.points.iter().enumerate();
        match series.shape {
            Shape::Points => html! {
                @for (index, point) in points {
                    @let (px, py) = self.at(point);
                    @if on_front.is_some_and(|flags| flags[index]) {
                        circle.ring cx=(pixels(px)) cy=(pixels(py)) r="9.5" {}
                    }
                    (marker(slot, (px, py), &point.title))
                }
            },
            Shape::Line => html! {
                @for (_, point) in points.skip(APART * slot).step_by(BETWEEN_MARKERS) {
                    (marker(slot, self.at(point), &format!("{}: {}", series.name, significant(point.y))))
                }
            },
        }
    }

    /// The labels at the ends of a series, where there is room beside them.
    fn ends(&self, series: &Series, labels: &mut Labels) -> Markup {
        let ends = match &series.points[..] {
            [] => vec![],
            [only] => vec![only],
            [first, .., last] => vec![first, last],
        };
        let mut texts = Vec::new();
        for point in ends.into_iter().filter(|point| !point.label.is_empty()) {
            let at = self.at(point);
            if let Some(Placed { rect, .. }) = labels.place(at, &point.label, NEAR) {
                texts.push((rect, anchored(rect, at), &point.label));
            }
        }
        html! {
            @for (rect, (x, anchor), label) in texts {
                text class={ "count m" (series.key.slot) } x=(pixels(x)) y=(pixels(rect.bottom - 0.33 * LETTERS)) text-anchor=(anchor) { (label) }
            }
        }
    }

    /// Room for labels that cover no marker.
    fn room(&self, all: &[Series]) -> Labels {
        let Frame {
            left,
            right,
            top,
            bottom,
            ..
        } = self.frame;
        let area = Rect {
            left,
            top,
            right,
            bottom,
        };
        let mut labels = Labels::new(area, LETTERS);
        let with_points = all.iter().filter(|series| series.shape == Shape::Points);
        for series in with_points {
            for point in &series.points {
                labels.keep_off(Rect::around(self.at(point), 5.0));
            }
            for pair in series.points.windows(2) {
                labels.avoid([self.at(&pair[0]), self.at(&pair[1])]);
            }
        }
        labels
    }
}

/// A shape per series, so that colour is not the only difference.
pub(super) fn marker(slot: usize, (x, y): (f64, f64), title: &str) -> Markup {
    let at = |dx: f64, dy: f64| format!("{:.1} {:.1}", x + dx, y + dy);
    let polygon = |corners: &[(f64, f64)]| {
        let points: Vec<String> = corners.iter().map(|&(dx, dy)| at(dx, dy)).collect();
        format!("M{}Z", points.join("L"))
    };
    let title = html! {
        @if !title.is_empty() {
            title { (title) }
        }
    };
    let path = match slot % 6 {
        0 => polygon(&[
            (-5.5, -2.0),
            (-2.0, -2.0),
            (-2.0, -5.5),
            (2.0, -5.5),
            (2.0, -2.0),
            (5.5, -2.0),
            (5.5, 2.0),
            (2.0, 2.0),
            (2.0, 5.5),
            (-2.0, 5.5),
            (-2.0, 2.0),
            (-5.5, 2.0),
        ]),
        1 => polygon(&[(0.0, -6.5), (6.5, 0.0), (0.0, 6.5), (-6.5, 0.0)]),
        2 => {
            return html! {
                circle class={ "dot m" (slot) } cx=(pixels(x)) cy=(pixels(y)) r="5" { (title) }
            };
        }
        3 => polygon(&[(-4.5, -4.5), (4.5, -4.5), (4.5, 4.5), (-4.5, 4.5)]),
        4 => polygon(&[(0.0, -6.0), (6.0, 4.8), (-6.0, 4.8)]),
        _ => polygon(&[(0.0, 6.0), (6.0, -4.8), (-6.0, -4.8)]),
    };
    html! {
        path class={ "dot m" (slot) } d=(path) { (title) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::study::Unit;

    fn point(x: f64, y: f64) -> Point {
        Point {
            spread: [0.9 * x, 1.1 * x],
            label: "4 & more".into(),
            title: "<here>".into(),
            ..Point::bare(x, y)
        }
    }

    fn series(slot: usize, points: Vec<Point>) -> Series {
        Series {
            name: "<line>".into(),
            aside: String::new(),
            key: Key {
                slot,
                dashed: slot == 3,
            },
            competes: true,
            shape: Shape::Points,
            points,
        }
    }

    fn draw_on(scales: [Scale; 2], series: Vec<Series>) -> Option<String> {
        let axis = |label: &str, scale| Axis {
            label: label.into(),
            scale,
            unit: Unit::Number,
        };
        let drawn = chart(&Chart {
            title: "a chart".into(),
            caption: String::new(),
            description: "error \"against\" time".into(),
            x: axis("time, <s>", scales[0]),
            y: axis("error", scales[1]),
            front: scales[1] == Scale::Log,
            series,
        });
        drawn.map(Markup::into_string)
    }

    fn draw(series: Vec<Series>) -> Option<String> {
        draw_on([Scale::Log; 2], series)
    }

    /// Every number in the attributes that hold coordinates.
    fn coordinates(svg: &str) -> Vec<f64> {
        let mut all = Vec::new();
        for attribute in [" d=\"", " cx=\"", " cy=\"", " x=\"", " y=\""] {
            for part in svg.split(attribute).skip(1) {
                let value = part.split('"').next().unwrap();
                let numbers = value.split(|c: char| c.is_ascii_alphabetic() || c == ' ');
                all.extend(
                    numbers
                        .filter(|n| !n.is_empty())
                        .map(|n| n.parse::<f64>().unwrap()),
                );
            }
        }
        all
    }

    #[test]
    fn everything_lies_inside_the_picture() {
        let points = |i| point(1e-3 * 2_f64.powi(i), 0.3 * 0.2_f64.powi(i));
        let all = (0..6).map(|slot| series(slot, (0..7).map(points).collect()));
        let svg = draw(all.collect()).unwrap();
        let numbers = coordinates(&svg);
        assert!(numbers.len() > 200);
        assert!(numbers.iter().all(|v| (0.0..=LOG.width).contains(v)));
        assert!(svg.contains("&lt;here&gt;") && svg.contains("4 &amp; more"));
        assert!(svg.contains("error &quot;against&quot; time") && svg.contains("time, &lt;s&gt;"));
        assert_eq!(svg.matches('<').count(), svg.matches('>').count());
    }

    #[test]
    fn the_label_of_the_last_tick_is_not_cut_off() {
        for end in 0..40 {
            let last = 2e-3 * 1.3_f64.powi(end);
            let svg = draw(vec![series(0, vec![point(1e-3, 0.1), point(last, 0.2)])]).unwrap();
            for label in svg.split("class=\"tick\" x=\"").skip(1) {
                let (x, rest) = label.split_once('"').unwrap();
                if rest.contains("middle") {
                    // At most "100 ms" at 8 units a letter.
                    assert!(x.parse::<f64>().unwrap() + 24.0 <= LOG.width, "{label}");
                }
            }
        }
    }

    #[test]
    fn an_error_of_zero_sits_on_the_edge_and_nothing_at_all_is_no_chart() {
        let svg = draw(vec![series(1, vec![point(1.0, 0.1), point(2.0, 0.0)])]).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(draw(vec![series(1, vec![point(2.0, 0.0)])]).is_none());
        assert!(draw(vec![]).is_none());
    }

    #[test]
    fn points_that_are_not_finite_are_left_out_and_are_not_on_the_front() {
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        let mut points: Vec<Point> = odd.map(|y| point(1e-9, y)).into();
        points.extend(odd.map(|x| point(x, 1e-9)));
        points.extend([point(1.0, 0.1), point(2.0, 0.01)]);
        for scales in [[Scale::Log; 2], [Scale::Linear; 2]] {
            let svg = draw_on(scales, vec![series(0, points.clone())]).unwrap();
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
            assert_eq!(svg.matches("<title>").count(), 2);
        }
        assert!(draw(vec![series(0, points[..6].to_vec())]).is_none());
    }

    #[test]
    fn the_front_is_ringed_once_per_member() {
        let points = vec![point(1.0, 0.1), point(2.0, 0.2), point(3.0, 0.01)];
        let svg = draw(vec![series(0, points)]).unwrap();
        assert_eq!(svg.matches("class=\"ring\"").count(), 2);
    }

    #[test]
    fn lines_stay_inside_and_have_few_markers() {
        let points = (0..200).map(|i| 0.01 * f64::from(i));
        let mut line = series(1, points.map(|x| Point::bare(x, 1.5 - x)).collect());
        line.shape = Shape::Line;
        let scales = [Scale::Linear, Scale::Between(0.0, 1.0)];
        let svg = draw_on(scales, vec![line.clone()]).unwrap();
        let numbers = coordinates(&svg);
        assert!(numbers.iter().all(|v| (0.0..=EVEN.width).contains(v)));
        assert!(svg.contains("<title>&lt;line&gt;: "), "{svg}");
        assert_eq!(svg.matches("<title>").count(), 3);
        assert!(!svg.contains("class=\"front\"") && !svg.contains("class=\"count"));
        line.points.truncate(1);
        assert!(draw_on(scales, vec![line]).is_none());
    }
}
