//! Segments that are hard for numbers, for tests.

use reference::oracle::segment::Part;
use reference::random::halton;
use reference::segments::random_stiff;

use crate::Segment;

/// Extinctions and segments of the list of random stiff ones.
pub(crate) fn cases(number: usize) -> Vec<(f32, Segment)> {
    let case = |(sigma_t, Part { x, s, h, length })| (sigma_t, Segment { x, s, h, length });
    random_stiff(number).into_iter().map(case).collect()
}

/// Segments that start at the eye, 1 m from the light, at all angles: half of them
/// endless, the others from 1e-3 m to 1e3 m long, through extinctions from 1e-3 to
/// 10 per metre. The logarithms of tan(θ/2) from 1e-4 to 1e4, of the length and of
/// the extinction are spread evenly.
pub(crate) fn spread(number: u32) -> impl Iterator<Item = (f32, Segment)> {
    let log = |from: f64, to: f64, unit: f64| from * (to / from).powf(unit);
    (1..=number).map(move |index| {
        let tangent = log(1e-4, 1e4, halton(index, 2));
        let square = tangent * tangent;
        let length = if index.is_multiple_of(3) {
            log(1e-3, 1e3, halton(index, 7))
        } else {
            f64::INFINITY
        };
        let segment = Segment {
            x: 0.0,
            s: ((square - 1.0) / (1.0 + square)) as f32,
            h: (2.0 * tangent / (1.0 + square)) as f32,
            length: length as f32,
        };
        (log(1e-3, 10.0, halton(index, 5)) as f32, segment)
    })
}
