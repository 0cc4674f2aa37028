//! The gather of many lights on a GPU.

use airlight::gpu::PHASE;
use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Part};
use gpu_backend::{Buffer, Error};

use super::gather::check;
use super::{AirlightTurns, GatherMany, LightVolumes, ManyLights};
use crate::Emitter;
use crate::gpu::scene::{EmitterRecord, MediumRecord};
use crate::gpu::{ARC, AirlightSlot, DIRECTIONAL, LIT, NUMERIC, PATH, VisibilitySlot};
use crate::scene::Medium;
use crate::voxelized::gpu::{VOXELS, VoxelRecord};
use crate::voxelized::{Detail, Sampling, State};

/// Invocations per workgroup in `many.wgsl`.
const GROUP: u32 = 64;

/// Turns of loops per invocation, unless one light needs more. Some software drivers end
/// all loops of an invocation after 65,535 turns without a word.
pub(super) const TURNS: u32 = 50_000;

/// Turns of loops for a light without those for its lit parts: kinks, and searches for
/// distances among the borders of voxels.
const TURNS_PER_LIGHT: u32 = 100;

/// `Block` of `block.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct BlockRecord {
    pub(super) medium: MediumRecord,
    pub(super) count: u32,
    pub(super) lights: u32,
    pub(super) first: u32,
    pub(super) weight: f32,
}

/// `Light` of `block.wgsl`.
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

/// Turns of loops for a light with texels of so many bits, at most.
pub(super) fn turns<A: AirlightTurns>(
    bits: u32,
    detail: Detail,
    airlight: &A,
    emitter: &Emitter,
) -> u32 {
    // A voxel may be a run, and a part, of its own.
    let parts = match detail {
        Detail::Average => 1,
        Detail::Voxels | Detail::Runs => bits + 1,
    };
    // A run takes a turn of the loops of runs, of voxels and of lit parts, and the
    // words are read.
    let voxels = TURNS_PER_LIGHT + 4 * (bits + 1);
    voxels.saturating_add(airlight.turns(emitter, parts))
}

/// Divides lights, each with its turns of loops, into blocks that end in time.
pub(super) fn blocks(lights: impl IntoIterator<Item = (usize, u32)>) -> Vec<Vec<usize>> {
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    let mut left = 0;
    for (light, turns) in lights {
        match blocks.last_mut() {
            Some(block) if turns <= left => block.push(light),
            _ => {
                blocks.push(vec![light]);
                left = TURNS;
            }
        }
        left = left.saturating_sub(turns);
    }
    blocks
}

/// What every shader that goes through blocks of lights begins with.
pub(super) fn assembly(entry: &[&'static str]) -> Result<Assembly, Error> {
    let mut sources = vec![
        INDEX_WGSL,
        NUMERIC,
        PHASE,
        PATH,
        ARC,
        DIRECTIONAL,
        LIT,
        include_str!("block.wgsl"),
    ];
    sources.extend_from_slice(entry);
    let mut shader = Assembly::new(&sources);
    let voxels = Part::new("light_voxels")
        .sources(&[epipolar::gpu::EPIPOLAR, epipolar::gpu::PHI])
        .sources(&[voxel_shadow::gpu::SHADOW, VOXELS]);
    shader.fill::<VisibilitySlot>(&voxels)?;
    Ok(shader)
}

/// The shader for an evaluator.
pub(super) fn shader<A: InShader<AirlightSlot>>() -> Result<Assembly, Error> {
    let mut shader = assembly(&[include_str!("many.wgsl")])?;
    shader.fill::<AirlightSlot>(&A::part())?;
    Ok(shader)
}

/// A block of lights with all that it reads but its words.
#[derive(Default)]
pub(super) struct Block {
    pub(super) lights: Vec<Light>,
    pub(super) texels: Vec<[f32; 4]>,
    pub(super) bounds: Vec<[f32; 2]>,
}

impl Block {
    /// Adds the light of a number among `volumes`.
    pub(super) fn add(
        &mut self,
        emitter: &Emitter,
        volumes: &LightVolumes<GpuMemory>,
        index: usize,
        (sampling, detail): (&Sampling, Detail),
    ) {
        let (emitter, texels) = EmitterRecord::new(emitter);
        let (state, tile) = match volumes.state(index) {
            State::Lit => (State::Lit, 0),
            State::Dark => (State::Dark, 0),
            State::Voxels((tile, lattice)) => (State::Voxels(lattice), tile),
        };
        self.lights.push(Light {
            emitter,
            voxels: VoxelRecord::new(state, sampling, detail),
            // What is beyond u32 fits into no buffer of a device.
            first_texel: self.texels.len() as u32,
            first_bound: self.bounds.len() as u32,
            first_word: (tile * volumes.resolution().words()) as u32,
            padding: 0,
        });
        self.texels.extend(texels);
        self.bounds.extend_from_slice(state.bounds());
    }

    /// The same lights for so many rays or points from the first on.
    pub(super) fn record(
        &self,
        medium: &Medium,
        [first, count]: [usize; 2],
        weight: f32,
    ) -> BlockRecord {
        BlockRecord {
            medium: MediumRecord::new(medium),
            // More than that are refused by the dispatch.
            count: count as u32,
            lights: self.lights.len() as u32,
            first: first as u32,
            weight,
        }
    }
}

impl<A, E> GatherMany<A> for Gpu<E>
where
    A: InShader<AirlightSlot> + AirlightTurns,
    E: Encode,
{
    /// Lights are taken a block at a time, in passes whose loops have at most 50,000
    /// turns for a ray. A light that needs more has a pass of its own; above 65,535 turns
    /// some software drivers lose the rest of its light, see [`AirlightTurns`].
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
        let shader = shader::<A>()?.finish(1);
        let constants = airlight.constants();
        let bits = volumes.resolution().bits();
        let runs = lights.interleaving.runs(lights.rays.len());
        let parts = runs.flat_map(|(run, part)| {
            // More lights than that do not fit into memory.
            let own = part.numbers(lights.emitters.len() as u32);
            let lit = own
                .map(|light| light as usize)
                .filter(|light| !matches!(volumes.state(*light), State::Dark));
            let with_turns = lit.map(|light| {
                let emitter = &lights.emitters[light];
                (light, turns(bits, lights.detail, airlight, emitter))
            });
            let all = blocks(with_turns).into_iter();
            all.map(move |numbers| (run.clone(), part, numbers))
        });
        for (run, part, numbers) in parts {
            let mut block = Block::default();
            for light in numbers {
                let read = (&volumes.sampling(), lights.detail);
                block.add(&lights.emitters[light], volumes, light, read);
            }
            let record = block.record(lights.medium, [run.start, run.len()], part.weight());
            self.dispatch(
                &Kernel {
                    label: "gather many lights",
                    parts: &shader,
                    entry: "gather_many",
                    constants: &constants,
                },
                &[
                    &[
                        Argument::uniform(record),
                        Argument::table(&block.lights),
                        Argument::table(&block.texels),
                        Argument::table(&block.bounds),
                        Argument::read(volumes.grid().words()),
                        Argument::read(lights.rays),
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
