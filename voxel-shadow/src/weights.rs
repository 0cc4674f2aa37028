//! Weights of the bits of a texel.

use crate::Error;

/// The weight of each voxel along φ in a weighted sum, kept as running sums.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// The sum of the weights of all bits below, one more than there are bits.
    sums: Vec<f32>,
}

impl Weights {
    /// From one weight per bit.
    ///
    /// # Errors
    /// [`Error::BadValue`] if there are none, or if one is negative or not
    /// finite, or their sum is not finite in f32.
    pub fn new(weights: &[f32]) -> Result<Self, Error> {
        let bad = |what, value, expected| Error::BadValue {
            what,
            value,
            expected,
        };
        if weights.is_empty() {
            return Err(bad("the number of weights", 0.0, "at least 1"));
        }
        let mut sum = 0.0_f64;
        let mut sums = vec![0.0];
        for &weight in weights {
            if !(weight >= 0.0 && weight.is_finite()) {
                return Err(bad(
                    "the weight of a bit",
                    f64::from(weight),
                    "at least 0 and finite",
                ));
            }
            sum += f64::from(weight);
            sums.push(sum as f32);
        }
        if sum > f64::from(f32::MAX) {
            return Err(bad("the sum of all weights", sum, "a number within f32"));
        }
        Ok(Self { sums })
    }

    /// The running sums: entry `i` is the weight of all bits below `i`.
    pub fn sums(&self) -> &[f32] {
        &self.sums
    }

    /// The weight of everything before a position, parts of a voxel in
    /// proportion.
    #[inline]
    pub(crate) fn before(&self, position: f32) -> f32 {
        let bits = self.sums.len() - 1;
        let first = (position as usize).min(bits - 1);
        let share = (position - first as f32).clamp(0.0, 1.0);
        self.sums[first] + share * (self.sums[first + 1] - self.sums[first])
    }
}
