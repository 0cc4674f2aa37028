//! The part of a ray that may be in shadow.

use gpu_backend::{Error, Host, Memory};

use super::check;
use super::search::Line;
use super::volumes::ShadowVolumes;
use crate::shadow_map::ShadowMap;
use crate::{Interval, Ray};

impl<M: Memory> ShadowVolumes<M> {
    /// Checks that the volumes have the texels per side and the faces of a map. Their lights
    /// are not compared.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if they differ.
    pub(in crate::methods) fn go_with(&self, map: &ShadowMap<M>) -> Result<(), Error> {
        check(&self.cells, map)
    }
}

#[cfg(feature = "wgpu")]
impl<M: Memory> ShadowVolumes<M> {
    /// Cells along a side of the finest level.
    pub(in crate::methods) fn cells_per_side(&self) -> u32 {
        self.cells.side
    }
}

impl ShadowVolumes<Host> {
    /// The range from the front of the first volume to the back of the last one that a finite
    /// part of a ray is in; `None` if it is in none. Volumes are told apart down to cells that
    /// the ray crosses within the length `shortest`, m.
    pub fn between(&self, ray: &Ray, part: Interval, shortest: f32) -> Option<Interval> {
        let line = Line::new(ray, self.cells.origin);
        self.span(&line, part, shortest, &mut 0)
    }
}
