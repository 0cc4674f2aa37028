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
}

/// A union of spans: what is known to be dark.
#[derive(Debug, Clone, Default)]
pub(super) struct Dark {
    /// In order, apart from each other.
    parts: Vec<Span>,
}

impl Dark {
    /// Adds a span.
    pub(super) fn add(&mut self, span: Span) {
        let first = self.parts.partition_point(|part| part.end < span.start);
        let last = self.parts.partition_point(|part| part.start <= span.end);
        let mut union = span;
        if first < last {
            union.start = union.start.min(self.parts[first].start);
            union.end = union.end.max(self.parts[last - 1].end);
        }
        self.parts.splice(first..last, [union]);
    }

    /// The dark parts, in order and apart from each other.
    pub(super) fn parts(&self) -> &[Span] {
        &self.parts
    }

    /// True if all of `span` is dark.
    pub(super) fn contains(&self, span: Span) -> bool {
        let after = self.parts.partition_point(|part| part.start <= span.start);
        after > 0 && span.end <= self.parts[after - 1].end
    }

    /// Appends to `lit` what is left of `whole`, in order.
    ///
    /// What is left between two dark parts is dropped if it is not longer than
    /// `crack`: two triangles that share an edge leave no light between them,
    /// however their ends were rounded.
    pub(super) fn leave(&self, whole: Span, crack: f64, lit: &mut Vec<Span>) {
        let mut from = whole.start;
        for part in &self.parts {
            if part.end <= from {
                continue;
            }
            if part.start >= whole.end {
                break;
            }
            if part.start - from > crack {
                lit.push(Span::new(from, part.start));
            }
            from = part.end;
        }
        if whole.end - from > crack || (from == whole.start && from < whole.end) {
            lit.push(Span::new(from, whole.end));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(whole: Span, holes: &[Span]) -> Vec<Span> {
        let (mut dark, mut lit) = (Dark::default(), Vec::new());
        for hole in holes {
            dark.add(*hole);
            assert!(dark.contains(*hole));
        }
        dark.leave(whole, 1e-12, &mut lit);
        lit
    }

    #[test]
    fn shadows_may_overlap_touch_and_stick_out() {
        let holes = [
            Span::new(4.0, 5.0),
            Span::new(-3.0, 1.0),
            Span::new(2.0, 4.0),
            Span::new(2.5, 3.0),
            Span::new(9.0, f64::INFINITY),
            Span::new(20.0, 21.0),
        ];
        let lit = left(Span::new(0.0, 10.0), &holes);
        assert_eq!(lit, [Span::new(1.0, 2.0), Span::new(5.0, 9.0)]);
        assert_eq!(left(Span::new(2.0, 5.0), &holes), []);
    }

    #[test]
    fn cracks_are_dark_but_a_short_span_of_its_own_is_not() {
        let holes = [Span::new(0.0, 1.0), Span::new(1.0 + 1e-13, 3.0)];
        assert_eq!(left(Span::new(0.5, 2.0), &holes), []);
        let short = Span::new(0.0, 1e-15);
        assert_eq!(left(short, &[]), [short]);
    }

    #[test]
    fn only_what_one_part_covers_is_contained() {
        let mut dark = Dark::default();
        assert!(!dark.contains(Span::new(0.0, 1.0)));
        dark.add(Span::new(0.0, 1.0));
        dark.add(Span::new(2.0, 3.0));
        assert!(dark.contains(Span::new(2.0, 3.0)) && !dark.contains(Span::new(0.5, 2.5)));
        dark.add(Span::new(1.0, 2.0));
        assert!(dark.contains(Span::new(0.5, 2.5)));
    }
}
