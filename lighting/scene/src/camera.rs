//! A pinhole camera.

use glam::{Quat, Vec3};

use super::{SceneError, is_near};

/// A pinhole camera that looks along its local −Z with +Y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: Vec3,
    rotation: Quat,
    vertical_fov: f32,
}

impl Camera {
    /// A camera at `eye`, turned by `rotation`, with the full vertical field of
    /// view `vertical_fov` in radians.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the eye is not within 1e9 m, the rotation is not finite, the
    /// rotation is 0, or the field of view is not inside (0, 3.1).
    pub fn new(
        eye: impl Into<[f32; 3]>,
        rotation: Quat,
        vertical_fov: f32,
    ) -> Result<Self, SceneError> {
        let eye = Vec3::from_array(eye.into());
        if !is_near(eye) {
            return Err(SceneError::bad_value(
                "camera",
                "position",
                eye,
                "coordinates within 1e9 m",
            ));
        }
        let length = rotation.length();
        if !(length.is_finite() && length > 0.0) {
            return Err(SceneError::bad_value(
                "camera",
                "rotation",
                rotation,
                "a finite quaternion other than 0",
            ));
        }
        // At π the image plane is infinitely large; stop visibly before it.
        if !(vertical_fov > 0.0 && vertical_fov < 3.1) {
            return Err(SceneError::bad_value(
                "camera",
                "vertical field of view",
                vertical_fov,
                "an angle between 0 and 3.1 radians, both excluded",
            ));
        }
        Ok(Self {
            eye,
            rotation: rotation.normalize(),
            vertical_fov,
        })
    }

    /// A camera at `eye` that has `target` in the middle of its picture.
    ///
    /// # Errors
    /// As [`Camera::new`]; [`SceneError::BadValue`] too if `eye` is `target`.
    pub fn look_at(
        eye: impl Into<[f32; 3]>,
        target: impl Into<[f32; 3]>,
        vertical_fov: f32,
    ) -> Result<Self, SceneError> {
        let [eye, target] = [eye.into(), target.into()].map(Vec3::from_array);
        let Some(forward) = (target - eye).try_normalize() else {
            return Err(SceneError::bad_value(
                "camera",
                "target",
                target,
                "a point other than the eye",
            ));
        };
        let up = if forward.y.abs() < 0.999 {
            Vec3::Y
        } else {
            Vec3::Z
        };
        let right = forward.cross(up).normalize();
        let rotation = Quat::from_mat3(&glam::Mat3::from_cols(
            right,
            right.cross(forward),
            -forward,
        ));
        Self::new(eye, rotation, vertical_fov)
    }

    /// The position of the camera.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// From camera space to world space.
    pub fn rotation(&self) -> Quat {
        self.rotation
    }

    /// Full vertical field of view, radians.
    pub fn vertical_fov(&self) -> f32 {
        self.vertical_fov
    }

    /// The unit direction through the point (`x`, `y`) of a picture of `width`
    /// × `height` pixels; (0, 0) is its upper left corner, pixel centres lie
    /// at + ½. Pixels are square.
    pub fn direction(&self, x: f32, y: f32, width: u32, height: u32) -> Vec3 {
        let half = (0.5 * self.vertical_fov).tan();
        let (w, h) = (width as f32, height as f32);
        let local = Vec3::new((2.0 * x - w) / h * half, (h - 2.0 * y) / h * half, -1.0);
        (self.rotation * local).normalize()
    }

    /// The directions through the corners of a picture of `width` × `height`
    /// pixels, in order around it.
    pub fn corners(&self, width: u32, height: u32) -> [Vec3; 4] {
        let (w, h) = (width as f32, height as f32);
        [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)].map(|(x, y)| self.direction(x, y, width, height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_target_is_in_the_middle_and_up_is_up() {
        for target in [Vec3::new(3.0, 1.0, -2.0), Vec3::Y * 9.0, Vec3::Z] {
            let eye = Vec3::new(0.0, 0.5, 0.0);
            let camera = Camera::look_at(eye, target, 1.0).unwrap();
            let middle = camera.direction(8.0, 4.5, 16, 9);
            assert!((middle - (target - eye).normalize()).length() < 1e-6);
            if target.x != 0.0 {
                assert!(camera.direction(8.0, 0.0, 16, 9).y > middle.y);
                assert!(camera.direction(8.0, 9.0, 16, 9).y < middle.y);
            }
        }
    }

    #[test]
    fn the_field_of_view_spans_the_height() {
        let camera = Camera::new(Vec3::ZERO, Quat::IDENTITY, 1.2).unwrap();
        let top = camera.direction(5.0, 0.0, 10, 10);
        let bottom = camera.direction(5.0, 10.0, 10, 10);
        assert!((top.angle_between(bottom) - 1.2).abs() < 1e-5);
    }

    #[test]
    fn bad_cameras_are_refused() {
        assert!(Camera::new(Vec3::NAN, Quat::IDENTITY, 1.0).is_err());
        assert!(Camera::new(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), 1.0).is_err());
        for fov in [0.0, -1.0, 3.15, f32::NAN] {
            assert!(Camera::new(Vec3::ZERO, Quat::IDENTITY, fov).is_err());
        }
        assert!(Camera::look_at(Vec3::ONE, Vec3::ONE, 1.0).is_err());
    }
}
