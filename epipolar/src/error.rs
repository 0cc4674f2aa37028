//! What constructors turn away.

use glam::Vec3;

use crate::limits::{FARTHEST, SMALLEST_DISTANCE};

/// Why there is no epipolar space, or no voxels in it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number outside of its range.
    #[error("{what} is {value}, expected {expected}")]
    BadValue {
        /// Which number.
        what: &'static str,
        /// As it was given.
        value: f64,
        /// What would have been right.
        expected: &'static str,
    },
    /// A position or direction that cannot be used.
    #[error("{what} is {value:?}, expected {expected}")]
    BadVector {
        /// Which one.
        what: &'static str,
        /// As it was given.
        value: [f32; 3],
        /// What would have been right.
        expected: &'static str,
    },
    /// Eye and light coincide, so there is no axis. A ray from there sees
    /// its own light as far as its first surface: no shadow is visible, and
    /// none has to be computed.
    #[error(
        "eye and light are {distance} m apart, expected at least {} m",
        SMALLEST_DISTANCE
    )]
    EyeAtLight {
        /// Their distance.
        distance: f64,
    },
    /// The cone of the spotlight does not meet what the view sees: nothing
    /// visible is lit, and nothing has to be computed.
    #[error("no point of the view is inside the cone of the spotlight")]
    Unlit,
}

impl Error {
    pub(crate) fn bad_value(
        what: &'static str,
        value: impl Into<f64>,
        expected: &'static str,
    ) -> Self {
        Self::BadValue {
            what,
            value: value.into(),
            expected,
        }
    }
}

/// `vector`, if its components are finite and within [`FARTHEST`].
pub(crate) fn position(what: &'static str, vector: [f32; 3]) -> Result<Vec3, Error> {
    let value = vector;
    let vector = Vec3::from(value);
    if vector.abs().max_element() <= FARTHEST && !vector.is_nan() {
        return Ok(vector);
    }
    Err(Error::BadVector {
        what,
        value,
        expected: "finite coordinates of at most 1e18 m",
    })
}

/// The direction of `vector` in f64.
pub(crate) fn direction(what: &'static str, value: [f32; 3]) -> Result<glam::DVec3, Error> {
    let vector = Vec3::from(value);
    vector
        .as_dvec3()
        .try_normalize()
        .filter(|_| vector.is_finite())
        .ok_or(Error::BadVector {
            what,
            value,
            expected: "a finite vector other than 0",
        })
}
