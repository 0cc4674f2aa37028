//! The steps of a ray: runs of pieces at each of which the light is asked about once.

use glam::DVec3;

use crate::scene::{MediaPiece, PhaseFunction, ScatteringAngle};

/// The line of an eye ray, as one light sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Where it comes nearest to a lamp, and how near; `None` for a sun.
    pub(super) lamp: Option<[f64; 2]>,
}

impl Line {
    /// The mean of `1/d²` between two distances; 1 for a sun.
    pub(super) fn falloff(&self, from: f64, to: f64) -> f64 {
        let Some([foot, h]) = self.lamp else {
            return 1.0;
        };
        let (a, b, length) = (from - foot, to - foot, to - from);
        // tan(Δη) = h Δx / (h² + a b), and 1/d² is dη/dx / h.
        let (rise, run) = (h * length, h * h + a * b);
        let tangent = rise / run;
        if run > 0.0 && tangent < SMALL {
            let square = tangent * tangent;
            return (1.0 - square * (1.0 / 3.0 - 0.2 * square)) / run;
        }
        rise.atan2(run) / rise
    }

    /// The angle at a lamp between two distances.
    pub(super) fn angle(&self, from: f64, to: f64) -> f64 {
        self.lamp.map_or(0.0, |[foot, h]| {
            let (a, b) = (from - foot, to - foot);
            if b == f64::INFINITY {
                return h.atan2(a);
            }
            (h * (b - a)).atan2(h * h + a * b)
        })
    }

    /// The distance of the light; infinite for a sun.
    fn distance(&self, x: f64) -> f64 {
        self.lamp
            .map_or(f64::INFINITY, |[foot, h]| (x - foot).hypot(h))
    }

    /// Where light comes from in the mean, of a part of this length, short beside the
    /// distance of the light, with a `middle` by all but `1/d²`.
    fn centroid(&self, middle: f64, length: f64) -> f64 {
        self.lamp.map_or(middle, |[foot, h]| {
            // The variance of x times the slope of the logarithm of 1/d².
            let s = middle - foot;
            middle - length * length / 6.0 * s / (s * s + h * h)
        })
    }

    /// The distance at which the angle from `from` on is `angle`, infinite if it is
    /// never that large.
    fn turned(&self, from: f64, angle: f64) -> f64 {
        let Some([foot, h]) = self.lamp else {
            return f64::INFINITY;
        };
        if angle >= std::f64::consts::PI {
            return f64::INFINITY;
        }
        // h tan(η + Δ) with tan η = a/h.
        let (a, (sin, cos)) = (from - foot, angle.sin_cos());
        let below = h * cos - a * sin;
        if below <= 0.0 {
            return f64::INFINITY;
        }
        foot + h * ((a * cos + h * sin) / below)
    }
}

/// Below this tangent the first terms of the arc tangent's series are exact to 1e-9.
const SMALL: f64 = 0.05;

/// How far a step goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Of the length within smoke, and of that through fog, m.
    lengths: [f64; 2],
    /// Of the angle at the light.
    pub(super) angle: f64,
    /// Of what is left of the light.
    pub(super) transmittance: f64,
    /// The length of a step for each metre from the first: where one colour outlasts the
    /// others, steps grow.
    growth: f64,
}

impl Limits {
    /// The length of a step on a piece.
    fn length(&self, piece: &MediaPiece<'_>) -> f64 {
        let [smoke, fog] = self.lengths;
        if piece.has_smoke() { smoke } else { fog }
    }

    /// Those of `steps` steps along a ray with so much of each.
    pub(super) fn new(steps: u32, lengths: [f64; 2], angle: f64) -> Self {
        let share = f64::from(steps) / if angle > 0.0 { 3.0 } else { 2.0 };
        // A ray has at least one step.
        let share = share.max(1.0);
        let each = match lengths {
            [0.0, fog] => [fog; 2],
            [smoke, 0.0] => [smoke; 2],
            // Half of the steps for each.
            [smoke, fog] => [2.0 * smoke, 2.0 * fog],
        };
        Self {
            lengths: each.map(|length| length / share),
            angle: if angle > 0.0 {
                angle / share
            } else {
                f64::INFINITY
            },
            transmittance: 1.0 / share,
            growth: 1.0 / share,
        }
    }
}

/// Light as it comes to a point of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arriving {
    /// Radiant intensity, or irradiance of a sun, that even fog on the way has left.
    pub(super) light: DVec3,
    /// The angle by which it is scattered towards the eye.
    pub(super) angle: ScatteringAngle,
}

/// Walks the pieces of a ray in parts, on each of which the light is evaluated once, and
/// those in steps.
#[derive(Debug)]
pub(super) struct Steps<L, V> {
    line: Line,
    limits: Limits,
    /// What arrives at a distance along the ray if nothing is in the way.
    light: L,
    /// What becomes of it: told a distance, and the light of a step.
    visit: V,
    part: Run,
    step: Run,
    /// Where the first step began.
    first: Option<f64>,
    /// Of the part: what each phase function scatters, as a share of all light.
    scattered: Vec<(PhaseFunction, DVec3)>,
    /// Of the step: what comes to the eye, all of the light arriving.
    radiance: DVec3,
    /// How far the pieces so far go, and what is left of the light there.
    behind: (f64, DVec3),
}

/// A run of pieces.
#[derive(Debug, Default)]
struct Run {
    is_open: bool,
    start: f64,
    end: f64,
    /// Where it has to end, and the optical depth at which it has to.
    last: f64,
    deepest: f64,
    full: f64,
    /// Sums of weights, and of weights × distance.
    weight: f64,
    moment: f64,
}

impl Run {
    fn new(start: f64, last: f64, [depth, deepest]: [f64; 2]) -> Self {
        Self {
            is_open: true,
            start,
            end: start,
            last,
            deepest,
            full: depth + 0.95 * (deepest - depth),
            ..Self::default()
        }
    }

    fn add(&mut self, weight: f64, x: f64) {
        self.weight += weight;
        self.moment += weight * x;
    }

    /// Whether it ends here, or so nearly that a sliver would be left.
    fn is_full(&self, end: f64, depth: f64) -> bool {
        end >= self.last || depth >= self.full
    }
}

/// Pieces of more steps than this are looked at from where they begin to be seen.
const LONG: f64 = 8.0;

/// Less than this of the light is not followed any further.
const NOTHING: f64 = 1e-7;

/// The most that a part is as long as the light is away, and that the optical depth grows
/// over it.
const PART_LENGTH: f64 = 0.15;
const PART_DEPTH: f64 = 0.4;

impl<L: Fn(f64) -> Arriving, V: FnMut(f64, DVec3)> Steps<L, V> {
    pub(super) fn new(line: Line, limits: Limits, light: L, visit: V) -> Self {
        Self {
            line,
            limits,
            light,
            visit,
            part: Run::default(),
            step: Run::default(),
            first: None,
            scattered: Vec::new(),
            radiance: DVec3::ZERO,
            behind: (f64::NAN, DVec3::ONE),
        }
    }

    /// Adds what of a piece is between `from` and `to`, and hands over each step that is
    /// full by then. False once nothing is left to be seen.
    pub(super) fn add(&mut self, piece: &MediaPiece<'_>, [from, to]: [f64; 2]) -> bool {
        if self.part.is_open && self.part.end < from {
            // A gap, over which the falloff must not be averaged.
            self.finish_part();
        }
        let length = self.limits.length(piece);
        // Smoke may want shorter steps than the fog before it.
        self.step.last = self.step.last.min(from + self.grown(length, from));
        let mut start = from;
        let mut depth = piece.depth_to(start);
        let mut before = match self.behind {
            (end, left) if end == start => left,
            _ => exp(-depth),
        };
        let all = piece.depth_to(to);
        if to - start > LONG * length {
            start = self.first_seen(piece, [start, to], (depth, before), length);
            depth = piece.depth_to(start);
            before = exp(-depth);
        }
        while start < to {
            if before.max_element() < NOTHING {
                return false;
            }
            let mut taken = -exp_m1(depth - all);
            // What is left of the piece, of every colour, is nothing to be seen.
            if (before * taken).max_element() < NOTHING {
                return to < f64::INFINITY;
            }
            self.begin(start, depth, before, length);
            let end = self.end_of_part(piece, [start, to], [depth, all]);
            let mut behind = all;
            if end < to {
                behind = piece.depth_to(end);
                taken = -exp_m1(depth - behind);
            }
            let lost = before * taken;
            let front = front_share((behind - depth).max_element(), taken.max_element());
            self.scatter(piece, start + (end - start) * front, lost);
            self.part.end = end;
            // The channel of which most is left.
            let least = behind.min_element();
            let is_step_full = self.step.is_full(end, least);
            if is_step_full || self.part.is_full(end, least) {
                self.finish_part();
            }
            if is_step_full {
                self.finish_step();
            }
            (depth, before, start) = (behind, before - lost, end);
            self.behind = (start, before);
        }
        true
    }

    /// Where a long piece begins to take light: fog may begin far below the eye.
    fn first_seen(
        &self,
        piece: &MediaPiece<'_>,
        [start, to]: [f64; 2],
        (depth, before): (DVec3, DVec3),
        mut step: f64,
    ) -> f64 {
        let is_seen = |x: f64| {
            let lost = before * -exp_m1(depth - piece.depth_to(x));
            lost.max_element() >= NOTHING
        };
        let mut unseen = start;
        let mut seen = start + step;
        while seen < to && !is_seen(seen) {
            (unseen, step) = (seen, 2.0 * step);
            seen = start + step;
        }
        if unseen == start {
            return start;
        }
        let mut seen = seen.min(to);
        // To a thousandth of where it is.
        while seen < f64::INFINITY && seen - unseen > 1e-3 * (seen - start) {
            let middle = 0.5 * (unseen + seen);
            if is_seen(middle) {
                seen = middle;
            } else {
                unseen = middle;
            }
        }
        unseen
    }

    /// Hands over the step that is not full.
    pub(super) fn finish(&mut self) {
        self.finish_part();
        self.finish_step();
    }

    /// A length of a step as it is at a distance.
    fn grown(&self, length: f64, at: f64) -> f64 {
        let first = self.first.unwrap_or(at);
        length.max((at - first) * self.limits.growth)
    }

    /// Begins a step and a part where there are none.
    fn begin(&mut self, start: f64, depth: DVec3, before: DVec3, length: f64) {
        let Limits {
            angle,
            transmittance,
            ..
        } = self.limits;
        let least = depth.min_element();
        self.first.get_or_insert(start);
        let length = self.grown(length, start);
        if !self.step.is_open {
            let left = before.max_element() - transmittance;
            let deepest = if left > 0.0 {
                -left.ln()
            } else {
                f64::INFINITY
            };
            let last = self.line.turned(start, angle).min(start + length);
            self.step = Run::new(start, last, [least, deepest]);
        }
        if !self.part.is_open {
            let last = start + PART_LENGTH * self.line.distance(start);
            self.part = Run::new(start, last, [least, least + PART_DEPTH]);
        }
    }

    /// Where what of a piece ends that fits into the part and the step; the optical depth is
    /// `depth` at its start, and `all` at the end of the piece.
    fn end_of_part(
        &self,
        piece: &MediaPiece<'_>,
        [start, to]: [f64; 2],
        [depth, all]: [DVec3; 2],
    ) -> f64 {
        let mut end = to.min(self.part.last).min(self.step.last);
        if end == f64::INFINITY {
            let sigma = piece.extinction(start).max_element();
            end = start + OPAQUE / sigma;
        }
        let deepest = self.part.deepest.min(self.step.deepest);
        let least = depth.min_element();
        let reached = if end == to { all } else { piece.depth_to(end) };
        let own = reached.min_element() - least;
        let most = deepest - least;
        if own > UNEVEN * most {
            // It may all be at the end: halves, until no float is between.
            let mut beyond = end;
            end = start;
            for _ in 0..f64::MANTISSA_DIGITS {
                let middle = 0.5 * (end + beyond);
                let reached = piece.depth_to(middle).min_element() - least;
                if reached > most {
                    beyond = middle;
                } else {
                    end = middle;
                }
                if reached <= most && reached > 0.5 * most {
                    break;
                }
            }
            if end == start {
                // It is all at the start: as if it were even, if a float is between.
                let even = start + most / piece.extinction(start).min_element();
                end = if start < even {
                    even.min(beyond)
                } else {
                    beyond
                };
            }
        } else if own > most {
            // As if it were even.
            end = start + (end - start) * (most / own);
        }
        end.max(start.next_up())
    }

    /// Adds what is scattered of `lost`, which a piece takes from the ray around `centroid`.
    fn scatter(&mut self, piece: &MediaPiece<'_>, centroid: f64, lost: DVec3) {
        let mut weight = 0.0;
        let mut add = |phase, scattered: DVec3| {
            weight += scattered.max_element();
            match self.scattered.iter_mut().find(|(known, _)| *known == phase) {
                Some((_, sum)) => *sum += scattered,
                None => self.scattered.push((phase, scattered)),
            }
        };
        // The share of what is lost that each medium scatters.
        if let [part] = piece.parts() {
            add(part.phase(), piece.albedo(part, centroid) * lost);
        } else {
            let extinction = piece.extinction(centroid);
            for part in piece.parts() {
                let at = piece.scattering(part, centroid);
                add(at.phase, share(at.scattering, extinction) * lost);
            }
        }
        self.part.add(weight, centroid);
    }

    /// Lights the part.
    fn finish_part(&mut self) {
        let part = std::mem::take(&mut self.part);
        if part.weight > 0.0 {
            let centroid = self
                .line
                .centroid(part.moment / part.weight, part.end - part.start);
            let Arriving { light, angle } = (self.light)(centroid);
            if light != DVec3::ZERO {
                let scattered = self.scattered.iter();
                let scattered = scattered
                    .map(|(phase, sum)| *sum * f64::from(phase.value(angle)))
                    .sum::<DVec3>();
                let radiance = self.line.falloff(part.start, part.end) * light * scattered;
                self.radiance += radiance;
                self.step.add(radiance.max_element(), centroid);
            }
        }
        self.scattered.clear();
    }

    fn finish_step(&mut self) {
        let step = std::mem::take(&mut self.step);
        let radiance = std::mem::take(&mut self.radiance);
        if step.weight > 0.0 {
            (self.visit)(step.moment / step.weight, radiance);
        }
    }
}

/// Depth beside that of a part from which a piece is not taken for an even one.
const UNEVEN: f64 = 4.0;

/// Optical depth at which nothing is left.
const OPAQUE: f64 = 16.2;

fn share(scattering: DVec3, extinction: DVec3) -> DVec3 {
    DVec3::select(
        extinction.cmpgt(DVec3::ZERO),
        scattering / extinction,
        DVec3::ZERO,
    )
}

/// An exponential of each channel, of one if all are alike.
fn of_each(x: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    if x.x == x.y && x.y == x.z {
        DVec3::splat(f(x.x))
    } else {
        x.map(f)
    }
}

pub(super) fn exp(x: DVec3) -> DVec3 {
    of_each(x, f64::exp)
}

fn exp_m1(x: DVec3) -> DVec3 {
    of_each(x, f64::exp_m1)
}

/// `1/τ − 1/(e^τ − 1)`: where on an even piece of this optical depth, which takes
/// `taken = 1 − e^−τ`, light is scattered in the mean, from 1/2 for thin ones to 0.
fn front_share(depth: f64, taken: f64) -> f64 {
    if depth < 0.1 {
        // To 1e-8.
        return 0.5 - depth / 12.0 * (1.0 - depth * depth / 60.0);
    }
    1.0 / depth - (1.0 - taken) / taken
}
