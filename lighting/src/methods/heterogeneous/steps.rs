//! The steps of a ray: runs of pieces, for each of which visibility is asked once.

use airlight::Phase;
use glam::DVec3;

use crate::scene::{Emitter, MediaPiece, Medium, PhaseFunction, Scattering, ScatteringAngle};

/// The line of an eye ray in relation to one light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Position and distance of the point nearest to a lamp; `None` for a sun.
    pub(super) lamp: Option<[f64; 2]>,
    /// Where the full cone of a spotlight begins and ends; infinite where it does not.
    pub(super) rims: [f64; 2],
    /// Whether stretches of even fog may be [wide](is_gentle).
    pub(super) is_gentle: bool,
}

impl Line {
    /// The mean of `1/d²` between two positions; 1 for a sun.
    pub(super) fn falloff(&self, from: f64, to: f64) -> f64 {
        let Some([foot, h]) = self.lamp else {
            return 1.0;
        };
        let (a, b, length) = (from - foot, to - foot, to - from);
        // The angle has tan(Δη) = h Δx / (h² + a b), and dx / d² = dη / h.
        let (rise, run) = (h * length, h * h + a * b);
        let tangent = rise / run;
        if run > 0.0 && tangent < SMALL {
            let square = tangent * tangent;
            return (1.0 - square * (1.0 / 3.0 - 0.2 * square)) / run;
        }
        rise.atan2(run) / rise
    }

    /// The end of what is smooth from a position on: `to`, or the rim of a spotlight before it.
    fn smooth(&self, from: f64, to: f64) -> f64 {
        let ahead = self.rims.into_iter().filter(|rim| *rim > from);
        ahead.fold(to, f64::min)
    }

    /// The angle at a lamp between two positions.
    pub(super) fn angle(&self, from: f64, to: f64) -> f64 {
        self.lamp.map_or(0.0, |[foot, h]| {
            let (a, b) = (from - foot, to - foot);
            if b == f64::INFINITY {
                return h.atan2(a);
            }
            (h * (b - a)).atan2(h * h + a * b)
        })
    }

    /// The distance of the light from a position; infinite for a sun.
    fn distance(&self, x: f64) -> f64 {
        self.lamp
            .map_or(f64::INFINITY, |[foot, h]| (x - foot).hypot(h))
    }

    /// The centroid of the light scattered on a part, which is short compared with the distance
    /// of the light; `middle` is the centroid by all factors except `1/d²`.
    fn centroid(&self, middle: f64, length: f64) -> f64 {
        self.lamp.map_or(middle, |[foot, h]| {
            // The shift is the variance of x times the slope of log(1/d²).
            let s = middle - foot;
            middle - length * length / 6.0 * s / (s * s + h * h)
        })
    }

    /// The position at which the angle at the light, measured from `from`, has had this turn;
    /// infinite if it never has.
    fn turned(&self, from: f64, turn: Turn) -> f64 {
        let Some([foot, h]) = self.lamp else {
            return f64::INFINITY;
        };
        // h tan(η + Δ), where tan η = a/h.
        let (a, Turn { sin, cos }) = (from - foot, turn);
        let below = h * cos - a * sin;
        if below <= 0.0 {
            return f64::INFINITY;
        }
        foot + h * ((a * cos + h * sin) / below)
    }

    /// The nodes of Gauss's rule in the angle at the light; of a sun, in the distance. There is
    /// one on a short stretch, else there are two.
    fn nodes(&self, [from, to]: [f64; 2], is_short: bool) -> ([Node; 2], usize) {
        let length = to - from;
        let weight = self.falloff(from, to) * length;
        // Weights of the two ends for the node next to the start: d sin(tΔ), where Δ is the
        // angle of the stretch, and the sines have a ratio of t/(1−t) (1 + (1−2t) Δ²/6) up to
        // the fourth order.
        let ([d_from, d_to], bend) = self.lamp.map_or(([1.0; 2], 1.0), |[foot, h]| {
            let (a, b) = (from - foot, to - foot);
            let tangent = h * length / (h * h + a * b);
            let bend = 1.0 + (1.0 - 2.0 * NODE) / 6.0 * tangent * tangent;
            ([a, b].map(|x| (x * x + h * h).sqrt()), bend)
        });
        let between = |near: f64, far: f64| length * near / (near + far);
        if is_short {
            let x = from + between(d_from, d_to);
            return ([Node { x, weight }; 2], 1);
        }
        let weight = 0.5 * weight;
        let (less, more) = (NODE * bend, 1.0 - NODE);
        let first = from + between(less * d_from, more * d_to);
        let last = to - between(less * d_to, more * d_from);
        ([first, last].map(|x| Node { x, weight }), 2)
    }
}

/// A node on a stretch, and its share of the integral of `1/d²`, or of the length for a sun.
#[derive(Debug, Clone, Copy)]
struct Node {
    x: f64,
    weight: f64,
}

/// The first node of Gauss's rule with two, as a share of the interval: `1/2 − 1/√12`.
const NODE: f64 = 0.211_324_865_405_187_13;

/// An angle of less than a half turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    sin: f64,
    cos: f64,
}

impl Turn {
    /// `None` for an angle of no less than a half turn, or of 0.
    fn new(angle: f64) -> Option<Self> {
        let (sin, cos) = angle.sin_cos();
        (0.0 < angle && angle < std::f64::consts::PI).then_some(Self { sin, cos })
    }
}

/// Below this tangent the first terms of the arc tangent's series are exact to 1e-9.
const SMALL: f64 = 0.05;

/// Where a step ends: when it has had its share of any of these.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Its length within smoke, and within fog, m.
    lengths: [f64; 2],
    /// The angle at the light; `None` where it is no limit.
    turn: Option<Turn>,
    /// The share of the light that its media take.
    pub(super) transmittance: f64,
    /// The relative growth of a step's length per metre from the first step: where one colour
    /// is visible farther than the others, steps grow.
    growth: f64,
}

impl Limits {
    /// The length of a step on a piece.
    fn length(&self, piece: &MediaPiece<'_>) -> f64 {
        let [smoke, fog] = self.lengths;
        if piece.has_smoke() { smoke } else { fog }
    }

    /// The limits for `steps` steps along a ray with these lengths within smoke and fog and
    /// this angle.
    pub(super) fn new(steps: u32, lengths: [f64; 2], angle: f64) -> Self {
        let share = f64::from(steps) / if angle > 0.0 { 3.0 } else { 2.0 };
        // A ray has at least one step.
        let share = share.max(1.0);
        let each = match lengths {
            [0.0, fog] => [fog; 2],
            [smoke, 0.0] => [smoke; 2],
            // Smoke and fog have half of the steps each.
            [smoke, fog] => [2.0 * smoke, 2.0 * fog],
        };
        Self {
            lengths: each.map(|length| length / share),
            turn: Turn::new(angle / share),
            transmittance: 1.0 / share,
            growth: 1.0 / share,
        }
    }
}

/// Light that arrives at a point of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arriving {
    /// Radiant intensity, or irradiance of a sun, after the extinction by homogeneous fog on
    /// the way.
    pub(super) light: DVec3,
    /// The angle by which it is scattered towards the eye.
    pub(super) angle: ScatteringAngle,
}

/// Walks along the pieces of a ray in parts, on each of which the light is evaluated once, and
/// in steps of parts.
#[derive(Debug)]
pub(super) struct Steps<L, V> {
    line: Line,
    limits: Limits,
    /// Gives the light that arrives at a distance along the ray if nothing blocks it.
    light: L,
    /// Is called with the distance and the unshadowed light of each step.
    visit: V,
    part: Run,
    step: Run,
    /// Where the first step began.
    first: Option<f64>,
    /// For the current part: what each phase function scatters, as a share of the light along
    /// the ray.
    scattered: Vec<(PhaseFunction, DVec3)>,
    /// The media of one piece at a point, in memory that pieces share.
    points: Vec<Scattering>,
    /// For the current step: the light that reaches the eye if nothing blocks the lamp.
    radiance: DVec3,
    /// The end of the pieces so far, and the share of light that is left there.
    behind: (f64, DVec3),
}

/// A run of pieces: the current part or step.
#[derive(Debug, Default)]
struct Run {
    is_open: bool,
    start: f64,
    end: f64,
    /// The position, and the optical depth, at which it has to end.
    last: f64,
    deepest: f64,
    full: f64,
    /// Sums of weights, and of weights times positions.
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

    /// Whether it ends here, or so close to its limit that only a sliver would be left.
    fn is_full(&self, end: f64, depth: f64) -> bool {
        end >= self.last || depth >= self.full
    }
}

/// A piece of more steps than this is entered where it begins to be visible.
const LONG: f64 = 8.0;

/// A share of the light below this is not followed any farther.
const NOTHING: f64 = 1e-7;

/// The largest length of a part as a share of the light's distance, and the largest growth of
/// the optical depth over it.
const PART_LENGTH: f64 = 0.15;
const PART_DEPTH: f64 = 0.4;

/// The largest angle at the light, and the largest optical depth, of a stretch of even fog with
/// two nodes, and of one with one node; the angle of two nodes is the wide one where the light
/// [is gentle](is_gentle).
const STRETCH_TURN: Turn = Turn {
    sin: 7.0 / 25.0,
    cos: 24.0 / 25.0,
};
const WIDE_TURN: Turn = Turn {
    sin: 28.0 / 53.0,
    cos: 45.0 / 53.0,
};
const STRETCH_DEPTH: f64 = 0.6;
const SHORT_TURN: Turn = Turn {
    sin: 33.0 / 545.0,
    cos: 544.0 / 545.0,
};
const SHORT_DEPTH: f64 = 0.05;

/// The largest optical depth of any stretch with two nodes, which are off by 0.3 % there.
const LAST_DEPTH: f64 = 2.0;

/// The largest optical depth of a stretch at whose start this share of the light is left. The
/// error of two nodes grows with the fifth power of the depth, times the share; so each mean free
/// path adds alike to the error of the ray.
fn stretch_depth(left: f64) -> f64 {
    (STRETCH_DEPTH / left.sqrt().sqrt()).min(LAST_DEPTH)
}

/// Whether the light that even fog scatters from a light changes so gently with the angle at the
/// light that stretches may be wide: the phase function has no narrow peak, the light shines
/// alike in all directions and does not fade, and no face of a box cuts its way through the fog.
pub(super) fn is_gentle(fog: &Medium, emitter: &Emitter) -> bool {
    /// The peak of Henyey and Greenstein's function of g = 1/7.
    const WIDTH: f64 = 0.75;
    let is_plain = match emitter {
        Emitter::Directional(_) => true,
        Emitter::Point(point) => point.is_plain(),
    };
    is_plain && fog.bounds().is_none() && fog.phase().peaks().iter().all(|peak| *peak >= WIDTH)
}

/// Colours of which less than this share is left, beside the one of which most is left, do not
/// shorten stretches.
const SEEN: f64 = 1e-3;

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
            points: Vec::new(),
            radiance: DVec3::ZERO,
            behind: (f64::NAN, DVec3::ONE),
        }
    }

    /// Adds the part of a piece between `from` and `to`, and hands over each step that is full.
    /// False once nothing behind can be seen.
    pub(super) fn add(&mut self, piece: &MediaPiece<'_>, [from, to]: [f64; 2]) -> bool {
        if self.part.is_open && self.part.end < from {
            // This is a gap; the falloff must not be averaged over it.
            self.finish_part();
        }
        let length = self.limits.length(piece);
        // Smoke may need shorter steps than the fog in front of it.
        self.step.last = self.step.last.min(from + self.grown(length, from));
        let mut start = from;
        let mut depth = piece.depth_to(start);
        let mut before = match self.behind {
            (end, left) if end == start => left,
            _ => exp(-depth),
        };
        if !piece.has_smoke() && piece.is_even() {
            return self.add_even(piece, [from, to], depth, before);
        }
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
            // In no colour is anything left to be seen of the piece.
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
            // The channel in which most is left.
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

    /// The same for a piece of even fog alone, at whose start the optical depth is `depth` and
    /// the share of light that is left is `before`.
    ///
    /// All is smooth there: stretches are long, and Gauss's rule takes the place of centroids.
    fn add_even(
        &mut self,
        piece: &MediaPiece<'_>,
        [from, to]: [f64; 2],
        mut depth: DVec3,
        mut before: DVec3,
    ) -> bool {
        let [fog] = piece.parts() else {
            return true;
        };
        self.finish_part();
        let fog = piece.scattering(fog, from);
        let length = self.limits.length(piece);
        let mut start = from;
        while start < to {
            if before.max_element() < NOTHING {
                return false;
            }
            // In no colour is anything left to be seen of the piece.
            let taken = DVec3::select(
                fog.extinction.cmpgt(DVec3::ZERO),
                (fog.extinction * (to - start)).min(DVec3::ONE),
                DVec3::ZERO,
            );
            if (before * taken).max_element() < NOTHING {
                return to < f64::INFINITY;
            }
            self.begin_step(start, depth, before, length);
            // The channel in which most is left has the least depth, and comes last.
            let room = (self.step.deepest - depth) / fog.extinction;
            let deepest = start + room.x.max(room.y).max(room.z);
            let mut end = to.min(self.step.last).min(deepest);
            if end == f64::INFINITY {
                end = start + OPAQUE / fog.extinction.max_element();
            }
            end = end.max(start.next_up());
            before = self.scatter_along([start, end], before, &fog);
            depth += (end - start) * fog.extinction;
            if self.step.is_full(end, depth.min_element()) {
                self.finish_step();
            }
            start = end;
            self.behind = (start, before);
        }
        true
    }

    /// Adds to the step what even fog scatters between two positions. `left` is the share of
    /// light that is left at the first; returns the share at the second.
    fn scatter_along(
        &mut self,
        [mut start, end]: [f64; 2],
        mut left: DVec3,
        fog: &Scattering,
    ) -> DVec3 {
        while start < end && left.max_element() >= NOTHING {
            let is_seen = left.cmpge(DVec3::splat(SEEN * left.max_element()));
            let most = DVec3::select(is_seen, fog.extinction, DVec3::ZERO).max_element();
            let turn = if self.line.is_gentle {
                WIDE_TURN
            } else {
                STRETCH_TURN
            };
            let deepest = stretch_depth(left.max_element());
            let limit = self.line.turned(start, turn).min(start + deepest / most);
            let rim = self.line.smooth(start, end);
            // A sliver would have nodes of its own.
            let is_last = rim - start < 1.1 * (limit - start);
            let stop = if is_last {
                rim
            } else {
                limit.max(start.next_up())
            };
            let depth = (stop - start) * fog.extinction;
            if most * (stop - start) > 2.0 * deepest {
                // No float is nearer.
                let lost = left * -exp_m1(-depth);
                let scattered = share(fog.scattering, fog.extinction) * lost;
                self.add_light(start, self.line.falloff(start, stop) * scattered, fog.phase);
            } else {
                let is_short = stop <= self.line.turned(start, SHORT_TURN)
                    && most * (stop - start) < SHORT_DEPTH;
                let (nodes, count) = self.line.nodes([start, stop], is_short);
                for Node { x, weight } in &nodes[..count] {
                    let before = left * exp((start - x) * fog.extinction);
                    self.add_light(*x, weight * fog.scattering * before, fog.phase);
                }
            }
            left *= exp(-depth);
            start = stop;
        }
        left
    }

    /// Adds to the step the light that arrives at a position, of which this share is scattered.
    fn add_light(&mut self, x: f64, share: DVec3, phase: PhaseFunction) {
        let Arriving { light, angle } = (self.light)(x);
        let radiance = f64::from(phase.value(angle)) * share * light;
        self.radiance += radiance;
        self.step.add(radiance.max_element(), x);
    }

    /// Where a long piece begins to be visible: fog may begin far below the eye.
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
        // To a thousandth of its distance.
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

    /// Hands over the last step, which is not full.
    pub(super) fn finish(&mut self) {
        self.finish_part();
        self.finish_step();
    }

    /// The length of a step at a distance, which grows with the distance.
    fn grown(&self, length: f64, at: f64) -> f64 {
        let first = self.first.unwrap_or(at);
        length.max((at - first) * self.limits.growth)
    }

    /// Begins a step and a part if there are none.
    fn begin(&mut self, start: f64, depth: DVec3, before: DVec3, length: f64) {
        self.begin_step(start, depth, before, length);
        if !self.part.is_open {
            let least = depth.min_element();
            let last = start + PART_LENGTH * self.line.distance(start);
            self.part = Run::new(start, last, [least, least + PART_DEPTH]);
        }
    }

    /// Begins a step if there is none.
    fn begin_step(&mut self, start: f64, depth: DVec3, before: DVec3, length: f64) {
        let Limits {
            turn,
            transmittance,
            ..
        } = self.limits;
        self.first.get_or_insert(start);
        let length = self.grown(length, start);
        if !self.step.is_open {
            let left = before.max_element() - transmittance;
            let deepest = if left > 0.0 {
                -left.ln()
            } else {
                f64::INFINITY
            };
            let turned = turn.map_or(f64::INFINITY, |turn| self.line.turned(start, turn));
            let last = turned.min(start + length);
            self.step = Run::new(start, last, [depth.min_element(), deepest]);
        }
    }

    /// Where the portion of a piece ends that fits into the part and the step; the optical
    /// depth is `depth` at the start of the piece and `all` at its end.
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
            // The optical depth may all be at the end, so the interval is halved until no float
            // is between.
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
                // The optical depth is all at the start: the piece counts as homogeneous, if a
                // float is between.
                let even = start + most / piece.extinction(start).min_element();
                end = if start < even {
                    even.min(beyond)
                } else {
                    beyond
                };
            }
        } else if own > most {
            // The piece counts as homogeneous.
            end = start + (end - start) * (most / own);
        }
        end.max(start.next_up())
    }

    /// Adds what is scattered of `lost`, which is the light that a piece takes from the ray
    /// around `centroid`.
    fn scatter(&mut self, piece: &MediaPiece<'_>, centroid: f64, lost: DVec3) {
        let mut weight = 0.0;
        let mut add = |phase, scattered: DVec3| {
            weight += scattered.max_element();
            match self.scattered.iter_mut().find(|(known, _)| *known == phase) {
                Some((_, sum)) => *sum += scattered,
                None => self.scattered.push((phase, scattered)),
            }
        };
        // Each medium scatters a share of what is lost.
        if let [part] = piece.parts() {
            add(part.phase(), piece.albedo(part, centroid) * lost);
        } else {
            let points = piece.parts().iter();
            self.points.clear();
            self.points
                .extend(points.map(|part| piece.scattering(part, centroid)));
            let extinction = self.points.iter().map(|at| at.extinction).sum();
            for at in &self.points {
                add(at.phase, share(at.scattering, extinction) * lost);
            }
        }
        self.part.add(weight, centroid);
    }

    /// Evaluates the light on the part.
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

/// A piece counts as homogeneous unless its optical depth changes that of a part by more than
/// this factor.
const UNEVEN: f64 = 4.0;

/// Behind this optical depth nothing is left.
const OPAQUE: f64 = 16.2;

fn share(scattering: DVec3, extinction: DVec3) -> DVec3 {
    DVec3::select(
        extinction.cmpgt(DVec3::ZERO),
        scattering / extinction,
        DVec3::ZERO,
    )
}

/// `f` of each channel, evaluated once if all channels are equal.
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

/// `1/τ − 1/(e^τ − 1)`: the mean position at which a homogeneous piece of this optical depth
/// scatters, as a share of its length. It is 1/2 for a thin piece and tends to 0; `taken` is 1
/// − e^−τ.
fn front_share(depth: f64, taken: f64) -> f64 {
    if depth < 0.1 {
        // The series, to 1e-8.
        return 0.5 - depth / 12.0 * (1.0 - depth * depth / 60.0);
    }
    1.0 / depth - (1.0 - taken) / taken
}
