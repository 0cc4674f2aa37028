//! The gather of many lights on a GPU.

use airlight::gpu::PHASE;
use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Part};
use gpu_backend::{Buffer, Error};

use super::gather::{blocks, check};
use super::{GatherMany, LightVolumes, ManyLights};
use crate::gpu::scene::{EmitterRecord, MediumRecord};
use crate::gpu::{ARC, AirlightSlot, DIRECTIONAL, LIT, NUMERIC, PATH, VisibilitySlot};
use crate::voxelized::gpu::{VOXELS, VoxelRecord};
use crate::voxelized::{Detail, State};

/// Invocations per workgroup in `many.wgsl`.
const GROUP: u32 = 64;

/// Turns of loops per invocation, at most. Some software drivers end all loops of an
/// invocation after 65,535 turns without a word.
const TURNS: u32 = 50_000;

/// Turns of loops for a lit part: the nodes of an evaluator (at most 64), and the
/// search for where the part begins and ends.
const TURNS_PER_PART: u32 = 80;

/// `Many` of `many.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Many {
    pub(super) medium: MediumRecord,
    pub(super) rays: u32,
    pub(super) lights: u32,
    pub(super) first: u32,
    pub(super) weight: f32,
}

/// `Light` of `many.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Light {
    pub(super) emitter: EmitterRecord,
    pub(super) voxels: VoxelRecord,
    pub(super) first_texel: u32,
    pub(super) first_bound: u32,
    pub(super) first_word: u32,
    pub(super) padding: u32,
}

/// How many lights an invocation goes through, for texels of so many bits.
pub(super) fn block(bits: u32, detail: Detail) -> usize {
    let parts = match detail {
        // The runs are counted and not evaluated; the shorter loops are as many as
        // a few parts'.
        Detail::Average => 8 + bits / TURNS_PER_PART,
        Detail::Voxels => bits + 1,
        Detail::Runs => bits / 2 + 1,
    };
    (TURNS / (parts * TURNS_PER_PART)).max(1) as usize
}

/// The shader for an evaluator.
pub(super) fn shader<A: InShader<AirlightSlot>>() -> Result<Assembly, Error> {
    let mut shader = Assembly::new(&[
        INDEX_WGSL,
        NUMERIC,
        PHASE,
        PATH,
        ARC,
        DIRECTIONAL,
        LIT,
        include_str!("many.wgsl"),
    ]);
    let voxels = Part::new("light_voxels")
        .sources(&[epipolar::gpu::EPIPOLAR, epipolar::gpu::PHI])
        .sources(&[voxel_shadow::gpu::SHADOW, VOXELS]);
    shader.fill::<VisibilitySlot>(&voxels)?;
    shader.fill::<AirlightSlot>(&A::part())?;
    Ok(shader)
}

/// A block of lights with all that it reads but its words.
#[derive(Default)]
struct Block {
    lights: Vec<Light>,
    texels: Vec<[f32; 4]>,
    bounds: Vec<[f32; 2]>,
}

impl Block {
    fn add(
        &mut self,
        lights: &ManyLights<'_, GpuMemory>,
        volumes: &LightVolumes<GpuMemory>,
        index: usize,
    ) {
        let (emitter, texels) = EmitterRecord::new(&lights.emitters[index]);
        let (state, tile) = match volumes.state(index) {
            State::Lit => (State::Lit, 0),
            State::Dark => return,
            State::Voxels((tile, lattice)) => (State::Voxels(lattice), tile),
        };
        self.lights.push(Light {
            emitter,
            voxels: VoxelRecord::new(state, &volumes.sampling(), lights.detail),
            // What is beyond u32 fits into no buffer of a device.
            first_texel: self.texels.len() as u32,
            first_bound: self.bounds.len() as u32,
            first_word: (tile * volumes.resolution().words()) as u32,
            padding: 0,
        });
        self.texels.extend(texels);
        self.bounds.extend_from_slice(state.bounds());
    }
}

impl<A: InShader<AirlightSlot>, E: Encode> GatherMany<A> for Gpu<E> {
    /// Lights are taken a block at a time, in passes whose loops end in time.
    fn gather_many(
        &self,
        lights: &ManyLights<'_, GpuMemory>,
        volumes: &LightVolumes<GpuMemory>,
        airlight: &A,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check(lights, volumes, [lights.rays.len(), radiance.len()])?;
        if lights.medium.scatters_nothing() {
            return Ok(());
        }
        let most = block(volumes.resolution().bits(), lights.detail);
        let parts = lights
            .interleaving
            .runs(lights.rays.len())
            .flat_map(|(run, part)| {
                let all = blocks(part, lights.emitters.len(), most);
                all.map(move |numbers| (run.clone(), part, numbers))
            });
        for (run, part, numbers) in parts {
            let mut block = Block::default();
            for light in numbers {
                block.add(lights, volumes, light);
            }
            if block.lights.is_empty() {
                continue;
            }
            let many = Many {
                medium: MediumRecord::new(lights.medium),
                // More rays than that are refused by the dispatch.
                rays: run.len() as u32,
                lights: block.lights.len() as u32,
                first: run.start as u32,
                weight: part.weight(),
            };
            self.dispatch(
                &Kernel {
                    label: "gather many lights",
                    parts: &shader::<A>()?.finish(1),
                    entry: "gather_many",
                    constants: &airlight.constants(),
                },
                &[
                    &[
                        Argument::uniform(many),
                        Argument::read(lights.rays),
                        Argument::table(&block.lights),
                        Argument::table(&block.texels),
                        Argument::table(&block.bounds),
                        Argument::read(volumes.grid().words()),
                        Argument::write(radiance),
                    ],
                    &airlight.arguments(),
                ],
                Workgroups::covering(run.len(), GROUP),
            )?;
        }
        Ok(())
    }
}
