//! The step that answers queries for many rays or points.

use glam::Vec4;
use gpu_backend::{Backend, BufferOf, Cpu, Host, Memory};

use crate::error::same_length;
use crate::{Error, LitInterval, RayShadow, ShadowVolume, Weights};

/// Rays per unit of work.
const CHUNK: usize = 1024;

/// Answers queries in batches. Rays are a direction of any length and, as the
/// fourth number, the distance to the first surface in metres ([`f32::MAX`] for the
/// sky).
pub trait Query: Backend {
    /// [`ShadowVolume::visibility`] of points on surfaces (metres; the fourth
    /// numbers are not used). [`Sampling`](crate::Sampling) says which bias they need.
    ///
    /// # Errors
    /// [`gpu_backend::Error::LengthMismatch`] unless there are as many results as
    /// points; errors of the backend.
    fn visibility(
        &self,
        volume: &ShadowVolume<'_, Self::Memory>,
        points: &BufferOf<Self, [f32; 4]>,
        visibility: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;

    /// [`RayShadow::lit_fraction`] of rays.
    ///
    /// # Errors
    /// As for [`Query::visibility`].
    fn lit_fraction(
        &self,
        volume: &ShadowVolume<'_, Self::Memory>,
        rays: &BufferOf<Self, [f32; 4]>,
        fractions: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;

    /// [`RayShadow::weighted_sum`] of rays.
    ///
    /// # Errors
    /// As for [`Query::visibility`]; the same error unless there are as many weights
    /// as bits per texel.
    fn weighted_sum(
        &self,
        volume: &ShadowVolume<'_, Self::Memory>,
        weights: &Weights,
        rays: &BufferOf<Self, [f32; 4]>,
        sums: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;

    /// [`RayShadow::lit_intervals`] of rays. `intervals` has the same
    /// capacity for each ray, its length divided by that of the rays; `counts` are
    /// how many intervals each ray has, of which those beyond its capacity are
    /// left out. Places without an interval keep what they held.
    ///
    /// # Errors
    /// [`gpu_backend::Error::LengthMismatch`] unless there is one count per ray and
    /// the same capacity for each ray; errors of the backend.
    fn lit_intervals(
        &self,
        volume: &ShadowVolume<'_, Self::Memory>,
        rays: &BufferOf<Self, [f32; 4]>,
        intervals: &mut BufferOf<Self, LitInterval>,
        counts: &mut BufferOf<Self, u32>,
    ) -> Result<(), Error>;
}

impl Query for Cpu {
    fn visibility(
        &self,
        volume: &ShadowVolume<'_, Host>,
        points: &Vec<[f32; 4]>,
        visibility: &mut Vec<f32>,
    ) -> Result<(), Error> {
        same_length("the visibilities of points", points.len(), visibility.len())?;
        self.for_each_chunk(visibility, CHUNK, |first, chunk| {
            for (value, point) in chunk.iter_mut().zip(&points[first..]) {
                *value = volume.visibility(Vec4::from_array(*point).truncate());
            }
        });
        Ok(())
    }

    fn lit_fraction(
        &self,
        volume: &ShadowVolume<'_, Host>,
        rays: &Vec<[f32; 4]>,
        fractions: &mut Vec<f32>,
    ) -> Result<(), Error> {
        same_length("the lit fractions of rays", rays.len(), fractions.len())?;
        for_each_ray(self, volume, rays, fractions, |ray| ray.lit_fraction());
        Ok(())
    }

    fn weighted_sum(
        &self,
        volume: &ShadowVolume<'_, Host>,
        weights: &Weights,
        rays: &Vec<[f32; 4]>,
        sums: &mut Vec<f32>,
    ) -> Result<(), Error> {
        same_length("the weighted sums of rays", rays.len(), sums.len())?;
        check_weights(volume, weights)?;
        for_each_ray(self, volume, rays, sums, |ray| ray.weighted_sum(weights));
        Ok(())
    }

    fn lit_intervals(
        &self,
        volume: &ShadowVolume<'_, Host>,
        rays: &Vec<[f32; 4]>,
        intervals: &mut Vec<LitInterval>,
        counts: &mut Vec<u32>,
    ) -> Result<(), Error> {
        let capacity = capacity(rays.len(), intervals.len(), counts.len())?;
        if capacity == 0 {
            self.for_each_chunk(counts, CHUNK, |first, counts| {
                let rays = &rays[first..][..counts.len()];
                volume.lit_intervals(rays, |i, lit| counts[i] = lit.len() as u32);
            });
            return Ok(());
        }
        // The intervals and the counts of the same rays, as one item of work.
        let mut work: Vec<_> = intervals
            .chunks_mut(CHUNK * capacity)
            .zip(counts.chunks_mut(CHUNK))
            .collect();
        self.for_each_chunk(&mut work, 1, |index, work| {
            for (intervals, counts) in work {
                let rays = &rays[index * CHUNK..][..counts.len()];
                volume.lit_intervals(rays, |i, lit| {
                    let places = &mut intervals[i * capacity..][..capacity];
                    for (place, interval) in places.iter_mut().zip(lit) {
                        *place = *interval;
                    }
                    counts[i] = lit.len() as u32;
                });
            }
        });
        Ok(())
    }
}

fn for_each_ray(
    cpu: &Cpu,
    volume: &ShadowVolume<'_, Host>,
    rays: &[[f32; 4]],
    results: &mut [f32],
    answer: impl Fn(RayShadow<'_>) -> f32 + Sync,
) {
    cpu.for_each_chunk(results, CHUNK, |first, chunk| {
        let rays = &rays[first..][..chunk.len()];
        volume.ray_shadows(rays, |i, ray| chunk[i] = answer(ray));
    });
}

pub(crate) fn check_weights<M: Memory>(
    volume: &ShadowVolume<'_, M>,
    weights: &Weights,
) -> Result<(), Error> {
    let bits = volume.lattice().resolution().bits() as usize;
    same_length("the weights of bits", bits, weights.sums().len() - 1)
}

/// The capacity for intervals per ray.
pub(crate) fn capacity(rays: usize, intervals: usize, counts: usize) -> Result<usize, Error> {
    same_length("the counts of lit intervals", rays, counts)?;
    let capacity = intervals.checked_div(rays).unwrap_or(0);
    same_length("the lit intervals of rays", capacity * rays, intervals)?;
    Ok(capacity)
}
