//! What a table of a frame holds.

use gpu_backend::Cpu;

use super::FrameTable;
use crate::{Phase, ScatteringAngle, gauss};

/// Cells of a row, of the near sheet and of the far one.
type Row = [Vec<Cell>; 2];

/// A cubic, and whether it follows the mean that it stands for.
#[derive(Debug, Clone, Copy)]
struct Cell {
    cubic: [f64; 4],
    follows: bool,
}

/// The largest error of a cubic in the middle of its cell, relative to the mean there. In
/// most places interpolation between two rows is off by as much.
const FOLLOWS: f64 = 1e-4;

/// The largest relative error of the density that a cubic stands for at a quarter and at three
/// quarters of its cell, where the error is largest.
const SLOPES_FOLLOW: f64 = 5e-3;

/// The largest error of the mean of two rows half way between them, relative to the mean
/// there, and relative to the light of a short step there.
const ACROSS: f64 = 5e-3;

/// Nodes for the integral over half a cell.
const NODES: u32 = 4;

/// Stands for the tangents 0 and ∞ of the first and the last row.
const FLATTEST: f64 = 1e-6;

pub(super) fn table<P: Phase>(phase: &P, sigma_t: f32, distance: f32, rows: u32) -> FrameTable {
    let depth = f64::from(sigma_t) * f64::from(distance);
    let cells = rows / 4;
    let rule = gauss::Rule::of(NODES);
    // Rows, and between each two of them the ray half way, to check their mean.
    let lights = 2 * rows - 1;
    let light = |i: usize| {
        let share = (i as f64 / f64::from(lights - 1)).powi(2);
        let tangent = (share / (1.0 - share)).clamp(FLATTEST, 1.0 / FLATTEST);
        Light::new(phase, depth, tangent)
    };
    let mut made: Vec<Option<Row>> = (0..lights).map(|_| None).collect();
    Cpu::new().for_each_chunk(&mut made, 8, |first, chunk: &mut [Option<Row>]| {
        for (i, row) in chunk.iter_mut().enumerate() {
            *row = Some(light(first + i).row(&rule, cells));
        }
    });
    let made: Vec<Row> = made.into_iter().flatten().collect();
    let sheet = |sheet: usize| {
        let (made, light) = (&made, &light);
        (0..made.len()).step_by(2).flat_map(move |i| {
            let row = &made[i][sheet];
            let next = made.get(i + 1).zip(made.get(i + 2));
            let lever = light(i + 1);
            row.iter().enumerate().map(move |(cell, above)| {
                let is_known = next.is_none_or(|(middle, below)| {
                    let levers = [0.0, 0.5, 1.0].map(|t| {
                        let y = (cell as f64 + t) / f64::from(cells);
                        f64::from(cells) * lever.lever(sheet, y)
                    });
                    let [middle, below] = [middle, below].map(|row| &row[sheet][cell]);
                    above.follows && below.follows && is_between(above, below, middle, levers)
                });
                marked(above.cubic, is_known)
            })
        })
    };
    FrameTable {
        cells: sheet(0).chain(sheet(1)).collect(),
        rows,
        cells_of_row: cells,
        sigma_t,
        distance,
        transmittance: (-depth).exp() as f32,
    }
}

/// The light along one ray, in units of the distance between eye and light.
struct Light<'a, P> {
    phase: &'a P,
    /// σ_t D.
    depth: f64,
    /// tan(γ/2).
    tangent: f64,
    /// The largest tangent of half the angle at the light, and at the point: that of
    /// both at `x = D`.
    largest: f64,
    /// Distance between ray and light, `D + x_F`, and `d + s` at `x = D`.
    h: f64,
    p: f64,
    q_m: f64,
}

impl<'a, P: Phase> Light<'a, P> {
    fn new(phase: &'a P, depth: f64, tangent: f64) -> Self {
        let square = 1.0 + tangent * tangent;
        let largest = 1.0 / (square.sqrt() + tangent);
        let h = 2.0 * tangent / square;
        Self {
            phase,
            depth,
            tangent,
            largest,
            h,
            p: 2.0 / square,
            q_m: h / largest,
        }
    }

    /// `2 f / (1 + t²)` without `e^{−σ_t D}`, for t = tan(φ/2).
    fn near(&self, t: f64) -> f64 {
        let v = self.tangent * t;
        let angle = ScatteringAngle::from_half_tangent(self.tangent + t, 1.0 - v);
        let way = 2.0 * v / (1.0 - v);
        2.0 / (1.0 + t * t) * self.phase.value_f64(angle) * (-self.depth * way).exp()
    }

    /// The same for w = tan(ψ/2).
    fn far(&self, w: f64) -> f64 {
        let angle = ScatteringAngle::from_half_tangent(1.0, w);
        let square = 1.0 + self.tangent * self.tangent;
        let way = 2.0 * self.tangent * (1.0 - self.tangent * w) / (w * square);
        let transmittance = if self.depth == 0.0 {
            1.0
        } else {
            (-self.depth * way).exp()
        };
        2.0 / (1.0 + w * w) * self.phase.value_f64(angle) * transmittance
    }

    /// `tan(ψ/2)/h` at a position of the far sheet, and its slope: the position y is
    /// `½ (q_m/q + (P + q_m)/(P + q))`.
    fn far_position(&self, y: f64) -> [f64; 2] {
        let Self { p, q_m, .. } = *self;
        if y == 0.0 {
            return [0.0, 2.0 / (2.0 * q_m + p)];
        }
        let b = 2.0 * y * p - 2.0 * q_m - p;
        let root = (b * b + 8.0 * y * q_m * p).sqrt();
        let q = if b > 0.0 {
            2.0 * q_m * p / (b + root)
        } else {
            (root - b) / (4.0 * y)
        };
        let slope = -0.5 * (q_m / (q * q) + (p + q_m) / (p + q).powi(2));
        [1.0 / q, -1.0 / (q * q * slope)]
    }

    /// The factor of the slope of the mean in the density at a position of a sheet: `v dy/dv`.
    fn lever(&self, sheet: usize, y: f64) -> f64 {
        if sheet == 0 {
            return y;
        }
        let [v, slope] = self.far_position(y);
        v / slope
    }

    fn row(&self, rule: &gauss::Rule, cells: u32) -> Row {
        let near_density = |u: f64| self.near(u * self.largest);
        let near = means(rule, cells, near_density, |u| [u, 1.0]);
        let far_density = |z: f64| self.far(self.h * z);
        [
            near,
            means(rule, cells, far_density, |y| self.far_position(y)),
        ]
    }
}

/// Cubics of the mean of a density over `[0, v]` in cells that are even in y, where
/// `position` is v and its slope at y.
fn means(
    rule: &gauss::Rule,
    cells: u32,
    density: impl Fn(f64) -> f64,
    position: impl Fn(f64) -> [f64; 2],
) -> Vec<Cell> {
    let width = 1.0 / f64::from(cells);
    let between = |from: f64, to: f64| {
        let nodes = rule.iter();
        let sum: f64 = nodes
            .map(|(t, weight)| weight * density(from + (to - from) * t))
            .sum();
        (to - from) * sum
    };
    // Mean and its slope per cell, from the integral up to y.
    let state = |y: f64, sum: f64| {
        let [v, slope] = position(y);
        let mean = sum / v;
        (v, [mean, (density(v) - mean) / v * slope * width])
    };
    let densities_follow = |cubic: [f64; 4], y: f64| {
        [0.25, 0.75].into_iter().all(|t| {
            let [v, slope] = position(y + t * width);
            let ([mean, rise], truth) = (at(cubic, t), density(v));
            (mean + rise * v / (slope * width) - truth).abs() <= SLOPES_FOLLOW * truth
        })
    };
    let cell_of = |cubic: [f64; 4], y: f64, mean: f64| {
        let mut cell = checked(cubic, mean);
        cell.follows &= densities_follow(cubic, y);
        cell
    };
    let mut sum = 0.0;
    let mut start = 0.0;
    let mut known = [0.0; 2];
    (0..cells)
        .map(|cell| {
            if cell == 0 {
                // The first cubic goes through two values in between instead of having the
                // slope at 0, which the density may lack.
                let [one, two, v] = [1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t| position(t * width)[0]);
                let first = between(0.0, one);
                let second = first + between(one, two);
                sum = second + between(two, v);
                (start, known) = state(width, sum);
                let cubic = through(first / one, second / two, known);
                let middle = position(0.5 * width)[0];
                return cell_of(cubic, 0.0, between(0.0, middle) / middle);
            }
            let y = f64::from(cell) * width;
            let middle = position(y + 0.5 * width)[0];
            sum += between(start, middle);
            let mean = sum / middle;
            sum += between(middle, position(y + width)[0]);
            let (v, end) = state(y + width, sum);
            let [from, rise] = known;
            let [to, fall] = end;
            (start, known) = (v, end);
            let change = to - from;
            let cubic = [
                from,
                rise,
                3.0 * change - 2.0 * rise - fall,
                rise + fall - 2.0 * change,
            ];
            cell_of(cubic, y, mean)
        })
        .collect()
}

/// A cell, which follows if its value in the middle is about `mean`.
fn checked(cubic: [f64; 4], mean: f64) -> Cell {
    let [middle, _] = at(cubic, 0.5);
    // A negative first coefficient marks cells that are not known.
    let follows = cubic[0] >= 0.0 && (middle - mean).abs() <= FOLLOWS * mean;
    Cell { cubic, follows }
}

/// Whether the mean of two cubics is about the cubic half way between them, at both ends
/// and in the middle, and the same holds for the densities, in which slopes count with the
/// `levers`.
fn is_between(above: &Cell, below: &Cell, middle: &Cell, levers: [f64; 3]) -> bool {
    let mean = [0, 1, 2, 3].map(|i| 0.5 * (above.cubic[i] + below.cubic[i]));
    let is_near = |found: f64, truth: f64| (found - truth).abs() <= ACROSS * truth;
    let agree = [0.0, 0.5, 1.0].into_iter().zip(levers).all(|(t, lever)| {
        let ([found, slope], [truth, rise]) = (at(mean, t), at(middle.cubic, t));
        // Where a sheet begins there may be no light.
        lever == 0.0
            || is_near(found, truth) && is_near(found + lever * slope, truth + lever * rise)
    });
    middle.follows && agree
}

/// A cubic and its slope.
fn at([a, b, c, d]: [f64; 4], t: f64) -> [f64; 2] {
    [
        a + t * (b + t * (c + t * d)),
        b + t * (2.0 * c + 3.0 * t * d),
    ]
}

/// The cubic with a negative first coefficient if the light between this row and the next one
/// is not known. Its magnitude stays, for the row before.
fn marked(cubic: [f64; 4], is_known: bool) -> [f32; 4] {
    let mut cubic = cubic.map(|c| c as f32);
    if !is_known {
        cubic[0] = -cubic[0].abs().max(f32::MIN_POSITIVE);
    }
    cubic
}

/// The cubic on `[0, 1]` with these values at ⅓ and ⅔, and this value and slope at 1.
fn through(one: f64, two: f64, [three, slope]: [f64; 2]) -> [f64; 4] {
    // In r = 1 − t: three − slope r + a r² + b r³.
    let excess = |value: f64, r: f64| (value - three + slope * r) / (r * r);
    let (first, second) = (excess(one, 2.0 / 3.0), excess(two, 1.0 / 3.0));
    let b = 3.0 * (first - second);
    let a = second - b / 3.0;
    [
        three - slope + a + b,
        slope - 2.0 * a - 3.0 * b,
        a + 3.0 * b,
        -b,
    ]
}
