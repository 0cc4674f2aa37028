//! Surfaces that many lights light, on a GPU.

use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, GpuMemory, Kernel, Workgroups};
use gpu_backend::shader::Assembly;
use gpu_backend::{Buffer, Error};

use super::LightVolumes;
use super::gpu::{Block, assembly, blocks};
use super::surfaces::{LightManySurfaces, ManyOnSurfaces, check};
use crate::gpu::{ARRIVING, SURFACE_POINT};
use crate::voxelized::Detail;

/// Invocations per workgroup in `surfaces.wgsl`.
const GROUP: u32 = 64;

/// Turns of loops for a light, at most: the search for a position among up to 1024 bits
/// of φ.
pub(super) const TURNS_PER_LIGHT: u32 = 16;

pub(super) fn shader() -> Result<Assembly, Error> {
    assembly(&[SURFACE_POINT, ARRIVING, include_str!("surfaces.wgsl")])
}

impl<E: Encode> LightManySurfaces for Gpu<E> {
    /// Lights are taken a block at a time, in passes whose loops end before some software
    /// drivers would end them.
    fn light_many_surfaces(
        &self,
        lit: &ManyOnSurfaces<'_, GpuMemory>,
        volumes: &LightVolumes<GpuMemory>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        let count = lit.points.len();
        check(lit, volumes, [count, radiance.len()])?;
        let shader = shader()?.finish(1);
        let sampling = lit.lookup.sampling();
        let lights = (0..lit.emitters.len()).map(|light| (light, TURNS_PER_LIGHT));
        for numbers in blocks(lights) {
            let mut block = Block::default();
            for light in numbers {
                let emitter = &lit.emitters[light];
                block.add(emitter, volumes, light, (&sampling, Detail::Runs));
            }
            self.dispatch(
                &Kernel {
                    label: "surfaces of many lights",
                    parts: &shader,
                    entry: "light_surfaces",
                    constants: &[],
                },
                &[&[
                    Argument::uniform(block.record(lit.medium, [0, count], 1.0)),
                    Argument::table(&block.lights),
                    Argument::table(&block.texels),
                    Argument::table(&block.bounds),
                    Argument::read(volumes.grid().words()),
                    Argument::read(lit.points),
                    Argument::write(radiance),
                ]],
                Workgroups::covering(count, GROUP),
            )?;
        }
        Ok(())
    }
}
