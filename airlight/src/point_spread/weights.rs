//! How much each texel of a map of directions adds at the centre of another.

use std::f64::consts::PI;

use super::Table;
use crate::gauss::Rule;

/// Beyond this many texels the value at the centre of a texel stands for its
/// mean: for a function like `1/γ²`, the steepest of them, that is off by
/// `(2/γ)² / 24` squared texels, 1e-4.
const FAR: f64 = 40.0;
/// That is so if the sphere is flat over a texel: the bend of the sphere over
/// larger ones, in radians, is as much, `1/24` squared texels.
const FLAT: f64 = 0.03;
/// Beyond this many texels four points do: off by less than 1e-4 too.
const NEAR: f64 = 6.0;
/// A piece of a texel is integrated by a 4 × 4 rule if the centre is this many
/// times its half-diagonal away. The integrand is analytic within that
/// distance, so the error is about `(3 + √8)^{-8}`, 1e-6.
const APART: f64 = 3.0;
/// Smallest piece of a texel, relative to the texel: what is nearer to the
/// centre counts as much, since N grows like 1/γ.
const SMALLEST: f64 = 1e-6;

/// The integrals of N over texels of a map of directions.
#[derive(Debug)]
pub(super) struct Weights<'a> {
    spread: &'a Table,
    width: usize,
    height: usize,
    /// `sin²(φ/2)` of the differences of longitude between the centre of one
    /// texel and points of another, in its own order: all centres, and then
    /// the two Gauss nodes on either side.
    centres: Vec<f64>,
    pairs: Vec<[f64; 2]>,
    rule: Rule,
}

impl<'a> Weights<'a> {
    pub(super) fn new(spread: &'a Table, width: usize, height: usize) -> Self {
        let step = 2.0 * PI / width as f64;
        let haversine = |columns: f64| (0.5 * step * columns).sin().powi(2);
        let offset = 0.5 / 3.0_f64.sqrt();
        let columns = 0..=width / 2;
        Self {
            spread,
            width,
            height,
            centres: columns.clone().map(|d| haversine(d as f64)).collect(),
            pairs: columns
                .map(|d| [haversine(d as f64 - offset), haversine(d as f64 + offset)])
                .collect(),
            rule: Rule::of(4),
        }
    }

    fn polar_angle(&self, row: f64) -> f64 {
        PI * row / self.height as f64
    }

    /// `∫ N dω` over the texels of row `from`, as seen from the centre of a
    /// texel of row `at`, by their distance in columns, from 0 to half of the
    /// width.
    pub(super) fn row(&self, at: usize, from: usize, weights: &mut [f64]) {
        let h = PI / self.height as f64;
        let step = 2.0 * PI / self.width as f64;
        let centre = self.polar_angle(at as f64 + 0.5);
        let polar = self.polar_angle(from as f64 + 0.5);
        // sin²(γ/2) = sin²(Δθ/2) + sin θ sin θ' sin²(Δφ/2)
        let terms = |polar: f64| {
            let apart = (0.5 * (polar - centre)).sin();
            (apart * apart, centre.sin() * polar.sin())
        };
        let texel = h.max(step * polar.sin());
        let (across, along) = terms(polar);
        let columns_within = |angle: f64| {
            if angle >= PI {
                return self.centres.len();
            }
            let limit = (0.5 * angle).sin().powi(2);
            self.centres
                .partition_point(|haversine| across + along * haversine < limit)
        };
        let near = columns_within(NEAR * texel);
        let middle = columns_within(if texel < FLAT { FAR * texel } else { PI });

        for (columns, weight) in weights[..near].iter_mut().enumerate() {
            *weight = self.texel(centre, from, columns);
        }
        if near < middle {
            let offset = 0.5 * h / 3.0_f64.sqrt();
            let rows = [polar - offset, polar + offset].map(|polar| {
                let (across, along) = terms(polar);
                (across, along, 0.25 * h * step * polar.sin())
            });
            for (weight, pair) in weights[near..middle].iter_mut().zip(&self.pairs[near..]) {
                *weight = 0.0;
                for (across, along, area) in rows {
                    for haversine in pair {
                        *weight += area * self.value(across + along * haversine);
                    }
                }
            }
        }
        let area = 2.0 * (0.5 * h).sin() * step * polar.sin();
        for (weight, haversine) in weights[middle..].iter_mut().zip(&self.centres[middle..]) {
            *weight = area * self.value(across + along * haversine);
        }
    }

    fn value(&self, q: f64) -> f64 {
        f64::from(self.spread.value(q as f32))
    }

    /// The integral over one texel that may be close to the centre or around
    /// it, by dividing it until every piece is far away for its size.
    fn texel(&self, centre: f64, row: usize, columns: usize) -> f64 {
        let step = 2.0 * PI / self.width as f64;
        let polar = [
            self.polar_angle(row as f64),
            self.polar_angle(row as f64 + 1.0),
        ];
        let smallest = SMALLEST * (polar[1] - polar[0]);
        // The texel around the centre is symmetric about its middle column.
        let (longitude, count) = if columns == 0 {
            ([0.0, 0.5 * step], 2.0)
        } else {
            let middle = columns as f64 * step;
            ([middle - 0.5 * step, middle + 0.5 * step], 1.0)
        };
        count * self.piece(centre, polar, longitude, smallest)
    }

    fn piece(&self, centre: f64, polar: [f64; 2], longitude: [f64; 2], smallest: f64) -> f64 {
        let middle = [
            0.5 * (polar[0] + polar[1]),
            0.5 * (longitude[0] + longitude[1]),
        ];
        let height = polar[1] - polar[0];
        let width = longitude[1] - longitude[0];
        let q = |polar: f64, longitude: f64| {
            (0.5 * (polar - centre)).sin().powi(2)
                + centre.sin() * polar.sin() * (0.5 * longitude).sin().powi(2)
        };
        let wide = width * middle[0].sin();
        let radius = 0.5 * height.hypot(wide);
        let distance = 2.0 * q(middle[0], middle[1]).sqrt().min(1.0).asin();
        if distance < APART * radius && radius > smallest {
            return if height > wide {
                self.piece(centre, [polar[0], middle[0]], longitude, smallest)
                    + self.piece(centre, [middle[0], polar[1]], longitude, smallest)
            } else {
                self.piece(centre, polar, [longitude[0], middle[1]], smallest)
                    + self.piece(centre, polar, [middle[1], longitude[1]], smallest)
            };
        }
        let mut sum = 0.0;
        for (y, row_weight) in self.rule.iter() {
            let theta = polar[0] + height * y;
            let area = row_weight * height * width * theta.sin();
            for (x, weight) in self.rule.iter() {
                sum += area * weight * self.value(q(theta, longitude[0] + width * x));
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::exact;
    use super::*;

    /// Σ over all texels of a map, which is the integral over the sphere.
    fn total(weights: &Weights<'_>, at: usize) -> f64 {
        let (width, height) = (weights.width, weights.height);
        let mut row = vec![0.0; width / 2 + 1];
        let mut sum = 0.0;
        for from in 0..height {
            weights.row(at, from, &mut row);
            sum += (0..width).map(|d| row[d.min(width - d)]).sum::<f64>();
        }
        sum
    }

    #[test]
    fn the_weights_of_every_texel_sum_to_the_total() {
        for (width, height) in [
            (1, 1),
            (2, 1),
            (3, 2),
            (16, 8),
            (37, 20),
            (512, 256),
            (64, 200),
        ] {
            for t in [0.0, 0.1, 2.0, 50.0] {
                let spread = Table::new(t).unwrap();
                let weights = Weights::new(&spread, width, height);
                for at in [0, height / 7, height / 2, height - 1] {
                    let error = total(&weights, at) / exact::total(t.into()) - 1.0;
                    // The bounds of the table and of the rules, and N at the
                    // smallest pieces.
                    assert!(
                        error.abs() < 1e-4,
                        "{width} x {height}, T {t}, row {at}: {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_weight_is_the_integral_over_its_texel() {
        let (width, height) = (96, 48);
        for t in [0.5, 50.0] {
            let spread = Table::new(t).unwrap();
            let weights = Weights::new(&spread, width, height);
            let mut row = vec![0.0; width / 2 + 1];
            for (at, from) in [
                (0, 0),
                (0, 1),
                (0, 7),
                (3, 5),
                (24, 24),
                (24, 25),
                (24, 30),
                (20, 47),
                (24, 8),
            ] {
                weights.row(at, from, &mut row);
                let centre = weights.polar_angle(at as f64 + 0.5);
                for (columns, weight) in row.iter().enumerate() {
                    // Every texel by the rule for near ones.
                    let expected = weights.texel(centre, from, columns);
                    let error = weight / expected - 1.0;
                    assert!(
                        error.abs() < 1.5e-4,
                        "T {t}, rows {at} {from}, column {columns}: {error:e}"
                    );
                }
            }
        }
    }
}
