//! Which steps of a ray a map has to be asked about.

use std::ops::Range;

use gpu_backend::Host;

use super::search::Line;
use super::volumes::ShadowVolumes;
use crate::airlight::far_end;
use crate::{Interval, LightPath};

/// Lit steps in a row after which the next volume is looked for: about what that costs,
/// so that no more than as much again is lost.
pub(super) const LEAP: u32 = 24;

/// The part of a path that steps are spread over: up to ten mean free paths to the sky.
pub(super) fn whole(path: &LightPath<'_>) -> Interval {
    let Interval { start, end } = path.span();
    Interval::new(start, end.min(start + far_end(path.medium())))
}

/// Steps of equal length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    start: f32,
    step: f64,
    count: u32,
}

impl Steps {
    pub(super) fn new(whole: Interval, count: u32) -> Self {
        Self {
            start: whole.start,
            step: (f64::from(whole.end) - f64::from(whole.start)) / f64::from(count),
            count,
        }
    }

    pub(super) fn middle(&self, number: u32) -> f32 {
        self.start + ((f64::from(number) + 0.5) * self.step) as f32
    }

    /// The numbers of those with their middles in a part.
    fn within(&self, part: Interval) -> Range<u32> {
        let number = |x: f32| (f64::from(x) - f64::from(self.start)) / self.step;
        // Conversions saturate.
        let first = (number(part.start) - 0.5).ceil() as u32;
        let end = (number(part.end) + 0.5).floor() as u32;
        first..end.min(self.count)
    }
}

/// The steps that a map is asked about, one after the other; all others are lit.
///
/// Between the front of the first shadow volume and the back of the last one every step
/// is asked about, until so many in a row were lit that it pays to look for where the
/// next volume begins.
#[derive(Debug)]
pub(super) struct Asking<'a> {
    volumes: Option<&'a ShadowVolumes<Host>>,
    line: Line,
    whole: Interval,
    pub(super) steps: Steps,
    next: u32,
    /// From here on all are lit.
    end: u32,
    lit_in_a_row: u32,
    leap: u32,
    /// Cells that were looked at.
    pub(super) cells: u32,
}

impl<'a> Asking<'a> {
    pub(super) fn new(
        path: &LightPath<'_>,
        origin: glam::Vec3,
        volumes: Option<&'a ShadowVolumes<Host>>,
        count: u32,
    ) -> Self {
        let whole = whole(path);
        let line = Line::new(path.ray(), origin);
        let steps = Steps::new(whole, count);
        let mut cells = 0;
        let asked = match volumes {
            None => 0..count,
            Some(volumes) => volumes
                .span(&line, whole, steps.step as f32, &mut cells)
                .map_or(0..0, |span| steps.within(span)),
        };
        Self {
            volumes,
            line,
            whole,
            steps,
            next: asked.start,
            end: asked.end,
            lit_in_a_row: 0,
            leap: LEAP,
            cells,
        }
    }

    pub(super) fn whole(&self) -> Interval {
        self.whole
    }

    /// The step after the last that may be in shadow: it is lit.
    pub(super) fn end(&self) -> u32 {
        self.end
    }

    /// The number of the next step, and whether it is lit.
    pub(super) fn next(&mut self, is_lit: impl FnOnce(f32) -> bool) -> Option<(u32, bool)> {
        let number = self.next;
        if number >= self.end {
            return None;
        }
        self.next += 1;
        let x = self.steps.middle(number);
        let now_lit = is_lit(x);
        self.lit_in_a_row = if now_lit { self.lit_in_a_row + 1 } else { 0 };
        if self.lit_in_a_row >= self.leap
            && let Some(volumes) = self.volumes
        {
            let rest = Interval::new(x, self.whole.end);
            let shortest = self.steps.step as f32;
            let front = volumes.front(&self.line, rest, shortest, &mut self.cells);
            let first = front.map_or(self.end, |x| self.steps.within(Interval::new(x, x)).start);
            if first < self.next + LEAP {
                self.leap = self.leap.saturating_mul(2);
            }
            self.next = self.next.max(first).min(self.end);
            self.lit_in_a_row = 0;
        }
        Some((number, now_lit))
    }
}
