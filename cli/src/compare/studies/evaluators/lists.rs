//! Lists of segments with their truths, and the errors of an evaluator on them.

use std::time::Instant;

use airlight::{Evaluator, FrameTable, PhaseFunction, Segment};
use reference::segments::{Case, easy, steps, stiff};

use crate::compare::times::Times;

/// Number of ordinary segments; the stiff list is about as long.
const EASY: usize = 6000;

/// Number of rays that are marched along, and of the steps of each.
const RAYS: usize = 60;
const STEPS: u32 = 100;

/// Errors from this one on are all alike.
pub(super) const WORST: f64 = 10.0;

/// Segments by extinction, as batches want them, with their truths.
#[derive(Debug)]
pub(super) struct List {
    batches: Vec<Batch>,
    count: usize,
}

#[derive(Debug)]
struct Batch {
    sigma_t: f32,
    segments: Vec<Segment>,
    truths: Vec<f64>,
}

/// Errors and time of an evaluator over a list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measurement {
    /// Largest and middle relative error of results that are normal f32;
    /// values that are not finite count as [`WORST`].
    pub(super) worst: f64,
    pub(super) median: f64,
    /// Seconds per evaluation on one thread.
    pub(super) time: Times,
}

impl List {
    /// Ordinary segments.
    pub(super) fn easy(phase: PhaseFunction) -> Self {
        Self::of(&easy(phase, EASY))
    }

    /// Segments on which evaluators break down.
    pub(super) fn stiff(phase: PhaseFunction) -> Self {
        Self::of(&stiff(phase))
    }

    /// The steps of marches along the first of the ordinary segments.
    pub(super) fn steps(phase: PhaseFunction) -> Self {
        Self::of(&steps(phase, RAYS, STEPS))
    }

    /// The segments that are marched along, without their steps.
    pub(super) fn marched(phase: PhaseFunction) -> Self {
        Self::of(&easy(phase, RAYS))
    }

    /// The extinctions and the distances between eye and light, each pair once, for which
    /// there are tables of a frame.
    pub(super) fn frames(&self) -> Vec<[f32; 2]> {
        let mut frames: Vec<[f32; 2]> = Vec::new();
        for batch in &self.batches {
            for Segment { x, s, h, .. } in &batch.segments {
                let frame = [batch.sigma_t, (x - s).hypot(*h)];
                let is_deep = frame[0] * frame[1] > FrameTable::DEEPEST;
                let is_known = |other: &[f32; 2]| {
                    other[0] == frame[0] && (other[1] / frame[1] - 1.0).abs() < 1e-5
                };
                // Steps that begin far along the ray have lost the digits of the eye's position.
                let has_eye = *x < 10.0 * frame[1];
                if has_eye && !is_deep && !frames.iter().rev().any(is_known) {
                    frames.push(frame);
                }
            }
        }
        frames
    }

    fn of(cases: &[Case]) -> Self {
        let mut batches: Vec<Batch> = Vec::new();
        for case in cases {
            let index = batches
                .iter()
                .position(|batch| batch.sigma_t == case.sigma_t)
                .unwrap_or_else(|| {
                    batches.push(Batch {
                        sigma_t: case.sigma_t,
                        segments: Vec::new(),
                        truths: Vec::new(),
                    });
                    batches.len() - 1
                });
            batches[index].segments.push(case.part.into());
            batches[index].truths.push(case.truth);
        }
        Self {
            batches,
            count: cases.len(),
        }
    }

    /// Errors and time of an evaluator; `seconds` is about how long it takes.
    pub(super) fn measure(&self, evaluator: &dyn Evaluator, seconds: f64) -> Measurement {
        let mut values: Vec<Vec<f32>> = self
            .batches
            .iter()
            .map(|batch| vec![0.0; batch.segments.len()])
            .collect();
        let mut times = Vec::new();
        let clock = Instant::now();
        while times.len() < 3 || clock.elapsed().as_secs_f64() < seconds && times.len() < 1000 {
            let round = Instant::now();
            for (batch, values) in self.batches.iter().zip(&mut values) {
                evaluator.airlight_batch(batch.sigma_t, &batch.segments, values);
            }
            times.push(round.elapsed().as_secs_f64() / self.count as f64);
        }
        let mut errors: Vec<f64> = self
            .batches
            .iter()
            .zip(&values)
            .flat_map(|(batch, values)| batch.truths.iter().zip(values))
            .map(|(truth, value)| relative_error(f64::from(*value), *truth))
            .collect();
        errors.sort_by(f64::total_cmp);
        Measurement {
            worst: errors.last().copied().unwrap_or(0.0),
            median: errors.get(errors.len() / 2).copied().unwrap_or(0.0),
            time: Times::of(&times),
        }
    }
}

/// The relative error where the truth is a normal f32. Where the truth is smaller, an error up to
/// the smallest normal f32 counts as none.
fn relative_error(value: f64, truth: f64) -> f64 {
    let smallest = f64::from(f32::MIN_POSITIVE);
    let error = (value - truth).abs() / truth.max(smallest);
    if !value.is_finite() {
        WORST
    } else if truth < smallest && error <= 1.0 {
        0.0
    } else {
        error.min(WORST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Says what it is told, in order.
    struct Constant(f32);

    impl Evaluator for Constant {
        fn airlight(&self, _: f32, _: &Segment) -> f32 {
            self.0
        }
    }

    #[test]
    fn errors_are_relative_and_never_hide_what_is_not_finite() {
        assert_eq!(relative_error(f64::NAN, 1.0), WORST);
        assert_eq!(relative_error(f64::INFINITY, 1.0), WORST);
        assert_eq!(relative_error(1.5, 1.0), 0.5);
        assert_eq!(relative_error(1e30, 1.0), WORST);
        assert_eq!(relative_error(0.0, 1e-45), 0.0);
        assert!(relative_error(1e-30, 1e-45) > 1.0);
        let list = List::easy(PhaseFunction::Isotropic);
        assert_eq!(list.count, EASY);
        let dark = list.measure(&Constant(0.0), 0.0);
        assert_eq!((dark.worst, dark.median), (1.0, 1.0));
        assert!(dark.time.repetitions == 3 && dark.time.median > 0.0);
        assert_eq!(list.measure(&Constant(f32::NAN), 0.0).median, WORST);
    }
}
