//! Airlight from a table that has no bad corners.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A practical analytic
//! single scattering model for real time rendering, SIGGRAPH 2005, as used by
//! Wyman and Ramsey, Interactive volumetric shadows in participating media
//! with single-scattering, Interactive Ray Tracing 2008: airlight as the
//! difference of two lookups in a table of two variables. Theirs is of
//! `F(u, v)`, multiplied by a factor that grows like `e^τ`; here, with
//! `y = σ_t (s + d)` and `u = σ_t h`,
//!
//! ```text
//! A = 2σ_t e^{−σ_t (x_a + d_a)} [R(y_a, u) − e^{−(y_b − y_a)} R(y_b, u)]
//! R(y, u) = ∫_y^∞ p(cos θ) e^{−(y' − y)} / (u² + y'²) dy',    tan(θ/2) = y'/u
//! ```
//!
//! both exponents are true optical path lengths, nothing is trigonometric and
//! `h = 0` is an ordinary value. What is stored is the logarithm of R times a
//! simple estimate of 1/R, for any phase function. Where the difference would
//! lose more than one bit, and only there, the part is integrated instead.

mod axes;
mod batch;
mod cells;
mod close;
mod design;
#[cfg(feature = "wgsl")]
mod gpu;
mod integral;
mod long;
mod march;
mod near;
mod short;
#[cfg(test)]
mod tests;
mod waiting;

use axes::Axes;
use batch::Batch;
use long::{Extinction, Lookup};
pub(crate) use long::{known, settle};

use crate::{Error, Evaluator, Phase, ScatteringAngle, Segment, simd};

/// Largest share that may be left behind the end of a part, of the light
/// behind its start, for the part to be a difference of lookups: the errors of
/// both lookups then count three times.
const LARGEST_REST: f32 = 0.5;

/// Airlight for one phase function, in `f32`: two lookups in a few tens of
/// KiB for any part of any ray, for all extinctions.
///
/// The relative error is below [`Table::error_bound`] wherever the result is a
/// normal number: for parts of 1e-9 of the ray and for endless ones, rays that
/// all but meet the light, however closely, vacuum and fog of an optical depth
/// of 80. That holds for distances between eye and light from 1e-6 m to 1e6 m;
/// others give numbers too. Results below `2^-126` may be 0.
///
/// The light on the segment gives +∞. A length of 0 gives 0, and so does what
/// is no length or no extinction: NaN, and a negative `h`, `length` or
/// extinction. Extinction that differs between colours takes one call for each.
///
/// Batches and single segments give the same bits, on any processor. A short
/// part takes about as long as two lookups; for phase functions with a
/// backward peak several times as long, because it takes more nodes.
///
/// ```
/// use airlight::{Evaluator, PhaseFunction, Segment, Table};
///
/// let haze = Table::new(&PhaseFunction::HenyeyGreenstein { g: 0.7 }, 64)?;
/// assert!(haze.error_bound() < 3e-4);
/// // A light 3 m away, 60 degrees off the ray, which ends after 5 m.
/// let (s, h) = (-3.0 * 0.5, 3.0 * 0.866);
/// let segment = Segment { x: 0.0, s, h, length: 5.0 };
/// let whole = haze.airlight(0.1, &segment);
/// // Its second half is less than half of it.
/// let rest = Segment { x: 2.5, s: s + 2.5, h, length: 2.5 };
/// let mut parts = [0.0; 2];
/// haze.airlight_batch(0.1, &[segment, rest], &mut parts);
/// assert_eq!(parts[0], whole);
/// assert!(parts[1] < 0.5 * whole);
///
/// // Any function of the angle will do, and the error is measured.
/// let lobe = Table::new(&|angle: airlight::ScatteringAngle<f64>| {
///     0.25 / std::f64::consts::PI * (1.0 + 0.8 * angle.cos())
/// }, 16)?;
/// assert!(lobe.error_bound() < 0.01);
/// # Ok::<(), airlight::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    axes: Axes,
    cells: Vec<[f32; 4]>,
    /// Of the coefficients of second order.
    units: [f32; 3],
    /// Logarithm of the phase function for base 2, if it is constant.
    constant: Option<f32>,
    /// The same for each row of cells, if it is not.
    phase: Vec<[f32; 4]>,
    /// Nodes and weights for short parts.
    rule: Vec<[f32; 2]>,
    /// The same for parts that are near, see [`near`].
    near_rule: Vec<[f32; 2]>,
    error_bound: f32,
}

impl Table {
    /// A table of at most `kibibytes` KiB for a phase function, which may be a closure. The time
    /// to make it has a constant part, and one that is proportional to its size and is larger
    /// from some tens of KiB on.
    ///
    /// The memory is divided to suit the function. Doubling it brings the
    /// error down by up to three times; 64 KiB give 1e-4 for isotropic
    /// scattering.
    ///
    /// # Errors
    /// [`Error::BadValue`] if a parameter of the phase function is out of
    /// range, or one of some values of it is negative or not finite, or the
    /// size not from 4 to 1024 KiB.
    pub fn new<P: Phase>(phase: &P, kibibytes: u32) -> Result<Self, Error> {
        phase.check()?;
        if !(4..=1024).contains(&kibibytes) {
            let expected = "4 to 1024";
            let what = "the size of a table in KiB";
            return Err(Error::bad_value(what, kibibytes, expected));
        }
        // Samples of a function of the user's own: whether it is one at all.
        for step in -64..=64 {
            let tangent = 10_f64.powf(f64::from(step) / 8.0);
            let value = phase.value_f64(ScatteringAngle::from_half_tangent(tangent, 1.0));
            if !(value >= 0.0 && value.is_finite()) {
                let expected = "finite and at least 0";
                return Err(Error::bad_value("a phase function", value, expected));
            }
        }
        Ok(design::table(phase, kibibytes))
    }

    /// Size of the table in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cells[..]) + size_of_val(&self.phase[..])
    }

    /// The largest relative error of a result that is a normal number.
    ///
    /// Found by the constructor: three times the largest error of a lookup, as
    /// measured in every cell, or that of the quadrature of short parts, as
    /// measured over all their directions and lengths, with that of the stored
    /// phase function in every row, and what rounding can add to it. The lookups
    /// of a phase function that is not smooth on the scale of a cell may be worse
    /// than measured, and where one falls to 0 there is no small relative error.
    pub fn error_bound(&self) -> f32 {
        self.error_bound
    }

    /// What there is at an end.
    fn found(&self, end: &long::End) -> long::Found {
        let place = end.place;
        let cell = self.cells[place.cell as usize];
        long::Found {
            value: cells::value(cell, self.units, place.alpha, place.beta),
            divisor: end.divisor,
        }
    }

    /// Unless the extinction is none.
    fn lookup(&self, sigma_t: f32) -> Option<Lookup> {
        (0.0..f32::INFINITY).contains(&sigma_t).then(|| Lookup {
            axes: self.axes,
            extinction: Extinction::new(sigma_t),
        })
    }
}

impl Evaluator for Table {
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32 {
        let Some(lookup) = self.lookup(sigma_t) else {
            return 0.0;
        };
        if close::is_close(segment) {
            return settle(known(segment), self.close(&lookup, segment));
        }
        if lookup.is_near(segment) {
            return settle(known(segment), self.near(&lookup, segment));
        }
        let ends = lookup.ends(segment);
        let found = [self.found(&ends.start), self.found(&ends.end)];
        let (value, is_short) = lookup.difference(found, ends.depth, ends.growth);
        let value = if is_short {
            self.short(&lookup, segment)
        } else {
            value
        };
        settle(known(segment), value)
    }

    fn airlight_batch(&self, sigma_t: f32, segments: &[Segment], airlight: &mut [f32]) {
        assert_eq!(segments.len(), airlight.len(), "one result per segment");
        match self.lookup(sigma_t) {
            Some(lookup) => simd::batch(
                &Batch {
                    table: self,
                    lookup,
                },
                segments,
                airlight,
            ),
            None => airlight.fill(0.0),
        }
    }

    fn has_independent_batches(&self) -> bool {
        true
    }
}
