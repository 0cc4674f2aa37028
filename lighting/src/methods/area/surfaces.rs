//! Surfaces lit by many lights, with shadows from the lights' voxels.
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
/// A single bit tells whether the voxel that contains a point is lit. The mean of four bits,
/// with the neighbours in the next plane of θ and at the next bit of φ, has a border that is
/// soft by a voxel. Along α there is nothing to interpolate, because light that is blocked once
/// stays blocked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum SurfaceLookup {
    /// The voxel that contains the point.
    Nearest,
    /// An interpolation along θ and φ.
    #[default]
    Interpolated,
}

impl SurfaceLookup {
    /// The sampling, with the biases that keep lit surfaces from shadowing themselves.
    pub(crate) fn sampling(self) -> Sampling {
        Sampling {
            interpolate: self == Self::Interpolated,
            ..Sampling::PAPER
        }
    }
}

/// Surfaces, and the many lights that light them.
#[derive(Debug)]
pub struct ManyOnSurfaces<'a, M: Memory> {
    /// The points of the surfaces, in the memory of the backend. They should be visible from
    /// the eye of the voxels; an invisible point gets the shadow of the nearest voxel.
    pub points: &'a M::Buffer<SurfacePoint>,
    /// The lights of the voxels, in their order; see
    /// [`ManyLights`](super::ManyLights::emitters).
    pub emitters: &'a [Emitter],
    /// The medium between lights and surfaces.
    pub medium: &'a Medium,
    /// How the voxels are looked up.
    pub lookup: SurfaceLookup,
}

/// The step that lights surfaces with the voxels of many lights.
pub trait LightManySurfaces: Backend {
    /// Adds to the first three components of `radiance[i]` what point i reflects to the eye of
    /// the direct light of all lights:
    ///
    /// ```text
    /// response Σ_l E_l max(cos θ_l, 0) V_l exp(−σ_t d_l)
    /// ```
    ///
    /// E is the irradiance of a surface that faces light l, θ the angle between the normal and
    /// the direction to the light, d the length of the way to the light in the medium, and V
    /// the visibility at the point according to the voxels, in [0, 1].
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if points and radiance differ in length, or lights and voxels
    /// in number; nothing is written then.
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
