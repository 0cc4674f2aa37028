//! The texts, with what they define.

/// Queries of a shadow volume. Needs the parts
/// [`EPIPOLAR`](epipolar::gpu::EPIPOLAR) and [`PHI`](epipolar::gpu::PHI) in front of it.
///
/// All lengths are in metres. `l` is a [`LatticeRecord`](epipolar::gpu::LatticeRecord),
/// `sampling` a [`SamplingRecord`](super::SamplingRecord), each usually in a uniform.
///
/// ```wgsl
/// struct vsv_LitInterval {
///     start: f32,
///     end: f32,
///     visibility: f32,
/// }
/// fn vsv_cursor(l: epi_Lattice, sampling: vsv_Sampling, direction: vec3<f32>, surface: f32) -> vsv_Cursor
/// fn vsv_next_lit(l: epi_Lattice, sampling: vsv_Sampling, cursor: ptr<function, vsv_Cursor>) -> vsv_LitInterval
/// ```
///
/// A cursor stands at the beginning of the eye ray along `direction`, of any length but 0,
/// up to `surface`, the distance to the first surface; `f32::MAX` for the sky. It hands out
/// the parts of the ray that are lit, from near to far: distances from the eye and the
/// share of the light that is there, above 0 and below 1 only where two texels differ. A
/// visibility of 0 says that there are no more.
///
/// ```wgsl
/// var cursor = vsv_cursor(lattice, sampling, direction, surface);
/// loop {
///     let lit = vsv_next_lit(lattice, sampling, &cursor);
///     if lit.visibility <= 0.0 { break; }
///     sum += lit.visibility * light_between(lit.start, lit.end);
/// }
/// ```
///
/// Ends of intervals lie on the borders of voxels, and are as wrong as these are
/// wide. A ray that is less than `sampling.axis` voxels from the direction to the light is
/// lit throughout or not at all.
///
/// ```wgsl
/// struct vsv_Run {
///     start: f32,
///     end: f32,
///     visibility: f32,
/// }
/// fn vsv_next_voxel(
///     l: epi_Lattice,
///     sampling: vsv_Sampling,
///     cursor: ptr<function, vsv_Cursor>,
///     run: ptr<function, vsv_Run>,
/// ) -> vsv_LitInterval
/// ```
///
/// The same voxel by voxel, for light that changes along an interval. `run` is what is left
/// of the current run: declare it as `var run: vsv_Run;`.
///
/// ```wgsl
/// fn vsv_lit_fraction(l: epi_Lattice, sampling: vsv_Sampling, cursor: ptr<function, vsv_Cursor>) -> f32
/// fn vsv_lit_fraction_between(
///     l: epi_Lattice,
///     sampling: vsv_Sampling,
///     cursor: ptr<function, vsv_Cursor>,
///     start: f32,
///     end: f32,
/// ) -> f32
/// ```
///
/// The share of the voxels up to the surface that are lit, and of those between two
/// distances. Both take a cursor at its beginning.
///
/// ```wgsl
/// fn vsv_visibility(l: epi_Lattice, sampling: vsv_Sampling, point: vec3<f32>) -> f32
/// ```
///
/// The visibility of the light from a point that the eye sees on a surface, from 0 to 1.
/// [`Sampling`](crate::Sampling#surfaces) says what it takes for that to look well.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn vsv_word(index: u32) -> u32
/// fn epi_bound(index: u32) -> vec2<f32>
/// ```
///
/// A word of [`Grid::words`](crate::Grid::words), and an entry of
/// [`Lattice::bounds`](epipolar::Lattice::bounds).
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("shadow.wgsl"), "\n```")]
pub const SHADOW: &str = text(include_str!("shadow.wgsl"));

/// Between the depths of a renderer's own shadow map and distances along light rays, for
/// parts of one's own in the `FirstBlockerSlot`. Needs no other part. For depth textures
/// there is `DepthLayers`.
///
/// ```wgsl
/// fn vsv_depth_place(matrix: mat4x4<f32>, origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32>
/// fn vsv_depth_distance(matrix: mat4x4<f32>, origin: vec3<f32>, direction: vec3<f32>, depth: f32) -> f32
/// ```
///
/// Where a light ray is in the view with this matrix from the world to clip coordinates,
/// from (0, 0) in the upper left corner of the texture to (1, 1), with a third number of 1,
/// or 0 beside the view; and the distance in metres along the ray at which it has a depth,
/// reversed or not. Views are seen from the light, or along a directional one:
/// [`DepthViews`](crate::DepthViews) has the same for the CPU, and the equations.
///
/// The finest cascade that has something on the ray is the right one; of those whose place
/// has a 1, that is the first whose depth is not that of empty texels.
///
/// ```wgsl
/// fn vsv_cube_face(direction: vec3<f32>) -> u32
/// ```
///
/// The layer of a cube map in which a direction from the light is.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("depth.wgsl"), "\n```")]
pub const DEPTH: &str = text(include_str!("depth.wgsl"));

/// The text itself. A call keeps it out of the line in which the documentation shows the
/// constant.
const fn text(source: &'static str) -> &'static str {
    source
}

#[cfg(test)]
mod tests {
    use epipolar::gpu::{EPIPOLAR, PHI};
    use gpu_backend::testing::Shader;

    use super::*;

    #[test]
    fn pages_say_what_the_parts_define() {
        let data = "
            fn epi_bound(index: u32) -> vec2<f32> { return vec2(f32(index)); }
            fn vsv_word(index: u32) -> u32 { return index; }";
        let parts = [EPIPOLAR, PHI, SHADOW, DEPTH, data];
        let named = Shader::documented(&parts, include_str!("parts.rs")).unwrap();
        for name in ["vsv_word", "vsv_next_lit", "vsv_depth_distance"] {
            assert!(named.iter().any(|other| other == name), "{name}");
        }
        let alone = Shader::new(&[DEPTH]).unwrap();
        alone.require_part(&["vsv_"]).unwrap();
    }
}
