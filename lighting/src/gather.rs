//! The light along a bundle of rays.

use gpu_backend::{Backend, BufferOf, Cpu, Error};

use crate::scene::Medium;
use crate::{AirlightEvaluator, Emitter, LightPath, Ray, VisibilitySource};

/// The step that turns a visibility source `V` and an airlight evaluator `A`
/// into an image.
///
/// Implemented for the CPU for every pair; a backend with shaders implements
/// it for the sources and evaluators that bring a shader part.
pub trait Gather<V, A>: Backend {
    /// Adds to `radiance[i]` the airlight of `rays[i]` due to one light: the
    /// sum over the lit intervals of the ray of visibility × radiance. The
    /// fourth component is left alone.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if `rays` and `radiance` differ in length;
    /// nothing is written then.
    fn gather(
        &self,
        rays: &BufferOf<Self, Ray>,
        emitter: &Emitter,
        medium: &Medium,
        visibility: &V,
        airlight: &A,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

/// One sum per ray.
pub(crate) fn check_lengths(rays: usize, radiance: usize) -> Result<(), Error> {
    if rays == radiance {
        return Ok(());
    }
    Err(Error::LengthMismatch {
        what: "the radiance buffer",
        expected: rays,
        actual: radiance,
    })
}

impl<V, A> Gather<V, A> for Cpu
where
    V: VisibilitySource,
    A: AirlightEvaluator,
{
    fn gather(
        &self,
        rays: &Vec<Ray>,
        emitter: &Emitter,
        medium: &Medium,
        visibility: &V,
        airlight: &A,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        if medium.scatters_nothing() {
            return Ok(());
        }
        self.for_each_chunk(radiance, 64, |first, chunk| {
            let mut lit = Vec::new();
            for (ray, sum) in rays[first..].iter().zip(chunk) {
                let Some(path) = LightPath::new(ray, emitter, medium) else {
                    continue;
                };
                let path = path.off_the_light();
                lit.clear();
                visibility.lit_intervals(&path, &mut lit);
                for part in &lit {
                    let light = part.visibility * airlight.radiance(&path, part.interval);
                    for channel in 0..3 {
                        sum[channel] += light[channel];
                    }
                }
            }
        });
        Ok(())
    }
}
