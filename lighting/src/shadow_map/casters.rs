//! The triangles that cast shadows in a shadow map.

use glam::Vec3;
#[cfg(any(feature = "voxel-shadow", feature = "wgpu"))]
use gpu_backend::Buffer;
use gpu_backend::{Backend, Error, Memory};

use super::masked::Masked;
use crate::scene::{Bounds, Geometry};

/// Triangles that cast shadows, in the memory of a backend that renders them.
///
/// A map has one depth per texel, and everything behind it is dark. So only what blocks all
/// light is in a map: solid triangles, and masked ones outside of their holes. Triangles that
/// cast no shadow and see-through ones are left out.
#[derive(Debug)]
pub struct Casters<M: Memory> {
    triangles: M::Buffer<[Vec3; 3]>,
    bounds: Bounds,
    masked: Masked,
    #[cfg(feature = "wgpu")]
    masks: super::masks::Masks<M>,
}

impl<M: Memory> Casters<M> {
    /// Copies the triangles of a scene to a backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit.
    pub fn upload<B: Backend<Memory = M>>(backend: &B, geometry: &Geometry) -> Result<Self, Error> {
        let masked = Masked::new(geometry);
        let triangles = match masked.order(geometry) {
            None => backend.upload(geometry.triangles())?,
            Some(order) => backend.upload(&order)?,
        };
        Ok(Self {
            triangles,
            bounds: geometry.bounds(),
            #[cfg(feature = "wgpu")]
            masks: super::masks::Masks::upload(backend, &masked)?,
            masked,
        })
    }

    /// A box around all of these triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The triangles. If all triangles of the geometry are solid, these are
    /// [`Geometry::triangles`] in their order. Otherwise those that let light pass are left
    /// out, and masked triangles come last.
    pub fn triangles(&self) -> &M::Buffer<[Vec3; 3]> {
        &self.triangles
    }

    /// Number of masked triangles, which are the last ones.
    pub fn masked(&self) -> usize {
        self.masked.len()
    }

    /// Number of solid triangles, which are the first ones.
    #[cfg(any(feature = "voxel-shadow", feature = "wgpu"))]
    pub(crate) fn solid(&self) -> usize {
        self.triangles.len() - self.masked.len()
    }

    pub(super) fn masks_on_host(&self) -> &Masked {
        &self.masked
    }

    #[cfg(feature = "wgpu")]
    pub(crate) fn masks(&self) -> &super::masks::Masks<M> {
        &self.masks
    }
}

#[cfg(feature = "voxel-shadow")]
impl voxel_shadow::Holes for Casters<gpu_backend::Host> {
    fn is_hole(&self, triangle: usize, u: f32, v: f32) -> bool {
        let masked = triangle.checked_sub(self.solid());
        masked.is_some_and(|index| !self.masked.blocks(index, u.into(), v.into()))
    }
}
