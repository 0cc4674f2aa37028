//! What tells one bake from another.

use glam::Vec3;

use crate::pool::{SALT, fold};
use crate::{LightSpace, Slices};

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

    pub(crate) fn value(self) -> u64 {
        self.0
    }

    /// Of triangles in the space of a light.
    pub(crate) fn of_triangles(
        light: &LightSpace,
        positions: &[Vec3],
        indices: &[[u32; 3]],
    ) -> Self {
        let lengths = [positions.len() as u64, indices.len() as u64];
        let corners = positions.iter().flat_map(|position| {
            let [x, y, z] = position.to_array().map(f32::to_bits);
            [u64::from(x) | u64::from(y) << 32, u64::from(z)]
        });
        let triangles = indices
            .iter()
            .flat_map(|&[a, b, c]| [u64::from(a) | u64::from(b) << 32, u64::from(c)]);
        let words = lengths.into_iter().chain(corners).chain(triangles);
        words.fold(Self::of_light(light), Self::with)
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
