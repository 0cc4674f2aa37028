//! The parts of a ray that are dark, and those behind something see-through.

use std::cmp::Ordering;

use glam::Vec3;

use crate::visibility::{LitInterval, Share};
use crate::{Interval, LightPath};

/// A part of the ray's line behind something see-through.
#[derive(Debug, Clone, Copy)]
struct Filter {
    start: f32,
    end: f32,
    transmittance: Vec3,
}

impl Filter {
    /// The key by which filters are sorted.
    fn in_order(&self) -> [f32; 5] {
        let [red, green, blue] = self.transmittance.to_array();
        [self.start, self.end, red, green, blue]
    }
}

/// Filters that are passed in order.
struct Filters {
    /// By their starts.
    all: Vec<Filter>,
    /// Starts and ends of all, in order.
    changes: Vec<f32>,
    /// Changes that lie behind.
    passed: usize,
    /// How many of them have begun.
    begun: usize,
    /// Those that have begun and not yet ended.
    active: Vec<Filter>,
}

impl Filters {
    fn new(mut all: Vec<Filter>) -> Self {
        // A product of the same factors in another order may differ in its last digit.
        all.sort_unstable_by(|a, b| {
            let pairs = a.in_order().into_iter().zip(b.in_order());
            pairs.fold(Ordering::Equal, |so_far, (a, b)| {
                so_far.then(a.total_cmp(&b))
            })
        });
        let mut changes: Vec<f32> = all.iter().flat_map(|f| [f.start, f.end]).collect();
        changes.sort_unstable_by(f32::total_cmp);
        changes.dedup();
        Self {
            all,
            changes,
            passed: 0,
            begun: 0,
            active: Vec::new(),
        }
    }

    /// Appends the part from `start` to `end`, cut where filters begin and end;
    /// calls must come in order.
    fn split(&mut self, start: f32, end: f32, lit: &mut Vec<LitInterval<Vec3>>) {
        let mut from = start;
        while from < end {
            while self.changes.get(self.passed).is_some_and(|at| *at <= from) {
                self.passed += 1;
            }
            let to = self.changes.get(self.passed).map_or(end, |at| at.min(end));
            while let Some(next) = self.all.get(self.begun)
                && next.start <= from
            {
                self.active.push(*next);
                self.begun += 1;
            }
            self.active.retain(|filter| from < filter.end);
            let shares = self.active.iter().map(|filter| filter.transmittance);
            let visibility: Vec3 = shares.product();
            if !visibility.is_dark() {
                lit.push(LitInterval {
                    interval: Interval::new(from, to),
                    visibility,
                });
            }
            from = to;
        }
    }
}

/// The dark part of a span, and what of it is seen through something.
///
/// It does not depend on the order in which blockers come, nor on blockers whose shadows
/// are dark already.
pub(super) struct Shadow {
    start: f64,
    end: f64,
    /// Intervals in order that do not touch, to the rounding of their ends.
    dark: Vec<(f32, f32)>,
    filters: Vec<Filter>,
}

impl Shadow {
    pub(super) fn new(path: &LightPath<'_>) -> Self {
        Self {
            start: f64::from(path.span().start),
            end: f64::from(path.span().end),
            dark: Vec::new(),
            filters: Vec::new(),
        }
    }

    /// Takes away from `[a, b]` what does not pass.
    pub(super) fn filter(&mut self, a: f64, b: f64, transmittance: Vec3) {
        if transmittance.is_dark() {
            self.insert(a, b);
        } else if transmittance != Vec3::ONE
            && let Some((a, b)) = self.clip(a, b)
        {
            let (start, end) = (a as f32, b as f32);
            if start < end {
                self.filters.push(Filter {
                    start,
                    end,
                    transmittance,
                });
            }
        }
    }

    /// The part of `[a, b]` in the span.
    pub(super) fn clip(&self, a: f64, b: f64) -> Option<(f64, f64)> {
        let (a, b) = (a.max(self.start), b.min(self.end));
        (a < b).then_some((a, b))
    }

    /// Whether any of the span is dark or filtered, to the rounding of its ends.
    pub(super) fn darkens(&self) -> bool {
        let (start, end) = (self.start as f32, self.end as f32);
        let is_inside = |&(a, b): &(f32, f32)| a < end && start < b;
        !self.filters.is_empty() || self.dark.iter().any(is_inside)
    }

    /// Whether all of the span is dark.
    pub(super) fn is_whole(&self) -> bool {
        let (start, end) = (self.start as f32, self.end as f32);
        matches!(self.dark[..], [(a, b)] if a <= start && end <= b)
    }

    /// True if all of `[a, b]`, a part of the span, is dark.
    pub(super) fn covers(&self, a: f64, b: f64) -> bool {
        let (a, b) = (a as f32, b as f32);
        let next = self.dark.partition_point(|dark| dark.1 < a);
        self.dark
            .get(next)
            .is_some_and(|dark| dark.0 <= a && b <= dark.1)
    }

    pub(super) fn insert(&mut self, a: f64, b: f64) {
        let Some((a, b)) = self.clip(a, b) else {
            return;
        };
        let (a, b) = (a as f32, b as f32);
        let first = self.dark.partition_point(|dark| dark.1 < a);
        let Some(dark) = self.dark.get_mut(first).filter(|dark| dark.0 <= b) else {
            self.dark.insert(first, (a, b));
            return;
        };
        dark.0 = dark.0.min(a);
        if dark.1 < b {
            let touched = self.dark[first..].iter().take_while(|dark| dark.0 <= b);
            let last = first + touched.count() - 1;
            self.dark[first].1 = b.max(self.dark[last].1);
            self.dark.drain(first + 1..=last);
        }
    }

    /// Appends what is left of the light of the span.
    pub(super) fn lit(self, lit: &mut Vec<LitInterval<Vec3>>) {
        let mut filters = Filters::new(self.filters);
        let mut put = |start: f32, end: f32| {
            if start < end {
                filters.split(start, end, lit);
            }
        };
        let mut lit_from = self.start as f32;
        for (a, b) in self.dark {
            put(lit_from, a);
            lit_from = b;
        }
        put(lit_from, self.end as f32);
    }
}
