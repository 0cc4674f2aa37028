//! The rays of a picture, and the surfaces that they meet.

use std::sync::Arc;

use glam::Vec3;
use gpu_backend::Cpu;

use crate::trace::{Hit, Pane, Tracer};
use crate::{Camera, Ray};

/// Largest width and height of a picture.
pub const MAX_SIDE: u32 = 16384;

/// A picture size that is not supported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a picture of {width} x {height} pixels was asked for, expected 1 to {MAX_SIDE} per side")]
pub struct SizeError {
    width: u32,
    height: u32,
}

/// One ray per pixel, through its centre, that ends at the first surface through which nothing
/// can be seen.
#[derive(Debug, Clone)]
pub struct View {
    width: u32,
    height: u32,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// The see-through surfaces in front of the hits, ray after ray.
    panes: Vec<Pane>,
    /// For each ray, the index behind its last pane; empty if there are no panes.
    ends: Vec<usize>,
    cover: Arc<Cover>,
}

/// What covers a share of what the rays of a picture meet and is not a surface: hair.
///
/// A ray has steps. At each of them the share of the light from behind that reaches the eye
/// falls to a lower value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cover {
    /// For each ray, the index behind its last step.
    ends: Vec<usize>,
    steps: Vec<CoverStep>,
}

/// A distance along a ray from which on more is covered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoverStep {
    /// Distance along the ray, m. What is exactly at this distance is not covered by the step.
    pub distance: f32,
    /// The share of the light from behind that reaches the eye, 0 to 1.
    pub share: f32,
}

impl Cover {
    /// Makes a cover from the steps of all rays; those of each ray must be in order of rising
    /// distance.
    pub fn new<I: IntoIterator<Item = CoverStep>>(rays: impl IntoIterator<Item = I>) -> Self {
        let mut cover = Self::default();
        for ray in rays {
            cover.steps.extend(ray);
            cover.ends.push(cover.steps.len());
        }
        cover
    }

    /// True if nothing is covered.
    pub fn is_clear(&self) -> bool {
        self.steps.is_empty()
    }

    /// The steps of a ray; none if there is no such ray.
    pub fn steps(&self, ray: usize) -> &[CoverStep] {
        let Some(&end) = self.ends.get(ray) else {
            return &[];
        };
        let start = ray.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.steps[start..end]
    }

    /// The share of the light that reaches the eye from a distance along a ray.
    pub fn share(&self, ray: usize, distance: f32) -> f32 {
        let steps = self.steps(ray);
        let before = steps.partition_point(|step| step.distance < distance);
        before.checked_sub(1).map_or(1.0, |last| steps[last].share)
    }
}

impl View {
    /// The view of `camera`, traced against the scene.
    ///
    /// # Errors
    /// [`SizeError`] if a side is 0 or above [`MAX_SIDE`].
    pub fn new(
        cpu: &Cpu,
        camera: &Camera,
        tracer: &Tracer,
        width: u32,
        height: u32,
    ) -> Result<Self, SizeError> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(SizeError { width, height });
        }
        let count = width as usize * height as usize;
        let traced: Vec<(Ray, Option<Hit>)> = cpu.map(count, |pixel| {
            let (row, column) = (pixel / width as usize, pixel % width as usize);
            let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
            let direction = camera.direction(x, y, width, height);
            let ray = Ray::new(camera.eye(), direction, f32::INFINITY)
                .expect("a camera has a finite eye and unit directions");
            match tracer.closest_hit(&ray) {
                Some(hit) => (ray.with_length(hit.distance), Some(hit)),
                None => (ray, None),
            }
        });
        let (rays, hits): (Vec<Ray>, Vec<_>) = traced.into_iter().unzip();
        let (mut panes, mut ends) = (Vec::new(), Vec::new());
        if tracer.coatings().any_see_through() {
            for of_ray in cpu.map(count, |pixel| tracer.panes(&rays[pixel])) {
                panes.extend(of_ray);
                ends.push(panes.len());
            }
        }
        Ok(Self {
            width,
            height,
            rays,
            hits,
            panes,
            ends,
            cover: Arc::default(),
        })
    }

    /// The same view with `cover` in front of what it sees; it replaces an earlier cover.
    #[must_use]
    pub fn with_cover(self, cover: Cover) -> Self {
        Self {
            cover: Arc::new(cover),
            ..self
        }
    }

    /// What covers a share of what the rays meet. A new view has an empty cover.
    pub fn cover(&self) -> &Arc<Cover> {
        &self.cover
    }

    /// Pixels per row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// One ray per pixel, row by row from the top.
    pub fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// What each ray ends on; `None` where it ends in the sky.
    pub fn hits(&self) -> &[Option<Hit>] {
        &self.hits
    }

    /// The see-through surfaces in front of what the ray of a pixel ends on, the nearest first.
    pub fn panes(&self, pixel: usize) -> &[Pane] {
        let Some(&end) = self.ends.get(pixel) else {
            return &[];
        };
        let start = pixel.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.panes[start..end]
    }

    /// The share of the light from the end of a pixel's ray that passes all panes in front, per
    /// colour channel.
    pub fn through_panes(&self, pixel: usize) -> Vec3 {
        let panes = self.panes(pixel).iter();
        panes.map(|pane| pane.transmittance).product()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cover_is_in_steps_and_what_is_at_one_is_before_it() {
        let step = |distance, share| CoverStep { distance, share };
        let cover = Cover::new([vec![], vec![step(1.0, 0.5), step(2.0, 0.25)], vec![]]);
        assert!(!cover.is_clear() && Cover::default().is_clear());
        for (ray, distance, share) in [
            (0, 9.0, 1.0),
            (1, 1.0, 1.0),
            (1, 1.5, 0.5),
            (1, f32::INFINITY, 0.25),
            (2, 3.0, 1.0),
            (7, 3.0, 1.0),
        ] {
            assert_eq!(cover.share(ray, distance), share);
        }
    }
}
