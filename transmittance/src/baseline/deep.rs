//! Deep shadow maps: as many vertices as an error bound takes.
//!
//! Based on: T. Lokovic, E. Veach, "Deep Shadow Maps", SIGGRAPH 2000: a line is
//! drawn from the last vertex through a window that every vertex of the exact
//! curve narrows, and ends in a new vertex when the window closes.
//!
//! Departures:
//!
//! * The exact curve is exponential between the ends of segments. It is cut
//!   into chords that stray from it by at most ε / 16, which the windows make
//!   up for, so that the bound holds for the true curve.
//! * A surface, a step of the curve, is a vertical edge: where its two ends do
//!   not fit into one window, two vertices share its depth.
//! * Beside the plain method, whose curve may rise and leave `[0, 1]`, there is
//!   one whose windows are cut off at slope 0 and at transmittance 0. The same
//!   bound holds: the exact curve never rises, so that a falling line that
//!   fits is always left.

use super::Captured;
use crate::numeric::{fraction, mix};
use crate::{Accumulate, BlockerSegment, Error, Evaluate};

/// Collects segments for a [`DeepCurve`]. Memory grows with them.
#[derive(Debug, Clone)]
pub struct Deep {
    captured: Captured,
    epsilon: f32,
    monotone: bool,
}

impl Deep {
    /// The method as published, with errors of at most `epsilon`. Results may
    /// leave `[0, 1]` by that much, as published; [`DeepCurve::transmittance`]
    /// does not clamp them.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless `1e-5 ≤ epsilon ≤ 1`: less is not above the
    /// roundings of f32.
    pub fn new(epsilon: f32) -> Result<Self, Error> {
        if !(1e-5..=1.0).contains(&epsilon) {
            return Err(Error::BadValue {
                what: "epsilon of a deep shadow map",
                value: epsilon.into(),
                expected: "a number from 1e-5 to 1",
            });
        }
        Ok(Self {
            captured: Captured::new(),
            epsilon,
            monotone: false,
        })
    }

    /// Curves that never rise and stay in `[0, 1]`, with the same bound.
    ///
    /// # Errors
    /// As [`Deep::new`].
    pub fn monotone(epsilon: f32) -> Result<Self, Error> {
        Ok(Self {
            monotone: true,
            ..Self::new(epsilon)?
        })
    }
}

impl Accumulate for Deep {
    type Curve = DeepCurve;

    fn insert(&mut self, segment: &BlockerSegment) {
        self.captured.insert(segment);
    }

    fn finish(self) -> DeepCurve {
        let epsilon = f64::from(self.epsilon);
        // Rounding a vertex to f32 moves it by at most 2^-24 of its size, which
        // is at most 1 + ε; looking up rounds once more.
        let windows = Windows {
            tolerance: epsilon * (1.0 - 1.0 / 16.0) - 2.5e-7,
            monotone: self.monotone,
            vertices: Vec::new(),
            slopes: (f64::NEG_INFINITY, f64::INFINITY),
            last: 0.0,
        };
        windows.compress(&self.captured.sum(), epsilon / 16.0)
    }
}

/// A line that is being drawn, and the vertices before it.
struct Windows {
    tolerance: f64,
    monotone: bool,
    /// Depth and transmittance, the last being where the line begins.
    vertices: Vec<(f32, f64)>,
    /// The slopes that fit all vertices so far.
    slopes: (f64, f64),
    /// Depth of the last vertex that they fit.
    last: f32,
}

impl Windows {
    fn compress(mut self, points: &[(f32, f64)], stray: f64) -> DeepCurve {
        let Some(&(first, _)) = points.first() else {
            return DeepCurve {
                vertices: Vec::new(),
            };
        };
        self.vertices.push((first, 1.0));
        self.last = first;
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            if to.0 > from.0 {
                self.exponential(from, to, stray);
            } else {
                self.step((-to.1).exp());
            }
        }
        if self.last > self.start().0 {
            self.close();
        }
        DeepCurve {
            vertices: self.vertices.iter().map(|&(d, t)| (d, t as f32)).collect(),
        }
    }

    /// Where the line begins.
    fn start(&self) -> (f32, f64) {
        self.vertices[self.vertices.len() - 1]
    }

    /// The values that may be stored for an exact transmittance.
    fn limits(&self, exact: f64) -> (f64, f64) {
        let (least, most) = (exact - self.tolerance, exact + self.tolerance);
        if self.monotone {
            (least.max(0.0), most.min(1.0))
        } else {
            (least, most)
        }
    }

    /// Follows the exact curve from one point to the next, in chords.
    fn exponential(&mut self, from: (f32, f64), to: (f32, f64), stray: f64) {
        // Behind an optical depth of 20 transmittance is below 2.1e-9: one
        // chord does for the rest.
        const DARK: f64 = 20.0;
        let (tau, rise) = (from.1, to.1 - from.1);
        let (near, far) = (f64::from(from.0), f64::from(to.0));
        let mut at = tau;
        while at < to.1.min(DARK) {
            // A chord over an optical depth x strays by at most e^(−at) x² / 8.
            let end = at + (8.0 * stray * at.exp()).sqrt();
            // Rounded towards the start, but at least to the next float: no depth lies between
            // two floats.
            let ideal = near + (far - near) * ((end - tau) / rise).min(1.0);
            let depth = ideal as f32;
            let depth = if f64::from(depth) > ideal {
                depth.next_down()
            } else {
                depth
            };
            let depth = depth.max(self.last.next_up());
            if depth >= to.0 {
                break;
            }
            at = tau + rise * fraction(from.0, to.0, depth);
            self.vertex(depth, (-at).exp());
        }
        self.vertex(to.0, (-to.1).exp());
    }

    /// Narrows the window to a vertex of the exact curve, or begins a new line
    /// at the one before it.
    fn vertex(&mut self, depth: f32, exact: f64) {
        let (least, most) = self.limits(exact);
        for _ in 0..2 {
            let (start, value) = self.start();
            let inverse = (f64::from(depth) - f64::from(start)).recip();
            let mut slopes = ((least - value) * inverse, (most - value) * inverse);
            if self.monotone {
                slopes.1 = slopes.1.min(0.0);
            }
            let slopes = (self.slopes.0.max(slopes.0), self.slopes.1.min(slopes.1));
            if slopes.0 <= slopes.1 || self.last == start {
                self.slopes = slopes;
                self.last = depth;
                return;
            }
            self.close();
        }
    }

    /// A surface at the depth of the last vertex, behind which `exact` is left.
    fn step(&mut self, exact: f64) {
        let (least, most) = self.limits(exact);
        let (start, value) = self.start();
        if self.last > start {
            // The line may go on if it fits both ends of the step.
            let inverse = (f64::from(self.last) - f64::from(start)).recip();
            let slopes = (
                self.slopes.0.max((least - value) * inverse),
                self.slopes.1.min((most - value) * inverse),
            );
            if slopes.0 <= slopes.1 {
                self.slopes = slopes;
                return;
            }
            self.close();
        } else if (least..=most).contains(&value) {
            return;
        }
        let above = self.start().1;
        let value = if self.monotone {
            exact.min(above)
        } else {
            exact
        };
        self.vertices.push((self.last, value));
        self.slopes = (f64::NEG_INFINITY, f64::INFINITY);
    }

    /// Ends the line in a vertex, in the middle of its window.
    fn close(&mut self) {
        let (start, value) = self.start();
        let slope = 0.5 * (self.slopes.0 + self.slopes.1);
        let end = value + slope * (f64::from(self.last) - f64::from(start));
        self.vertices.push((self.last, end));
        self.slopes = (f64::NEG_INFINITY, f64::INFINITY);
    }
}

/// Transmittance within ε of the truth, as a polygonal line.
///
/// Of the order of `log n` steps per query for `n` vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct DeepCurve {
    vertices: Vec<(f32, f32)>,
}

impl DeepCurve {
    /// How many vertices it took.
    #[must_use]
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// True if nothing is in the way.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// Share of the light that gets as far as `depth`, as the line has it.
    #[must_use]
    pub fn transmittance(&self, depth: f32) -> f32 {
        let next = self.vertices.partition_point(|vertex| vertex.0 < depth);
        let Some(before) = next.checked_sub(1).map(|index| self.vertices[index]) else {
            return 1.0;
        };
        match self.vertices.get(next) {
            Some(&after) => mix(before.1, after.1, fraction(before.0, after.0, depth)),
            None => before.1,
        }
    }
}

impl Evaluate for DeepCurve {
    /// Clamped, as the trait promises.
    fn evaluate(&self, depth: f32) -> [f32; 1] {
        [self.transmittance(depth).clamp(0.0, 1.0)]
    }
}
