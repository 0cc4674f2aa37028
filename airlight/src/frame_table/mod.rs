//! Airlight from a table that is made anew for every frame.
//!
//! Based on: Wyman and Ramsey, Interactive volumetric shadows in participating
//! media with single-scattering, Interactive Ray Tracing 2008, section 3.4: for
//! one eye, one light and one medium, airlight is a function of two variables,
//! the angle γ between ray and light and the distance x from the eye. They store
//! `F'(cos γ, x) = A0 F(A1, A2(x))`, and a step of a march is the difference of two
//! lookups, of which one is that of the step before.
//!
//! # What is stored
//!
//! `F'` itself serves badly: A0 grows like `e^τ / sin γ` away from the light, so that
//! short steps are differences of large numbers; steps of equal `cos γ` put a single
//! row on the three degrees next to the light; and steps of equal x put all that
//! happens there into one of them. Here, with the triangle of eye, light and point,
//! its angles γ at the eye, φ at the light and ψ at the point, and
//! `dx/d² = dφ/h`,
//!
//! ```text
//! A[a, b] = 1/h ∫ f dφ,    f = p(cos θ) e^{−σ_t (x + d)},    x + d = D (1 + v)/(1 − v)
//! v = tan(γ/2) tan(φ/2),   θ = π − ψ
//! ```
//!
//! f is bounded and smooth, and so is its mean over an angle. One sheet of the table
//! holds the mean from the eye on, for points nearer than the light (`x ≤ D`), the
//! other the mean from infinity back to the point, for those farther away. Both are
//! means over the tangent of half the angle, φ or ψ, which is at most 1 then and takes
//! a square root and a division to find:
//!
//! ```text
//! tan(φ/2)/h = x / (D d + h² − s x_F),   tan(ψ/2)/h = 1/(d + s)
//! ```
//!
//! The product of tangent and mean is a cumulative that begins at 0 where rays begin
//! and where they end, as far apart as can be, and never falls. No angle is found, no
//! exponential taken, and `h = 0` is an ordinary value. The factor `e^{−σ_t D}`, which
//! all points share, is left out.
//!
//! | axis | positions |
//! |---|---|
//! | across, both sheets | even in `√(tan(γ/2) / (1 + tan(γ/2)))`: finest towards the light |
//! | near sheet | even in `tan(φ/2)` as a share of its largest value |
//! | far sheet | even in the mean of two shares: of `tan(ψ/2)`, and of `tan(ψ/2) / (tan(ψ/2) + tan(γ/2))`, which tells apart what lies behind the light at a small angle |
//!
//! Along the ray a cell holds a cubic that has the cumulative and its slope right at
//! both ends, so that the shortest step is as good as a long one; across, two rows are
//! interpolated, which is where the error comes from.
//!
//! # What it cannot know
//!
//! A difference of lookups below 1/1024 of either has lost its digits, and far behind
//! the light in thick fog light falls by more than a cubic follows. Peaks of phase
//! functions, at `γ = 0` and π, may be narrower than the distance between rows. Both are
//! found out when a table is made, from the means and the densities within cells and half
//! way between rows, and such cells are marked. There, for rays that begin elsewhere, for other extinctions and for the light itself
//! [`FrameTable::look_up`] returns `None`; [`Framed`] asks another evaluator then.

mod build;
#[cfg(feature = "wgsl")]
mod gpu;
#[cfg(test)]
mod tests;

use crate::{Error, Evaluator, Phase, Segment};

/// Airlight for one distance between eye and light, one extinction and one phase
/// function: a lookup and a square root for each end of a part.
///
/// Largest relative error of what is looked up, at optical distances of 0.1, 0.5 and 2
/// between eye and light: rays spread over the sphere, runs from the eye on and from
/// there to infinity, and hundredths of them (`steps`):
///
/// | rows | memory | isotropic | steps | Henyey-Greenstein 0.7 | steps | 0.9 | steps | −0.9 | steps |
/// |---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
/// | 64 | 32 KiB | 4.3e-3 | 3.3e-3 | 4.3e-3 | 4.0e-3 | 4.3e-3 | 5.2e-3 | 5.0e-3 | 5.6e-3 |
/// | 128 | 128 KiB | 1.6e-3 | 3.8e-3 | 1.8e-3 | 3.6e-3 | 1.8e-3 | 3.6e-3 | 4.5e-3 | 4.9e-3 |
/// | 256 | 512 KiB | 2.1e-3 | 2.0e-3 | 2.1e-3 | 2.0e-3 | 2.1e-3 | 2.0e-3 | 3.6e-3 | 3.8e-3 |
///
/// The light is checked half way between rows when the table is made, and what is off by
/// more than 5e-3 there is refused, so that sharper phase functions cost knowledge, not
/// accuracy: for Henyey-Greenstein from −0.99 to 0.999, and for droplets of fog, all that
/// is known is within 1e-2 of the truth. Where nothing is refused, errors of runs come from the distance between rows
/// and fall with its square; elsewhere, from the cells next to those that are refused.
///
/// Of the runs and steps of the table, with 128 rows, at optical distances of 0.1 and 0.5
/// at most 0.2 % are refused, and 10 % and 13 % for −0.9; at 2, a quarter of the runs and a
/// tenth of the steps, and 33 % and 14 % for −0.9: they lie in the dark behind much light.
/// With 64 rows it is 45 % to 64 % and 19 % to 51 % at 2. Of parts that crowd the axis,
/// half of them within 6 degrees of it, 46 % to 66 % of the runs and 34 % to 50 % of the
/// steps are refused for −0.99, −0.97, 0.97, 0.99 and 0.999 with 128 rows.
///
/// ```
/// use airlight::{Evaluator, FrameTable, PhaseFunction, Quadrature, Segment};
///
/// let phase = PhaseFunction::HenyeyGreenstein { g: 0.5 };
/// // A light 4 m from the eye in fog of 0.1/m.
/// let table = FrameTable::new(&phase, 0.1, 4.0, 128)?;
/// // A step of a ray that looks 60 degrees away from it.
/// let (foot, h) = (4.0 * 0.5, 4.0 * 0.866_025_4);
/// let step = Segment { x: 3.0, s: 3.0 - foot, h, length: 0.1 };
/// let airlight = table.look_up(&step).expect("a ray from the eye");
/// let truth = Quadrature::with_tolerance(phase, 1e-6)?.airlight(0.1, &step);
/// assert!((airlight / truth - 1.0).abs() < 1e-3);
/// // The same step 5 m farther along: no ray from that eye.
/// assert_eq!(table.look_up(&Segment { x: 8.0, ..step }), None);
/// # Ok::<(), airlight::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTable {
    /// Cubics of the near sheet, row by row, then those of the far one.
    cells: Vec<[f32; 4]>,
    rows: u32,
    /// Cells of a row in each sheet.
    cells_of_row: u32,
    sigma_t: f32,
    distance: f32,
    /// `e^{−σ_t D}`.
    transmittance: f32,
}

/// The smallest difference of lookups that counts, as a share of the larger one.
const LEAST: f32 = 1.0 / 1024.0;

/// How far from the eye of the table a ray may begin, as a share of its distance from
/// the light: what rounding makes of rays from the eye.
const ELSEWHERE: f32 = 1.0 / 65536.0;

/// A ray from the eye of a [`FrameTable`].
///
/// With `P = D + x_F` and `q_m` the value of `d + s` at `x = D`.
#[derive(Debug, Clone, Copy)]
pub struct FrameRay<'a> {
    table: &'a FrameTable,
    foot: f32,
    h: f32,
    p: f32,
    q_m: f32,
    row: u32,
    /// Position between the row and the next one.
    across: f32,
}

/// What a [`FrameTable`] holds for a point of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramePoint {
    is_far: bool,
    /// The distance from the eye, m.
    x: f32,
    /// Tangent times mean, 1/m: from the eye, or else from infinity.
    sum: f32,
}

impl FrameTable {
    /// The largest optical distance between eye and light.
    pub const DEEPEST: f32 = 16.0;

    /// For a light `distance` metres from the eye; the more `rows`, the better, with
    /// `8 rows²` bytes. Several threads make it; the result does not depend on how many.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless extinction is finite and not negative, the distance
    /// from 1e-9 m to 1e9 m and at most [`DEEPEST`](Self::DEEPEST) mean free paths, and
    /// the rows are 16 to 1024 and a multiple of 8, or if the phase function is out of
    /// range.
    pub fn new<P: Phase>(phase: &P, sigma_t: f32, distance: f32, rows: u32) -> Result<Self, Error> {
        phase.check()?;
        if !(0.0..f32::INFINITY).contains(&sigma_t) {
            return Err(Error::bad_value("extinction", sigma_t, "0 or more, in 1/m"));
        }
        if !(1e-9..=1e9).contains(&distance) {
            let what = "the distance between eye and light";
            return Err(Error::bad_value(what, distance, "1e-9 m to 1e9 m"));
        }
        let depth = sigma_t * distance;
        if depth > Self::DEEPEST {
            let what = "the optical distance between eye and light";
            return Err(Error::bad_value(what, depth, "at most 16"));
        }
        Self::check_rows(rows)?;
        Ok(build::table(phase, sigma_t, distance, rows))
    }

    /// Whether there are tables of so many rows.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless they are 16 to 1024 and a multiple of 8.
    pub fn check_rows(rows: u32) -> Result<(), Error> {
        if (16..=1024).contains(&rows) && rows.is_multiple_of(8) {
            return Ok(());
        }
        let expected = "16 to 1024 and a multiple of 8";
        Err(Error::bad_value(
            "the rows of a frame table",
            rows,
            expected,
        ))
    }

    /// The airlight of a part of a ray from the eye, per unit of `σ_s I`, in 1/(m sr).
    ///
    /// `None` where the table cannot know it: if the ray begins elsewhere, by more than
    /// 1/65536 of the distance to the light; if the part has less than 1/1024 of the
    /// light between it and the eye, or beyond the light between it and infinity, so
    /// that a difference would have no digits; if it ends where the light falls faster
    /// than the table follows, far behind the light in thick fog, or where the phase
    /// function is too sharp for the distance between rows; if it may hold the light
    /// itself; and if its numbers are no lengths.
    #[inline]
    pub fn look_up(&self, segment: &Segment) -> Option<f32> {
        let Segment { x, s, h, length } = *segment;
        // NaN is refused, too.
        if !(x >= 0.0 && length > 0.0) {
            return None;
        }
        let ray = self.ray(x - s, h)?;
        let start = ray.point(x, s)?;
        ray.between(&start, &ray.point(x + length, s + length)?)
    }

    /// A ray of which the light is the distance `h` away, `foot` metres along it, for
    /// many lookups; `None` if it does not begin at the eye.
    ///
    /// ```
    /// # use airlight::{FrameTable, PhaseFunction};
    /// let table = FrameTable::new(&PhaseFunction::Isotropic, 0.1, 5.0, 128)?;
    /// let ray = table.ray(4.0, 3.0).expect("5 m away");
    /// // A march: each step takes one lookup and a subtraction.
    /// let mut steps = Vec::new();
    /// let mut before = ray.at(0.0);
    /// for x in [1.0, 2.0, 4.0, f32::INFINITY] {
    ///     let here = ray.at(x);
    ///     let light = before.zip(here).and_then(|(a, b)| ray.between(&a, &b));
    ///     steps.push(light.expect("thin fog"));
    ///     before = here;
    /// }
    /// assert!(steps[2] > steps[1] && steps[1] > steps[0]);
    /// # Ok::<(), airlight::Error>(())
    /// ```
    #[inline]
    pub fn ray(&self, foot: f32, h: f32) -> Option<FrameRay<'_>> {
        let distance = self.distance;
        let found = (foot * foot + h * h).sqrt();
        if !((found - distance).abs() <= ELSEWHERE * distance && h >= 0.0) {
            return None;
        }
        // D + |x_F|, and D − |x_F| without cancellation: their product is h².
        let larger = distance + foot.abs();
        let smaller = h * (h / larger);
        let (p, q, share) = if foot >= 0.0 {
            (larger, smaller, h / (h + larger))
        } else {
            (smaller, larger, larger / (larger + h))
        };
        let position = share.sqrt() * (self.rows - 1) as f32;
        let row = (position as u32).min(self.rows - 2);
        Some(FrameRay {
            table: self,
            foot,
            h,
            p,
            q_m: (2.0 * distance * q).sqrt() + q,
            row,
            across: position - row as f32,
        })
    }

    /// Size of the table in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cells[..])
    }

    /// The extinction that it is for, 1/m.
    pub fn sigma_t(&self) -> f32 {
        self.sigma_t
    }

    /// The distance between eye and light that it is for, m.
    pub fn distance(&self) -> f32 {
        self.distance
    }
}

impl FrameRay<'_> {
    /// The point at the distance `x` from the eye, at least 0, which may be infinite;
    /// `None` where the table does not follow the light.
    #[inline]
    pub fn at(&self, x: f32) -> Option<FramePoint> {
        self.point(x, x - self.foot)
    }

    /// The airlight between two points, as [`FrameTable::look_up`] gives it; `None`, too,
    /// unless `end` is farther from the eye than `start`.
    #[inline]
    pub fn between(&self, start: &FramePoint, end: &FramePoint) -> Option<f32> {
        let holds_light = self.h == 0.0 && start.x <= self.foot && self.foot <= end.x;
        if !(start.x < end.x) || holds_light {
            return None;
        }
        let (difference, larger) = match (start.is_far, end.is_far) {
            (false, false) => (end.sum - start.sum, end.sum),
            (true, _) => (start.sum - end.sum, start.sum),
            (false, true) => {
                let [near, far] = self.at_light_distance()?;
                ((near - start.sum) + (far - end.sum), near + far)
            }
        };
        let counts = difference >= LEAST * larger && difference > 0.0 && difference.is_finite();
        counts.then_some(self.table.transmittance * difference)
    }

    /// `s` is `x − x_F` with its digits.
    #[inline]
    fn point(&self, x: f32, s: f32) -> Option<FramePoint> {
        let distance = self.table.distance;
        let d = (s * s + self.h * self.h).sqrt();
        if x <= distance {
            let tangent = x / (distance * d + (self.h * self.h - s * self.foot));
            let mean = self.mean(false, self.q_m * tangent)?;
            return Some(FramePoint {
                is_far: false,
                x,
                sum: tangent * mean,
            });
        }
        let q = d + s.max(0.0);
        if q == f32::INFINITY {
            return Some(FramePoint {
                is_far: true,
                x,
                sum: 0.0,
            });
        }
        let position = 0.5 * (self.q_m / q + (self.p + self.q_m) / (self.p + q));
        Some(FramePoint {
            is_far: true,
            x,
            sum: self.mean(true, position)? / q,
        })
    }

    /// Both cumulatives at `x = D`.
    #[inline]
    fn at_light_distance(&self) -> Option<[f32; 2]> {
        let tangent = 1.0 / self.q_m;
        let (near, far) = (self.mean(false, 1.0)?, self.mean(true, 1.0)?);
        Some([tangent * near, tangent * far])
    }

    /// `None` in a cell that does not follow it.
    #[inline]
    fn mean(&self, is_far: bool, position: f32) -> Option<f32> {
        let table = self.table;
        let cells = table.cells_of_row;
        let first = if is_far { table.rows * cells } else { 0 };
        let position = position * cells as f32;
        let cell = (position as u32).min(cells - 1);
        let along = (position - cell as f32).min(1.0);
        let index = (first + self.row * cells + cell) as usize;
        let (above, below) = (&table.cells[index], &table.cells[index + cells as usize]);
        // The sign of the upper row's cell says whether the strip between the two is known.
        if above[0] < 0.0 {
            return None;
        }
        let below = [below[0].abs(), below[1], below[2], below[3]];
        let mut mean = 0.0;
        for (above, below) in above.iter().zip(below).rev() {
            mean = mean * along + (above + self.across * (below - above));
        }
        Some(mean)
    }
}

/// A table of a frame, and another evaluator for what it does not know.
///
/// ```
/// use airlight::{Evaluator, FrameTable, Framed, PhaseFunction, Quadrature, Segment};
///
/// let phase = PhaseFunction::Rayleigh;
/// let fallback = Quadrature::with_tolerance(phase, 1e-5)?;
/// let framed = Framed::new(FrameTable::new(&phase, 0.1, 4.0, 128)?, fallback.clone());
/// // Of a ray that begins 1 m from the light, and so not at the eye of the table.
/// let other = Segment { x: 0.0, s: 0.0, h: 1.0, length: 2.0 };
/// assert_eq!(framed.airlight(0.1, &other), fallback.airlight(0.1, &other));
/// # Ok::<(), airlight::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Framed<E> {
    table: FrameTable,
    fallback: E,
}

impl<E: Evaluator> Framed<E> {
    /// `fallback` must be for the phase function of the table.
    pub fn new(table: FrameTable, fallback: E) -> Self {
        Self { table, fallback }
    }

    /// The table.
    pub fn table(&self) -> &FrameTable {
        &self.table
    }

    /// What is asked where the table does not know.
    pub fn fallback(&self) -> &E {
        &self.fallback
    }
}

impl<E: Evaluator> Evaluator for Framed<E> {
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32 {
        let known = (sigma_t == self.table.sigma_t).then(|| self.table.look_up(segment));
        let known = known.flatten();
        known.unwrap_or_else(|| self.fallback.airlight(sigma_t, segment))
    }
}
