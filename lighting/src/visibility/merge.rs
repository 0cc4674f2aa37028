//! Runs of lit steps as one interval.

use super::VisibilitySource;
use crate::{LightPath, LitInterval};

/// Joins lit intervals that touch and are equally visible.
///
/// A march yields one interval per lit step, which is right for an evaluator
/// that takes one sample of each. An evaluator that is accurate over an
/// interval of any length does better with whole runs: fewer calls, and no
/// error from the number of steps but at the ends of the runs.
#[derive(Debug, Clone, Copy)]
pub struct MergeTouching<V>(pub V);

impl<V: VisibilitySource> VisibilitySource for MergeTouching<V> {
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let first = lit.len();
        self.0.lit_intervals(path, lit);
        let mut last = first;
        for next in first + 1..lit.len() {
            if lit[last].interval.end == lit[next].interval.start
                && lit[last].visibility == lit[next].visibility
            {
                lit[last].interval.end = lit[next].interval.end;
            } else {
                last += 1;
                lit[last] = lit[next];
            }
        }
        lit.truncate((last + 1).min(lit.len()));
    }
}
