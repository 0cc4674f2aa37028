//! From the world to the grid of a light.

use glam::{DMat4, DVec3, DVec4, Vec3};

use crate::{Error, Resolution, Slices};

/// Where in the grid of a light a point of the world is.
///
/// The matrix takes a point `(p, 1)` to `(X, Y, D, W)`: the texel is at
/// `(X/W, Y/W)`, 0…1 over the map with row 0 on top. With linear slices `W` is
/// 1 everywhere and `D` the depth 0…1; with logarithmic slices `W` is the
/// distance along the axis of the light, and the depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSpace {
    matrix: DMat4,
    slices: Slices,
}

impl LightSpace {
    /// The space with this matrix. For linear slices the last row must be
    /// `(0, 0, 0, 1)`; for logarithmic slices the third row is not used.
    ///
    /// # Errors
    /// [`Error::BadValue`] if the matrix is not finite, does not keep three
    /// dimensions apart, or has another last row under linear slices.
    pub fn new(matrix: DMat4, slices: Slices) -> Result<Self, Error> {
        let endless = |x: &f64| !x.is_finite();
        if let Some(element) = matrix.to_cols_array().into_iter().find(endless) {
            let what = "an element of the matrix";
            return Err(Error::bad_value(what, element, "a finite number"));
        }
        let space = Self { matrix, slices };
        let depth = match slices {
            Slices::Linear => {
                let row = matrix.row(3).to_array().into_iter();
                let mut elements = row.zip(DVec4::W.to_array());
                if let Some((element, _)) = elements.find(|(element, right)| element != right) {
                    return Err(Error::bad_value(
                        "an element of the fourth row of the matrix",
                        element,
                        "the row (0, 0, 0, 1), because slices are linear",
                    ));
                }
                matrix.row(2)
            }
            Slices::Logarithmic(_) => matrix.row(3),
        };
        // The three rows that are used, scaled so that units do not matter.
        let rows =
            [matrix.row(0), matrix.row(1), depth].map(|row| row.truncate().normalize_or_zero());
        let volume = rows[0].cross(rows[1]).dot(rows[2]).abs();
        if !(volume > 0.0) {
            return Err(Error::bad_value(
                "the volume that the axes of the matrix span",
                volume,
                "above 0",
            ));
        }
        Ok(space)
    }

    /// Parallel light along the local −Z of `view`, a matrix from the world
    /// to the light that keeps lengths. The map spans `width × height` around
    /// the axis, the slices `near` to `far` along it, in metres.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless all lengths are finite, `width` and `height`
    /// above 0 and `far > near`.
    pub fn orthographic(
        view: DMat4,
        width: f64,
        height: f64,
        near: f64,
        far: f64,
    ) -> Result<Self, Error> {
        for (what, value) in [
            ("the width", width),
            ("the height", height),
            ("far − near", far - near),
        ] {
            if !(value > 0.0 && value < f64::INFINITY) {
                return Err(Error::bad_value(what, value, "a finite length above 0"));
            }
        }
        let to_map = DMat4::from_cols(
            DVec4::new(1.0 / width, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -1.0 / height, 0.0, 0.0),
            DVec4::new(0.0, 0.0, -1.0 / (far - near), 0.0),
            DVec4::new(0.5, 0.5, -near / (far - near), 1.0),
        );
        Self::new(to_map * view, Slices::Linear)
    }

    /// A light at the origin of `view` that shines along the local −Z into a
    /// square pyramid of full angle `angle`, in radians, with logarithmic
    /// slices between the distances `near` and `far` along the axis.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless `0 < angle < π` and `0 < near < far < ∞`.
    pub fn perspective(view: DMat4, angle: f64, near: f64, far: f64) -> Result<Self, Error> {
        if !(angle > 0.0 && angle < std::f64::consts::PI) {
            return Err(Error::bad_value("the angle", angle, "0 < angle < π"));
        }
        let reach = 0.5 / (0.5 * angle).tan();
        let to_map = DMat4::from_cols(
            DVec4::new(reach, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -reach, 0.0, 0.0),
            DVec4::new(-0.5, -0.5, 0.0, -1.0),
            DVec4::ZERO,
        );
        Self::new(to_map * view, Slices::logarithmic(near, far)?)
    }

    /// Voxels themselves: the space in which coordinates count voxels of a
    /// grid of `resolution`.
    pub fn of_voxels(resolution: Resolution) -> Self {
        let scale = 1.0 / f64::from(resolution.side());
        Self {
            matrix: DMat4::from_scale(DVec3::splat(scale)),
            slices: Slices::Linear,
        }
    }

    /// From the world to `(X, Y, D, W)`.
    pub fn matrix(&self) -> &DMat4 {
        &self.matrix
    }

    /// How slices are spread over depth.
    pub fn slices(&self) -> &Slices {
        &self.slices
    }

    /// Homogeneous coordinates `(X, Y, depth, W)` of a point or direction.
    pub(crate) fn homogeneous(&self, point: DVec4) -> DVec4 {
        let h = self.matrix * point;
        match self.slices {
            Slices::Linear => h,
            Slices::Logarithmic(_) => DVec4::new(h.x, h.y, h.w, h.w),
        }
    }

    /// The position of a point in the grid, in voxels: the whole part is the
    /// voxel. None if the light cannot see the point at any depth: behind a
    /// perspective light, or not finite.
    pub fn voxel(&self, resolution: Resolution, point: impl Into<[f32; 3]>) -> Option<DVec3> {
        let point = Vec3::from_array(point.into());
        let h = self.homogeneous(point.as_dvec3().extend(1.0));
        let perspective = self.slices != Slices::Linear;
        if perspective && !(h.w > 0.0) {
            return None;
        }
        let position = DVec3::new(h.x / h.w, h.y / h.w, self.slices.position(h.z));
        let voxel = position * f64::from(resolution.side());
        voxel.is_finite().then_some(voxel)
    }

    /// The direction in the grid of a surface normal at `point`, of length 1;
    /// zero where there is none.
    ///
    /// A normal stands for the plane it is perpendicular to, so it moves with
    /// the inverse transpose of the derivative of [`LightSpace::voxel`]: that
    /// keeps it perpendicular to the surface in the grid whatever the shape of
    /// a voxel.
    pub fn normal(&self, point: impl Into<[f32; 3]>, normal: impl Into<[f32; 3]>) -> Vec3 {
        let point = Vec3::from_array(point.into());
        let normal = Vec3::from_array(normal.into());
        let h = self.homogeneous(point.as_dvec3().extend(1.0));
        // Rows of the derivative of (X/W, Y/W, t); for t only a factor.
        let row = |i: usize| self.matrix.row(i).truncate();
        let (rows, w) = match self.slices {
            Slices::Linear => ([row(0), row(1), row(2)], 1.0),
            Slices::Logarithmic(ends) => {
                let w = row(3);
                let scale = 1.0 / ends.stretch();
                (
                    [
                        row(0) - w * (h.x / h.w),
                        row(1) - w * (h.y / h.w),
                        w * scale,
                    ],
                    h.w,
                )
            }
        };
        if !(w > 0.0) {
            return Vec3::ZERO;
        }
        // The inverse transpose of a matrix with these rows has their cross
        // products as rows, up to a factor of its determinant.
        let determinant = rows[0].cross(rows[1]).dot(rows[2]);
        let n = normal.as_dvec3() * determinant.signum();
        DVec3::new(
            rows[1].cross(rows[2]).dot(n),
            rows[2].cross(rows[0]).dot(n),
            rows[0].cross(rows[1]).dot(n),
        )
        .normalize_or_zero()
        .as_vec3()
    }
}
