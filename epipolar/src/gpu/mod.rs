//! Epipolar space in shaders.
//!
//! [`EPIPOLAR`] is a part for shaders of your own: structures, constants and
//! functions with the prefix `epi_`, no bindings. Its functions take an
//! `epi_Lattice`, a [`LatticeRecord`] in a uniform. [`PHI`] has the voxels along φ
//! and reads their bounds through `epi_bound`, which you define;
//! [`Lattice::bounds`] is what it returns.
//!
//! # Agreement with the CPU
//!
//! Both compute the same formulas in f32, the angle function by the same
//! polynomial. They differ where a shader fuses multiplications and by what WGSL
//! grants division (2.5 ULP) and square roots: positions agree within twice
//! the bound that [`Lattice`] states for each.

use glam::{Vec2, Vec3};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Buffer, Error};

use crate::locate::check_lengths;
use crate::{Lattice, Locate};

/// WGSL of the coordinates, and of their voxels along α and θ.
pub const EPIPOLAR: &str = include_str!("epipolar.wgsl");

/// WGSL of the voxels along φ.
pub const PHI: &str = include_str!("phi.wgsl");

/// A [`Lattice`] as shaders see it: `epi_Lattice`, but for the bounds of the
/// voxels along φ.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct LatticeRecord {
    eye: Vec3,
    distance: f32,
    axis: Vec3,
    directional: u32,
    right: Vec3,
    alpha_scale: f32,
    up: Vec3,
    theta_scale: f32,
    light: Vec3,
    wraps: u32,
    alpha_start: Vec2,
    theta_centre: Vec2,
    alpha: u32,
    theta: u32,
    bits: u32,
    starts_on_axis: u32,
}

impl LatticeRecord {
    /// The numbers of a lattice.
    pub fn new(lattice: &Lattice) -> Self {
        let space = lattice.space();
        let [axis, right, up] = space.frame();
        let (alpha_start, alpha_scale, theta_centre, theta_scale) = lattice.scales();
        let resolution = lattice.resolution();
        Self {
            eye: space.eye(),
            distance: if space.is_directional() {
                0.0
            } else {
                space.distance()
            },
            axis,
            directional: u32::from(space.is_directional()),
            right,
            alpha_scale,
            up,
            theta_scale,
            light: space.light().position().unwrap_or(Vec3::ZERO),
            wraps: u32::from(lattice.ranges().wraps()),
            alpha_start: alpha_start.vector(),
            theta_centre: theta_centre.vector(),
            alpha: resolution.alpha(),
            theta: resolution.theta(),
            bits: resolution.bits(),
            starts_on_axis: u32::from(lattice.starts_on_axis()),
        }
    }
}

/// Uniforms of `locate.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Parameters {
    lattice: LatticeRecord,
    count: u32,
    padding: [u32; 3],
}

const LOCATE: &[&str] = &[INDEX_WGSL, EPIPOLAR, PHI, include_str!("locate.wgsl")];

/// Invocations per workgroup in `locate.wgsl`.
const GROUP: u32 = 64;

impl<E: Encode> Locate for Gpu<E> {
    fn locate(
        &self,
        lattice: &Lattice,
        points: &GpuBuffer<[f32; 4]>,
        positions: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(points.len(), positions.len())?;
        let parameters = Parameters {
            lattice: LatticeRecord::new(lattice),
            // More are refused by the dispatch.
            count: points.len() as u32,
            padding: [0; 3],
        };
        self.dispatch(
            &Kernel {
                label: "locate",
                parts: LOCATE,
                entry: "locate",
                constants: &[],
            },
            &[&[
                Argument::uniform(parameters),
                Argument::table(lattice.bounds()),
                Argument::read(points),
                Argument::write(positions),
            ]],
            Workgroups::covering(points.len(), GROUP),
        )
    }
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::{self, Shader};
    use gpu_backend::{Backend, Cpu, Download, assert_same_layout};
    use reference::random::noise;
    use reference::tolerances::Allowed;

    use super::*;
    use crate::numeric::{ATAN, TAN_EIGHTH};
    use crate::{Light, Resolution, Space, Spacing, View};

    /// Stands for the bindings.
    const CONTRACT: &str = "fn epi_bound(index: u32) -> vec2<f32> { return vec2(f32(index)); }";

    #[test]
    fn the_part_is_fit_for_other_shaders_and_has_the_constants_of_rust() {
        Shader::new(&[EPIPOLAR])
            .and_then(|alone| alone.require_part(&["epi_"]))
            .unwrap();
        let shader = Shader::new(&[EPIPOLAR, PHI, CONTRACT]).unwrap();
        shader.require_part(&["epi_"]).unwrap();
        let value = |name: &str| shader.values(name).unwrap();
        let wide = |v: f32| f64::from(v);
        assert_eq!(value("epi_ATAN"), ATAN.map(wide));
        assert_eq!(value("epi_TAN_EIGHTH"), [wide(TAN_EIGHTH)]);
        assert_eq!(value("epi_INFINITE"), [wide(f32::MAX)]);
        assert_eq!(value("epi_PI"), [wide(std::f32::consts::PI)]);
        assert_eq!(value("epi_FARTHEST"), [wide(crate::FARTHEST)]);
        assert_same_layout!(
            shader,
            "epi_Lattice",
            LatticeRecord {
                eye,
                distance,
                axis,
                directional,
                right,
                alpha_scale,
                up,
                theta_scale,
                light,
                wraps,
                alpha_start,
                theta_centre,
                alpha,
                theta,
                bits,
                starts_on_axis,
            }
        );
        let step = Shader::new(LOCATE).unwrap();
        assert_same_layout!(step, "Parameters", Parameters { lattice, count });
    }

    #[test]
    fn positions_agree_with_the_cpu() {
        let Some(gpu) = testing::gpu() else { return };
        let [angle, rounding] =
            [Allowed::GpuAngle, Allowed::GpuPosition].map(|allowed| allowed.error() as f32);
        let eye = Vec3::new(0.2, 1.7, 0.4);
        let camera = View::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.45], 0.0, 30.0).unwrap();
        let around = View::all_around(0.0, 30.0).unwrap();
        // Points on all orders of magnitude of distance from eye and light.
        let points: Vec<[f32; 4]> = (0..20_000_u32)
            .map(|i| {
                let random = |k: u32| noise(u64::from(i * 4 + k));
                let v = Vec3::new(random(0), random(1), random(2)) - 0.5;
                (eye + v * (12.0 * random(3) - 7.0).exp2())
                    .extend(0.0)
                    .into()
            })
            .collect();
        for light in [
            Light::point(Vec3::new(1.0, 2.0, -5.0)).unwrap(),
            Light::point(Vec3::new(9.0, 4.0, -2.0)).unwrap(),
            Light::directional(Vec3::new(0.1, -1.0, 0.3)).unwrap(),
        ] {
            for view in [&camera, &around] {
                let space = Space::new(light, eye).unwrap();
                let resolution = Resolution::new(256, 256, 128).unwrap();
                let lattice = Lattice::new(space, view, resolution, Spacing::Angle).unwrap();
                let mut expected = vec![[0.0; 4]; points.len()];
                Cpu::new().locate(&lattice, &points, &mut expected).unwrap();
                let there = gpu.upload(&points).unwrap();
                let mut found = gpu.zeros(points.len()).unwrap();
                gpu.locate(&lattice, &there, &mut found).unwrap();
                let found = gpu.download(&found).unwrap();
                let ranges = lattice.ranges();
                let alpha_width = (ranges.alpha()[1] - ranges.alpha()[0]) as f32 / 256.0;
                let theta_width = ranges.theta_extent() as f32 / 256.0;
                for ((e, f), point) in expected.iter().zip(&found).zip(&points) {
                    let place = space.coordinates(Vec3::new(point[0], point[1], point[2]));
                    let error = |k: usize| (e[k] - f[k]).abs();
                    assert!(error(0) <= angle / alpha_width + rounding);
                    // At ±π the same plane has two positions.
                    let apart = error(1).min((error(1) - 256.0).abs());
                    let sine = place.ray.alpha.unit().y;
                    assert!(apart <= angle / theta_width / sine + rounding);
                    let bit = (e[2] as usize).min(127);
                    let width = lattice.bounds()[bit].perp_dot(lattice.bounds()[bit + 1]);
                    let size = if space.is_directional() { 30.0 } else { 1.0 };
                    assert!(error(2) <= angle * size / width + rounding, "{e:?} {f:?}");
                }
                let mut short = gpu.zeros(3).unwrap();
                assert!(gpu.locate(&lattice, &there, &mut short).is_err());
            }
        }
    }
}
