//! Error against time as inline SVG.

use std::fmt::Write;

use super::axis::{LogAxis, Tick};
use crate::compare::results::pareto;
use crate::format::escape;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 470.0;
const LEFT: f64 = 92.0;
// Half of the label of a tick at the very end fits beside the plot.
const RIGHT: f64 = 34.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 52.0;

/// One method on one backend.
#[derive(Debug)]
pub(crate) struct Curve {
    /// Colour and marker.
    pub(crate) slot: usize,
    /// Second and further backends have dashed lines.
    pub(crate) dashed: bool,
    /// False if its points may not be on the front.
    pub(crate) competes: bool,
    pub(crate) points: Vec<Point>,
}

/// One measurement.
#[derive(Debug)]
pub(crate) struct Point {
    pub(crate) time: f64,
    /// The fastest and the slowest repetition.
    pub(crate) spread: (f64, f64),
    pub(crate) error: f64,
    /// The quality, written beside the ends of a curve.
    pub(crate) label: String,
    /// What a pointer that rests on it is told.
    pub(crate) title: String,
}

/// The words around the plot.
pub(crate) struct Labels<'a> {
    pub(crate) description: &'a str,
    pub(crate) time: &'a str,
    pub(crate) error: &'a str,
    pub(crate) write_time: &'a dyn Fn(f64) -> String,
    pub(crate) write_error: &'a dyn Fn(f64) -> String,
}

/// A log-log plot; `None` if no point has a positive time and error. Errors of
/// exactly 0 sit on the lower edge.
pub(crate) fn chart(curves: &[Curve], labels: &Labels<'_>) -> Option<String> {
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let times = all().flat_map(|p| [p.time, p.spread.0, p.spread.1]);
    let x = LogAxis::around(times, LEFT, WIDTH - RIGHT)?;
    let y = LogAxis::around(all().map(|p| p.error), HEIGHT - BOTTOM, TOP)?;
    let mut svg = format!(
        "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\n",
        escape(labels.description)
    );
    grid(&mut svg, &x, &y, labels);
    let front = front(curves, &x, &y);
    let _ = writeln!(svg, "<path class=\"front\" d=\"{}\"/>", front.path);
    for curve in curves {
        draw_curve(&mut svg, curve, &x, &y);
    }
    for (curve, on_front) in curves.iter().zip(&front.members) {
        draw_points(&mut svg, curve, on_front, &x, &y);
    }
    let mut placed = Vec::new();
    for curve in curves {
        draw_labels(&mut svg, curve, &x, &y, &mut placed);
    }
    svg.push_str("</svg>\n");
    Some(svg)
}

/// The marker of a method on its own, for legends and tables.
pub(crate) fn swatch(slot: usize, dashed: bool) -> String {
    let dash = if dashed { " dashed" } else { "" };
    format!(
        "<svg class=\"swatch\" viewBox=\"0 0 30 14\" aria-hidden=\"true\"><path class=\"line m{slot}{dash}\" d=\"M0 7H30\"/>{}</svg>",
        marker(slot, 15.0, 7.0, "")
    )
}

fn grid(svg: &mut String, x: &LogAxis, y: &LogAxis, labels: &Labels<'_>) {
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    let class = |tick: &Tick| if tick.labelled { "grid major" } else { "grid" };
    for tick in x.ticks() {
        let at = tick.position;
        let _ = writeln!(
            svg,
            "<path class=\"{}\" d=\"M{at:.1} {TOP}V{bottom}\"/>",
            class(&tick)
        );
        if tick.labelled {
            let text = (labels.write_time)(tick.value);
            let below = bottom + 18.0;
            let _ = writeln!(
                svg,
                "<text class=\"tick\" x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{text}</text>"
            );
        }
    }
    for tick in y.ticks() {
        let at = tick.position;
        let _ = writeln!(
            svg,
            "<path class=\"{}\" d=\"M{LEFT} {at:.1}H{right}\"/>",
            class(&tick)
        );
        if tick.labelled {
            let text = (labels.write_error)(tick.value);
            let (beside, baseline) = (LEFT - 8.0, at + 4.5);
            let _ = writeln!(
                svg,
                "<text class=\"tick\" x=\"{beside}\" y=\"{baseline:.1}\" text-anchor=\"end\">{text}</text>"
            );
        }
    }
    let middle = 0.5 * (LEFT + right);
    let below = HEIGHT - 10.0;
    let _ = writeln!(
        svg,
        "<text class=\"axis\" x=\"{middle}\" y=\"{below}\" text-anchor=\"middle\">{}</text>",
        escape(labels.time)
    );
    let middle = 0.5 * (TOP + bottom);
    let _ = writeln!(
        svg,
        "<text class=\"axis\" transform=\"translate(15 {middle}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        escape(labels.error)
    );
}

struct Front {
    path: String,
    /// Per curve, per point.
    members: Vec<Vec<bool>>,
}

/// The staircase of the best errors within a time.
fn front(curves: &[Curve], x: &LogAxis, y: &LogAxis) -> Front {
    let points: Vec<Option<(f64, f64)>> = curves
        .iter()
        .flat_map(|curve| {
            let point = |p: &Point| curve.competes.then_some((p.time, p.error));
            curve.points.iter().map(point)
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
    for (index, (time, error)) in steps.iter().enumerate() {
        let (px, py) = (x.position(*time), y.position(*error));
        let _ = if index == 0 {
            write!(path, "M{px:.1} {TOP}V{py:.1}")
        } else {
            write!(path, "H{px:.1}V{py:.1}")
        };
    }
    if !path.is_empty() {
        let _ = write!(path, "H{}", WIDTH - RIGHT);
    }
    let mut members = Vec::new();
    for curve in curves {
        let rest = flags.split_off(curve.points.len());
        members.push(std::mem::replace(&mut flags, rest));
    }
    Front { path, members }
}

fn draw_curve(svg: &mut String, curve: &Curve, x: &LogAxis, y: &LogAxis) {
    let slot = curve.slot;
    let dash = if curve.dashed { " dashed" } else { "" };
    let mut path = String::new();
    for (index, point) in curve.points.iter().enumerate() {
        let (px, py) = (x.position(point.time), y.position(point.error));
        let command = if index == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{command}{px:.1} {py:.1}");
        let (low, high) = (x.position(point.spread.0), x.position(point.spread.1));
        if high - low > 1.0 {
            let _ = writeln!(
                svg,
                "<path class=\"spread m{slot}\" d=\"M{low:.1} {py:.1}H{high:.1}\"/>"
            );
        }
    }
    let _ = writeln!(svg, "<path class=\"line m{slot}{dash}\" d=\"{path}\"/>");
}

fn draw_points(svg: &mut String, curve: &Curve, on_front: &[bool], x: &LogAxis, y: &LogAxis) {
    for (point, best) in curve.points.iter().zip(on_front) {
        let (px, py) = (x.position(point.time), y.position(point.error));
        if *best {
            let _ = writeln!(
                svg,
                "<circle class=\"ring\" cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"9.5\"/>"
            );
        }
        svg.push_str(&marker(curve.slot, px, py, &point.title));
        svg.push('\n');
    }
}

/// The qualities at the ends of a curve, where they do not cover another.
fn draw_labels(
    svg: &mut String,
    curve: &Curve,
    x: &LogAxis,
    y: &LogAxis,
    placed: &mut Vec<(f64, f64)>,
) {
    let ends = match &curve.points[..] {
        [] => vec![],
        [only] => vec![only],
        [first, .., last] => vec![first, last],
    };
    for point in ends {
        let (px, py) = (x.position(point.time), y.position(point.error));
        let (tx, anchor) = if px > WIDTH - RIGHT - 46.0 {
            (px - 10.0, "end")
        } else {
            (px + 10.0, "start")
        };
        let ty = (py - 6.0).max(TOP + 10.0);
        let covers = |&(ox, oy): &(f64, f64)| (ox - tx).abs() < 30.0 && (oy - ty).abs() < 13.0;
        if placed.iter().any(covers) {
            continue;
        }
        placed.push((tx, ty));
        let _ = writeln!(
            svg,
            "<text class=\"count m{}\" x=\"{tx:.1}\" y=\"{ty:.1}\" text-anchor=\"{anchor}\">{}</text>",
            curve.slot,
            escape(&point.label)
        );
    }
}

/// A shape per method, so that colour is not the only difference.
pub(super) fn marker(slot: usize, x: f64, y: f64, title: &str) -> String {
    let at = |dx: f64, dy: f64| format!("{:.1} {:.1}", x + dx, y + dy);
    let polygon = |corners: &[(f64, f64)]| {
        let points: Vec<String> = corners.iter().map(|&(dx, dy)| at(dx, dy)).collect();
        format!("M{}Z", points.join("L"))
    };
    let title = if title.is_empty() {
        String::new()
    } else {
        format!("<title>{}</title>", escape(title))
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
            return format!(
                "<circle class=\"dot m{slot}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\">{title}</circle>"
            );
        }
        3 => polygon(&[(-4.5, -4.5), (4.5, -4.5), (4.5, 4.5), (-4.5, 4.5)]),
        4 => polygon(&[(0.0, -6.0), (6.0, 4.8), (-6.0, 4.8)]),
        _ => polygon(&[(0.0, 6.0), (6.0, -4.8), (-6.0, -4.8)]),
    };
    format!("<path class=\"dot m{slot}\" d=\"{path}\">{title}</path>")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(time: f64, error: f64) -> Point {
        Point {
            time,
            spread: (0.9 * time, 1.1 * time),
            error,
            label: "4 & more".into(),
            title: "<here>".into(),
        }
    }

    fn draw(curves: &[Curve]) -> Option<String> {
        let labels = Labels {
            description: "error against time",
            time: "time",
            error: "error",
            write_time: &|v| format!("{v} s"),
            write_error: &|v| format!("{v}"),
        };
        chart(curves, &labels)
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
        let curves: Vec<Curve> = (0..6)
            .map(|slot| Curve {
                slot,
                dashed: slot == 3,
                competes: true,
                points: (0..7)
                    .map(|i| point(1e-3 * 2_f64.powi(i), 0.3 * 0.2_f64.powi(i)))
                    .collect(),
            })
            .collect();
        let svg = draw(&curves).unwrap();
        let numbers = coordinates(&svg);
        assert!(numbers.len() > 200);
        assert!(numbers.iter().all(|v| (0.0..=WIDTH).contains(v)));
        assert!(svg.contains("&lt;here&gt;") && svg.contains("4 &amp; more"));
        assert_eq!(svg.matches('<').count(), svg.matches('>').count());
    }

    #[test]
    fn the_label_of_the_last_tick_is_not_cut_off() {
        for end in 0..40 {
            let last = 2e-3 * 1.3_f64.powi(end);
            let points = vec![point(1e-3, 0.1), point(last, 0.2)];
            let curve = Curve {
                slot: 0,
                dashed: false,
                competes: true,
                points,
            };
            let svg = draw(&[curve]).unwrap();
            for label in svg.split("class=\"tick\" x=\"").skip(1) {
                let (x, rest) = label.split_once('"').unwrap();
                if rest.contains("middle") {
                    // At most "100 ms" at 8 units a letter.
                    assert!(x.parse::<f64>().unwrap() + 24.0 <= WIDTH, "{label}");
                }
            }
        }
    }

    #[test]
    fn an_error_of_zero_sits_on_the_edge_and_nothing_at_all_is_no_chart() {
        let curve = |points| Curve {
            slot: 1,
            dashed: false,
            competes: true,
            points,
        };
        let svg = draw(&[curve(vec![point(1.0, 0.1), point(2.0, 0.0)])]).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(draw(&[curve(vec![point(2.0, 0.0)])]).is_none());
        assert!(draw(&[]).is_none());
    }

    #[test]
    fn the_front_is_ringed_once_per_member() {
        let curve = Curve {
            slot: 0,
            dashed: false,
            competes: true,
            points: vec![point(1.0, 0.1), point(2.0, 0.2), point(3.0, 0.01)],
        };
        assert_eq!(draw(&[curve]).unwrap().matches("class=\"ring\"").count(), 2);
    }
}
