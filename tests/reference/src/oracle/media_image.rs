//! Whole pictures of the light that media which are not uniform scatter: the integral of
//! [`media`](super::media), for as many rays as a picture has.
//!
//! Each ray is cut where a coefficient has a kink (faces of cells, edges of media), where
//! something opaque or a piece of strand begins or ends to hide the light, where shadows of
//! smoke can begin or end, and in dense media where the optical depth has grown by 1, 8 and 64.
//! Each part is asked at one of Gauss's nodes and at two, then, where these differ most, at
//! two on each of its halves and so on, until the sum of all differences of n and 2n nodes
//! is within the tolerance.
//!
//! At a node the light that has got there is dimmed by the optical depth of all media up to
//! the lamp, cell by cell in closed form, and so is what it scatters on its way to the eye:
//! `scene::Media` has both. Neither curves nor steps are taken from any method.
//!
//! # Error
//! The bound is an estimate: four times the difference between n and 2n nodes, which is far
//! above the error of 2n where the light is smooth. Where cells in front of the light give it
//! a kink, a difference can be less than the error: in random scenes of a few large cells all
//! pixels are within it at a tolerance of 1e-3, and nine in ten at 1e-5. What lies between all
//! nodes of a part may be missed.
//! `media::MediaWorld`, which is adaptive in both directions and shares no walk with this,
//! checks it.
//!
//! # Limits
//! Single scattering of the emitters; what media emit themselves is not part of it. Strands
//! cast shadows and are not seen.

use glam::DVec3;
use scene::{Emitter, Geometry, HeightFog, Media, MediaPiece, Ray, Translucent};

use super::airlight::{NEAREST, NEAREST_METRES, Tolerance};
use super::coats::Coats;
use super::image::{Options, Reference, refined};
use super::media::Air;
use super::quadrature::Estimate;
use super::shades::Shades;
use super::translucent::Translucency;
use super::visibility::{Blockers, Search};
use super::{Fog, Lamp, Line, Phase, Span};

/// A bound over the difference of n and 2n nodes: at a kink between nodes they may err alike.
/// Taken from random scenes of grids with constant cells.
const SAFETY: f64 = 4.0;

/// Optical depth behind which nothing is looked for.
const OPAQUE: f64 = 40.0;

/// Parts of a line to begin with, at least.
const LEAST_PARTS: u32 = 16;

/// Parts of the shadows of smoke to begin with.
const SHADOW_PARTS: u32 = 16;

/// Parts of a ray beyond which it is left as inaccurate as it is.
const MOST_PARTS: usize = 1 << 12;

/// The light that the media of `air` scatter along each ray into its origin, from all
/// `emitters`, with the shadows of `geometry` and of the media themselves.
///
/// A line through a point light passes it at a distance of 1e-4 of that of the eye. The
/// result does not depend on the number of threads.
pub fn reference(
    rays: &[Ray],
    air: Air<'_>,
    emitters: &[Emitter],
    geometry: &Geometry,
    options: Options<'_>,
) -> Reference {
    let world = World::new(air, emitters, geometry, options.search);
    refined(rays, options, 500, |ray, tolerance| {
        world.radiance(ray, tolerance)
    })
}

struct World<'a> {
    media: Media<'a>,
    /// What dims the light of a sun: even fog without bounds does not.
    sunward: Media<'a>,
    height_fog: Option<&'a HeightFog>,
    fog: Option<Fog>,
    translucency: Translucency,
    strands: Option<Translucency>,
    lamps: Vec<Lamp>,
    blockers: Blockers,
    coats: Option<Coats<'a>>,
    search: Search,
}

/// A part of a line on which all coefficients are smooth.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    span: Span,
    /// The optical depth from the eye to its start.
    depth: DVec3,
}

/// A lamp as a line sees it.
struct Light {
    lamp: Lamp,
    /// What hair lets pass.
    hair: Steps,
}

/// A function that is constant between steps: where each begins, and its value.
#[derive(Debug, Default)]
struct Steps(Vec<(f64, f64)>);

impl Steps {
    /// The product of factors that hold on spans; 1 elsewhere.
    fn new(factors: &[(Span, f64)]) -> Self {
        let mut ends: Vec<(f64, usize, bool)> = Vec::with_capacity(2 * factors.len());
        for (index, (span, _)) in factors.iter().enumerate() {
            ends.extend([(span.start, index, true), (span.end, index, false)]);
        }
        // Those of a span without length in this order too: the sort is stable.
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A tree of products: whatever the order in which they begin, the same factors have the
        // same product.
        let leaves = factors.len().next_power_of_two();
        let mut products = vec![1.0; 2 * leaves];
        let steps = ends.into_iter().map(|(x, index, begins)| {
            let mut node = leaves + index;
            products[node] = if begins { factors[index].1 } else { 1.0 };
            while node > 1 {
                node /= 2;
                products[node] = products[2 * node] * products[2 * node + 1];
            }
            (x, products[1])
        });
        let mut steps: Vec<(f64, f64)> = steps.collect();
        // Of those at one place the last one counts.
        steps.dedup_by(|later, kept| {
            let is_same = later.0 == kept.0;
            if is_same {
                kept.1 = later.1;
            }
            is_same
        });
        Self(steps)
    }

    fn at(&self, x: f64) -> f64 {
        let after = self.0.partition_point(|(start, _)| *start <= x);
        after.checked_sub(1).map_or(1.0, |index| self.0[index].1)
    }
}

/// What a part is integrated over.
#[derive(Debug, Clone, Copy)]
enum Variable {
    /// The distance.
    Along,
    /// The angle at a lamp: x = foot + h tan η.
    Angle { foot: f64, h: f64 },
    /// Towards infinity: u = (x − start) / (x − start + scale).
    Endless { start: f64, scale: f64 },
}

impl Variable {
    fn at(self, x: f64) -> f64 {
        match self {
            Self::Along => x,
            Self::Angle { foot, h } => ((x - foot) / h).atan(),
            Self::Endless { start, scale } if x.is_finite() => (x - start) / (x - start + scale),
            Self::Endless { .. } => 1.0,
        }
    }

    /// The distance, and its change with the variable.
    fn distance(self, t: f64) -> [f64; 2] {
        match self {
            Self::Along => [t, 1.0],
            Self::Angle { foot, h } => {
                let tan = t.tan();
                [foot + h * tan, h * (1.0 + tan * tan)]
            }
            Self::Endless { start, scale } => {
                let rest = 1.0 - t;
                [start + scale * t / rest, scale / (rest * rest)]
            }
        }
    }
}

/// A part of a line.
#[derive(Debug, Clone, Copy)]
struct Part {
    light: usize,
    stretch: usize,
    /// What gets past surfaces that are not solid.
    share: DVec3,
    variable: Variable,
    /// Of the variable.
    start: f64,
    end: f64,
    /// By n nodes, and by 2n: one and two, or two and two on each half.
    coarse: DVec3,
    fine: Fine,
}

#[derive(Debug, Clone, Copy)]
enum Fine {
    Whole(DVec3),
    Halves([DVec3; 2]),
}

impl Part {
    fn value(&self) -> DVec3 {
        match self.fine {
            Fine::Whole(value) => value,
            Fine::Halves([near, far]) => near + far,
        }
    }

    fn error(&self) -> f64 {
        (self.value() - self.coarse).abs().max_element()
    }

    fn middle(&self) -> f64 {
        0.5 * (self.start + self.end)
    }
}

impl<'a> World<'a> {
    fn new(air: Air<'a>, emitters: &[Emitter], geometry: &'a Geometry, search: Search) -> Self {
        let is_hair = |caster: &&Translucent| matches!(caster, Translucent::Strands(_));
        let hair: Vec<Translucent> = air.translucent.iter().filter(is_hair).cloned().collect();
        let bounded = air.medium.filter(|medium| medium.bounds().is_some());
        Self {
            media: Media::new(air.medium, air.height_fog, air.translucent),
            sunward: Media::new(bounded, None, air.translucent),
            height_fog: air.height_fog,
            fog: bounded.map(Fog::new),
            translucency: Translucency::new(air.translucent),
            strands: (!hair.is_empty()).then(|| Translucency::new(&hair)),
            lamps: emitters.iter().map(Lamp::new).collect(),
            blockers: Blockers::new(geometry),
            coats: Coats::new(geometry),
            search,
        }
    }

    fn radiance(&self, ray: &Ray, tolerance: Tolerance) -> Estimate {
        let line = Line::new(ray);
        let stretches = self.stretches(&line);
        let (Some(first), Some(last)) = (stretches.first(), stretches.last()) else {
            return Estimate::default();
        };
        let whole = Span::new(first.span.start, last.span.end);
        let seen = Seen {
            world: self,
            line,
            stretches: &stretches,
            lights: (self.lamps.iter())
                .map(|lamp| self.light(&line, lamp, whole))
                .collect(),
        };
        let mut parts = Vec::new();
        for light in 0..seen.lights.len() {
            seen.add_parts(light, whole, &mut parts);
        }
        seen.integrate(parts, tolerance)
    }

    fn light(&self, line: &Line, lamp: &Lamp, whole: Span) -> Light {
        let mut lamp = lamp.clone();
        if let Lamp::Point(point) = &lamp {
            let (foot, offset) = line.nearest(point.position);
            let h = offset.length();
            let nearest = (NEAREST * foot.hypot(h)).max(NEAREST_METRES);
            if h < nearest {
                let aside = offset
                    .try_normalize()
                    .unwrap_or_else(|| line.direction.any_orthonormal_vector());
                lamp = Lamp::Point(point.moved_to(line.at(foot) - nearest * aside));
            }
        }
        let strands = self.strands.as_ref();
        let shadows = strands.map(|strands| strands.strand_shadows(line, &lamp, whole));
        Light {
            hair: Steps::new(&shadows.unwrap_or_default()),
            lamp,
        }
    }

    /// Where on a line there is something that scatters.
    fn stretches(&self, line: &Line) -> Vec<Stretch> {
        let mut all: Vec<Stretch> = Vec::new();
        let mut pieces = self
            .media
            .along(line.origin, line.direction, 0.0, line.length);
        while let Some(piece) = pieces.advance() {
            if piece.is_empty() {
                continue;
            }
            let depth = piece.depth_before();
            if depth.min_element() > OPAQUE {
                break;
            }
            let mut from = piece.start();
            let own = piece.optical_depth().max_element();
            for grown in [1.0, 8.0, 64.0] {
                if own <= grown {
                    break;
                }
                let to = depth_reached(&piece, grown);
                all.push(Stretch {
                    span: Span::new(from, to),
                    depth: piece.depth_to(from),
                });
                from = to;
            }
            all.push(Stretch {
                span: Span::new(from, piece.end()),
                depth: piece.depth_to(from),
            });
        }
        all.retain(|stretch| stretch.span.start < stretch.span.end);
        all
    }

    /// The optical depth from a point towards a light.
    fn depth_towards(&self, lamp: &Lamp, point: DVec3, toward: DVec3, distance: f64) -> DVec3 {
        match lamp {
            Lamp::Point(_) => self.media.optical_depth(point, toward, 0.0, distance),
            Lamp::Sun(_) => {
                let fog = self.height_fog;
                self.sunward.optical_depth(point, toward, 0.0, distance)
                    + fog.map_or(DVec3::ZERO, |fog| {
                        fog.depth_towards(point.y, toward.y, distance)
                    })
            }
        }
    }

    /// A length over which what is endless fades.
    fn reach(&self) -> f64 {
        let even = self.media.medium();
        let even = even.map_or(0.0, |medium| f64::from(medium.sigma_t().max_element()));
        let free = if even > 0.0 {
            1.0 / even
        } else {
            f64::INFINITY
        };
        let height = self.height_fog;
        let height = height.map_or(f64::INFINITY, |fog| fog.scale_height().into());
        free.min(height).clamp(1e-9, 1e9)
    }
}

/// Where on a piece its own optical depth has grown to this.
fn depth_reached(piece: &MediaPiece<'_>, depth: f64) -> f64 {
    let (mut low, mut high) = (piece.start(), piece.end().min(piece.start() + 1e12));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if piece.own_depth_to(middle).max_element() < depth {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// A line and what there is on it.
struct Seen<'a> {
    world: &'a World<'a>,
    line: Line,
    stretches: &'a [Stretch],
    lights: Vec<Light>,
}

impl Seen<'_> {
    /// Cuts what a light reaches of the line.
    fn add_parts(&self, light: usize, whole: Span, parts: &mut Vec<Part>) {
        let Self { world, line, .. } = self;
        let Light { lamp, hair } = &self.lights[light];
        let mut lit = Vec::new();
        world
            .blockers
            .lit(line, lamp, whole, world.search, &mut lit);
        if lit.is_empty() {
            return;
        }
        let mut cuts: Vec<f64> = hair.0.iter().map(|(x, _)| *x).collect();
        let smoke = world.translucency.balls_around_media();
        Shades::new(line, lamp, smoke).cut(
            &lit,
            SHADOW_PARTS,
            10.0 * world.reach(),
            |part, sampled| {
                cuts.extend([part.end, sampled.end]);
            },
        );
        let variable = match lamp {
            Lamp::Point(point) => {
                let (foot, offset) = line.nearest(point.position);
                cuts.push(foot);
                point.edges(line, &mut cuts);
                point.cookie_edges(line, &mut cuts);
                if let Some(fog) = &world.fog {
                    fog.point_edges(line, point.position, &mut cuts);
                }
                Variable::Angle {
                    foot,
                    h: offset.length(),
                }
            }
            Lamp::Sun(sun) => {
                if let Some(fog) = &world.fog {
                    fog.sun_edges(line, sun.toward, &mut cuts);
                }
                Variable::Along
            }
        };
        // Long parts of few nodes would be believed too soon.
        let even = match variable {
            Variable::Along if whole.end.is_infinite() => Variable::Endless {
                start: whole.start,
                scale: world.reach(),
            },
            other => other,
        };
        let [from, to] = [whole.start, whole.end].map(|x| even.at(x));
        let step = (to - from) / f64::from(LEAST_PARTS);
        cuts.extend((1..LEAST_PARTS).map(|k| even.distance(from + f64::from(k) * step)[0]));
        cuts.sort_by(f64::total_cmp);
        let mut add = |span: Span, share: DVec3| {
            let first = self.stretches.partition_point(|s| s.span.end <= span.start);
            for (index, stretch) in self.stretches.iter().enumerate().skip(first) {
                let Some(inside) = stretch.span.intersect(span) else {
                    break;
                };
                let from = cuts.partition_point(|&cut| cut <= inside.start);
                let within = cuts[from..].iter().copied();
                let within = within.take_while(|&cut| cut < inside.end);
                let mut start = inside.start;
                for end in within.chain([inside.end]) {
                    if start < end {
                        self.add_part(light, index, share, variable, Span::new(start, end), parts);
                    }
                    start = end;
                }
            }
        };
        for span in lit {
            match &world.coats {
                None => add(span, DVec3::ONE),
                Some(coats) => {
                    for part in coats.parts(line, lamp, span) {
                        add(part.span, part.share);
                    }
                }
            }
        }
    }

    fn add_part(
        &self,
        light: usize,
        stretch: usize,
        share: DVec3,
        variable: Variable,
        span: Span,
        parts: &mut Vec<Part>,
    ) {
        let variable = match variable {
            Variable::Along if span.end.is_infinite() => Variable::Endless {
                start: span.start,
                scale: self.world.reach(),
            },
            other => other,
        };
        let mut part = Part {
            light,
            stretch,
            share,
            variable,
            start: variable.at(span.start),
            end: variable.at(span.end),
            coarse: DVec3::ZERO,
            fine: Fine::Whole(DVec3::ZERO),
        };
        let length = part.end - part.start;
        part.coarse = length * part.share * self.light_at(&part, part.middle());
        part.fine = Fine::Whole(self.gauss(&part, part.start, part.end));
        parts.push(part);
    }

    fn halve(&self, part: &mut Part) {
        let middle = part.middle();
        part.fine = Fine::Halves([
            self.gauss(part, part.start, middle),
            self.gauss(part, middle, part.end),
        ]);
    }

    /// Halves parts until the sum of their differences is within the tolerance.
    fn integrate(&self, mut parts: Vec<Part>, tolerance: Tolerance) -> Estimate {
        loop {
            let value: DVec3 = parts.iter().map(Part::value).sum();
            let error: f64 = parts.iter().map(Part::error).sum();
            let brightest = value.max_element();
            let rounding = 1e-12 * brightest;
            let target = (tolerance.relative * brightest)
                .max(tolerance.absolute)
                .max(rounding);
            let estimate = Estimate {
                value,
                bound: SAFETY * error + rounding,
            };
            if !(error > target) {
                return estimate;
            }
            let share = 0.5 * target / parts.len() as f64;
            let mut is_done = true;
            for index in 0..parts.len() {
                let part = parts[index];
                let middle = part.middle();
                let is_divisible = part.start < middle && middle < part.end;
                if !(part.error() > share && is_divisible && parts.len() < MOST_PARTS) {
                    continue;
                }
                match part.fine {
                    Fine::Whole(value) => {
                        parts[index].coarse = value;
                        self.halve(&mut parts[index]);
                    }
                    Fine::Halves(halves) => {
                        let [mut near, mut far] = [part; 2];
                        (near.end, near.coarse) = (middle, halves[0]);
                        (far.start, far.coarse) = (middle, halves[1]);
                        self.halve(&mut near);
                        self.halve(&mut far);
                        parts[index] = near;
                        parts.push(far);
                    }
                }
                is_done = false;
            }
            if is_done {
                return estimate;
            }
        }
    }

    /// Two nodes, exact for cubic functions of the variable.
    fn gauss(&self, part: &Part, start: f64, end: f64) -> DVec3 {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        let node = half / 3.0_f64.sqrt();
        half * part.share
            * (self.light_at(part, middle - node) + self.light_at(part, middle + node))
    }

    /// What is scattered to the eye per step of the variable.
    fn light_at(&self, part: &Part, t: f64) -> DVec3 {
        let [x, per_step] = part.variable.distance(t);
        if !(x.is_finite() && per_step.is_finite()) {
            return DVec3::ZERO;
        }
        let (world, line) = (self.world, &self.line);
        let Stretch { span, depth } = self.stretches[part.stretch];
        let behind = depth
            + world
                .media
                .optical_depth(line.origin, line.direction, span.start, x);
        let seen = (-behind).exp();
        let Light { lamp, hair } = &self.lights[part.light];
        let point = line.at(x);
        let (toward, distance, irradiance) = match lamp {
            Lamp::Sun(sun) => (sun.toward, f64::INFINITY, sun.irradiance),
            Lamp::Point(lamp) => {
                if !lamp.reaches(point) {
                    return DVec3::ZERO;
                }
                let offset = lamp.position - point;
                let distance = offset.length();
                let toward = offset / distance;
                let emitted = lamp.intensity * lamp.emission(-toward) * lamp.fading(distance);
                (toward, distance, emitted / (distance * distance))
            }
        };
        // The angle between light and its way on to the eye, halved.
        let sin2 = 0.25 * (toward - line.direction).length_squared();
        let cos2 = 0.25 * (toward + line.direction).length_squared();
        let mut scattering = DVec3::ZERO;
        world.media.scattering_at(point, |medium| {
            scattering += medium.scattering * Phase::from(medium.phase).at(sin2, cos2);
        });
        let unshadowed = seen * scattering * irradiance * per_step;
        if unshadowed == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let passed = hair.at(x);
        if passed == 0.0 {
            return DVec3::ZERO;
        }
        let depth = world.depth_towards(lamp, point, toward, distance);
        passed * unshadowed * (-depth).exp()
    }
}

#[cfg(test)]
mod tests;
