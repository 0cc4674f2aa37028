//! How to spend the memory of a table.

use super::axes::Axes;
use super::cells::{self, ZEROS, parabola, stored};
use super::integral::Tail;
use super::{LARGEST_REST, Table};
use crate::gauss::Rule;
use crate::{Phase, Segment};
use std::f64::consts::LN_2;

/// What rounding adds to the error. The optical depth of a result in range is
/// below 110; it is rounded four times, and its part between the ends as often.
const ROUNDING: f64 = 4e-5;

/// Crowdings of rows that are tried.
const CROWDINGS: [f32; 7] = [0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95];

/// Rows with which crowdings are compared; the error falls with the third
/// power of their number.
const TRIAL_ROWS: u32 = 12;

/// The relative error of a parabola through the zeros, at both ends of a cell
/// and between.
fn misfit(value: impl Fn(f64) -> f64) -> f64 {
    let f = ZEROS.map(&value);
    let error = |x: f64| (parabola(f, x) - value(x)).abs();
    [-0.5, -0.25, 0.25, 0.5]
        .map(error)
        .into_iter()
        .fold(0.0, f64::max)
        * 2.0
        * LN_2
}

/// The error along b on a side of the foot point.
fn angular_error<P: Phase>(tail: &Tail<'_, P>, side: usize, crowding: f32) -> f64 {
    let mut rows = [0, 0];
    rows[side] = TRIAL_ROWS;
    let axes = Axes::new(0, 0, rows, [crowding; 2]);
    let mut worst = 0.0_f64;
    for row in 0..TRIAL_ROWS {
        for v in [1e-3, 0.1, 2.0, 100.0] {
            worst = worst.max(misfit(|beta| {
                let (b, behind) = axes.b(row, beta);
                stored(tail.value(v, b, behind))
            }));
        }
    }
    worst
}

/// The error along v.
fn radial_error<P: Phase>(tail: &Tail<'_, P>, low: i32, steps: u32) -> f64 {
    let axes = Axes::new(low, steps, [1, 1], [0.0; 2]);
    let mut worst = 0.0_f64;
    // All of the first octave, where v ln v is, and some of the others.
    for column in (0..axes.radial).filter(|c| c >> steps == 0 || c % 3 == 0) {
        for (b, behind) in [(0.02, false), (0.9, false), (0.02, true), (0.9, true)] {
            worst = worst.max(misfit(|alpha| {
                stored(tail.value(axes.v(column, alpha), b, behind))
            }));
        }
    }
    worst
}

/// The best division of the plane into `count` cells, of which each row takes
/// `extra` for itself.
fn axes<P: Phase>(tail: &Tail<'_, P>, count: u32, extra: u32) -> Axes {
    let (crowding, error): (Vec<f32>, Vec<f64>) = [0, 1]
        .map(|side| {
            let tried = CROWDINGS.map(|c| (c, angular_error(tail, side, c)));
            tried
                .into_iter()
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((0.0, 1.0))
        })
        .into_iter()
        .unzip();
    let crowding = [crowding[0], crowding[1]];
    let mut best = (f64::INFINITY, Axes::new(-8, 1, [1, 1], crowding));
    for steps in 0..=3 {
        for low in [-14, -12, -10, -8, -6] {
            let rows = count / (Axes::radial(low, steps) + extra);
            if rows < 4 {
                continue;
            }
            let ratio = (error[0] / error[1]).cbrt();
            let front = (f64::from(rows) * ratio / (1.0 + ratio)).round() as u32;
            let front = front.clamp(2, rows - 2);
            let angular = [(front, error[0]), (rows - front, error[1])]
                .map(|(n, e)| e * (f64::from(TRIAL_ROWS) / f64::from(n)).powi(3));
            let total = angular[0].max(angular[1]) + radial_error(tail, low, steps);
            if total < best.0 {
                best = (
                    total,
                    Axes::new(low, steps, [front, rows - front], crowding),
                );
            }
        }
    }
    best.1
}

/// Numbers of nodes that are tried for short parts. Two are enough for parts
/// that are near, three or four for others but for functions that scatter more
/// and more light along the part, back to where it came from.
const NODES: [u32; 10] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32];

/// Short parts may be this many times as wrong as a lookup. Differences of
/// lookups may be three times, so that the bound does not depend on it.
const SHORT_ERROR: f64 = 2.0;

/// The table for a phase function, at most this large.
pub(super) fn table<P: Phase>(phase: &P, kibibytes: u32) -> Table {
    let tail = Tail::new(phase);
    let constant = phase.constant().map(|p| (p as f32).log2());
    let axes = axes(&tail, kibibytes * 64, u32::from(constant.is_none()));
    let (cells, units) = cells::fit(&axes, &tail);
    let rows = match constant {
        Some(_) => Vec::new(),
        None => cells::fit_phase(&axes, &tail),
    };
    let mut table = Table {
        axes,
        cells,
        units,
        constant,
        phase: rows,
        rule: Vec::new(),
        near_rule: Vec::new(),
        error_bound: 0.0,
    };
    let lookup = lookup_error(&table, &tail);
    let long = lookup * f64::from((1.0 + LARGEST_REST) / (1.0 - LARGEST_REST));
    let parts = short_parts(&table, &tail);
    let enough = SHORT_ERROR * lookup.max(1e-5);
    let (all, rule) = shortest_rule(&table, &parts, enough);
    let is_near = |(sigma_t, segment, _): &(f32, Segment, f64)| {
        let lookup = table.lookup(*sigma_t);
        lookup.is_some_and(|lookup| lookup.is_near(segment))
    };
    let near: Vec<_> = parts.iter().copied().filter(is_near).collect();
    let (near, near_rule) = match near.len() {
        0 => (all, rule.clone()),
        _ => shortest_rule(&table, &near, enough),
    };
    table.rule = rule;
    table.near_rule = near_rule;
    table.error_bound = (long.max(all).max(near) + ROUNDING) as f32;
    table
}

/// The rule with the fewest nodes that are enough, or with the smallest error
/// of those that are tried, and its error.
fn shortest_rule(
    table: &Table,
    parts: &[(f32, Segment, f64)],
    enough: f64,
) -> (f64, Vec<[f32; 2]>) {
    let mut best = (f64::INFINITY, Vec::new());
    for count in NODES {
        let rule: Vec<_> = Rule::of(count)
            .iter()
            .map(|(t, w)| [t as f32, w as f32])
            .collect();
        let error = short_error(table, &rule, parts);
        if error < best.0 {
            best = (error, rule);
        }
        if error < enough {
            break;
        }
    }
    best
}

/// The worst relative error of a lookup, at corners and edges of cells and in
/// their middle.
fn lookup_error<P: Phase>(table: &Table, tail: &Tail<'_, P>) -> f64 {
    let axes = &table.axes;
    let mut worst = 0.0_f64;
    for row in 0..axes.all_rows() {
        for column in 0..axes.radial {
            let cell = table.cells[(row * axes.radial + column) as usize];
            for (alpha, beta) in [(-0.5, -0.5), (0.5, 0.5), (0.0, 0.5), (-0.5, 0.0)] {
                let (b, behind) = axes.b(row, beta);
                let truth = stored(tail.value(axes.v(column, alpha), b, behind));
                let value = cells::value(cell, table.units, alpha as f32, beta as f32);
                worst = worst.max((f64::from(value) - truth).abs() * 2.0 * LN_2);
            }
        }
    }
    worst
}

/// Lengths of parts in distances of their start from the light. Those to the
/// foot point and a little beyond are the hardest where the ray all but meets
/// the light.
const LENGTHS: [f32; 12] = [
    0.05, 0.2, 0.5, 0.8, 0.9, 0.99, 1.0, 1.01, 1.1, 2.0, 5.0, 20.0,
];

/// Parts that are integrated, each with its extinction and its airlight.
fn short_parts<P: Phase>(table: &Table, tail: &Tail<'_, P>) -> Vec<(f32, Segment, f64)> {
    let mut parts = Vec::new();
    for sigma_t in [1e-3_f32, 0.1, 1.0, 10.0] {
        let Some(lookup) = table.lookup(sigma_t) else {
            continue;
        };
        for step in 0..80 {
            // The start in units of its distance, from close to the axis in
            // front of the light to close to the axis behind it.
            let half = 10_f32.powf((step as f32 - 39.5) / 13.0);
            let d = 0.5 * (1.0 + half * half);
            let (s, h) = (0.5 * (half * half - 1.0) / d, half / d);
            // Parts that end at the foot point, just before or behind it.
            let at_foot = [0.9, 0.97, 0.99, 1.0, 1.01, 1.1].map(|share| share * (-s).max(0.0));
            for length in LENGTHS.into_iter().chain(at_foot) {
                let segment = Segment {
                    x: 0.0,
                    s,
                    h,
                    length,
                };
                let ends = lookup.ends(&segment);
                let cells = [ends.start, ends.end].map(|end| table.cells[end.place.cell as usize]);
                if lookup.difference(&ends, cells).1 {
                    let truth = difference(tail, sigma_t.into(), &segment);
                    // What is left of the difference must have digits.
                    parts.extend(truth.map(|truth| (sigma_t, segment, truth)));
                }
            }
        }
    }
    parts
}

/// The airlight of a segment that starts at the eye, unless too much of it is
/// lost in the difference of its ends.
fn difference<P: Phase>(tail: &Tail<'_, P>, sigma_t: f64, segment: &Segment) -> Option<f64> {
    let (s, h) = (f64::from(segment.s), f64::from(segment.h));
    let end = s + f64::from(segment.length);
    let whole = |s: f64| {
        let d = s.hypot(h);
        let (q, behind) = (s.abs() + d, s >= 0.0);
        let longer = if behind { q } else { h };
        let v = sigma_t * longer;
        let path = sigma_t * (s - f64::from(segment.s) + d);
        2.0 * tail.value(v, h / q, behind) / (longer * (1.0 + v)) * (-path).exp()
    };
    let (from, to) = (whole(s), whole(end));
    (to < (1.0 - 1e-5) * from).then_some(from - to)
}

/// The worst relative error of short parts with a rule.
fn short_error(table: &Table, rule: &[[f32; 2]], parts: &[(f32, Segment, f64)]) -> f64 {
    let error = |&(sigma_t, segment, truth): &(f32, Segment, f64)| {
        let lookup = table.lookup(sigma_t)?;
        let value = table.integrate(&lookup, &segment, rule);
        Some((f64::from(value) / truth - 1.0).abs())
    };
    parts.iter().filter_map(error).fold(0.0, f64::max)
}
