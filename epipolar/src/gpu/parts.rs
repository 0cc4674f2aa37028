//! The texts, with what they define.

/// Epipolar coordinates, and their voxels along α and θ. Needs no other part.
///
/// All lengths are in metres. A lattice is an `epi_Lattice`, which is a
/// [`LatticeRecord`](super::LatticeRecord) in a uniform. α and θ of an eye ray travel as
/// vectors, so that rays next to the axis keep their digits:
///
/// ```wgsl
/// struct epi_Ray {
///     alpha: vec2<f32>,
///     theta: vec2<f32>,
/// }
/// fn epi_ray(l: epi_Lattice, direction: vec3<f32>) -> epi_Ray
/// fn epi_ray_to(l: epi_Lattice, point: vec3<f32>) -> epi_Ray
/// ```
///
/// The ray from the eye along a direction of any length but 0, and the one to a point.
/// `alpha` is a unit vector, `theta` a vector of any length.
///
/// ```wgsl
/// fn epi_alpha_position(l: epi_Lattice, alpha: vec2<f32>) -> f32
/// fn epi_theta_position(l: epi_Lattice, theta: vec2<f32>) -> f32
/// ```
///
/// Positions in voxels: the whole part is the voxel if it is from 0 to their number.
/// Angles are within 8e-7 of the CPU's, 4e-7 relative to the truth.
///
/// ```wgsl
/// fn epi_phi(l: epi_Lattice, ray: epi_Ray, point: vec3<f32>) -> vec2<f32>
/// fn epi_phi_along(l: epi_Lattice, ray: epi_Ray, distance: f32) -> vec2<f32>
/// fn epi_distance_along(l: epi_Lattice, ray: epi_Ray, phi: vec2<f32>) -> f32
/// ```
///
/// φ of a point on a ray; φ at a distance from the eye along a ray; and the distance at
/// which a ray has reached a φ, `epi_INFINITE` if it never does. φ is a pair whose quotient
/// is what counts. Distances above `epi_FARTHEST` are infinite.
///
/// ```wgsl
/// struct epi_LightRay {
///     origin: vec3<f32>,
///     direction: vec3<f32>,
/// }
/// fn epi_light_ray(l: epi_Lattice, plane: vec2<f32>, phi: vec2<f32>) -> epi_LightRay
/// ```
///
/// The light ray of a plane, an entry of [`Lattice::planes`](crate::Lattice::planes), and an
/// angle at the light, one of [`Lattice::light_angles`](crate::Lattice::light_angles). The
/// direction is a unit vector. The rays of a directional light begin level with the eye.
///
/// ```wgsl
/// fn epi_blocked_from(l: epi_Lattice, phi: vec2<f32>, distance: f32) -> u32
/// ```
///
/// The voxel along α in which that light ray is after a distance, from which on it is in
/// shadow if its first blocker is there; the number of voxels for a blocker beyond all of
/// them or none, which is a distance of `epi_INFINITE`.
///
/// ```wgsl
/// fn epi_angle(y: f32, x: f32) -> f32
/// fn epi_cross(a: vec2<f32>, b: vec2<f32>) -> f32
/// ```
///
/// The angle of a vector in [−π, π], within 3e-7 of itself, 0 for the zero vector (WGSL's
/// own may be off by 4096 units of the last digit); and `a.x b.y − a.y b.x` for vectors
/// next to each other, within 2⁻³⁴ of the product of their lengths and a rounding.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("space.wgsl"), "\n```")]
pub const EPIPOLAR: &str = text(include_str!("space.wgsl"));

/// The voxels along φ. Needs [`EPIPOLAR`].
///
/// ```wgsl
/// fn epi_phi_position(l: epi_Lattice, phi: vec2<f32>) -> f32
/// fn epi_phi_at(l: epi_Lattice, position: f32) -> vec2<f32>
/// ```
///
/// The position of a φ in voxels, from 0 to their number, in log₂ of it steps; and the φ
/// at a position, which is cut off at both ends.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn epi_bound(index: u32) -> vec2<f32>
/// ```
///
/// An entry of [`Lattice::bounds`](crate::Lattice::bounds), of which there is one more than
/// voxels along φ.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("phi.wgsl"), "\n```")]
pub const PHI: &str = text(include_str!("phi.wgsl"));

/// The text itself. A call keeps it out of the line in which the documentation shows the
/// constant.
const fn text(source: &'static str) -> &'static str {
    source
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use super::*;

    #[test]
    fn pages_say_what_the_parts_define() {
        let data = "fn epi_bound(index: u32) -> vec2<f32> { return vec2(f32(index)); }";
        let parts = [EPIPOLAR, PHI, data];
        let named = Shader::documented(&parts, include_str!("parts.rs")).unwrap();
        for name in ["epi_bound", "epi_ray_to", "epi_phi_position"] {
            assert!(named.iter().any(|other| other == name), "{name}");
        }
    }
}
