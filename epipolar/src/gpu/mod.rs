//! Epipolar space in shaders.
//!
//! [`EPIPOLAR`] is a part for shaders of your own: structures, constants and
//! functions with the prefix `epi_`, no bindings. Its functions take an
//! `epi_Lattice`, a [`LatticeRecord`] in a uniform. [`PHI`] has the voxels along φ
//! and reads their bounds through `epi_bound`, which you define;
//! [`Lattice::bounds`] is what it returns. The page of each has the signatures of its
//! functions and the source.
//!
//! # A whole shader
//!
//! The step [`Locate`](crate::Locate), which finds the positions of many points. After
//! both parts and `gpu_backend::gpu::INDEX_WGSL`:
//!
#![doc = concat!("```wgsl\n", include_str!("locate.wgsl"), "\n```")]
//!
//! # Agreement with the CPU
//!
//! Both have the same formulas and the angle function by the same polynomial. The
//! CPU goes through f64 where digits cancel; a shader takes away what a vector has
//! along the axis in parts whose products are exact in f32, which leaves 2⁻³³ of
//! the larger coordinates. They differ by that and by what WGSL grants division
//! (2.5 ULP) and square roots: positions agree within twice the bound that
//! [`Lattice`] states for each.

#[cfg(feature = "wgpu")]
mod locate;
mod parts;
#[cfg(test)]
#[cfg(feature = "wgpu")]
mod tests;

pub use parts::{EPIPOLAR, PHI};

use glam::{DVec3, Vec2, Vec3};

use crate::Lattice;

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
    slope_high: Vec3,
    alpha: u32,
    slope_low: Vec3,
    theta: u32,
    largest: Vec3,
    bits: u32,
    alpha_start: Vec2,
    theta_centre: Vec2,
    thinnest: f32,
    starts_on_axis: u32,
    padding: [u32; 2],
}

impl LatticeRecord {
    /// The numbers of a lattice.
    pub fn new(lattice: &Lattice) -> Self {
        let space = lattice.space();
        let [axis, right, up] = space.frame().map(Vec3::from);
        let (alpha_start, alpha_scale, theta_centre, theta_scale) = lattice.scales();
        let resolution = lattice.resolution();
        let exact = space.exact_axis();
        let largest = DVec3::AXES[exact.abs().max_position()];
        let slope = exact / exact.dot(largest);
        let upper_bits = |x: f32| f32::from_bits(x.to_bits() & 0xffff_f000);
        let slope_high = slope.as_vec3().map(upper_bits);
        Self {
            eye: space.eye_point(),
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
            light: space.light().at().unwrap_or(Vec3::ZERO),
            wraps: u32::from(lattice.ranges().wraps()),
            slope_high,
            alpha: resolution.alpha(),
            slope_low: (slope - slope_high.as_dvec3()).as_vec3(),
            theta: resolution.theta(),
            largest: largest.as_vec3(),
            bits: resolution.bits(),
            alpha_start: alpha_start.0,
            theta_centre: theta_centre.0,
            thinnest: lattice.thinnest(),
            starts_on_axis: u32::from(lattice.starts_on_axis()),
            padding: [0; 2],
        }
    }
}
