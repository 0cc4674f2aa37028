//! Many questions at once.

use glam::{IVec3, Vec3};
use gpu_backend::Cpu;

use super::filter::FilterSize;
use crate::error::same_length;
use crate::{Error, ShadowDag};

/// Questions that one thread takes at a time: a few microseconds of work.
const CHUNK: usize = 256;

impl<B: AsRef<[u8]> + Sync> ShadowDag<B> {
    /// [`ShadowDag::is_lit`] of each voxel.
    ///
    /// # Errors
    /// [`Error::Length`] if there are not as many places as voxels.
    pub fn is_lit_batch(&self, cpu: &Cpu, voxels: &[IVec3], lit: &mut [bool]) -> Result<(), Error> {
        batch(cpu, voxels, lit, |voxel| self.is_lit(*voxel))
    }

    /// [`ShadowDag::filter`] of each voxel.
    ///
    /// # Errors
    /// [`Error::Length`] if there are not as many places as voxels.
    pub fn filter_batch(
        &self,
        cpu: &Cpu,
        voxels: &[IVec3],
        size: FilterSize,
        lit: &mut [f32],
    ) -> Result<(), Error> {
        batch(cpu, voxels, lit, |voxel| self.filter(*voxel, size))
    }

    /// [`ShadowDag::filter_bilinear`] of each position.
    ///
    /// # Errors
    /// [`Error::Length`] if there are not as many places as positions.
    pub fn filter_bilinear_batch(
        &self,
        cpu: &Cpu,
        positions: &[Vec3],
        size: FilterSize,
        lit: &mut [f32],
    ) -> Result<(), Error> {
        batch(cpu, positions, lit, |position| {
            self.filter_bilinear(*position, size)
        })
    }
}

/// The `answer` to each of the `questions`.
pub(super) fn batch<Q: Sync, A: Send>(
    cpu: &Cpu,
    questions: &[Q],
    answers: &mut [A],
    answer: impl Fn(&Q) -> A + Sync,
) -> Result<(), Error> {
    same_length("places for answers", questions.len(), answers.len())?;
    cpu.for_each_chunk(answers, CHUNK, |first, chunk| {
        for (place, question) in chunk.iter_mut().zip(&questions[first..]) {
            *place = answer(question);
        }
    });
    Ok(())
}
