//! Values between those that are known.

/// The value at `x` of the straight lines through points `(ln x, ln y)`, which go on
/// beyond the ends; that of the only point, if there is one alone, and `None` if there is
/// none. Points are sorted by `x`, and all numbers are positive.
pub(super) fn along_logarithms(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let first = points.first()?;
    if points.len() == 1 {
        return Some(first.1);
    }
    let after = points.partition_point(|point| point.0 < x);
    let after = after.clamp(1, points.len() - 1);
    let [(x0, y0), (x1, y1)] = [points[after - 1], points[after]];
    let run = (x1 / x0).ln();
    if run == 0.0 {
        return Some(y0);
    }
    Some(y0 * ((y1 / y0).ln() * (x / x0).ln() / run).exp())
}
