//! Batches of segments as a step on a backend.

use gpu_backend::{Backend, Buffer, BufferOf, Cpu, Error};

use crate::{Evaluator, Segment};

/// Segments that are evaluated as one unit of work.
const CHUNK: usize = 1024;

/// The step that evaluates a buffer of segments with the evaluator `E`.
///
/// Implemented for the CPU for every [`Evaluator`]; a GPU implements it for
/// those that bring their part of a shader.
pub trait EvaluateAirlight<E>: Backend {
    /// Sets `airlight[i]` to the airlight of `segments[i]` per unit of `σ_s I`
    /// for extinction `sigma_t`, 1/m; one call per channel of a coloured
    /// medium.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the buffers differ in length; nothing is
    /// written then.
    fn evaluate_airlight(
        &self,
        evaluator: &E,
        sigma_t: f32,
        segments: &BufferOf<Self, Segment>,
        airlight: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;
}

impl<E: Evaluator> EvaluateAirlight<E> for Cpu {
    fn evaluate_airlight(
        &self,
        evaluator: &E,
        sigma_t: f32,
        segments: &Vec<Segment>,
        airlight: &mut Vec<f32>,
    ) -> Result<(), Error> {
        check_lengths(segments, airlight)?;
        self.for_each_chunk(airlight, CHUNK, |first, chunk| {
            let segments = &segments[first..first + chunk.len()];
            evaluator.airlight_batch(sigma_t, segments, chunk);
        });
        Ok(())
    }
}

pub(crate) fn check_lengths(
    segments: &impl Buffer<Segment>,
    airlight: &impl Buffer<f32>,
) -> Result<(), Error> {
    if segments.len() == airlight.len() {
        return Ok(());
    }
    Err(Error::LengthMismatch {
        what: "the buffer of results",
        expected: segments.len(),
        actual: airlight.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Exact, PhaseFunction};

    #[test]
    fn a_step_is_its_evaluator_on_any_number_of_threads() {
        let evaluator = Exact::new(PhaseFunction::Rayleigh).unwrap();
        let segments: Vec<Segment> = (0..3000)
            .map(|i| Segment {
                x: 0.0,
                s: 0.01 * i as f32 - 15.0,
                h: 0.5,
                length: 3.0,
            })
            .collect();
        let expected: Vec<f32> = segments
            .iter()
            .map(|segment| Evaluator::airlight(&evaluator, 0.2, segment))
            .collect();
        for cpu in [Cpu::single_threaded(), Cpu::new()] {
            let mut airlight = vec![0.0; segments.len()];
            cpu.evaluate_airlight(&evaluator, 0.2, &segments, &mut airlight)
                .unwrap();
            assert_eq!(airlight, expected);
            let mut short = vec![7.0; 2];
            let error = cpu.evaluate_airlight(&evaluator, 0.2, &segments, &mut short);
            assert!(matches!(error, Err(Error::LengthMismatch { .. })));
            assert_eq!(short, [7.0; 2]);
        }
    }
}
