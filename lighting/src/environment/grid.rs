//! Grids of texels over all directions.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

/// Numbers of texels, evenly spaced in longitude and in latitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Grid {
    pub(super) fn len(self) -> usize {
        self.width * self.height
    }

    /// The grid, made no larger than this and no smaller than the convolution needs.
    pub(super) fn limited(self, width: usize, height: usize) -> Self {
        Self {
            width: self.width.clamp(4, width),
            height: self.height.clamp(2, height),
        }
    }

    /// The four texels around a direction, with their weights for bilinear interpolation.
    pub(super) fn around(self, direction: Vec3) -> [(usize, f32); 4] {
        let Vec3 { x, y, z } = direction;
        let column = (x.atan2(-z) / (2.0 * PI) + 0.5) * self.width as f32 - 0.5;
        let row = x.hypot(z).atan2(y) / PI * self.height as f32 - 0.5;
        let (left, top) = (column.floor(), row.floor());
        let (u, v) = (column - left, row - top);
        let column = |c: i64| c.rem_euclid(self.width as i64) as usize;
        let row = |r: i64| r.clamp(0, self.height as i64 - 1) as usize;
        let (left, top) = (left as i64, top as i64);
        let at = |r: i64, c: i64| row(r) * self.width + column(c);
        [
            (at(top, left), (1.0 - u) * (1.0 - v)),
            (at(top, left + 1), u * (1.0 - v)),
            (at(top + 1, left), (1.0 - u) * v),
            (at(top + 1, left + 1), u * v),
        ]
    }

    /// `∫ ω dω` over a texel.
    pub(super) fn weighted_direction(self, index: usize) -> Vec3 {
        let (row, column) = (index / self.width, index % self.width);
        let angle = |i: usize, n: usize, whole: f64| whole * i as f64 / n as f64;
        let pi = std::f64::consts::PI;
        let (upper, lower) = (angle(row, self.height, pi), angle(row + 1, self.height, pi));
        let (west, east) = (
            angle(column, self.width, 2.0 * pi) - pi,
            angle(column + 1, self.width, 2.0 * pi) - pi,
        );
        // ω = (sin θ sin λ, cos θ, −sin θ cos λ), dω = sin θ dθ dλ.
        let sin2 = 0.5 * (lower - upper) - 0.25 * ((2.0 * lower).sin() - (2.0 * upper).sin());
        let sin_cos = 0.5 * (lower.sin().powi(2) - upper.sin().powi(2));
        DVec3::new(
            sin2 * (west.cos() - east.cos()),
            sin_cos * (east - west),
            -sin2 * (east.sin() - west.sin()),
        )
        .as_vec3()
    }

    /// The same picture on another grid; every texel has the mean of what it covers.
    pub(super) fn resampled(self, texels: &[[f32; 3]], target: Self) -> Vec<[f32; 3]> {
        if self == target {
            return texels.to_vec();
        }
        let pi = std::f64::consts::PI;
        let rows = overlaps(self.height, target.height, |t| -(pi * t).cos());
        let columns = overlaps(self.width, target.width, |t| t);
        rows.iter()
            .flat_map(|rows| columns.iter().map(move |columns| (rows, columns)))
            .map(|(rows, columns)| {
                let mut sum = [0.0_f64; 3];
                for (row, height) in rows {
                    for (column, width) in columns {
                        let texel = texels[row * self.width + column];
                        for (sum, value) in sum.iter_mut().zip(texel) {
                            *sum += height * width * f64::from(value);
                        }
                    }
                }
                sum.map(|value| value as f32)
            })
            .collect()
    }
}

/// For each of `to` equal parts of [0, 1], the parts of `from` equal ones that it covers, with
/// shares that sum to 1. Lengths are measured by `along`.
fn overlaps(from: usize, to: usize, along: impl Fn(f64) -> f64) -> Vec<Vec<(usize, f64)>> {
    let edge = |i: usize, n: usize| i as f64 / n as f64;
    (0..to)
        .map(|target| {
            let (start, end) = (edge(target, to), edge(target + 1, to));
            let whole = along(end) - along(start);
            let first = target * from / to;
            let last = ((target + 1) * from).div_ceil(to).min(from);
            (first..last)
                .map(|source| {
                    let low = edge(source, from).max(start);
                    let high = edge(source + 1, from).min(end);
                    (source, ((along(high) - along(low)) / whole).max(0.0))
                })
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid {
        width: 24,
        height: 12,
    };

    #[test]
    fn weighted_directions_sum_to_nothing_and_point_into_their_texels() {
        let all: Vec3 = (0..GRID.len()).map(|i| GRID.weighted_direction(i)).sum();
        assert!(all.length() < 1e-5, "{all}");
        for index in 0..GRID.len() {
            let direction = GRID.weighted_direction(index).normalize();
            let nearest = GRID
                .around(direction)
                .into_iter()
                .max_by(|a, b| a.1.total_cmp(&b.1));
            assert_eq!(nearest.map(|(texel, _)| texel), Some(index), "{direction}");
        }
    }

    #[test]
    fn the_middle_of_a_picture_is_ahead_and_its_right_is_right() {
        let brightest = |direction: Vec3| {
            let [first, ..] = GRID.around(direction);
            (first.0 % 24, first.0 / 24)
        };
        assert_eq!(brightest(Vec3::NEG_Z), (11, 5));
        assert_eq!(brightest(Vec3::X).0, 17);
        assert_eq!(brightest(Vec3::Y).1, 0);
        assert_eq!(brightest(Vec3::NEG_Y).1, 11);
    }

    #[test]
    fn resampling_keeps_what_is_even_and_the_flux_of_what_is_not() {
        let source = Grid {
            width: 7,
            height: 5,
        };
        let texels: Vec<[f32; 3]> = (0..source.len()).map(|i| [i as f32, 1.0, 0.0]).collect();
        let flux = |grid: Grid, texels: &[[f32; 3]]| -> f64 {
            let rows = overlaps(grid.height, 1, |t| -(std::f64::consts::PI * t).cos());
            let row = |row: usize| texels[row * grid.width..][..grid.width].iter();
            rows[0]
                .iter()
                .map(|(r, share)| {
                    share / grid.width as f64 * row(*r).map(|t| f64::from(t[0])).sum::<f64>()
                })
                .sum()
        };
        for target in [
            GRID,
            Grid {
                width: 4,
                height: 2,
            },
        ] {
            let result = source.resampled(&texels, target);
            assert!(result.iter().all(|texel| (texel[1] - 1.0).abs() < 1e-6));
            let (before, after) = (flux(source, &texels), flux(target, &result));
            assert!((after / before - 1.0).abs() < 1e-6, "{before} {after}");
        }
    }
}
