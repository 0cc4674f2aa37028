//! Segments that are hard for numbers, for tests.

use reference::oracle::segment::Part;
use reference::segments::random_stiff;

use crate::Segment;

/// Extinctions and segments of the list of random stiff ones.
pub(crate) fn cases(number: usize) -> Vec<(f32, Segment)> {
    let case = |(sigma_t, Part { x, s, h, length })| (sigma_t, Segment { x, s, h, length });
    random_stiff(number).into_iter().map(case).collect()
}
