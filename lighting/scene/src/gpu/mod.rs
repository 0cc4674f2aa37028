//! Media on a GPU: a part for any shader.
//!
//! [`MEDIA`] is WGSL text that holds only functions, structures and constants whose
//! names start with `scn_`; its page has the signatures of the functions with their units, and
//! the source. It reaches the densities through one function, `scn_density`, which the
//! shader around it writes.
//!
//! | function of the part | CPU | what |
//! |---|---|---|
//! | `scn_walk`, `scn_next_cell` | [`DensityGrid::cells_along`] | the cells of a grid on a line |
//! | `scn_cubic`, `scn_mean`, `scn_up_to` | [`MediaPiece`](crate::MediaPiece) | the extinction along a part of a cell, its integral, a part of it |
//! | `scn_grid_depth` | [`Media::optical_depth`](crate::Media::optical_depth) | the optical depth of a grid |
//! | `scn_chord`, `scn_ball_cubic` | the same of particles | where a line is in a ball, and the extinction there |
//! | `scn_height_density`, `scn_height_column`, which [`HEIGHT_FOG`] has alone | [`HeightFog::density`], [`HeightFog::column`] | fog that thins out with altitude |
//!
//! # A whole shader
//!
#![doc = concat!("```wgsl\n", include_str!("example.wgsl"), "\n```")]
//!
//! # Agreement with the CPU
//!
//! The CPU works in f64. A shader computes the point at which a line enters a grid to four
//! roundings of the distances involved, as if the ray were moved aside by `2⁻²² (D + S)`, where
//! D is the distance of the eye from the grid's corner and S the size of the grid. From there
//! on lengths are relative to that point, and every sum has terms that are not negative. So for
//! a line through `n` cells of a grid, the optical depth is that of the moved ray to a relative
//! `(n + 20) 2⁻²³`. Columns of height fog are as exact as WGSL's `exp`: `3 + 2 |(y − y₀)/H|`
//! units of the last digit.

mod part;

pub use part::{HEIGHT_FOG, MEDIA};

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use airlight::gpu::PhaseRecord;

use crate::{DensityGrid, HeightFog, Interpolation};

/// A density grid as `scn_Grid`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GridRecord {
    row_x: Vec3,
    first: u32,
    row_y: Vec3,
    is_linear: u32,
    row_z: Vec3,
    scale: f32,
    corner: Vec3,
    phase: u32,
    resolution: [u32; 3],
    padding_a: u32,
    tint: Vec3,
    padding_b: u32,
    albedo: Vec3,
    padding_c: u32,
    phase_parameters: [f32; 4],
}

impl GridRecord {
    /// The grid whose first density has the index `first` in `scn_density`. The albedo is that
    /// of the whole grid; albedos of samples and emission are left to the shader.
    pub fn new(grid: &DensityGrid, first: u32) -> Self {
        let (corner, matrix) = grid.cell_space();
        let phase = PhaseRecord::from(grid.phase());
        Self {
            row_x: matrix.row(0).as_vec3(),
            first,
            row_y: matrix.row(1).as_vec3(),
            is_linear: u32::from(grid.interpolation() == Interpolation::Linear),
            row_z: matrix.row(2).as_vec3(),
            scale: grid.scale(),
            corner: corner.as_vec3(),
            phase: phase.kind,
            resolution: grid.resolution(),
            padding_a: 0,
            tint: grid.tint(),
            padding_b: 0,
            albedo: grid.albedo(),
            padding_c: 0,
            phase_parameters: phase.parameters,
        }
    }
}

/// Fog that thins out with altitude as `scn_HeightFog`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct HeightFogRecord {
    sigma_s: Vec3,
    altitude: f32,
    sigma_t: Vec3,
    scale_height: f32,
    phase_parameters: [f32; 4],
    phase: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

impl From<&HeightFog> for HeightFogRecord {
    fn from(fog: &HeightFog) -> Self {
        let phase = PhaseRecord::from(fog.phase());
        Self {
            sigma_s: fog.sigma_s(),
            altitude: fog.altitude(),
            sigma_t: fog.sigma_t(),
            scale_height: fog.scale_height(),
            phase_parameters: phase.parameters,
            phase: phase.kind,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use gpu_backend::assert_same_layout;
    use gpu_backend::testing::Shader;

    use super::*;

    #[test]
    fn the_part_is_fit_for_other_shaders_and_its_records_are_those_of_rust() {
        let data = "fn scn_density(index: u32) -> f32 { return f32(index); }";
        let shader = Shader::new(&[MEDIA, data]).unwrap();
        shader.require_part(&["scn_"]).unwrap();
        assert_same_layout!(
            shader,
            "scn_Grid",
            GridRecord {
                row_x,
                first,
                row_y,
                is_linear,
                row_z,
                scale,
                corner,
                phase,
                resolution,
                padding_a,
                tint,
                padding_b,
                albedo,
                padding_c,
                phase_parameters
            }
        );
        assert_same_layout!(
            shader,
            "scn_HeightFog",
            HeightFogRecord {
                sigma_s,
                altitude,
                sigma_t,
                scale_height,
                phase_parameters,
                phase,
                padding_a,
                padding_b,
                padding_c
            }
        );
        assert_eq!(shader.values("scn_FAR").unwrap(), [f64::from(f32::MAX)]);
    }
}
