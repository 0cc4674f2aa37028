//! Many questions at once.

use glam::{IVec3, Vec3};
use gpu_backend::Cpu;
use pulp::{Arch, Simd, WithSimd};

use super::blocks::Blocks;
use super::filter::{FilterSize, count_lit, filter_bilinear};
use super::point::clamp;
use crate::dag::with_nodes;
use crate::error::same_length;
use crate::nodes::Nodes;
use crate::{Error, ShadowDag};

/// Questions that one thread takes at a time if they share nothing.
const CHUNK: usize = 256;

/// The most that one thread takes at a time if they may: some rows of a picture.
const LARGE_CHUNK: usize = 16384;

/// A question that is asked about many places.
pub(super) trait Question: Copy + Sync {
    /// The place that a question asks about.
    type Place;
    type Answer;

    /// The answer in a grid of `side`. Must be `#[inline(always)]`, or it is not compiled for
    /// the instructions that it runs on.
    fn answer<N: Nodes>(
        self,
        blocks: &mut Blocks<'_, N>,
        side: u32,
        place: Self::Place,
    ) -> Self::Answer;
}

/// [`ShadowDag::is_lit`].
#[derive(Debug, Clone, Copy)]
pub(super) struct IsLit;

impl Question for IsLit {
    type Place = IVec3;
    type Answer = bool;

    #[inline(always)]
    fn answer<N: Nodes>(self, blocks: &mut Blocks<'_, N>, side: u32, voxel: IVec3) -> bool {
        clamp(voxel, side).is_none_or(|voxel| blocks.is_lit(voxel))
    }
}

/// [`ShadowDag::count_lit`].
#[derive(Debug, Clone, Copy)]
pub(super) struct CountLit(pub(super) FilterSize);

impl Question for CountLit {
    type Place = IVec3;
    type Answer = u32;

    #[inline(always)]
    fn answer<N: Nodes>(self, blocks: &mut Blocks<'_, N>, side: u32, voxel: IVec3) -> u32 {
        count_lit(voxel, self.0, side, |window, z, lit| {
            blocks.count(window, z, lit);
        })
    }
}

/// [`ShadowDag::filter_bilinear`].
#[derive(Debug, Clone, Copy)]
pub(super) struct FilterBilinear(pub(super) FilterSize);

impl Question for FilterBilinear {
    type Place = Vec3;
    type Answer = f32;

    #[inline(always)]
    fn answer<N: Nodes>(self, blocks: &mut Blocks<'_, N>, side: u32, position: Vec3) -> f32 {
        filter_bilinear(position, self.0, side, |window, z, four| {
            blocks.count(window, z, four);
        })
    }
}

impl<B: AsRef<[u8]> + Sync> ShadowDag<B> {
    /// [`ShadowDag::is_lit`] of each voxel.
    ///
    /// Voxels near each other share the way down to them, in any order.
    ///
    /// # Errors
    /// [`Error::Length`] if there are not as many places as voxels.
    pub fn is_lit_batch(&self, cpu: &Cpu, voxels: &[IVec3], lit: &mut [bool]) -> Result<(), Error> {
        self.ask(cpu, IsLit, voxels, lit, |voxel| *voxel, |lit| lit)
    }

    /// [`ShadowDag::filter`] of each voxel.
    ///
    /// Voxels near each other share the way down to them, in any order.
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
        let share = |count| size.share(count);
        self.ask(cpu, CountLit(size), voxels, lit, |voxel| *voxel, share)
    }

    /// [`ShadowDag::filter_bilinear`] of each position.
    ///
    /// Positions near each other share the way down to them, in any order.
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
        let question = FilterBilinear(size);
        self.ask(cpu, question, positions, lit, |place| *place, |lit| lit)
    }

    /// The answers to one question about many places.
    pub(super) fn ask<K: Question, P: Sync, A: Send>(
        &self,
        cpu: &Cpu,
        question: K,
        places: &[P],
        answers: &mut [A],
        place: impl Fn(&P) -> K::Place + Sync,
        answer: impl Fn(K::Answer) -> A + Sync,
    ) -> Result<(), Error> {
        same_length("places for answers", places.len(), answers.len())?;
        let arch = Arch::new();
        // Rows of a picture that are in one chunk share what they have in common: with 128 chunks
        // those of 480 × 270 would take 1.4 times as long, with fewer many threads would wait.
        let chunk = (places.len() / 32).clamp(CHUNK, LARGE_CHUNK);
        cpu.for_each_chunk(answers, chunk, |first, answers| {
            with_nodes!(self, nodes => arch.dispatch(Chunk {
                blocks: Blocks::new(nodes, &self.top, answers.len()),
                side: self.resolution().side(),
                question,
                places: &places[first..],
                answers,
                place: &place,
                answer: &answer,
            }));
        });
        Ok(())
    }
}

/// A part of a batch, compiled for each level of instructions: bits are counted and shifted by
/// one instruction where there is one. Nothing of it can be rounded differently.
struct Chunk<'a, N, K, P, A, ToPlace, ToAnswer> {
    blocks: Blocks<'a, N>,
    side: u32,
    question: K,
    places: &'a [P],
    answers: &'a mut [A],
    place: &'a ToPlace,
    answer: &'a ToAnswer,
}

impl<N, K, P, A, ToPlace, ToAnswer> WithSimd for Chunk<'_, N, K, P, A, ToPlace, ToAnswer>
where
    N: Nodes,
    K: Question,
    ToPlace: Fn(&P) -> K::Place,
    ToAnswer: Fn(K::Answer) -> A,
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        for (to, from) in self.answers.iter_mut().zip(self.places) {
            let place = (self.place)(from);
            let answer = self.question.answer(&mut self.blocks, self.side, place);
            *to = (self.answer)(answer);
        }
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
