//! Parts of a line and their differences.

/// The part of a line between two distances; `end` may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Where it starts.
    pub start: f64,
    /// Where it ends, above `start`.
    pub end: f64,
}

impl Span {
    /// From `start` to `end`.
    pub const fn new(start: f64, end: f64) -> Self {
        Self { start, end }
    }

    /// The common part, `None` if it is empty or a point.
    #[must_use]
    pub fn intersect(self, other: Self) -> Option<Self> {
        let (start, end) = (self.start.max(other.start), self.end.min(other.end));
        (start < end).then_some(Self { start, end })
    }

    /// Appends to `out` what is left of `self` without the `holes`, in order.
    /// The holes may overlap and come in any order; they are sorted here.
    ///
    /// What is left between two holes is dropped if it is not longer than
    /// `crack`: two triangles that share an edge leave no light between them,
    /// however their ends were rounded.
    pub fn without(self, holes: &mut [Self], crack: f64, out: &mut Vec<Self>) {
        holes.sort_by(|a, b| a.start.total_cmp(&b.start));
        let mut lit_from = self.start;
        for hole in holes {
            if hole.start >= self.end {
                break;
            }
            if hole.end <= lit_from {
                continue;
            }
            if hole.start - lit_from > crack {
                out.push(Self::new(lit_from, hole.start));
            }
            lit_from = lit_from.max(hole.end);
        }
        if self.end - lit_from > crack || (lit_from == self.start && lit_from < self.end) {
            out.push(Self::new(lit_from, self.end));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_may_overlap_touch_and_stick_out() {
        let mut holes = [
            Span::new(4.0, 5.0),
            Span::new(-3.0, 1.0),
            Span::new(2.0, 4.0),
            Span::new(2.5, 3.0),
            Span::new(9.0, f64::INFINITY),
        ];
        let mut lit = Vec::new();
        Span::new(0.0, 10.0).without(&mut holes, 1e-12, &mut lit);
        assert_eq!(lit, [Span::new(1.0, 2.0), Span::new(5.0, 9.0)]);
    }

    #[test]
    fn cracks_are_dark_but_a_short_span_of_its_own_is_not() {
        let mut lit = Vec::new();
        let mut holes = [Span::new(0.0, 1.0), Span::new(1.0 + 1e-13, 3.0)];
        Span::new(0.5, 2.0).without(&mut holes, 1e-12, &mut lit);
        assert_eq!(lit, []);
        Span::new(0.0, 1e-15).without(&mut [], 1e-12, &mut lit);
        assert_eq!(lit, [Span::new(0.0, 1e-15)]);
    }
}
