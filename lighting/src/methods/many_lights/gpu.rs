//! Many lights in one dispatch.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, GpuMemory, InShader, Kernel, Workgroups};
use gpu_backend::shader::{Assembly, Part, Slot};
use gpu_backend::{Backend, Buffer, Error};

use super::{GatherMany, LitByMany, check};
use crate::Emitter;
use crate::Touching;
use crate::culling::TileLights;
use crate::gpu::scene::{EmitterRecord, MediumRecord};
use crate::gpu::{AirlightSlot, LIT_PARTS, VisibilitySlot, assembly};
use crate::visibility::Unshadowed;

/// The slot for the question: *which parts of this ray see this one of many lights?* A part
/// defines the same functions as one in the [`VisibilitySlot`], for the light whose index is
/// `light_number()`.
#[derive(Debug, Clone, Copy)]
pub struct ManyVisibilitySlot;

impl Slot for ManyVisibilitySlot {
    fn glue(part: &str) -> String {
        VisibilitySlot::glue(part)
    }
}

impl InShader<ManyVisibilitySlot> for Unshadowed {
    fn part() -> Part {
        <Self as InShader<VisibilitySlot>>::part()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        <Self as InShader<VisibilitySlot>>::arguments(self)
    }
}

/// `Scene` of `gather.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) medium: MediumRecord,
    pub(super) rays: u32,
    pub(super) tiles: u32,
    pub(super) joined: u32,
    pub(super) first: u32,
    pub(super) entry: u32,
    pub(super) most: u32,
    pub(super) cookies: u32,
    pub(super) padding: u32,
}

/// `ManyLight` of `lights.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct ManyLight {
    pub(super) emitter: EmitterRecord,
    pub(super) cookie: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
    pub(super) padding_c: u32,
}

/// A table of many lights.
pub(crate) const LIGHTS: &str = include_str!("lights.wgsl");

/// The index at which the texels of cookies begin in the [`table`] of so many lights.
pub(crate) fn first_texel(lights: usize) -> u32 {
    // A table with a larger index does not fit into a binding, and is refused.
    (lights * (size_of::<ManyLight>() / 16)) as u32
}

/// Invocations per workgroup in `gather.wgsl`.
const GROUP: u32 = 64;

/// The bind group of all parts.
const PARTS: u32 = 1;

/// Storage buffers of the entry point.
#[cfg(test)]
pub(super) const STORAGE: usize = 4;

/// The shader of a pair.
pub(super) fn shader<V, A>() -> Result<Assembly, Error>
where
    V: InShader<ManyVisibilitySlot>,
    A: InShader<AirlightSlot>,
{
    let mut shader = assembly(&[LIGHTS, LIT_PARTS, include_str!("gather.wgsl")]);
    shader.fill::<ManyVisibilitySlot>(&V::part())?;
    shader.fill::<AirlightSlot>(&A::part())?;
    Ok(shader)
}

/// The lights, followed by the texels of their cookies.
pub(crate) fn table<'a>(emitters: impl IntoIterator<Item = &'a Emitter>) -> Vec<[u32; 4]> {
    let mut lights = Vec::new();
    let mut texels: Vec<[u32; 4]> = Vec::new();
    for emitter in emitters {
        let (emitter, cookie) = EmitterRecord::new(emitter);
        lights.push(ManyLight {
            emitter,
            // A table with more texels is refused.
            cookie: texels.len() as u32,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        });
        texels.extend(cookie.iter().map(|texel| texel.map(f32::to_bits)));
    }
    let mut table: Vec<[u32; 4]> = bytemuck::cast_slice(&lights).to_vec();
    table.extend(texels);
    table
}

/// The lists, followed by the rays in their tiles.
fn words(lists: &TileLights<'_>) -> Vec<u32> {
    let (offsets, lights) = lists.lists();
    let tiles = lists.tiles();
    let places = (0..tiles.tiles()).flat_map(|tile| {
        let rays = tiles.rays_of(tile).iter();
        rays.flat_map(move |ray| [*ray, tile as u32])
    });
    let mut words = offsets.to_vec();
    words.extend(places);
    words.extend_from_slice(lights);
    words
}

impl<V, A, E> GatherMany<V, A> for Gpu<E>
where
    V: InShader<ManyVisibilitySlot>,
    A: InShader<AirlightSlot>,
    E: Encode,
{
    fn gather_many(
        &self,
        lit: &LitByMany<'_, GpuMemory>,
        visibility: &V,
        airlight: &A,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check(lit, radiance.len())?;
        let tiles = lit.lists.tiles().tiles();
        let longest = (0..tiles).map(|tile| lit.lists.of_tile(tile).len()).max();
        let longest = longest.unwrap_or(0);
        if lit.medium.scatters_nothing() || longest == 0 {
            return Ok(());
        }
        let table = self.upload(&table(lit.emitters))?;
        let lists = self.upload(&words(lit.lists))?;
        let parts = shader::<V, A>()?.finish(PARTS);
        let constants = [visibility.constants(), airlight.constants()].concat();
        let lights_per_dispatch = lit.lights_per_dispatch.clamp(1, longest);
        for entry in (0..longest).step_by(lights_per_dispatch) {
            let mut arguments = visibility.arguments();
            arguments.extend(airlight.arguments());
            let scene = Scene {
                medium: MediumRecord::new(lit.medium),
                // None that fits into a binding has more rays, tiles, lights or entries than a
                // u32 counts.
                rays: lit.rays.len() as u32,
                tiles: tiles as u32,
                joined: u32::from(lit.touching == Touching::Joined),
                first: lit.first as u32,
                entry: entry as u32,
                most: lights_per_dispatch as u32,
                cookies: first_texel(lit.emitters.len()),
                padding: 0,
            };
            self.dispatch(
                &Kernel {
                    label: "gather of many lights",
                    parts: &parts,
                    entry: "gather_many",
                    constants: &constants,
                },
                &[
                    &[
                        Argument::uniform(scene),
                        Argument::read(lit.rays),
                        Argument::read(&table),
                        Argument::read(&lists),
                        Argument::write(radiance),
                    ],
                    &arguments,
                ],
                Workgroups::covering(lit.rays.len(), GROUP),
            )?;
        }
        Ok(())
    }
}
