//! The lights that have an epipolar space.

use glam::{DVec3, Vec3};

use crate::Error;
use crate::error::{direction, position};

/// Where light comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light(pub(crate) Kind);

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Point(Vec3),
    /// Unit direction of travel.
    Directional(DVec3),
    Spot {
        position: Vec3,
        /// Unit direction of the axis.
        axis: DVec3,
        /// Half of the opening angle, radians.
        outer: f64,
    },
}

impl Light {
    /// A light at `position` that shines everywhere.
    ///
    /// # Errors
    /// [`Error::BadVector`] unless all coordinates are finite and at most 1e18 m.
    pub fn point(at: impl Into<[f32; 3]>) -> Result<Self, Error> {
        Ok(Self(Kind::Point(position(
            "the position of a light",
            at.into(),
        )?)))
    }

    /// Parallel light that travels along `direction`, of any length.
    ///
    /// # Errors
    /// [`Error::BadVector`] if it is 0 or not finite.
    pub fn directional(along: impl Into<[f32; 3]>) -> Result<Self, Error> {
        let along = direction("the direction of a directional light", along.into())?;
        Ok(Self(Kind::Directional(along)))
    }

    /// A light at `position` that shines into the cone of half-angle `outer`
    /// (radians) around `direction`. The cone only narrows the [`Ranges`] of
    /// what has to be computed.
    ///
    /// [`Ranges`]: crate::Ranges
    ///
    /// # Errors
    /// [`Error::BadVector`] as for the other two, [`Error::BadValue`] unless
    /// 0 < outer ≤ π.
    pub fn spot(
        at: impl Into<[f32; 3]>,
        along: impl Into<[f32; 3]>,
        outer: f32,
    ) -> Result<Self, Error> {
        let outer = f64::from(outer);
        if !(outer > 0.0 && outer <= f64::from(std::f32::consts::PI)) {
            return Err(Error::bad_value(
                "the half-angle of a spotlight",
                outer,
                "more than 0 and at most pi",
            ));
        }
        Ok(Self(Kind::Spot {
            position: position("the position of a light", at.into())?,
            axis: direction("the direction of a spotlight", along.into())?,
            outer,
        }))
    }

    /// Where it is; `None` for a directional light.
    pub fn position(&self) -> Option<[f32; 3]> {
        self.at().map(Vec3::into)
    }

    pub(crate) fn at(&self) -> Option<Vec3> {
        match self.0 {
            Kind::Point(position) | Kind::Spot { position, .. } => Some(position),
            Kind::Directional(_) => None,
        }
    }
}
