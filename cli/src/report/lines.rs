//! Transmittance against depth as inline SVG, both axes linear.

use std::fmt::Write;

use super::chart::marker;
use crate::compare::curves::Figure;
use crate::format::{escape, significant};

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 52.0;

/// Samples from one marker of a line to the next; lines start apart, so that
/// markers do not cover each other.
const BETWEEN_MARKERS: usize = 84;

/// The plot of a figure; `None` if there are not two depths.
pub(super) fn plot(figure: &Figure) -> Option<String> {
    let (near, far) = (*figure.depths.first()?, *figure.depths.last()?);
    if !(near < far) {
        return None;
    }
    let x = |depth: f64| LEFT + (WIDTH - RIGHT - LEFT) * (depth - near) / (far - near);
    let y = |value: f64| HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * value.clamp(0.0, 1.0);
    let mut svg = format!(
        "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\n",
        escape(&figure.title)
    );
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    // Writing to a string cannot fail, here and below.
    for quarter in 0..=4 {
        let value = 0.25 * f64::from(quarter);
        let (at, beside) = (y(value), LEFT - 8.0);
        let _ = writeln!(
            svg,
            "<path class=\"grid major\" d=\"M{LEFT} {at:.1}H{right}\"/>\n\
             <text class=\"tick\" x=\"{beside}\" y=\"{:.1}\" text-anchor=\"end\">{value}</text>",
            at + 4.5
        );
    }
    for depth in ticks(near, far) {
        let at = x(depth);
        let _ = writeln!(
            svg,
            "<path class=\"grid\" d=\"M{at:.1} {TOP}V{bottom}\"/>\n\
             <text class=\"tick\" x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            bottom + 18.0,
            significant(depth)
        );
    }
    let _ = writeln!(
        svg,
        "<text class=\"axis\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">depth, m</text>\n\
         <text class=\"axis\" transform=\"translate(15 {}) rotate(-90)\" text-anchor=\"middle\">transmittance</text>",
        0.5 * (LEFT + right),
        HEIGHT - 10.0,
        0.5 * (TOP + bottom)
    );
    for line in &figure.lines {
        let points = || figure.depths.iter().zip(&line.values);
        let mut path = String::new();
        for (index, (&depth, &value)) in points().enumerate() {
            let command = if index == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{:.1} {:.1}", x(depth), y(value));
        }
        let _ = writeln!(svg, "<path class=\"line m{}\" d=\"{path}\"/>", line.slot);
        let marked = points().skip(12 * line.slot).step_by(BETWEEN_MARKERS);
        for (&depth, &value) in marked {
            let title = format!("{}: {}", line.name, significant(value));
            svg.push_str(&marker(line.slot, x(depth), y(value), &title));
            svg.push('\n');
        }
    }
    svg.push_str("</svg>\n");
    Some(svg)
}

/// Round depths between two others, about six of them.
fn ticks(near: f64, far: f64) -> Vec<f64> {
    let rough = (far - near) / 6.0;
    let decade = 10_f64.powf(rough.log10().floor());
    let fits = [1.0, 2.0, 5.0, 10.0].map(|multiple| multiple * decade);
    let step = fits.into_iter().find(|step| *step >= rough);
    let step = step.unwrap_or(10.0 * decade);
    let first = (near / step).ceil();
    let mut ticks: Vec<f64> = (0..12).map(|i| (first + f64::from(i)) * step).collect();
    ticks.retain(|tick| *tick <= far);
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::curves::Line;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 6.0), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for (near, far) in [(-3.2, 8.9), (1e6, 1e6 + 3.0), (-1e-9, 1e-9), (1e30, 3e30)] {
            let ticks = ticks(near, far);
            assert!((2..=8).contains(&ticks.len()), "{near} {far}: {ticks:?}");
            assert!(ticks.iter().all(|tick| near <= *tick && *tick <= far));
        }
    }

    #[test]
    fn lines_stay_inside_and_nothing_is_no_plot() {
        let figure = |depths: Vec<f64>| Figure {
            title: "a & b".into(),
            lines: vec![Line {
                name: "<line>".into(),
                slot: 1,
                values: depths.iter().map(|depth| 1.5 - depth).collect(),
            }],
            depths,
        };
        let svg = plot(&figure((0..200).map(|i| 0.01 * f64::from(i)).collect())).unwrap();
        assert!(svg.contains("a &amp; b") && svg.contains("&lt;line&gt;"));
        assert!(!svg.contains("NaN") && svg.matches('<').count() == svg.matches('>').count());
        assert!(plot(&figure(vec![])).is_none() && plot(&figure(vec![1.0, 1.0])).is_none());
    }
}
