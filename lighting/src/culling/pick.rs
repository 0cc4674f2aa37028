//! Copies of some pixels of a picture, in a buffer of their own.

use gpu_backend::{Backend, BufferOf, Cpu, Error};

/// A backend that takes pixels out of a picture and puts them back. Every backend of this
/// workspace does.
pub trait PickPixels: Backend {
    /// The pixels of a picture with the indices `which`, in their order; black for an index
    /// beyond the picture.
    ///
    /// # Errors
    /// Those of [`Backend::zeros`].
    fn pick(
        &self,
        picture: &BufferOf<Self, [f32; 4]>,
        which: &BufferOf<Self, u32>,
    ) -> Result<BufferOf<Self, [f32; 4]>, Error>;

    /// Writes `pixels[i]` to `picture[which[i]]`; indices beyond the picture are ignored. No
    /// index may occur twice.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if there are not as many pixels as indices; nothing is written
    /// then.
    fn put_back(
        &self,
        pixels: &BufferOf<Self, [f32; 4]>,
        which: &BufferOf<Self, u32>,
        picture: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

pub(super) fn check(pixels: usize, which: usize) -> Result<(), Error> {
    if pixels == which {
        return Ok(());
    }
    Err(Error::LengthMismatch {
        what: "the pixels that are put back",
        expected: which,
        actual: pixels,
    })
}

impl PickPixels for Cpu {
    fn pick(&self, picture: &Vec<[f32; 4]>, which: &Vec<u32>) -> Result<Vec<[f32; 4]>, Error> {
        let pixel = |i: &u32| picture.get(*i as usize).copied().unwrap_or_default();
        Ok(which.iter().map(pixel).collect())
    }

    fn put_back(
        &self,
        pixels: &Vec<[f32; 4]>,
        which: &Vec<u32>,
        picture: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check(pixels.len(), which.len())?;
        for (pixel, i) in pixels.iter().zip(which) {
            if let Some(place) = picture.get_mut(*i as usize) {
                *place = *pixel;
            }
        }
        Ok(())
    }
}
