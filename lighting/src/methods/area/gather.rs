//! The step that sums the airlight of many lights.

use glam::Vec3;
use gpu_backend::{Backend, BufferOf, Cpu, Error, Host, Memory};

use super::LightVolumes;
use crate::gather::{Batch, RAYS, check_lengths};
use crate::scene::Medium;
use crate::voxelized::{Detail, State};
use crate::{AirlightEvaluator, Emitter, Interleaving, LightPath, Part, Ray};

/// The rays of a gather of many lights, with the lights.
#[derive(Debug)]
pub struct ManyLights<'a, M: Memory> {
    /// The rays, in the memory of the backend.
    pub rays: &'a M::Buffer<Ray>,
    /// The lights of the voxels, in their order. Since the voxels were made, their intensities
    /// may have changed, but nothing else.
    pub emitters: &'a [Emitter],
    /// The medium that scatters their light.
    pub medium: &'a Medium,
    /// What is read from the voxels.
    pub detail: Detail,
    /// How rays share the lights.
    pub interleaving: Interleaving,
}

/// The step that turns the voxels of many lights and an airlight evaluator `A` into
/// an image.
pub trait GatherMany<A>: Backend {
    /// Adds to the first three components of `radiance[i]` the airlight of ray i from all
    /// lights, in their order; the result is that of one [`Gather`](crate::Gather) for each
    /// light, on the CPU bit for bit. A ray that [shares](ManyLights::interleaving) the lights
    /// takes some of them, weighted.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length, or lights and voxels in
    /// number; nothing is written then.
    fn gather_many(
        &self,
        lights: &ManyLights<'_, Self::Memory>,
        volumes: &LightVolumes<Self::Memory>,
        airlight: &A,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

pub(super) fn check<M: Memory>(
    lights: &ManyLights<'_, M>,
    volumes: &LightVolumes<M>,
    [rays, radiance]: [usize; 2],
) -> Result<(), Error> {
    check_lengths(rays, radiance)?;
    volumes.are_of(lights.emitters)
}

/// Bytes of voxels that are gathered at a time: what the cache of a core holds.
const BLOCK: usize = 1 << 20;

impl<A: AirlightEvaluator> GatherMany<A> for Cpu {
    /// Gathers lights in blocks whose voxels stay in the cache.
    fn gather_many(
        &self,
        lights: &ManyLights<'_, Self::Memory>,
        volumes: &LightVolumes<Self::Memory>,
        airlight: &A,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check(lights, volumes, [lights.rays.len(), radiance.len()])?;
        if lights.medium.scatters_nothing() {
            return Ok(());
        }
        for (run, part) in lights.interleaving.runs(lights.rays.len()) {
            let (rays, sums) = (&lights.rays[run.clone()], &mut radiance[run]);
            gather_part(self, lights, volumes, airlight, (part, rays), sums);
        }
        Ok(())
    }
}

/// The lights that rays of a part take, in blocks of so many.
pub(super) fn blocks(part: Part, lights: usize, block: usize) -> impl Iterator<Item = Vec<usize>> {
    // Memory holds no more lights than a u32 counts.
    let mut numbers = part.numbers(lights as u32).map(|light| light as usize);
    std::iter::from_fn(move || {
        let next: Vec<usize> = numbers.by_ref().take(block.max(1)).collect();
        (!next.is_empty()).then_some(next)
    })
}

/// Adds to `sums` the airlight of `rays` from the lights of a part.
fn gather_part<A: AirlightEvaluator>(
    cpu: &Cpu,
    lights: &ManyLights<'_, Host>,
    volumes: &LightVolumes<Host>,
    airlight: &A,
    (part, rays): (Part, &[Ray]),
    sums: &mut [[f32; 4]],
) {
    let each = 4 * volumes.resolution().words();
    let weight = part.weight();
    for numbers in blocks(part, lights.emitters.len(), BLOCK / each) {
        let sources: Vec<_> = numbers
            .iter()
            .map(|light| (&lights.emitters[*light], volumes.volume(*light)))
            .collect();
        cpu.for_each_chunk(sums, RAYS, |first, chunk| {
            let rays = &rays[first..first + chunk.len()];
            let mut batch = Batch::new(airlight);
            for (emitter, source) in &sources {
                if matches!(source, State::Dark) {
                    continue;
                }
                let (mut numbers, mut paths) = (Vec::new(), Vec::new());
                for (number, ray) in rays.iter().enumerate() {
                    if let Some(path) = LightPath::new(ray, emitter, lights.medium) {
                        numbers.push(number);
                        paths.push(path.off_the_light());
                    }
                }
                let detail = lights.detail;
                detail.lit_parts_of(source, &paths, &mut |index, parts| {
                    batch.path(numbers[index], paths[index]);
                    for part in parts {
                        let share = Vec3::splat(weight * part.visibility);
                        batch.part(part.interval, share, chunk);
                    }
                });
                batch.finish(chunk);
            }
        });
    }
}
