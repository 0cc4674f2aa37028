//! The eye and the lines of sight that a view-projection matrix describes.

use glam::{DMat4, DVec3, DVec4, Vec3, Vec4};

use super::FogError;
use crate::Interval;
use crate::airlight::far_end;
use crate::scene::Medium;
use crate::voxelized::{Eye, Spacing};

/// An eye as the shader takes it; see `Scene` in `fog.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    pub(super) eye: Vec3,
    /// The third clip coordinate of the eye.
    pub(super) depth: f32,
    pub(super) right: Vec4,
    pub(super) up: Vec4,
    pub(super) forward: Vec4,
}

impl View {
    /// Reads the eye from a matrix M that maps the world to clip coordinates.
    ///
    /// With M⁻¹ e₃ = (a, b), the eye is a / b: its clip coordinates x, y and w are 0, and this
    /// is where all lines of sight meet. With M⁻¹ (x, y, 0, 1) = (q, s), the line of sight
    /// through (x, y) runs along q − s a / b.
    pub(super) fn new(matrix: &[[f32; 4]; 4]) -> Result<Self, FogError> {
        let refused = FogError::NoEye { matrix: *matrix };
        let columns = matrix.map(|column| column.map(f64::from));
        let clip = DMat4::from_cols_array_2d(&columns);
        // In a parallel view w is the same everywhere.
        if clip.row(3).truncate() == DVec3::ZERO {
            return Err(refused);
        }
        let world = clip.inverse();
        let eye = world.z_axis.truncate() / world.z_axis.w;
        let line = |x: f64, y: f64| {
            let q = world * DVec4::new(x, y, 0.0, 1.0);
            q.truncate() - q.w * eye
        };
        let forward = line(0.0, 0.0);
        let with_depth = |v: DVec3| v.extend(clip.row(2).truncate().dot(v)).as_vec4();
        let view = Self {
            eye: eye.as_vec3(),
            depth: clip.row(2).dot(eye.extend(1.0)) as f32,
            right: with_depth(line(1.0, 0.0) - forward),
            up: with_depth(line(0.0, 1.0) - forward),
            forward: with_depth(forward),
        };
        let numbers = [
            view.right,
            view.up,
            view.forward,
            view.eye.extend(view.depth),
        ];
        if numbers.iter().all(|v| v.is_finite()) {
            Ok(view)
        } else {
            Err(refused)
        }
    }

    /// The part of the view that is divided into voxels: the fog as far as it can be seen,
    /// which is ten mean free paths behind the place where a line of sight enters it.
    pub(super) fn volume(&self, medium: &Medium, reach: f32) -> Eye {
        let corner = |x: f32, y: f32| (self.forward + x * self.right + y * self.up).truncate();
        let [start, end] = match medium.bounds() {
            None => [0.0, far_end(medium)],
            Some(bounds) => {
                let nearest = self.eye.clamp(bounds.min(), bounds.max());
                let outside = nearest.cmpne(self.eye);
                let (mut entry, mut farthest) = (0.0_f32, 0.0_f32);
                for corner in bounds.corners() {
                    let distance = corner.distance(self.eye);
                    farthest = farthest.max(distance);
                    // A line of sight enters through one of the faces that the eye sees from
                    // outside.
                    if (corner.cmpeq(nearest) & outside).any() {
                        entry = entry.max(distance);
                    }
                }
                let start = nearest.distance(self.eye);
                [start, farthest.min(entry + far_end(medium))]
            }
        };
        Eye {
            position: self.eye,
            corners: Some([
                corner(-1.0, 1.0).normalize(),
                corner(1.0, 1.0).normalize(),
                corner(1.0, -1.0).normalize(),
                corner(-1.0, -1.0).normalize(),
            ]),
            depths: Interval::new(start, end.min(reach).max(start)),
            lamp_spacing: Spacing::Angle,
            sun_spacing: Spacing::Airlight {
                sigma_t: medium.sigma_t().x,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Mat4;
    use glam::camera::rh::proj::directx::{
        orthographic, perspective, perspective_infinite_reverse,
    };
    use glam::camera::rh::view::look_to_mat4;

    use super::*;
    use crate::scene::{Bounds, PhaseFunction};

    #[test]
    fn depths_lead_back_to_points_whatever_the_projection() {
        let eye = Vec3::new(120.0, -3.0, 45.0);
        let look = look_to_mat4(eye, Vec3::new(0.3, -0.2, 1.0).normalize(), Vec3::Y);
        for projection in [
            perspective(1.1, 1.7, 0.1, 300.0),
            perspective(1.1, 1.7, 300.0, 0.1),
            perspective_infinite_reverse(1.1, 1.7, 0.1),
            // Half of a headset: the middle of the picture is beside the axis.
            perspective_infinite_reverse(1.1, 1.7, 0.1)
                * Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::new(0.2, -0.1, 1.0, 0.0), Vec4::W),
        ] {
            let matrix = projection * look;
            let view = View::new(&matrix.to_cols_array_2d()).unwrap();
            assert!(view.eye.distance(eye) < 1e-3, "{view:?}");
            for (x, y, w) in [(0.0, 0.0, 2.0), (-0.9, 0.4, 7.0), (0.5, -1.0, 60.0)] {
                let v = view.forward + x * view.right + y * view.up;
                let point = view.eye + w * v.truncate();
                let clip = matrix.as_dmat4() * point.as_dvec3().extend(1.0);
                assert!((clip.w as f32 / w - 1.0).abs() < 1e-3, "{clip} {w}");
                assert!((clip.x / clip.w - f64::from(x)).abs() < 1e-3, "{clip}");
                assert!((clip.y / clip.w - f64::from(y)).abs() < 1e-3, "{clip}");
                let found = view.depth / ((clip.z / clip.w) as f32 - v.w);
                // What f32 leaves of a depth next to 1.
                assert!(
                    (found / w - 1.0).abs() < 1e-3 + 1e-6 * w / 0.1,
                    "{found} {w}"
                );
            }
        }
    }

    #[test]
    fn voxels_end_ten_mean_free_paths_behind_the_entry_into_a_box() {
        let fog = Medium::new([0.1; 3], [0.0; 3], PhaseFunction::Isotropic).unwrap();
        let look = look_to_mat4(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y);
        let matrix = perspective_infinite_reverse(1.1, 1.7, 0.1) * look;
        let view = View::new(&matrix.to_cols_array_2d()).unwrap();
        for (min, max, start, end) in [
            // Around the eye, in front of it, and smaller than that.
            ([-1e4; 3], [1e4; 3], 0.0, 100.0),
            ([-3.0, -4.0, -1e4], [3.0, 4.0, -12.0], 12.0, 113.0),
            ([-1.0, -4.0, -8.0], [1.0, 4.0, 0.0], 0.0, 9.0),
            // A layer below, which is seen up to the horizon.
            ([-300.0, -6.0, -300.0], [300.0, -5.0, 300.0], 5.0, 424.306),
        ] {
            let bounds = Bounds::new(Vec3::from(min), Vec3::from(max)).unwrap();
            let depths = view.volume(&fog.within(bounds), f32::INFINITY).depths;
            assert!((depths.start - start).abs() < 1e-3, "{depths:?}");
            assert!((depths.end - end).abs() < 1e-3, "{depths:?}");
        }
    }

    #[test]
    fn a_matrix_without_an_eye_is_refused() {
        let mut endless = Mat4::IDENTITY.to_cols_array_2d();
        endless[1][2] = f32::NAN;
        for matrix in [
            Mat4::IDENTITY.to_cols_array_2d(),
            orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0).to_cols_array_2d(),
            [[0.0; 4]; 4],
            [[1.0; 4]; 4],
            endless,
        ] {
            let error = View::new(&matrix);
            assert!(matches!(error, Err(FogError::NoEye { .. })), "{error:?}");
        }
    }
}
