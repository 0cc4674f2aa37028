//! How rays share the work of a picture.

use std::ops::Range;

/// How rays share the parts of some work, so that each takes only one part in so many
/// (interleaved sampling: Keller and Heidrich, Interleaved Sampling, EGWR 2001).
///
/// The parts, lights or steps, are summed. The first `of · each` rays take turns in runs of
/// `each`: ray i takes the parts
///
/// ```text
/// k, k + of, k + 2 of, …    with k = ⌊i / each⌋,
/// ```
///
/// and weights them by `of`, so that the mean over rays with all values of k is the sum of all
/// parts. The rays after these take all parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interleaving {
    of: u32,
    each: u32,
}

/// The parts that one ray takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Index of the first part.
    pub index: u32,
    /// The stride from one part to the next, at least 1.
    pub of: u32,
}

impl Part {
    /// All parts.
    pub const ALL: Self = Self { index: 0, of: 1 };

    /// The indices, below `count`, of the parts that are taken.
    pub fn numbers(self, count: u32) -> impl Iterator<Item = u32> {
        (self.index..count).step_by(self.of as usize)
    }

    /// The factor by which the parts are weighted: the stride.
    pub fn weight(self) -> f32 {
        self.of as f32
    }
}

impl Default for Interleaving {
    fn default() -> Self {
        Self::NONE
    }
}

impl Interleaving {
    /// Every ray takes all parts.
    pub const NONE: Self = Self { of: 1, each: 0 };

    /// Runs of `each` rays take every `of`-th part. With 0 rays or 1 part every ray takes all.
    pub fn new(of: u32, each: u32) -> Self {
        if of <= 1 || each == 0 {
            return Self::NONE;
        }
        Self { of, each }
    }

    /// Whether every ray takes all parts.
    pub fn is_none(self) -> bool {
        self.of == 1
    }

    /// The stride between the parts that a ray takes.
    pub fn of(self) -> u32 {
        self.of
    }

    /// The number of rays in a run; 0 if every ray takes all parts.
    pub fn each(self) -> u32 {
        self.each
    }

    /// The parts that ray number `ray` takes.
    pub fn part(self, ray: u32) -> Part {
        match ray.checked_div(self.each) {
            Some(index) if index < self.of => Part { index, of: self.of },
            _ => Part::ALL,
        }
    }

    /// The runs of rays that take the same parts, of `rays` rays in all; every ray is in one of
    /// the runs.
    pub fn runs(self, rays: usize) -> impl Iterator<Item = (Range<usize>, Part)> {
        let shared = if self.is_none() { 0 } else { self.of };
        let each = self.each as usize;
        let runs = (0..shared).map(move |index| {
            let start = (index as usize * each).min(rays);
            let end = (start + each).min(rays);
            (start..end, Part { index, of: self.of })
        });
        let first = (shared as usize * each).min(rays);
        runs.chain(std::iter::once((first..rays, Part::ALL)))
            .filter(|(run, _)| !run.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_what_each_ray_takes() {
        for (of, each, rays) in [(1, 0, 7), (4, 2, 11), (4, 2, 5), (9, 1, 9), (3, 5, 0)] {
            let all = Interleaving::new(of, each);
            let mut next = 0;
            for (run, part) in all.runs(rays) {
                assert_eq!(run.start, next);
                next = run.end;
                assert!(run.into_iter().all(|ray| all.part(ray as u32) == part));
            }
            assert_eq!(next, rays);
        }
        assert_eq!(Interleaving::new(1, 5), Interleaving::NONE);
        assert_eq!(Interleaving::new(4, 0), Interleaving::default());
    }

    #[test]
    fn the_parts_of_all_runs_are_everything_once() {
        for count in [0, 1, 5, 9, 10] {
            let all = Interleaving::new(9, 1);
            let mut taken: Vec<u32> = (0..9)
                .flat_map(|ray| all.part(ray).numbers(count))
                .collect();
            taken.sort_unstable();
            assert_eq!(taken, (0..count).collect::<Vec<_>>());
        }
        let part = Interleaving::new(9, 1).part(3);
        assert_eq!(part.weight(), 9.0);
        assert_eq!(Part::ALL.numbers(3).collect::<Vec<_>>(), [0, 1, 2]);
    }
}
