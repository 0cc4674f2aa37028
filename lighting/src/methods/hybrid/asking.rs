//! The steps of a ray that have to ask the map.

use std::ops::Range;

use gpu_backend::Host;

use super::Spread;
use super::lit_volumes::LitVolumes;
use super::search::Line;
use super::volumes::ShadowVolumes;
use crate::airlight::far_end;
use crate::{Interval, LightPath};

/// The number of equal results in a row after which the next volume is searched. A search costs
/// about as much as so many steps, so no more than this is lost twice.
pub(super) const LEAP: u32 = 24;

/// If steps are spread over spans, cells are not divided below this share of a step of the
/// whole ray, which is then the largest error in the ends of spans.
pub(super) const SHORT: f32 = 0.25;

/// The part of a path over which steps are spread: up to ten mean free paths to the sky.
pub(super) fn whole(path: &LightPath<'_>) -> Interval {
    let Interval { start, end } = path.span();
    Interval::new(start, end.min(start + far_end(path.medium())))
}

/// The length along a ray below which volumes are not told apart.
fn shortest(whole: Interval, count: u32, spread: Spread) -> f32 {
    let step = (f64::from(whole.end) - f64::from(whole.start)) / f64::from(count);
    match spread {
        Spread::Ray => step as f32,
        Spread::Span => SHORT * step as f32,
    }
}

/// Steps of equal length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    part: Interval,
    step: f64,
    count: u32,
}

impl Steps {
    pub(super) fn new(part: Interval, count: u32) -> Self {
        Self {
            part,
            step: (f64::from(part.end) - f64::from(part.start)) / f64::from(count),
            count,
        }
    }

    /// The middle of a step; behind the last step, the end of all.
    pub(super) fn middle(&self, number: u32) -> f32 {
        if number >= self.count {
            return self.part.end;
        }
        self.part.start + ((f64::from(number) + 0.5) * self.step) as f32
    }

    /// The middle of the previous step; for the first step, the start of all.
    pub(super) fn before(&self, number: u32) -> f32 {
        match number.checked_sub(1) {
            Some(before) => self.middle(before),
            None => self.part.start,
        }
    }

    /// The start of a step; behind the last step, the end of all.
    pub(super) fn start(&self, number: u32) -> f32 {
        if number >= self.count {
            return self.part.end;
        }
        self.part.start + (f64::from(number) * self.step) as f32
    }

    /// The indices of the steps whose middles are in a part.
    fn within(&self, part: Interval) -> Range<u32> {
        let number = |x: f32| (f64::from(x) - f64::from(self.part.start)) / self.step;
        // Conversions saturate.
        let first = (number(part.start) - 0.5).ceil() as u32;
        let end = (number(part.end) + 0.5).floor() as u32;
        first.min(self.count)..end.min(self.count)
    }
}

/// The volumes of a light: everything outside of the shadow volumes is lit, and everything
/// outside of the lit volumes is dark.
#[derive(Debug, Clone, Copy, Default)]
pub struct Volumes<'a> {
    /// The shadow volumes.
    pub shadow: Option<&'a ShadowVolumes<Host>>,
    /// The lit volumes.
    pub light: Option<&'a LitVolumes<Host>>,
}

impl Volumes<'_> {
    /// The origin of the light's pictures.
    pub(super) fn origin(&self) -> Option<glam::Vec3> {
        let shadow = self.shadow.map(|volumes| volumes.cells.origin);
        shadow.or(self.light.map(|volumes| volumes.cells.origin))
    }
}

/// What the volumes tell about a ray.
#[derive(Debug, Clone, Copy)]
struct Known {
    /// The part about which the map has to be asked; empty if everything is known.
    part: Interval,
    /// Whether the ray is lit in front of that part, and behind it.
    outside: [bool; 2],
}

impl Known {
    fn all(whole: Interval, is_lit: bool) -> Self {
        Self {
            part: Interval::new(whole.start, whole.start),
            outside: [is_lit; 2],
        }
    }

    fn new(
        volumes: Volumes<'_>,
        line: &Line,
        whole: Interval,
        shortest: f32,
        cells: &mut u32,
    ) -> Self {
        let mut part = whole;
        if let Some(volumes) = volumes.shadow {
            match volumes.span(line, whole, shortest, cells) {
                Some(span) => part = span,
                None => return Self::all(whole, true),
            }
        }
        let mut outside = [true; 2];
        let Some(volumes) = volumes.light.map(LitVolumes::search) else {
            return Self { part, outside };
        };
        // The lit ends of a ray outside of the shadow volumes are inside of lit volumes.
        if part.start <= whole.start {
            match volumes.front(line, part, shortest, cells) {
                Some(front) => part = Interval::new(front, part.end),
                None => return Self::all(whole, false),
            }
            outside[0] = part.start <= whole.start;
        }
        if part.end >= whole.end {
            let back = volumes.back(line, part, shortest, cells);
            part = Interval::new(part.start, back.unwrap_or(part.start));
            outside[1] = part.end >= whole.end;
        }
        Self { part, outside }
    }
}

/// Finds the steps that have to ask the map, one after the other; the result of all others is
/// known.
///
/// Between the first and the last position that may be lit or dark, every step asks, until so
/// many in a row had the same result that it pays to search for the start of the next volume of
/// the other kind.
#[derive(Debug)]
pub(super) struct Asking<'a> {
    volumes: Volumes<'a>,
    line: Line,
    whole: Interval,
    /// Cells that are no longer than this along the ray are not divided.
    shortest: f32,
    pub(super) steps: Steps,
    outside: [bool; 2],
    next: u32,
    /// Steps from this index on do not ask.
    end: u32,
    was_lit: bool,
    alike: u32,
    leap: u32,
    /// Number of cells that were visited.
    pub(super) cells: u32,
}

impl<'a> Asking<'a> {
    pub(super) fn new(
        path: &LightPath<'_>,
        origin: glam::Vec3,
        volumes: Volumes<'a>,
        (count, spread): (u32, Spread),
    ) -> Self {
        let whole = whole(path);
        let line = Line::new(path.ray(), origin);
        let shortest = shortest(whole, count, spread);
        let mut cells = 0;
        let Known { part, outside } = Known::new(volumes, &line, whole, shortest, &mut cells);
        let is_known = part.start >= part.end;
        let steps = match spread {
            Spread::Span if !is_known => Steps::new(part, count),
            _ => Steps::new(whole, count),
        };
        let asked = match spread {
            Spread::Span if !is_known => 0..count,
            _ => steps.within(part),
        };
        Self {
            volumes,
            line,
            whole,
            shortest,
            steps,
            outside,
            next: asked.start,
            end: asked.end.max(asked.start),
            was_lit: outside[0],
            alike: 0,
            leap: LEAP,
            cells,
        }
    }

    pub(super) fn whole(&self) -> Interval {
        self.whole
    }

    /// The part over which steps are spread; empty if none ask.
    pub(super) fn part(&self) -> Interval {
        let start = self.steps.part.start;
        match self.next < self.end {
            true => self.steps.part,
            false => Interval::new(start, start),
        }
    }

    /// Whether the ray is lit in front of the first step that asks.
    pub(super) fn is_lit_before(&self) -> bool {
        self.outside[0]
    }

    /// Whether anything of the ray is in front of a step.
    pub(super) fn is_anything_before(&self, number: u32) -> bool {
        number > 0 || self.steps.part.start > self.whole.start
    }

    /// The end of the last step that asks, and whether the ray is lit behind it.
    pub(super) fn rest(&self) -> (f32, bool) {
        (self.steps.start(self.end), self.outside[1])
    }

    /// The step behind the last one that asks, and whether it is lit; `None` if that was the
    /// last step.
    pub(super) fn behind(&self) -> Option<(u32, bool)> {
        let Steps { part, count, .. } = self.steps;
        let is_behind = self.end < count || part.end < self.whole.end;
        is_behind.then_some((self.end, self.outside[1]))
    }

    /// The index of the next step, and whether it is lit.
    pub(super) fn next(&mut self, is_lit: impl FnOnce(f32) -> bool) -> Option<(u32, bool)> {
        self.next_step(|steps, number| {
            let is_lit = is_lit(steps.middle(number));
            (is_lit, Some(is_lit))
        })
    }

    /// The index of the next step, and the result of `ask`, which also tells whether the step
    /// is all lit or all dark, if it is either.
    pub(super) fn next_step<T>(
        &mut self,
        ask: impl FnOnce(Steps, u32) -> (T, Option<bool>),
    ) -> Option<(u32, T)> {
        let number = self.next;
        if number >= self.end {
            return None;
        }
        self.next += 1;
        let (found, is_lit) = ask(self.steps, number);
        self.alike = match is_lit {
            Some(is_lit) if is_lit == self.was_lit => self.alike + 1,
            Some(_) => 1,
            None => 0,
        };
        self.was_lit = is_lit.unwrap_or(self.was_lit);
        if self.alike >= self.leap {
            self.leap(self.steps.middle(number));
        }
        Some((number, found))
    }

    /// Skips the steps that are known to have the same result as the step whose middle is `x`.
    fn leap(&mut self, x: f32) {
        let others = match self.was_lit {
            true => self.volumes.shadow.map(ShadowVolumes::search),
            false => self.volumes.light.map(LitVolumes::search),
        };
        let Some(others) = others else {
            return;
        };
        let rest = Interval::new(x, self.whole.end);
        let front = others.front(&self.line, rest, self.shortest, &mut self.cells);
        let first = front.map_or(self.end, |x| self.steps.within(Interval::new(x, x)).start);
        if first < self.next + LEAP {
            self.leap = self.leap.saturating_mul(2);
        }
        self.next = self.next.max(first).min(self.end);
        self.alike = 0;
    }
}
