//! The step that makes a picture of the samples of lines.

use gpu_backend::{Backend, BufferOf, Cpu, Error};

use super::choice::{Choice, Mixture, NONE};
use crate::gather::check_lengths;

/// A backend that makes a picture of the samples of lines: every backend of this
/// workspace.
pub trait FillFromLines: Backend {
    /// Adds to `radiance[i]` what `mixtures[i]` makes of `gathered`. The fourth
    /// component is left alone.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if there are not as many mixtures as pixels, or not as
    /// many gathered as rays of the choice; nothing is written then.
    fn fill_from_lines(
        &self,
        choice: &Choice,
        gathered: &BufferOf<Self, [f32; 4]>,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

pub(super) fn check(choice: &Choice, gathered: usize, radiance: usize) -> Result<(), Error> {
    if gathered != choice.rays.len() {
        return Err(Error::LengthMismatch {
            what: "the light of the rays of a choice",
            expected: choice.rays.len(),
            actual: gathered,
        });
    }
    check_lengths(choice.mixtures.len(), radiance)
}

fn between(a: [f32; 4], b: [f32; 4], share: f32) -> [f32; 4] {
    std::array::from_fn(|i| (1.0 - share) * a[i] + share * b[i])
}

impl Mixture {
    fn light(&self, gathered: &[[f32; 4]]) -> [f32; 4] {
        let line = |i: usize| {
            let first = self.samples[i] as usize;
            match self.along[i] {
                0.0 => gathered[first],
                along => between(gathered[first], gathered[first + 1], along),
            }
        };
        match self.across {
            0.0 => line(0),
            across => between(line(0), line(1), across),
        }
    }
}

impl FillFromLines for Cpu {
    fn fill_from_lines(
        &self,
        choice: &Choice,
        gathered: &Vec<[f32; 4]>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check(choice, gathered.len(), radiance.len())?;
        self.for_each_chunk(radiance, 256, |first, chunk| {
            for (mixture, sum) in choice.mixtures[first..].iter().zip(chunk) {
                if mixture.samples[0] == NONE {
                    continue;
                }
                let light = mixture.light(gathered);
                for (sum, light) in sum.iter_mut().zip(light).take(3) {
                    *sum += light;
                }
            }
        });
        Ok(())
    }
}
