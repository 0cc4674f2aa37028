//! The bit grid.

use bitvec::order::Lsb0;
use bitvec::slice::BitSlice;
use bitvec::view::BitView;
use epipolar::Resolution;
use gpu_backend::{Backend, Buffer, Host, Memory};

use crate::Error;
use crate::error::{same_length, too_large};

/// One bit per voxel, 1 where it is in shadow.
///
/// The bits of a texel (all φ of one α and θ) are consecutive words, the lowest
/// bit of a word first; texels of one α are a row, with θ running fastest. A scan
/// along α therefore combines whole rows, and the two texels that an
/// interpolation needs lie side by side.
#[derive(Debug)]
pub struct Grid<M: Memory> {
    resolution: Resolution,
    words: M::Buffer<u32>,
}

impl<M: Memory> Grid<M> {
    /// A grid without shadow.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if it does not fit on the backend, with a resolution that does.
    pub fn new<B: Backend<Memory = M>>(backend: &B, resolution: Resolution) -> Result<Self, Error> {
        let named = too_large("a bit grid", resolution, Resolution::words);
        Ok(Self {
            words: backend.zeros(resolution.words()).map_err(named)?,
            resolution,
        })
    }

    /// A grid from its words.
    ///
    /// # Errors
    /// [`gpu_backend::Error::LengthMismatch`] unless there are
    /// [`Resolution::words`] of them.
    pub fn from_words(resolution: Resolution, words: M::Buffer<u32>) -> Result<Self, Error> {
        same_length("a bit grid", resolution.words(), words.len())?;
        Ok(Self { resolution, words })
    }

    /// How many voxels there are.
    pub fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// All words, in the order of the type's description.
    pub fn words(&self) -> &M::Buffer<u32> {
        &self.words
    }

    pub(crate) fn words_mut(&mut self) -> &mut M::Buffer<u32> {
        &mut self.words
    }
}

impl Grid<Host> {
    /// The words of a texel.
    ///
    /// # Panics
    /// If there is no such texel.
    #[inline]
    pub fn texel(&self, alpha: u32, theta: u32) -> &[u32] {
        let words = self.resolution.words_per_texel();
        assert!(theta < self.resolution.theta(), "no such plane");
        let texel = alpha as usize * self.resolution.theta() as usize + theta as usize;
        &self.words[texel * words..(texel + 1) * words]
    }

    /// The bits of a texel, φ running upwards.
    ///
    /// # Panics
    /// If there is no such texel.
    pub fn bits(&self, alpha: u32, theta: u32) -> &BitSlice<u32, Lsb0> {
        self.texel(alpha, theta).view_bits()
    }

    /// The same grid on another backend.
    ///
    /// # Errors
    /// [`gpu_backend::Error::TooLarge`] if it does not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<Grid<B::Memory>, Error> {
        Ok(Grid {
            resolution: self.resolution,
            words: backend.upload(&self.words)?,
        })
    }
}
