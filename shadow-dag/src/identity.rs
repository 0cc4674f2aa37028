//! What tells one bake from another.

use glam::Vec3;
use gpu_backend::Cpu;

use crate::pool::{SALT, fold};
use crate::{LightSpace, Slices};

/// Positions or triangles whose hashes become one word, so that threads can
/// share the work.
const RUN: usize = 1 << 14;

/// A hash of 64 bits of a sequence of words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Identity(u64);

impl Identity {
    /// Of nothing yet.
    pub(crate) fn new() -> Self {
        Self(SALT[0])
    }

    /// Of the sequence with one more word.
    pub(crate) fn with(self, word: u64) -> Self {
        // The sum keeps a product of zero from erasing what was before.
        Self(fold(self.0 ^ word, SALT[1]).wrapping_add(self.0.rotate_left(32)))
    }

    /// The one with this value.
    pub(crate) fn of_value(value: u64) -> Self {
        Self(value)
    }

    pub(crate) fn value(self) -> u64 {
        self.0
    }

    /// Of triangles.
    pub(crate) fn of_triangles(cpu: &Cpu, positions: &[Vec3], indices: &[[u32; 3]]) -> Self {
        let lengths = [positions.len() as u64, indices.len() as u64];
        let words = |[a, b, c]: [u32; 3]| [u64::from(a) | u64::from(b) << 32, u64::from(c)];
        let runs_of = |count: usize, item: &(dyn Fn(usize) -> [u32; 3] + Sync)| {
            cpu.map(count.div_ceil(RUN), |run| {
                (run * RUN..count.min((run + 1) * RUN))
                    .flat_map(|i| words(item(i)))
                    .fold(Self::new(), Self::with)
                    .value()
            })
        };
        let corners = runs_of(positions.len(), &|i| {
            positions[i].to_array().map(f32::to_bits)
        });
        let triangles = runs_of(indices.len(), &|i| indices[i]);
        let words = lengths.into_iter().chain(corners).chain(triangles);
        words.fold(Self::new(), Self::with)
    }

    /// Of the space of a light.
    pub(crate) fn of_light(light: &LightSpace) -> Self {
        let ends = match light.slices() {
            Slices::Linear => [0.0; 2],
            Slices::Logarithmic(ends) => [ends.near(), ends.far()],
        };
        let numbers = light.matrix().to_cols_array().into_iter().chain(ends);
        numbers.map(f64::to_bits).fold(Self::new(), Self::with)
    }
}
