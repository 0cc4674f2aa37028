//! Interpolation between known values.

/// The value at `x` on straight lines through the points `(ln x, ln y)`, extended beyond the
/// ends. A single point gives its value everywhere; no point gives `None`. Points must be
/// sorted by `x`, and all numbers positive.
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
