//! How many voxels there are.

use crate::Error;

/// The largest number of words of a grid: 4 GiB.
const MAX_WORDS: u64 = 1 << 30;

/// The largest number of texels along α or θ.
const MAX_SIDE: u32 = 1 << 14;

/// The number of voxels along each coordinate.
///
/// For the shadow volume of one light in a picture of full size, begin with 512 × 512 × 256,
/// which are 8 MiB. Details that are thinner than a voxel get lost, so a large scene or a fine
/// fence needs more. Of a sun over a city, shadow maps as fine as the voxels, 128³ voxels gave
/// the light in the air with an error of 4 % (RMSE over the mean), 256³ with 2.5 % and 512³ with
/// 1.4 %. The quality is that of the coarsest of the three numbers and of the shadow map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Resolution {
    alpha: u32,
    theta: u32,
    bits: u32,
}

impl Resolution {
    /// `alpha` × `theta` texels of `bits` bits along φ each. The page of the type says which
    /// numbers to begin with.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless `bits` is a multiple of 32 from 32 to 1024,
    /// the other two are 1 to 16384, and all bits take at most 4 GiB.
    pub fn new(alpha: u32, theta: u32, bits: u32) -> Result<Self, Error> {
        for (what, value) in [("texels along alpha", alpha), ("texels along theta", theta)] {
            if !(1..=MAX_SIDE).contains(&value) {
                return Err(Error::bad_value(what, value, "1 to 16384"));
            }
        }
        if !bits.is_multiple_of(32) || !(32..=1024).contains(&bits) {
            return Err(Error::bad_value(
                "bits per texel",
                bits,
                "a multiple of 32 from 32 to 1024",
            ));
        }
        let words = u64::from(alpha) * u64::from(theta) * u64::from(bits / 32);
        if words > MAX_WORDS {
            return Err(Error::bad_value(
                "words of a grid",
                words as f64,
                "at most 2^30, which is 4 GiB",
            ));
        }
        Ok(Self { alpha, theta, bits })
    }

    /// Texels along α.
    pub fn alpha(&self) -> u32 {
        self.alpha
    }

    /// Texels along θ.
    pub fn theta(&self) -> u32 {
        self.theta
    }

    /// Bits per texel, along φ.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// Words of 32 bits per texel.
    pub fn words_per_texel(&self) -> usize {
        (self.bits / 32) as usize
    }

    /// Words per row: all texels of one α.
    pub fn words_per_row(&self) -> usize {
        self.theta as usize * self.words_per_texel()
    }

    /// Words of all voxels.
    pub fn words(&self) -> usize {
        self.alpha as usize * self.words_per_row()
    }

    /// Light rays: pairs (θ, φ).
    pub fn light_rays(&self) -> usize {
        self.theta as usize * self.bits as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_do_not_fit_are_turned_away() {
        for (alpha, theta, bits) in [
            (0, 1, 32),
            (1, 0, 32),
            (1, 1, 0),
            (1, 1, 33),
            (1, 1, 1056),
            (16385, 1, 32),
            (1, u32::MAX, 32),
            (16384, 16384, 1024),
        ] {
            assert!(Resolution::new(alpha, theta, bits).is_err());
        }
        let resolution = Resolution::new(512, 256, 128).unwrap();
        assert_eq!(resolution.words(), 512 * 256 * 4);
        assert_eq!(resolution.light_rays(), 256 * 128);
        assert!(Resolution::new(16384, 16384, 128).is_ok());
    }
}
