//! Airlight from a table that is made anew for every frame.
//!
//! Based on: Wyman and Ramsey, Interactive volumetric shadows in participating
//! media with single-scattering, Interactive Ray Tracing 2008: for one eye, one
//! light and one medium the airlight of a step along a ray depends on the angle
//! of the ray and the two distances, so that a table of the two variables
//! `F'(cos γ, x)` serves it with one lookup, and one subtraction from the
//! lookup of the step before. Here the table holds the airlight from the eye
//! up to x, which differs from their `F'` by what is the same all along a ray,
//! and is made with any evaluator: for any phase function, and without the
//! large numbers that `F'` has away from the light.

use crate::{Error, Evaluator, Segment};

/// `F'(cos γ, x) = ∫_0^x p(cos θ) e^{−σ_t (x' + d)} / d² dx'`, 1/(m sr), for
/// one distance `D` between eye and light and one extinction, at points evenly
/// spaced in `cos γ` from -1 to 1 and in x, with linear interpolation.
///
/// The error is what the spacing makes it: it is largest next to the light,
/// where F' rises by `π p / (D sin γ)` within `D sin γ` of x. The row of
/// `cos γ = 1`, which meets the light, holds the limit at [`FrameTable::NEAREST`].
///
/// ```
/// use airlight::{Exact, FrameTable, PhaseFunction};
///
/// let exact = Exact::new(PhaseFunction::Isotropic)?;
/// // A light 4 m away in fog of 0.1/m, seen as far as 10 m.
/// let table = FrameTable::new(&exact, 0.1, 4.0, 10.0, [256, 256])?;
/// let mut steps = [0.0; 3];
/// table.steps(0.5, &[0.0, 1.0, 2.0, 4.0], &mut steps);
/// assert_eq!(steps[1], table.up_to(0.5, 2.0) - table.up_to(0.5, 1.0));
/// # Ok::<(), airlight::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTable {
    /// Rows of equal cos γ.
    values: Vec<f32>,
    angles: usize,
    distances: usize,
    /// Entries per metre.
    density: f32,
}

/// Most entries of a table: 256 MiB.
const MOST: u64 = 1 << 26;

impl FrameTable {
    /// The angle, in radians, that takes the place of 0: rays through the
    /// light have no finite airlight.
    pub const NEAREST: f32 = 1e-4;

    /// For a light `distance` m from the eye and parts of rays up to
    /// `farthest` m; `size` counts angles and distances.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless extinction is finite and not negative, both
    /// lengths are positive and finite, and there are 2 to 65536 angles and
    /// distances and at most 2^26 entries, or if the light is so near that its
    /// airlight leaves the range of f32.
    pub fn new(
        evaluator: &impl Evaluator,
        sigma_t: f32,
        distance: f32,
        farthest: f32,
        size: [u32; 2],
    ) -> Result<Self, Error> {
        if !(0.0..f32::INFINITY).contains(&sigma_t) {
            return Err(Error::bad_value("extinction", sigma_t, "0 or more, in 1/m"));
        }
        let lengths = [
            ("the distance between eye and light", distance),
            ("the farthest distance", farthest),
        ];
        for (what, length) in lengths {
            if !(length > 0.0 && length < f32::INFINITY) {
                return Err(Error::bad_value(what, length, "a positive length in m"));
            }
        }
        for count in size {
            if !(2..=65_536).contains(&count) {
                let expected = "2 to 65536";
                return Err(Error::bad_value("a side of a frame table", count, expected));
            }
        }
        let entries = u64::from(size[0]) * u64::from(size[1]);
        if entries > MOST {
            let expected = "at most 2^26";
            return Err(Error::bad_value(
                "entries of a frame table",
                entries as f64,
                expected,
            ));
        }
        let [angles, distances] = size.map(|count| count as usize);
        let last = f64::from(size[1] - 1);
        let step = f64::from(farthest) / last;
        let mut values = Vec::with_capacity(angles * distances);
        let mut segments = vec![Segment::default(); distances - 1];
        let mut parts = vec![0.0; distances - 1];
        for row in 0..size[0] {
            let cos = 2.0 * f64::from(row) / f64::from(size[0] - 1) - 1.0;
            let gamma = cos.clamp(-1.0, 1.0).acos().max(f64::from(Self::NEAREST));
            for (j, segment) in segments.iter_mut().enumerate() {
                let x = step * j as f64;
                *segment = Segment {
                    x: x as f32,
                    s: (x - f64::from(distance) * gamma.cos()) as f32,
                    h: (f64::from(distance) * gamma.sin()) as f32,
                    length: step as f32,
                };
            }
            evaluator.airlight_batch(sigma_t, &segments, &mut parts);
            values.push(0.0);
            let mut sum = 0.0;
            values.extend(parts.iter().map(|&part| {
                sum += f64::from(part);
                sum as f32
            }));
            if !sum.is_finite() || sum > f64::from(f32::MAX) {
                let expected = "one at which airlight does not leave the range of f32";
                return Err(Error::bad_value(lengths[0].0, distance, expected));
            }
        }
        Ok(Self {
            values,
            angles,
            distances,
            density: (1.0 / step) as f32,
        })
    }

    /// `F'(cos γ, x)`, for numbers beyond the ends of the table its value
    /// there: one lookup.
    #[inline]
    pub fn up_to(&self, cos_gamma: f32, x: f32) -> f32 {
        let (row, across) = split(
            (cos_gamma + 1.0) * 0.5 * (self.angles - 1) as f32,
            self.angles,
        );
        let (column, along) = split(x * self.density, self.distances);
        let start = row * self.distances + column;
        let (above, below) = (
            &self.values[start..],
            &self.values[start + self.distances..],
        );
        let above = above[0] + along * (above[1] - above[0]);
        let below = below[0] + along * (below[1] - below[0]);
        above + across * (below - above)
    }

    /// The airlight of each step between consecutive `distances` along the ray
    /// at γ: a lookup and a subtraction for each.
    ///
    /// # Panics
    /// Unless there is one distance more than there are steps.
    pub fn steps(&self, cos_gamma: f32, distances: &[f32], airlight: &mut [f32]) {
        assert_eq!(
            distances.len(),
            airlight.len() + 1,
            "a step between any two distances"
        );
        let Some((&first, rest)) = distances.split_first() else {
            return;
        };
        let mut before = self.up_to(cos_gamma, first);
        for (&x, airlight) in rest.iter().zip(airlight) {
            let value = self.up_to(cos_gamma, x);
            *airlight = value - before;
            before = value;
        }
    }

    /// The table, rows of equal `cos γ` one after the other, and the numbers
    /// of rows and columns.
    pub fn values(&self) -> (&[f32], [usize; 2]) {
        (&self.values, [self.angles, self.distances])
    }
}

/// The entry before a position and the position behind it.
#[inline]
fn split(position: f32, entries: usize) -> (usize, f32) {
    // NaN counts as 0.
    let position = position.max(0.0).min((entries - 1) as f32);
    let entry = (position as usize).min(entries - 2);
    (entry, position - entry as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Exact, PhaseFunction};

    #[test]
    fn steps_add_up_and_are_near_the_truth() -> Result<(), Error> {
        let exact = Exact::new(PhaseFunction::Isotropic)?;
        let table = FrameTable::new(&exact, 0.2, 3.0, 8.0, [513, 1024])?;
        for step in 0..=180 {
            let gamma = f64::from(step).to_radians();
            let cos = gamma.cos() as f32;
            let distances: Vec<f32> = (0..=8).map(|x| x as f32).collect();
            let mut steps = [0.0; 8];
            table.steps(cos, &distances, &mut steps);
            let sum: f32 = steps.iter().sum();
            let whole = table.up_to(cos, 8.0);
            assert!((sum - whole).abs() <= 1e-6 * whole, "{sum} is not {whole}");
            if gamma > 0.3 {
                let segment = Segment {
                    x: 0.0,
                    s: (-3.0 * gamma.cos()) as f32,
                    h: (3.0 * gamma.sin()) as f32,
                    length: 8.0,
                };
                let truth = exact.airlight(f64::from(0.2_f32), &segment.into());
                let error = f64::from(whole) / truth - 1.0;
                // An eighth of the second difference along cos γ, of what is
                // near (π − γ) / sin γ: (2/512)² / 8 times
                // (1 + 2 cos²) / sin⁴ + 3 cos / ((π − γ) sin³), 7.5e-4 at 0.3.
                assert!(error.abs() < 1e-3, "{step} degrees: {error:e}");
            }
        }
        Ok(())
    }

    #[test]
    fn lookups_beyond_the_table_and_of_nan_are_numbers() -> Result<(), Error> {
        let exact = Exact::new(PhaseFunction::Isotropic)?;
        let table = FrameTable::new(&exact, 0.0, 1.0, 2.0, [16, 16])?;
        for value in [
            -2.0,
            2.0,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
            1.0,
            -1.0,
        ] {
            for x in [-1.0, 1e30, f32::INFINITY, f32::NAN, 0.0, 2.0] {
                assert!(table.up_to(value, x) >= 0.0, "at {value}, {x}");
            }
        }
        Ok(())
    }

    #[test]
    fn bad_sizes_and_lengths_are_errors() -> Result<(), Error> {
        let exact = Exact::new(PhaseFunction::Isotropic)?;
        let made = |sigma, distance, farthest, size| {
            FrameTable::new(&exact, sigma, distance, farthest, size).is_ok()
        };
        assert!(made(0.1, 1.0, 1.0, [2, 2]));
        for sigma in [-1.0, f32::NAN, f32::INFINITY] {
            assert!(!made(sigma, 1.0, 1.0, [2, 2]));
        }
        for length in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(!made(0.1, length, 1.0, [2, 2]) && !made(0.1, 1.0, length, [2, 2]));
        }
        for size in [[1, 2], [2, 1], [65_537, 2], [65_536, 65_536]] {
            assert!(!made(0.1, 1.0, 1.0, size));
        }
        Ok(())
    }
}
