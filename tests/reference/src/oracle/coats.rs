//! How much of a light gets through triangles that are not solid, exactly.
//!
//! All triangles are tried one after the other, and the texture is looked up from
//! the definition of its sampler, in f64. Parts of a ray behind them are found by
//! asking at many points, and where two neighbours differ by halving what is between
//! them.

use glam::{DVec2, DVec3, Vec3};
use scene::{AlphaMode, Caster, Coating, Filter, Geometry, Texture, Wrap};

use super::{Lamp, Line, Span};

/// Points at which a span is asked.
const POINTS: usize = 1024;

/// A difference between neighbours that counts as a step.
const STEP: f64 = 0.02;

/// The triangles of a scene that are masked, see-through, or cast no shadow.
#[derive(Debug)]
pub struct Coats<'a> {
    all: Vec<Coat<'a>>,
}

#[derive(Debug)]
struct Coat<'a> {
    corners: [DVec3; 3],
    /// What it does to what is seen through it.
    cover: Caster<'a>,
    casts_shadow: bool,
}

/// A part of a ray and the share of the light that gets there and on to the eye.
#[derive(Debug, Clone, Copy)]
pub struct Shared {
    /// Which part.
    pub span: Span,
    /// The share of each colour, in its middle.
    pub share: DVec3,
}

impl<'a> Coats<'a> {
    /// Those of a scene; `None` if all triangles are solid.
    pub fn new(geometry: &'a Geometry) -> Option<Self> {
        if geometry.all_solid() {
            return None;
        }
        let all = geometry.triangles().iter().enumerate();
        let coats = all.map(|(index, corners)| Coat {
            corners: corners.map(Vec3::as_dvec3),
            cover: geometry.coatings().cover(index),
            casts_shadow: geometry.caster(index) != Caster::Absent,
        });
        let is_coat = |coat: &Coat<'_>| !coat.casts_shadow || coat.cover != Caster::Solid;
        Some(Self {
            all: coats.filter(is_coat).collect(),
        })
    }

    /// The share of the light of `lamp` that gets to the point at `x` of a line and
    /// on to its origin, past all that is not solid; in a vacuum.
    pub fn share(&self, line: &Line, lamp: &Lamp, x: f64) -> DVec3 {
        let point = line.at(x);
        let (toward, distance) = match lamp {
            Lamp::Point(lamp) => {
                let way = lamp.position - point;
                (way / way.length(), way.length())
            }
            Lamp::Sun(sun) => (sun.toward, f64::INFINITY),
        };
        let mut share = DVec3::ONE;
        let mut edges = Vec::new();
        for coat in self.all.iter().filter(|coat| coat.casts_shadow) {
            if let Some((u, v)) = coat.meets(point, toward, distance, &mut edges) {
                share *= passing(&coat.cover, u, v);
            }
        }
        edges.clear();
        for coat in &self.all {
            // What is solid ends the ray.
            if coat.cover != Caster::Solid
                && let Some((u, v)) = coat.meets(line.origin, line.direction, x, &mut edges)
            {
                share *= passing(&coat.cover, u, v);
            }
        }
        share
    }

    /// The parts of `span` with their shares, those without any left out. Ends of
    /// parts that are shorter than a thousandth of the span may be missed.
    pub fn parts(&self, line: &Line, lamp: &Lamp, span: Span) -> Vec<Shared> {
        // An endless span is asked at ever larger distances.
        let at = |k: usize| {
            let place = k as f64 / POINTS as f64;
            if span.end.is_finite() {
                span.start + place * (span.end - span.start)
            } else {
                span.start + 10.0 * place / (1.0 - place)
            }
        };
        let mut parts: Vec<Shared> = Vec::new();
        let mut put = |start: f64, end: f64, share: DVec3| match parts.last_mut() {
            Some(last) if last.share == share && last.span.end == start => last.span.end = end,
            _ if start < end && share != DVec3::ZERO => parts.push(Shared {
                span: Span::new(start, end),
                share,
            }),
            _ => {}
        };
        let middle = |k: usize| 0.5 * (at(k) + at(k + 1).min(2.0 * at(k) + 1e4));
        let mut from = span.start;
        let mut before = self.share(line, lamp, middle(0));
        for k in 1..POINTS {
            let here = self.share(line, lamp, middle(k));
            let border = if (here - before).abs().max_element() > STEP {
                let (mut low, mut high) = (middle(k - 1), middle(k));
                for _ in 0..60 {
                    let centre = 0.5 * (low + high);
                    let share = self.share(line, lamp, centre);
                    let is_before =
                        (share - before).abs().max_element() <= (share - here).abs().max_element();
                    if is_before {
                        low = centre;
                    } else {
                        high = centre;
                    }
                }
                high
            } else {
                at(k)
            };
            put(from, border, before);
            (from, before) = (border, here);
        }
        put(from, span.end, before);
        parts
    }
}

impl Coat<'_> {
    /// Barycentric coordinates of the second and third corner where a path meets the
    /// triangle. In `edges` are the distances at which it met an edge: what
    /// neighbours have in common counts once.
    fn meets(
        &self,
        start: DVec3,
        direction: DVec3,
        length: f64,
        edges: &mut Vec<f64>,
    ) -> Option<(f64, f64)> {
        let [a, b, c] = self.corners;
        let (e, f, s) = (b - a, c - a, start - a);
        let p = direction.cross(f);
        let determinant = e.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let u = s.dot(p) / determinant;
        let q = s.cross(e);
        let v = direction.dot(q) / determinant;
        let t = f.dot(q) / determinant;
        let inside = u.min(v).min(1.0 - u - v);
        if !(inside >= -1e-12 && 0.0 < t && t < length) {
            return None;
        }
        if inside < 1e-9 {
            if edges.iter().any(|edge| (edge - t).abs() <= 1e-9 * t) {
                return None;
            }
            edges.push(t);
        }
        Some((u, v))
    }
}

/// 1 − a + a · transmission · colour.
fn passing(cover: &Caster<'_>, u: f64, v: f64) -> DVec3 {
    let coating: &Coating<'_> = match cover {
        Caster::Masked(coating) | Caster::SeeThrough(coating) => coating,
        Caster::Absent => return DVec3::ONE,
        _ => return DVec3::ZERO,
    };
    let w = 1.0 - u - v;
    let [a, b, c] = coating.texture_coordinates().map(|uv| uv.as_dvec2());
    let uv = w * a + u * b + v * c;
    let [a, b, c] = coating.colors().map(|color| color.as_dvec4());
    let vertex = w * a + u * b + v * c;
    let (mut color, mut alpha) = (DVec3::ONE, 1.0);
    if let Some(texture) = coating.texture() {
        color = lookup(texture, uv, |texel| texture.texels()[texel].as_dvec3());
        if let Some(alphas) = texture.alpha() {
            alpha = lookup(texture, uv, |texel| DVec3::splat(alphas[texel].into())).x;
        }
    }
    let alpha = (f64::from(coating.base_opacity()) * vertex.w * alpha).clamp(0.0, 1.0);
    let covered = match coating.mode() {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask { cutoff } => f64::from(u8::from(alpha >= f64::from(cutoff))),
        AlphaMode::Blend => alpha,
    };
    let mut transmission = f64::from(coating.transmission());
    if let Some(texture) = coating.transmission_texture() {
        let [a, b, c] = coating.transmission_coordinates().map(|uv| uv.as_dvec2());
        let uv = w * a + u * b + v * c;
        let red = lookup(texture, uv, |texel| texture.texels()[texel].as_dvec3()).x;
        transmission *= red.min(1.0);
    }
    let color = coating.base_color().as_dvec3() * vertex.truncate() * color;
    let color = color.clamp(DVec3::ZERO, DVec3::ONE);
    (1.0 - covered) + covered * transmission * color
}

/// A sum of hat functions around the centres of texels, or the texel itself.
fn lookup(texture: &Texture, uv: DVec2, texel: impl Fn(usize) -> DVec3) -> DVec3 {
    // What is nowhere is the first texel.
    if !uv.is_finite() {
        return texel(0);
    }
    let counts = [texture.width(), texture.height()].map(i64::from);
    let sampler = texture.sampler();
    let index = |axis: usize, at: i64| {
        let count = counts[axis];
        match sampler.wrap[axis] {
            Wrap::Repeat => at.rem_euclid(count),
            Wrap::Clamp => at.clamp(0, count - 1),
            Wrap::Mirror => {
                let turn = at.div_euclid(count);
                let within = at.rem_euclid(count);
                if turn % 2 == 0 {
                    within
                } else {
                    count - 1 - within
                }
            }
        }
    };
    let weights = |axis: usize| {
        let at = uv[axis] * counts[axis] as f64;
        match sampler.filter {
            Filter::Nearest => vec![(at.floor() as i64, 1.0)],
            Filter::Linear => {
                let first = (at - 0.5).floor();
                let share = at - 0.5 - first;
                vec![(first as i64, 1.0 - share), (first as i64 + 1, share)]
            }
        }
    };
    let mut sum = DVec3::ZERO;
    for (column, across) in weights(0) {
        for (row, down) in weights(1) {
            let number = index(1, row) * counts[0] + index(0, column);
            sum += across * down * texel(number as usize);
        }
    }
    sum
}
