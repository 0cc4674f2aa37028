//! The airlight of a segment per unit of `σ_s I`, in f64, by adaptive
//! quadrature along the ray itself.
//!
//! ```text
//! A = ∫_0^length p(cos θ) exp(−σ_t (x + t + d)) / d² dt,   d² = (s + t)² + h²
//! ```
//!
//! No variable is changed: pieces that shrink towards the foot point of the
//! light resolve the peak there, pieces of mean free paths the extinction. A
//! segment of any shortness keeps its digits, because only its own length is
//! divided.

use glam::DVec3;

use super::Phase;
use super::quadrature::{Piece, Tolerance, integrate};

/// Mean free paths after which nothing is left that could be seen in f64.
const OPAQUE: f64 = 60.0;

/// A part of a ray by its own four lengths, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// From the eye to the start of the part.
    pub x: f32,
    /// From the foot point of the light to the start; negative before it.
    pub s: f32,
    /// Between the light and the line of the ray.
    pub h: f32,
    /// Of the part; may be infinite.
    pub length: f32,
}

impl Part {
    /// True if the light lies on the part, whose airlight is infinite then.
    pub fn holds_the_light(&self) -> bool {
        self.h == 0.0 && self.s <= 0.0 && self.s + self.length >= 0.0
    }
}

#[cfg(feature = "scene")]
impl From<airlight::Segment> for Part {
    fn from(segment: airlight::Segment) -> Self {
        let airlight::Segment { x, s, h, length } = segment;
        Self { x, s, h, length }
    }
}

#[cfg(feature = "scene")]
impl From<Part> for airlight::Segment {
    fn from(part: Part) -> Self {
        let Part { x, s, h, length } = part;
        Self { x, s, h, length }
    }
}

/// A value and the bound on its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Airlight {
    /// `A`, 1/(m sr).
    pub value: f64,
    /// Bound on the error of the value.
    pub bound: f64,
}

/// `A` to a relative error of about `relative`, which is at least 1e-13. A
/// segment that contains the light has no finite one and must not be asked for.
pub fn airlight(
    phase: impl Into<Phase>,
    sigma_t: f64,
    part: impl Into<Part>,
    relative: f64,
) -> Airlight {
    let (phase, part) = (phase.into(), part.into());
    let [x, s, h, length] = [part.x, part.s, part.h, part.length].map(f64::from);
    let start = s.hypot(h);
    // s + d without cancellation in front of the light.
    let ahead = |s: f64, d: f64| if s < 0.0 { h * (h / (d - s)) } else { s + d };
    // On the way towards the light as much is lost in front as is gained
    // behind: only behind its foot point does the depth grow for sure.
    let in_front = (-s).max(0.0);
    let depth_ahead = in_front + OPAQUE / sigma_t.max(f64::MIN_POSITIVE);
    // Without extinction what lies 1e20 of its distances behind the light is
    // 1e-20 of the whole.
    let end = length.min(depth_ahead).min(1e20 * (start + h));
    // What is common to all of the segment comes last, so that nothing
    // underflows before.
    let integrand = |_: usize, t: f64| {
        let s_t = s + t;
        let d = s_t.hypot(h);
        let narrow = 0.5 * (h / d) * (h / (d + s_t.abs()));
        let wide = 0.5 * (d + s_t.abs()) / d;
        let (sin2, cos2) = if s_t > 0.0 {
            (wide, narrow)
        } else {
            (narrow, wide)
        };
        let longer = t * (ahead(s, start) + ahead(s_t, d)) / (start + d);
        let value = (start / d).powi(2) * (-sigma_t * longer).exp();
        DVec3::splat(value * phase.at(sin2, cos2))
    };
    let mut pieces = Vec::new();
    let mut edges = vec![0.0, end];
    let mut edge = |t: f64| {
        if 0.0 < t && t < end {
            edges.push(t);
        }
    };
    edge(-s);
    let finest = h.max(1e-18 * start);
    let mut width = finest;
    while width < end + start {
        edge(-s - width);
        edge(-s + width);
        width *= 4.0;
    }
    let mut depth = 0.5;
    while depth < OPAQUE {
        let way = depth / sigma_t.max(f64::MIN_POSITIVE);
        edge(way);
        edge(in_front + way);
        depth *= 2.0;
    }
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    for pair in edges.windows(2) {
        pieces.push(Piece::new(0, pair[0], pair[1], &integrand));
    }
    let sum = integrate(
        &mut pieces,
        Tolerance::relative(relative.max(1e-13)),
        integrand,
    );
    let scale = (-sigma_t * (x + start)).exp() / (start * start);
    Airlight {
        value: sum.value.x * scale,
        bound: sum.bound * scale,
    }
}
