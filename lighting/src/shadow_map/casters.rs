//! What casts shadows in the maps of a light.

use glam::Vec3;
#[cfg(any(feature = "voxel-shadow", feature = "wgpu"))]
use gpu_backend::Buffer;
use gpu_backend::{Backend, Error, Memory};

use super::masked::Masked;
use crate::scene::{Bounds, Geometry};

/// Triangles that cast shadows, where a backend can render them.
///
/// A map has one depth per texel, behind which all is dark. So it holds what no
/// light passes: solid triangles, and masked ones where they are there. What casts no
/// shadow is left out, and so is what is see-through.
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

    /// A box around all of them.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The triangles: those of [`Geometry::triangles`] in their order, if all of
    /// them are solid. Else what lets light pass is left out, and masked triangles
    /// come last.
    pub fn triangles(&self) -> &M::Buffer<[Vec3; 3]> {
        &self.triangles
    }

    /// Number of masked triangles, the last ones.
    pub fn masked(&self) -> usize {
        self.masked.len()
    }

    /// Number of solid triangles, the first ones.
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
