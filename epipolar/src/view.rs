//! What a camera can see.

use glam::DVec3;

use crate::Error;
use crate::cone::Cone;
use crate::error::direction;
use crate::limits::FARTHEST;

/// The directions and distances that a picture shows: a pyramid with the eye
/// at its top, or all directions, between two distances from the eye.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewVolume {
    /// `None` looks everywhere.
    pub(crate) pyramid: Option<Cone>,
    pub(crate) near: f64,
    pub(crate) far: f64,
}

impl ViewVolume {
    /// The pyramid whose edges point along `corners`, in order around it, at
    /// distances (along the rays, not along the view axis) `near` to `far` from the
    /// eye. An infinite `far` is legal for lights that are not directional.
    ///
    /// # Errors
    /// [`Error::BadVector`] for a corner that is 0, not finite, or not on the
    /// convex side of its neighbours (the pyramid must be narrower than a
    /// half-space), [`Error::BadValue`] unless 0 ≤ near < far, near ≤ 1e18.
    pub fn new(corners: [impl Into<[f32; 3]>; 4], near: f32, far: f32) -> Result<Self, Error> {
        let mut directions = [DVec3::ZERO; 4];
        for (out, corner) in directions.iter_mut().zip(corners) {
            *out = direction("a corner of a view", corner.into())?;
        }
        Self::of_pyramid(directions, near, far)
    }

    fn of_pyramid(corners: [DVec3; 4], near: f32, far: f32) -> Result<Self, Error> {
        let pyramid = Cone::new(corners.to_vec());
        if let Some(index) = pyramid.concave_corner() {
            return Err(Error::BadVector {
                what: "a corner of a view",
                value: corners[index].as_vec3().into(),
                expected: "four edges of a convex pyramid, in order around it",
            });
        }
        Self::with_bounds(Some(pyramid), near, far)
    }

    /// The symmetric pyramid of a camera that looks along `forward`;
    /// `tan_half_width` and `tan_half_height` are the tangents of half its opening
    /// angles. `up` need not be orthogonal to `forward`.
    ///
    /// # Errors
    /// Those of [`ViewVolume::new`]; [`Error::BadVector`] if `up` is parallel to
    /// `forward`, [`Error::BadValue`] for a tangent that is not positive and
    /// finite.
    pub fn perspective(
        forward: impl Into<[f32; 3]>,
        up: impl Into<[f32; 3]>,
        [tan_half_width, tan_half_height]: [f32; 2],
        near: f32,
        far: f32,
    ) -> Result<Self, Error> {
        for (what, tan) in [
            ("the tangent of half the width of a view", tan_half_width),
            ("the tangent of half the height of a view", tan_half_height),
        ] {
            if !(tan > 0.0 && tan.is_finite()) {
                return Err(Error::bad_value(what, tan, "a positive finite number"));
            }
        }
        let up = up.into();
        let forward = direction("the direction of a view", forward.into())?;
        let right = forward
            .cross(direction("the upward direction of a view", up)?)
            .try_normalize()
            .ok_or(Error::BadVector {
                what: "the upward direction of a view",
                value: up,
                expected: "a vector that is not parallel to the view",
            })?;
        let up = right.cross(forward);
        let corner = |x: f64, y: f64| {
            let (w, h) = (f64::from(tan_half_width), f64::from(tan_half_height));
            (forward + x * w * right + y * h * up).normalize()
        };
        let corners = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        Self::of_pyramid(corners, near, far)
    }

    /// All directions.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless 0 ≤ near < far, near ≤ 1e18.
    pub fn all_around(near: f32, far: f32) -> Result<Self, Error> {
        Self::with_bounds(None, near, far)
    }

    fn with_bounds(pyramid: Option<Cone>, near: f32, far: f32) -> Result<Self, Error> {
        if !(0.0..=FARTHEST).contains(&near) {
            return Err(Error::bad_value(
                "the near bound of a view",
                near,
                "at least 0 and at most 1e18",
            ));
        }
        if !(far > near) {
            return Err(Error::bad_value(
                "the far bound of a view",
                far,
                "more than the near bound",
            ));
        }
        let far = if far <= FARTHEST {
            f64::from(far)
        } else {
            f64::INFINITY
        };
        Ok(Self {
            pyramid,
            near: f64::from(near),
            far,
        })
    }
}
