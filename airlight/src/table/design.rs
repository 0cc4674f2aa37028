//! How to spend the memory of a table.

use super::axes::Axes;
use super::cells::{self, ZEROS, parabola, stored};
use super::integral::Tail;
use super::near::{NEAR, Node, THIN};
use super::short::Short;
use super::{LARGEST_REST, Table};
use crate::gauss::Rule;
use crate::{Phase, Segment64, exact};
use std::f64::consts::LN_2;

/// The error that rounding adds. The optical depth of a result in range is below 110; it is
/// rounded four times, and its part between the ends as often.
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
const NODES: [u32; 13] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96];

/// The rule for short parts may always be as wrong as this: it is below what
/// rounding adds.
const RULE_ERROR: f64 = 2e-5;

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
    // Weights and phase function are positive, so that the relative error of the sum is no
    // larger than that of the values of the phase function.
    let rows = phase_error(&table, &tail);
    // So that short parts are not what sets the bound.
    let enough = RULE_ERROR.max(long - rows);
    let (short, near) = (short_parts(&tail), near_parts(&tail));
    let (far, rule) = shortest_rule(enough, |rule| short_error(&tail, rule, &short));
    let (near, near_rule) = shortest_rule(enough, |rule| near_error(&tail, rule, &near));
    table.rule = rule;
    table.near_rule = near_rule;
    let short = (1.0 + far.max(near)) * (1.0 + rows) - 1.0;
    table.error_bound = (long.max(short) + ROUNDING) as f32;
    table
}

/// The rule with the fewest nodes that are enough, or with the smallest error
/// of those that are tried, and its error.
fn shortest_rule(enough: f64, error: impl Fn(&Rule) -> f64) -> (f64, Vec<[f32; 2]>) {
    let mut best = (f64::INFINITY, Vec::new());
    for count in NODES {
        let rule = Rule::of(count);
        let error = BETWEEN * error(&rule);
        if error < best.0 {
            let single = rule.iter().map(|(t, w)| [t as f32, w as f32]);
            best = (error, single.collect());
        }
        if error < enough {
            break;
        }
    }
    best
}

/// The worst relative error of the phase function in a row.
///
/// A cubic through the zeros of T₄ is off by about T₄, whose extrema are among
/// nine points that are spaced like those of T₈.
fn phase_error<P: Phase>(table: &Table, tail: &Tail<'_, P>) -> f64 {
    let axes = &table.axes;
    let points = [0.0, 0.191, 0.354, 0.462, 0.5].map(|x: f64| [x, -x]);
    let mut worst = 0.0_f64;
    for (row, &cubic) in (0..axes.all_rows()).zip(&table.phase) {
        for &beta in points.as_flattened() {
            let (b, behind) = axes.b(row, beta);
            let truth = tail.phase(b, behind).max(cells::LEAST).log2();
            let value = cells::phase_value(cubic, beta as f32);
            worst = worst.max(((f64::from(value) - truth) * LN_2).exp_m1().abs());
        }
    }
    worst
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

/// The error of a rule may be larger between samples than at them by this factor. The error
/// varies with the logarithm of `tan(θ/2)` on the scale on which the integrand does, by which at
/// most a factor of 1.25 lies in a near part and more in others, and is sampled ten times per
/// decade: next to a maximum of that width samples miss `(0.115/0.5)² / 2` of it.
const BETWEEN: f64 = 1.05;

/// A part that is integrated, in double precision.
#[derive(Debug)]
struct Part {
    short: Short<f64>,
    /// Of the sum over the nodes.
    truth: f64,
}

impl Part {
    /// That starts at the eye, at the distance 1 from the light.
    fn new<P: Phase>(tail: &Tail<'_, P>, sigma_t: f64, [s, h]: [f64; 2], length: f64) -> Self {
        let octaves = sigma_t * std::f64::consts::LOG2_E;
        let short = Short::new(octaves, [0.0, s, h, length]);
        let segment = Segment64 {
            x: 0.0,
            s,
            h,
            length,
        };
        let airlight = exact::estimate(tail.phase_function(), sigma_t, &segment).value;
        let truth = airlight / (2.0 * short.angle) * (2.0 * short.depth).exp2();
        Self { short, truth }
    }
}

/// Positions of the start of a part, at the distance 1 from the light: from all
/// but the axis in front of it to all but the axis behind it.
fn starts() -> impl Iterator<Item = [f64; 2]> {
    (-70..=70).map(|step| {
        let half = 10_f64.powf(f64::from(step) / 10.0);
        let square = half * half;
        let d = 1.0 + square;
        [(square - 1.0) / d, 2.0 * half / d]
    })
}

/// A part that is near, in double precision.
#[derive(Debug)]
struct NearPart {
    octaves: f64,
    lengths: [f64; 4],
    airlight: f64,
}

/// Parts that are near: their error grows with the length and with the
/// extinction but for a change of sign, so that most of the samples are as long
/// and as deep as such parts may be.
fn near_parts<P: Phase>(tail: &Tail<'_, P>) -> Vec<NearPart> {
    let most = f64::from(NEAR);
    let lengths = [1.0, 0.8, 0.5, 0.2].map(|share| share * most);
    // Over a part, see `THIN`.
    let depths = [0.0, 0.5, 1.0].map(|share| share * f64::from(THIN) * LN_2 / 2.0);
    let mut parts = Vec::new();
    for [s, h] in starts() {
        for length in lengths {
            for depth in depths {
                let sigma_t = depth / length;
                let lengths = [0.0, s, h, length];
                let [x, s, h, length] = lengths;
                let segment = Segment64 { x, s, h, length };
                parts.push(NearPart {
                    octaves: sigma_t * std::f64::consts::LOG2_E,
                    lengths,
                    airlight: exact::estimate(tail.phase_function(), sigma_t, &segment).value,
                });
            }
        }
    }
    parts
}

/// Lengths of parts in distances of their start from the light. Those to the
/// foot point and a little beyond are the hardest where the ray all but meets
/// the light.
const LENGTHS: [f64; 6] = [0.125, 0.25, 0.5, 1.0, 2.0, 5.0];

/// The same in distances from the start to the foot point.
const AT_FOOT: [f64; 10] = [0.8, 0.9, 0.97, 0.99, 0.999, 1.0, 1.001, 1.01, 1.1, 1.3];

/// Parts that are integrated because most of the light of the ray is behind
/// their end, up to the longest such part, where the difference of two lookups
/// takes over.
fn short_parts<P: Phase>(tail: &Tail<'_, P>) -> Vec<Part> {
    let mut parts = Vec::new();
    for sigma_t in [0.0, 0.3, 1.0, 3.0, 10.0, 50.0] {
        for start in starts() {
            let longest = longest_short(tail, sigma_t, start);
            let at_foot = AT_FOOT.map(|share| share * (-start[0]).max(0.0));
            let lengths = LENGTHS.into_iter().chain(at_foot);
            let lengths = lengths.filter(|length| *length > 0.0 && *length < longest);
            for length in lengths.chain([longest, 0.9 * longest]) {
                parts.push(Part::new(tail, sigma_t, start, length));
            }
        }
    }
    parts
}

/// The length behind which [`LARGEST_REST`] of the light behind the start is
/// left, and a little more for what is wrong with lookups.
fn longest_short<P: Phase>(tail: &Tail<'_, P>, sigma_t: f64, [s, h]: [f64; 2]) -> f64 {
    // `e^{−σ_t (x + d)} R`, see the module.
    let behind = |end: f64| {
        let d = end.hypot(h);
        let (q, behind) = (end.abs() + d, end >= 0.0);
        let longer = if behind { q } else { h };
        let v = sigma_t * longer;
        tail.value(v, h / q, behind) / (longer * (1.0 + v)) * (-sigma_t * (end - s + d)).exp()
    };
    let most = (f64::from(LARGEST_REST) * (1.0 - 1e-3)) * behind(s);
    // In the logarithm of `w = s + d`, which resolves the foot point however
    // close the ray comes to the light.
    let end = |w: f64| 0.5 * (w - h * (h / w));
    let mut low = if s < 0.0 {
        h * (h / (1.0 - s))
    } else {
        1.0 + s
    };
    let mut high = 1e6;
    for _ in 0..24 {
        let middle = (low * high).sqrt();
        if behind(end(middle)) > most {
            low = middle;
        } else {
            high = middle;
        }
    }
    end(high) - s
}

/// The worst relative error of a rule.
fn short_error<P: Phase>(tail: &Tail<'_, P>, rule: &Rule, parts: &[Part]) -> f64 {
    let error = |Part { short, truth }: &Part| {
        let sum: f64 = rule
            .iter()
            .map(|(t, weight)| short.term(t, weight, |w, h| tail.phase_at(w, h)))
            .sum();
        (sum / truth - 1.0).abs()
    };
    // There is no relative error where all is dark.
    let lit = parts.iter().filter(|part| part.truth > cells::LEAST);
    lit.map(error).fold(0.0, f64::max)
}

/// The same for parts that are near.
fn near_error<P: Phase>(tail: &Tail<'_, P>, rule: &Rule, parts: &[NearPart]) -> f64 {
    let error = |part: &NearPart| {
        let term = |(t, weight)| {
            let node = Node::new(part.octaves, part.lengths, t);
            node.term(weight, |w, h| tail.phase_at(w, h))
        };
        (rule.iter().map(term).sum::<f64>() / part.airlight - 1.0).abs()
    };
    let lit = parts.iter().filter(|part| part.airlight > cells::LEAST);
    lit.map(error).fold(0.0, f64::max)
}
