//! How depths become slices.

use crate::{Error, Resolution};

/// How the slices of the grid are spread over depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Slices {
    /// Slices of equal height over the depths 0…1, for lights whose rays are
    /// parallel.
    Linear,
    /// Slices whose height is a constant share of their distance from the
    /// light, for perspective lights: `t = ln(d/near) / ln(far/near)` of the
    /// distance `d` along the axis of the light.
    Logarithmic(Logarithmic),
}

/// The ends of logarithmic slices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logarithmic {
    near: f64,
    far: f64,
    /// ln(far/near).
    stretch: f64,
}

impl Logarithmic {
    /// Where the first slice begins.
    pub fn near(&self) -> f64 {
        self.near
    }

    /// Where the last slice ends.
    pub fn far(&self) -> f64 {
        self.far
    }

    /// `ln(far/near)`.
    pub(crate) fn stretch(&self) -> f64 {
        self.stretch
    }
}

impl Slices {
    /// Logarithmic slices between the distances `near` and `far` along the
    /// axis of the light.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless `0 < near < far < ∞`.
    pub fn logarithmic(near: f64, far: f64) -> Result<Self, Error> {
        if !(near > 0.0 && near < f64::INFINITY) {
            return Err(Error::bad_value(
                "the near distance",
                near,
                "a finite number above 0",
            ));
        }
        if !(far > near && far < f64::INFINITY) {
            return Err(Error::bad_value(
                "the far distance",
                far,
                "a finite number above the near distance",
            ));
        }
        let stretch = (far / near).ln();
        Ok(Self::Logarithmic(Logarithmic { near, far, stretch }))
    }

    /// The position `t` of a depth in the grid, 0 at the near and 1 at the
    /// far plane. Distances of logarithmic slices that are not above 0 give
    /// −∞ or NaN.
    pub fn position(&self, depth: f64) -> f64 {
        match self {
            Self::Linear => depth,
            Self::Logarithmic(Logarithmic { near, stretch, .. }) => (depth / near).ln() / stretch,
        }
    }

    /// The depth at position `t`; undoes [`Slices::position`].
    pub fn depth(&self, position: f64) -> f64 {
        match self {
            Self::Linear => position,
            Self::Logarithmic(Logarithmic { near, stretch, .. }) => {
                near * (position * stretch).exp()
            }
        }
    }

    /// The first slice behind a surface: `⌈N t − ½⌉`, at least 0 and at most
    /// N, so that a voxel is in front of the surface if its centre is. A NaN
    /// counts as 0.
    pub fn boundary(&self, resolution: Resolution, depth: f64) -> u32 {
        // Rounding up by truncation, because not every processor has an
        // instruction for it. `max` takes a NaN to 0.
        let position = f64::from(resolution.side()) * self.position(depth).clamp(0.0, 1.0) - 0.5;
        let whole = position.max(0.0) as u32;
        whole + u32::from(f64::from(whole) < position)
    }

    /// [`Slices::boundary`] of many depths.
    pub(crate) fn boundaries(&self, resolution: Resolution, depths: &[f32], out: &mut [u32]) {
        if *self == Self::Linear {
            // The product with a power of two is exact; so is the difference,
            // or it is negative. Truncating towards zero and adding one where
            // that lost something is the same as rounding up, and vectorises.
            let side = resolution.side() as f32;
            for (out, &depth) in out.iter_mut().zip(depths) {
                let position = (side * depth.clamp(0.0, 1.0) - 0.5).max(0.0);
                let whole = position as i32;
                *out = (whole + i32::from((whole as f32) < position)) as u32;
            }
        } else {
            for (out, &depth) in out.iter_mut().zip(depths) {
                *out = self.boundary(resolution, f64::from(depth));
            }
        }
    }
}
