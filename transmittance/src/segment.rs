//! Blockers as a light ray meets them.

use crate::Error;

/// The optical depth that stands for an opaque blocker. Its transmittance is 0
/// in f32 (as it is from 104 on), and 1e8 of them still have a finite sum.
pub(crate) const OPAQUE: f32 = 1e30;

/// A stretch of a light ray that takes light away at a constant rate, in each
/// of `C` colour channels.
///
/// With the optical depth `τ` of the whole stretch from `a` to `b`, the share of
/// the light that gets as far as depth `z` is
///
/// ```text
/// T(z) = exp(−τ (z − a) / (b − a))     clamped to [a, b]
/// ```
///
/// (Beer–Lambert). Where `a = b` it is a *surface*: 1 for `z ≤ a` and `exp(−τ)`
/// for `z > a`; a surface does not shadow itself.
///
/// Depths are in any unit, along the ray or along the light's axis, as long as
/// it is the same for all blockers and receivers of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockerSegment<const C: usize = 1> {
    entry: f32,
    exit: f32,
    optical_depth: [f32; C],
}

impl BlockerSegment {
    /// A stretch through which the share `transmittance` of the light passes.
    ///
    /// 0 is opaque, whatever the length: nothing passes beyond `entry`.
    ///
    /// # Errors
    /// [`Error::BadSegment`] unless the depths are finite, `entry ≤ exit`, and
    /// `0 ≤ transmittance ≤ 1`.
    pub fn from_transmittance(entry: f32, exit: f32, transmittance: f32) -> Result<Self, Error> {
        BlockerSegment::with_transmittances(entry, exit, [transmittance])
    }

    /// A stretch of extinction `sigma_t` per unit of depth: optical depth
    /// `sigma_t (exit − entry)`.
    ///
    /// # Errors
    /// [`Error::BadSegment`] unless the depths are finite, `entry ≤ exit`, and
    /// `sigma_t` is at least 0 and not NaN.
    pub fn from_density(entry: f32, exit: f32, sigma_t: f32) -> Result<Self, Error> {
        BlockerSegment::with_densities(entry, exit, [sigma_t])
    }

    /// A stretch of optical depth `optical_depth`, infinity included.
    ///
    /// # Errors
    /// [`Error::BadSegment`] unless the depths are finite, `entry ≤ exit`, and
    /// the optical depth is at least 0 and not NaN.
    pub fn from_optical_depth(entry: f32, exit: f32, optical_depth: f32) -> Result<Self, Error> {
        BlockerSegment::with_optical_depths(entry, exit, [optical_depth])
    }

    /// A surface that lets the share `transmittance` pass.
    ///
    /// # Errors
    /// [`Error::BadSegment`] unless the depth is finite and
    /// `0 ≤ transmittance ≤ 1`.
    pub fn surface(depth: f32, transmittance: f32) -> Result<Self, Error> {
        Self::from_transmittance(depth, depth, transmittance)
    }
}

impl<const C: usize> BlockerSegment<C> {
    /// [`BlockerSegment::from_transmittance`], one number per channel. A stretch that
    /// is opaque in one channel is taken together to its entry in all of them.
    ///
    /// # Errors
    /// As there.
    pub fn with_transmittances(
        entry: f32,
        exit: f32,
        transmittance: [f32; C],
    ) -> Result<Self, Error> {
        for value in transmittance {
            if !(0.0..=1.0).contains(&value) {
                return Err(Error::BadSegment {
                    entry,
                    exit,
                    what: "the transmittance",
                    value,
                    expected: "a number from 0 to 1",
                });
            }
        }
        // The optical depth of a transmittance of 1 is -0 without the sum.
        let optical_depth = transmittance.map(|value| 0.0 - value.ln());
        Self::with_optical_depths(entry, exit, optical_depth)
    }

    /// [`BlockerSegment::from_density`], one number per channel.
    ///
    /// # Errors
    /// As there.
    pub fn with_densities(entry: f32, exit: f32, sigma_t: [f32; C]) -> Result<Self, Error> {
        for value in sigma_t {
            if !(value >= 0.0) {
                return Err(Error::BadSegment {
                    entry,
                    exit,
                    what: "the density",
                    value,
                    expected: "a number of at least 0",
                });
            }
        }
        // In f64 the length of a segment can neither overflow nor be lost.
        let length = f64::from(exit) - f64::from(entry);
        let optical_depth = sigma_t.map(|value| {
            if length > 0.0 {
                (f64::from(value) * length) as f32
            } else {
                0.0
            }
        });
        Self::with_optical_depths(entry, exit, optical_depth)
    }

    /// [`BlockerSegment::from_optical_depth`], one number per channel. Optical depths
    /// of 1e30 and more are opaque; a stretch that is opaque in one channel is
    /// taken together to its entry in all of them.
    ///
    /// # Errors
    /// As there.
    pub fn with_optical_depths(
        entry: f32,
        exit: f32,
        optical_depth: [f32; C],
    ) -> Result<Self, Error> {
        let bad = |what, value, expected| Error::BadSegment {
            entry,
            exit,
            what,
            value,
            expected,
        };
        if !entry.is_finite() {
            return Err(bad("the entry", entry, "a finite depth"));
        }
        if !exit.is_finite() {
            return Err(bad("the exit", exit, "a finite depth"));
        }
        if entry > exit {
            return Err(bad("the exit", exit, "a depth not in front of the entry"));
        }
        for value in optical_depth {
            if !(value >= 0.0) {
                let expected = "a number of at least 0";
                return Err(bad("the optical depth", value, expected));
            }
        }
        let opaque = optical_depth.iter().any(|&value| value >= OPAQUE);
        Ok(Self {
            entry,
            exit: if opaque { entry } else { exit },
            optical_depth: optical_depth.map(|value| value.min(OPAQUE)),
        })
    }

    /// Nothing passes beyond `depth`, in any channel.
    ///
    /// # Errors
    /// [`Error::BadSegment`] unless the depth is finite.
    pub fn opaque(depth: f32) -> Result<Self, Error> {
        Self::with_optical_depths(depth, depth, [OPAQUE; C])
    }

    /// Depth at which the stretch starts.
    pub fn entry(&self) -> f32 {
        self.entry
    }

    /// Depth at which it ends; [`BlockerSegment::entry`] for a surface.
    pub fn exit(&self) -> f32 {
        self.exit
    }

    /// Optical depth of the whole stretch per channel; 1e30 is opaque.
    pub fn optical_depth(&self) -> [f32; C] {
        self.optical_depth
    }

    /// True if it takes no light at all.
    pub fn is_clear(&self) -> bool {
        self.optical_depth.iter().all(|&value| value == 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_input_is_an_error_that_names_the_segment() {
        let nan = f32::NAN;
        for (segment, words) in [
            (BlockerSegment::from_density(nan, 1.0, 1.0), "the entry"),
            (
                BlockerSegment::from_density(0.0, f32::INFINITY, 1.0),
                "the exit",
            ),
            (BlockerSegment::from_density(2.0, 1.0, 1.0), "from 2 to 1"),
            (BlockerSegment::from_density(0.0, 1.0, -0.5), "is -0.5"),
            (BlockerSegment::from_density(0.0, 1.0, nan), "the density"),
            (BlockerSegment::from_transmittance(0.0, 1.0, 1.5), "is 1.5"),
            (BlockerSegment::from_transmittance(0.0, 1.0, nan), "is NaN"),
            (BlockerSegment::from_optical_depth(0.0, 1.0, -1.0), "is -1"),
            (BlockerSegment::surface(nan, 0.5), "NaN to NaN"),
            (BlockerSegment::opaque(f32::NEG_INFINITY), "-inf"),
        ] {
            let message = segment.unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }

    #[test]
    fn whatever_lets_nothing_pass_is_opaque_from_its_entry_on() -> Result<(), Error> {
        for segment in [
            BlockerSegment::opaque(3.0)?,
            BlockerSegment::surface(3.0, 0.0)?,
            BlockerSegment::from_transmittance(3.0, 4.0, 0.0)?,
            BlockerSegment::from_density(3.0, 4.0, f32::INFINITY)?,
            BlockerSegment::from_optical_depth(3.0, 4.0, f32::MAX)?,
        ] {
            assert_eq!((segment.entry(), segment.exit()), (3.0, 3.0));
            assert_eq!(segment.optical_depth(), [OPAQUE]);
        }
        Ok(())
    }

    #[test]
    fn the_three_ways_to_say_how_much_agree() -> Result<(), Error> {
        let thickness = BlockerSegment::from_optical_depth(1.0, 3.0, 0.5)?;
        assert_eq!(BlockerSegment::from_density(1.0, 3.0, 0.25)?, thickness);
        let passed = BlockerSegment::from_transmittance(1.0, 3.0, (-0.5_f32).exp())?;
        assert!((passed.optical_depth()[0] - 0.5).abs() < 1e-7);
        assert!(BlockerSegment::surface(1.0, 1.0)?.is_clear());
        assert!(BlockerSegment::from_density(1.0, 1.0, f32::MAX)?.is_clear());
        Ok(())
    }
}
