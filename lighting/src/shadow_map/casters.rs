//! What casts shadows in the maps of a light.

use glam::Vec3;
use gpu_backend::{Backend, Error, Memory};

use crate::scene::{Caster, Coatings, Geometry};

/// Triangles that cast shadows, where a backend can render them.
///
/// A map has one depth per texel, behind which all is dark. So it holds what no
/// light passes: solid triangles, and masked ones where they are there. What casts no
/// shadow is left out, and so is what is see-through.
#[derive(Debug)]
pub struct Casters<M: Memory> {
    triangles: M::Buffer<[Vec3; 3]>,
    corners: [Vec3; 2],
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
        let bounds = geometry.bounds();
        let masked = Masked::new(geometry);
        let triangles = match masked.order(geometry) {
            None => backend.upload(geometry.triangles())?,
            Some(order) => backend.upload(&order)?,
        };
        Ok(Self {
            triangles,
            corners: [bounds.min(), bounds.max()],
            #[cfg(feature = "wgpu")]
            masks: super::masks::Masks::upload(backend, &masked)?,
            masked,
        })
    }

    /// Two opposite corners of a box around all of them.
    pub(crate) fn corners(&self) -> [Vec3; 2] {
        self.corners
    }

    /// The triangles: those of [`Geometry::triangles`] in their order, if all of
    /// them are solid. Else what lets light pass is left out, and masked triangles
    /// come last.
    pub fn triangles(&self) -> &M::Buffer<[Vec3; 3]> {
        &self.triangles
    }

    /// Number of masked triangles, the last ones.
    pub fn masked(&self) -> usize {
        self.masked.triangles.len()
    }

    pub(super) fn masks_on_host(&self) -> &Masked {
        &self.masked
    }

    #[cfg(feature = "wgpu")]
    pub(crate) fn masks(&self) -> &super::masks::Masks<M> {
        &self.masks
    }
}

/// The masked triangles of a scene.
#[derive(Debug, Clone)]
pub(crate) struct Masked {
    coatings: Coatings,
    /// Their indices in the geometry.
    triangles: Vec<u32>,
}

impl Masked {
    pub(crate) fn new(geometry: &Geometry) -> Self {
        let coatings = geometry.coatings().clone();
        let is_masked = |index: &u32| matches!(coatings.caster(*index as usize), Caster::Masked(_));
        let triangles = if coatings.all_solid() {
            Vec::new()
        } else {
            let all = 0..geometry.triangles().len() as u32;
            all.filter(is_masked).collect()
        };
        Self {
            coatings,
            triangles,
        }
    }

    /// The solid triangles and after them the masked ones; `None` if all are solid.
    pub(crate) fn order(&self, geometry: &Geometry) -> Option<Vec<[Vec3; 3]>> {
        if self.coatings.all_solid() {
            return None;
        }
        let all = geometry.triangles();
        let solid = (0..all.len()).filter(|index| self.coatings.caster(*index) == Caster::Solid);
        let masked = self.triangles.iter().map(|index| *index as usize);
        Some(solid.chain(masked).map(|index| all[index]).collect())
    }

    pub(crate) fn len(&self) -> usize {
        self.triangles.len()
    }

    /// What the masked triangle `index` does to light.
    pub(crate) fn caster(&self, index: usize) -> Caster<'_> {
        self.coatings.caster(self.triangles[index] as usize)
    }

    /// Whether the masked triangle `index` is there at the barycentric coordinates
    /// (`u`, `v`).
    pub(crate) fn blocks(&self, index: usize, u: f64, v: f64) -> bool {
        self.caster(index).transmittance_at(u, v) == Vec3::ZERO
    }
}
