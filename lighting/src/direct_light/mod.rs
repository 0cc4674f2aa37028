//! The light of many lights that reaches surfaces directly.
//!
//! A [`SurfacePoint`] has a position, a normal and a response: how much of what it reflects
//! reaches the eye. A [list](PointLists) names the lights that may reach the point, and
//! [`ShadowsOfMany`] says which share of each arrives. [`AddDirectLight`] adds up the light
//! that the point reflects:
//!
//! ```text
//! response Σ_l E_l max(cos θ_l, 0) V_l exp(−σ_t d_l)
//! ```
//!
//! E is the irradiance that light l, with its cone, cookie and window, causes on a surface that
//! faces it; θ the angle between the normal and the direction to the light; d the length of the
//! way to the light in the medium; V the visibility, 0 to 1 for each colour. In a medium
//! without bounds, the irradiance of a sun is the one that arrives, and is not attenuated
//! again.
//!
//! Based on: Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of Voxelized
//! Shadows, I3D 2015, section 4: a city lit by 165 spotlights, culled by tiles, with
//! precomputed shadows that are filtered over 9 × 9 texels. Departures: lists belong to
//! clusters (see [`culling`](crate::culling)) and have no length limit; the filter may have any
//! odd width; every light has its own bias.
//!
//! # Shadows
//!
//! | source | what |
//! |---|---|
//! | [`Unshadowed`] | none |
//! | `precomputed::FilteredShadows` | precomputed voxelized shadows, k × k filtered |
//! | `shadow_map::FilteredMapsOfMany` | shadow maps, k × k filtered |
//! | [`Both`](crate::visibility::Both) of two | shadows of either: of what stays and of what moves |
//! | `Vec<S>` of any [`SurfaceShadow`] | on the CPU alone: maps, voxels and all others |
//!
//! # What is guaranteed
//!
//! Every point adds its lights in their order. On either backend the result depends neither on
//! the lists, as long as they leave out no light that reaches a point, nor on how many lights a
//! dispatch takes. Backends agree to rounding, except for points that are within rounding of
//! the border of a voxel, as `shadow_dag::gpu` says, or of a texel.
//!
//! Cost: a test for each point and each light of its list, and a lookup of the shadow where the
//! light reaches the front of the surface.
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu};
//! use lighting::culling::PointLists;
//! use lighting::direct_light::{AddDirectLight, LitPoints};
//! use lighting::scene::{Emission, Emitter};
//! use lighting::visibility::Unshadowed;
//! use lighting::SurfacePoint;
//!
//! let point = |x: f32| SurfacePoint::new(Vec3::new(x, 0.0, 0.0), Vec3::Y, Vec3::splat(0.25));
//! let points = [point(0.0), point(3.0)].map(|point| point.expect("a sound point"));
//! let lamp = Emitter::point(2.0 * Vec3::Y, Vec3::splat(8.0), 2.5, Emission::Isotropic)?;
//! let (lamps, lists) = ([lamp], PointLists::all(points.len(), 1));
//!
//! let cpu = Cpu::new();
//! let points = cpu.upload(&points)?;
//! let mut radiance = cpu.zeros::<[f32; 4]>(points.len())?;
//! let lit = LitPoints::new(&points, &lamps, &lists, None);
//! cpu.add_direct_light(&lit, &Unshadowed, &mut radiance)?;
//! assert_eq!(radiance[0][0], 0.25 * 8.0 / 4.0);
//! assert_eq!(radiance[1][0], 0.0, "out of range");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "wgpu")]
mod gpu;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod gpu_tests;
#[cfg(test)]
mod tests;

#[cfg(feature = "wgpu")]
pub use gpu::ManySurfacesSlot;

use glam::Vec3;
use gpu_backend::{Backend, Buffer, BufferOf, Cpu, Error, Memory};

use crate::culling::PointLists;
use crate::gather::check_lengths;
use crate::scene::Medium;
use crate::surface_point::Arriving;
use crate::visibility::{SurfaceShadow, Unshadowed};
use crate::{Emitter, SurfacePoint};

/// Points of surfaces, and the lights that may reach each.
#[derive(Debug)]
pub struct LitPoints<'a, M: Memory> {
    /// The points, in the memory of the backend.
    pub points: &'a M::Buffer<SurfacePoint>,
    /// The lights that the lists refer to. The source of shadows must number them in the same
    /// way.
    pub emitters: &'a [Emitter],
    /// Which of the lights may reach each point.
    pub lists: &'a PointLists,
    /// The medium between lights and points; `None` for a vacuum.
    pub medium: Option<&'a Medium>,
    /// Entries of each list that one dispatch takes on a GPU, at least 1. Further dispatches
    /// take the entries after these.
    pub lights_per_dispatch: usize,
}

impl<'a, M: Memory> LitPoints<'a, M> {
    /// Points whose lists are taken whole by one dispatch.
    pub fn new(
        points: &'a M::Buffer<SurfacePoint>,
        emitters: &'a [Emitter],
        lists: &'a PointLists,
        medium: Option<&'a Medium>,
    ) -> Self {
        Self {
            points,
            emitters,
            lists,
            medium,
            lights_per_dispatch: usize::MAX,
        }
    }
}

/// The step that adds the direct light of many lights to surfaces, with the shadows `V`.
///
/// It is implemented on the CPU for all [`ShadowsOfMany`], and on GPUs for those that bring a
/// shader part.
pub trait AddDirectLight<V>: Backend {
    /// Adds to the first three components of `radiance[i]` what point i reflects to the eye of
    /// the direct light of the lights that its list names, in their order.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the numbers of sums and lists are not that of points, or if
    /// the lists were made for another number of lights; nothing is written then. On a GPU
    /// [`Error::TooLarge`] if lights and cookies, or the lists, do not fit into one binding.
    fn add_direct_light(
        &self,
        lit: &LitPoints<'_, Self::Memory>,
        shadows: &V,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

/// The shadows of many lights on surfaces, on the CPU.
pub trait ShadowsOfMany: Sync {
    /// The share, 0 to 1 per colour, of the light of index `light` that reaches `point`
    /// unblocked. The point is on a surface with the unit `normal`, which points to the side of
    /// the light. The share is 0 for an index of no light.
    fn visibility(&self, light: usize, point: Vec3, normal: Vec3) -> Vec3;
}

impl ShadowsOfMany for Unshadowed {
    fn visibility(&self, _: usize, _: Vec3, _: Vec3) -> Vec3 {
        Vec3::ONE
    }
}

impl<S: SurfaceShadow + Send> ShadowsOfMany for Vec<S> {
    fn visibility(&self, light: usize, point: Vec3, normal: Vec3) -> Vec3 {
        let shadow = self.get(light);
        shadow.map_or(Vec3::ZERO, |shadow| shadow.visibility(point, normal))
    }
}

fn check<M: Memory>(lit: &LitPoints<'_, M>, radiance: usize) -> Result<(), Error> {
    check_lengths(lit.points.len(), radiance)?;
    for (what, expected, actual) in [
        ("the lists of points", lit.points.len(), lit.lists.points()),
        (
            "the lights of the lists",
            lit.emitters.len(),
            lit.lists.emitters(),
        ),
    ] {
        if expected != actual {
            return Err(Error::LengthMismatch {
                what,
                expected,
                actual,
            });
        }
    }
    Ok(())
}

impl<V: ShadowsOfMany> AddDirectLight<V> for Cpu {
    fn add_direct_light(
        &self,
        lit: &LitPoints<'_, Self::Memory>,
        shadows: &V,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check(lit, radiance.len())?;
        self.for_each_chunk(radiance, 64, |first, chunk| {
            for (i, sum) in (first..).zip(chunk) {
                let point = &lit.points[i];
                if !point.reflects() {
                    continue;
                }
                for light in lit.lists.of(i) {
                    let light = *light as usize;
                    let arrives = arriving(point, &lit.emitters[light], lit.medium);
                    if arrives == Vec3::ZERO {
                        continue;
                    }
                    let share = shadows.visibility(light, point.position(), point.normal());
                    let added = point.response() * (arrives * share);
                    for channel in 0..3 {
                        sum[channel] += added[channel];
                    }
                }
            }
        });
        Ok(())
    }
}

/// The irradiance of a point from a light, without shadow.
fn arriving(point: &SurfacePoint, emitter: &Emitter, medium: Option<&Medium>) -> Vec3 {
    let Some(light) = Arriving::at(point.position(), emitter) else {
        return Vec3::ZERO;
    };
    let cos = point.normal().dot(light.to_light);
    if cos <= 0.0 || light.irradiance == Vec3::ZERO {
        return Vec3::ZERO;
    }
    light.irradiance * cos * light.through(medium, point.position())
}
