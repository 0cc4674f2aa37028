//! The step that assembles and runs the shader of a pair.

use airlight::gpu::PHASE;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Assembly;
use gpu_backend::{Buffer, Error};

use super::scene::{EmitterRecord, MediumRecord, Scene};
use super::{ARC, AirlightSlot, DIRECTIONAL, LIT, LIT_PARTS, NUMERIC, PANES, PATH, VisibilitySlot};
use crate::gather::check_lengths;
use crate::{Gather, LitRays, Touching};

/// Invocations per workgroup in `gather.wgsl`.
const GROUP: u32 = 64;

/// Stands for the place of panes where there are none.
const NO_PANES: u32 = u32::MAX;

/// The bind group of all parts.
const PARTS: u32 = 1;

/// What a gather by the entry points of `sources` begins with, whatever its slots.
pub(crate) fn assembly(sources: &[&'static str]) -> Assembly {
    let shared = [INDEX_WGSL, NUMERIC, PHASE, PATH, ARC, DIRECTIONAL, LIT];
    Assembly::new(&[&shared, sources].concat())
}

/// The shader of a pair.
pub(super) fn shader<V, A>() -> Result<Assembly, Error>
where
    V: InShader<VisibilitySlot>,
    A: InShader<AirlightSlot>,
{
    let mut shader = assembly(&[PANES, LIT_PARTS, include_str!("gather.wgsl")]);
    shader.fill::<VisibilitySlot>(&V::part())?;
    shader.fill::<AirlightSlot>(&A::part())?;
    Ok(shader)
}

impl<V, A, E> Gather<V, A> for Gpu<E>
where
    V: InShader<VisibilitySlot>,
    A: InShader<AirlightSlot>,
    E: Encode,
{
    fn gather(
        &self,
        lit: &LitRays<'_, GpuMemory>,
        visibility: &V,
        airlight: &A,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(lit.rays.len(), radiance.len())?;
        if lit.medium.scatters_nothing() {
            return Ok(());
        }
        let (light, cookie) = EmitterRecord::new(lit.emitter);
        let mut table: Vec<_> = cookie.iter().map(|texel| texel.map(f32::to_bits)).collect();
        let mut panes = NO_PANES;
        if let Some(all) = lit.panes {
            // A table with more is refused.
            panes = table.len() as u32;
            all.write(lit.first, lit.rays.len(), &mut table);
        }
        let scene = Scene {
            emitter: light,
            medium: MediumRecord::new(lit.medium),
            // More rays than that are refused by the dispatch.
            rays: lit.rays.len() as u32,
            first: lit.first,
            joined: u32::from(lit.touching == Touching::Joined),
            panes,
        };
        let mut arguments = visibility.arguments();
        arguments.extend(airlight.arguments());
        self.dispatch(
            &Kernel {
                label: "gather",
                parts: &shader::<V, A>()?.finish(PARTS),
                entry: "gather",
                constants: &[visibility.constants(), airlight.constants()].concat(),
            },
            &[
                &[
                    Argument::uniform(scene),
                    Argument::read(lit.rays),
                    Argument::table(&table),
                    Argument::write(radiance),
                ],
                &arguments,
            ],
            Workgroups::covering(lit.rays.len(), GROUP),
        )
    }
}
