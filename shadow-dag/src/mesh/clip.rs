//! Triangles cut off where they leave the range of numbers.

use glam::DVec4;

/// The part of a polygon in which `distance`, linear in its argument, is not
/// negative.
///
/// A new corner is computed from the ends of its edge in an order that does
/// not depend on the direction, so that triangles that shared the edge still
/// share it.
pub(crate) fn clip(polygon: &mut Vec<DVec4>, distance: impl Fn(DVec4) -> f64) {
    if polygon.iter().all(|corner| distance(*corner) >= 0.0) {
        return;
    }
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        let (d_from, d_to) = (distance(from), distance(to));
        if d_from >= 0.0 {
            kept.push(from);
        }
        if (d_from >= 0.0) != (d_to >= 0.0) {
            let (inner, outer, a, b) = if d_from >= 0.0 {
                (from, to, d_from, d_to)
            } else {
                (to, from, d_to, d_from)
            };
            kept.push(inner + (outer - inner) * (a / (a - b)));
        }
    }
    *polygon = kept;
}
