//! The light of hair on a backend.

use gpu_backend::Download;
use gpu_backend::gpu::{Encode, Gpu};
use lighting::hair::{AddHairLight, LitHair, SeenHair};
use lighting::methods::exact::{UploadTracerError, UploadedTracer};
use lighting::scene::Geometry;
use lighting::scene::trace::Tracer;

use crate::failure::Failure;

/// What hair alone sends to the eye.
pub(crate) fn light_of<T, B>(
    backend: &B,
    hair: &SeenHair,
    lit: &LitHair<'_, B::Memory, T>,
) -> Result<Vec<[f32; 4]>, Failure>
where
    B: AddHairLight<T> + Download,
{
    let mut radiance = backend.zeros(lit.view.rays().len())?;
    backend.add_hair_light(hair, lit, &mut radiance)?;
    Ok(backend.download(&radiance)?)
}

/// Triangles that a software driver gets: such drivers end the loops of a shadow ray after 65,535
/// turns, and it takes at most three for each triangle.
const MOST_ON_SOFTWARE: usize = 20_000;

/// The triangles of a scene where shaders trace them, or the reason why they are not there.
pub(crate) fn triangles_in_shaders<E: Encode>(
    gpu: &Gpu<E>,
    geometry: &Geometry,
    tracer: &Tracer,
) -> Result<Result<UploadedTracer, &'static str>, Failure> {
    if gpu.context().is_software() && geometry.triangles().len() > MOST_ON_SOFTWARE {
        return Ok(Err(
            "a software driver may end shadow rays through so many triangles",
        ));
    }
    Ok(match UploadedTracer::new(gpu, tracer) {
        Ok(tracer) => Ok(tracer),
        Err(UploadTracerError::NotSolid { .. }) => {
            Err("some triangles are masked or see-through, which its shader does not know")
        }
        Err(UploadTracerError::Backend(gpu_backend::Error::TooLarge { .. })) => {
            Err("the GPU cannot bind so many triangles at once")
        }
        Err(error) => return Err(error.into()),
    })
}
