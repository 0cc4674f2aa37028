//! Masked triangles, and where their masks have holes.

use glam::Vec3;

use crate::scene::{Caster, Coatings, Geometry};

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
        let is_masked = |index: &u32| match coatings.caster(*index as usize) {
            Caster::Masked(coating) => !coating.covers_nothing(),
            _ => false,
        };
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

    /// The solid triangles, followed by the masked ones without those that are holes
    /// everywhere; `None` if all triangles are solid.
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

    /// What the masked triangle `index` does to light that meets it.
    pub(crate) fn caster(&self, index: usize) -> Caster<'_> {
        self.coatings.caster(self.triangles[index] as usize)
    }

    /// Whether the masked triangle `index` blocks light at the barycentric coordinates (`u`,
    /// `v`).
    pub(crate) fn blocks(&self, index: usize, u: f64, v: f64) -> bool {
        self.caster(index).transmittance_at(u, v) == Vec3::ZERO
    }
}
