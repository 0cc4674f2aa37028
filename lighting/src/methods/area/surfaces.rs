//! Surfaces that many lights light, with shadows from the voxels of these.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013: what
//! `QueryVisibilityAtFragment` reads in the pseudocode of section 3.1.5, interpolated
//! along θ and φ and not along α as in section 3.3 and appendix A. Departure: surfaces
//! are Lambertian, as everywhere here, and not those of Phong.

use gpu_backend::{Backend, BufferOf, Cpu, Error, Memory};

use super::LightVolumes;
use crate::gather::check_lengths;
use crate::scene::Medium;
use crate::surface_point::Arriving;
use crate::voxelized::Sampling;
use crate::{Emitter, SurfacePoint};

/// How voxels are looked up for surfaces.
///
/// One bit tells whether the voxel that holds a point is lit. Neighbours in the next
/// plane of θ and at the next bit of φ, four bits together, have a mean whose border is
/// soft by a voxel; along α there is nothing to interpolate, because light that is
/// blocked stays so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum SurfaceLookup {
    /// The voxel that holds the point.
    Nearest,
    /// Interpolated along θ and φ.
    #[default]
    Interpolated,
}

impl SurfaceLookup {
    /// With the biases that keep lit surfaces from shadowing themselves.
    pub(crate) fn sampling(self) -> Sampling {
        Sampling {
            interpolate: self == Self::Interpolated,
            ..Sampling::PAPER
        }
    }
}

/// Surfaces, and many lights that light them.
#[derive(Debug)]
pub struct ManyOnSurfaces<'a, M: Memory> {
    /// The points of the surfaces, in the memory of the backend. They should be those
    /// that the eye of the voxels sees; what it does not see is as dark as the nearest
    /// voxel.
    pub points: &'a M::Buffer<SurfacePoint>,
    /// The lights whose voxels there are, in their order; see
    /// [`ManyLights`](super::ManyLights::emitters).
    pub emitters: &'a [Emitter],
    /// What is between.
    pub medium: &'a Medium,
    /// How the voxels are looked up.
    pub lookup: SurfaceLookup,
}

/// The step that lights surfaces with the voxels of many lights.
pub trait LightManySurfaces: Backend {
    /// Adds to `radiance[i]` what the point i reflects to the eye of the light that
    /// reaches it straight from all lights:
    ///
    /// ```text
    /// response Σ_l E_l max(cos θ_l, 0) V_l exp(−σ_t d_l)
    /// ```
    ///
    /// E is the irradiance of a surface that faces light l, θ the angle between the
    /// normal and the way to it, d the length of that way in the medium, and V the
    /// visibility that the voxels have at the point, in [0, 1]. The fourth component is
    /// left alone.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if points and radiance differ in length, or lights and
    /// voxels in number; nothing is written then.
    fn light_many_surfaces(
        &self,
        lit: &ManyOnSurfaces<'_, Self::Memory>,
        volumes: &LightVolumes<Self::Memory>,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

pub(super) fn check<M: Memory>(
    lit: &ManyOnSurfaces<'_, M>,
    volumes: &LightVolumes<M>,
    [points, radiance]: [usize; 2],
) -> Result<(), Error> {
    check_lengths(points, radiance)?;
    volumes.are_of(lit.emitters)
}

impl LightManySurfaces for Cpu {
    fn light_many_surfaces(
        &self,
        lit: &ManyOnSurfaces<'_, Self::Memory>,
        volumes: &LightVolumes<Self::Memory>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        use crate::visibility::SurfaceShadow;

        check(lit, volumes, [lit.points.len(), radiance.len()])?;
        let shadows: Vec<_> = (0..lit.emitters.len())
            .map(|light| volumes.on_surfaces(light, lit.lookup))
            .collect();
        self.for_each_chunk(radiance, 64, |first, chunk| {
            for (sum, point) in chunk.iter_mut().zip(&lit.points[first..]) {
                if !point.reflects() {
                    continue;
                }
                let (position, normal) = (point.position(), point.normal());
                for (emitter, shadow) in lit.emitters.iter().zip(&shadows) {
                    let Some(light) = Arriving::at(position, emitter) else {
                        continue;
                    };
                    let cos = normal.dot(light.to_light);
                    if cos <= 0.0 {
                        continue;
                    }
                    let share = shadow.visibility(position, normal);
                    let through = light.through(Some(lit.medium), position);
                    let added = point.response() * (light.irradiance * cos * through * share);
                    for channel in 0..3 {
                        sum[channel] += added[channel];
                    }
                }
            }
        });
        Ok(())
    }
}
