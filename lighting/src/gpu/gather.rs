//! The step that assembles and runs the shader of a pair.

use airlight::gpu::PHASE;
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Buffer, Error};

use super::scene::{EmitterRecord, MediumRecord, Scene};
use super::{ARC, DIRECTIONAL, LIT, NUMERIC, PATH, WgslAirlight, WgslVisibility};
use crate::gather::check_lengths;
use crate::scene::Medium;
use crate::{Emitter, Gather, Ray};

/// Invocations per workgroup in `gather.wgsl`.
const GROUP: u32 = 64;

/// All parts of the shader of a pair.
pub(super) fn parts<V: WgslVisibility, A: WgslAirlight>() -> Vec<&'static str> {
    let shared = [INDEX_WGSL, NUMERIC, PHASE, PATH, ARC, DIRECTIONAL, LIT];
    let entry = [include_str!("gather.wgsl")];
    [&shared, V::parts(), A::parts(), &entry].concat()
}

impl<V, A, E> Gather<V, A> for Gpu<E>
where
    V: WgslVisibility,
    A: WgslAirlight,
    E: Encode,
{
    fn gather(
        &self,
        rays: &GpuBuffer<Ray>,
        emitter: &Emitter,
        medium: &Medium,
        visibility: &V,
        airlight: &A,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        if medium.scatters_nothing() {
            return Ok(());
        }
        let (light, slide) = EmitterRecord::new(emitter);
        let scene = Scene {
            emitter: light,
            medium: MediumRecord::new(medium),
            // More rays than that are refused by the dispatch.
            rays: rays.len() as u32,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        };
        let constants = [visibility.constants(), airlight.constants()].concat();
        self.dispatch(
            &Kernel {
                label: "gather",
                parts: &parts::<V, A>(),
                entry: "gather",
                constants: &constants,
            },
            &[
                &[
                    Argument::uniform(scene),
                    Argument::read(rays),
                    Argument::table(&slide),
                    Argument::write(radiance),
                ],
                &visibility.arguments(),
                &airlight.arguments(),
            ],
            Workgroups::covering(rays.len(), GROUP),
        )
    }
}
