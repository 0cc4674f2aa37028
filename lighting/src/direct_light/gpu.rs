//! Direct light of many lights, on a GPU.

use airlight::gpu::PHASE;
use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Part, Slot};
use gpu_backend::{Backend, Buffer, Error};

use super::{AddDirectLight, LitPoints, check};
use crate::gpu::scene::MediumRecord;
use crate::gpu::{ARC, ARRIVING, NUMERIC, PATH, SURFACE_POINT, visibility_on};
use crate::methods::many_lights::gpu::{LIGHTS, first_texel, table};
use crate::visibility::Unshadowed;

/// The slot for the question: *which share of one of many lights reaches this surface?* A part
/// `x` defines
///
/// ```wgsl
/// fn x_on_surface(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32>
/// ```
///
/// which returns the share, 0 to 1 for each colour, of the light whose index is
/// `light_number()`.
#[derive(Debug, Clone, Copy)]
pub struct ManySurfacesSlot;

impl Slot for ManySurfacesSlot {
    fn glue(part: &str) -> String {
        visibility_on(part, "light_surface_visibility")
    }
}

impl InShader<ManySurfacesSlot> for Unshadowed {
    fn part() -> Part {
        Part::new("light_unshadowed").source(include_str!("unshadowed.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

/// `Scene` of `direct_light.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) medium: MediumRecord,
    pub(super) points: u32,
    pub(super) lists: u32,
    pub(super) entry: u32,
    pub(super) most: u32,
    pub(super) cookies: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
    pub(super) padding_c: u32,
}

/// Invocations per workgroup in `direct_light.wgsl`.
const GROUP: u32 = 64;

/// The bind group of the part.
const PARTS: u32 = 1;

/// Storage buffers of the entry point.
#[cfg(test)]
pub(super) const STORAGE: usize = 4;

/// The shader for a source of shadows.
pub(super) fn shader<V: InShader<ManySurfacesSlot>>() -> Result<Assembly, Error> {
    let mut shader = Assembly::new(&[
        INDEX_WGSL,
        NUMERIC,
        PHASE,
        PATH,
        ARC,
        SURFACE_POINT,
        ARRIVING,
        LIGHTS,
        include_str!("direct_light.wgsl"),
    ]);
    shader.fill::<ManySurfacesSlot>(&V::part())?;
    Ok(shader)
}

impl<V, E> AddDirectLight<V> for Gpu<E>
where
    V: InShader<ManySurfacesSlot>,
    E: Encode,
{
    fn add_direct_light(
        &self,
        lit: &LitPoints<'_, GpuMemory>,
        shadows: &V,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check(lit, radiance.len())?;
        let longest = lit.lists.longest();
        if longest == 0 {
            return Ok(());
        }
        let table = self.upload(&table(lit.emitters))?;
        let lists = self.upload(&lit.lists.words())?;
        let parts = shader::<V>()?.finish(PARTS);
        let constants = shadows.constants();
        let lights_per_dispatch = lit.lights_per_dispatch.clamp(1, longest);
        for entry in (0..longest).step_by(lights_per_dispatch) {
            let scene = Scene {
                medium: lit
                    .medium
                    .map_or_else(MediumRecord::zeroed, MediumRecord::new),
                // Points, lists, lights and entries are counted by u32, as none that fits into
                // a binding has more.
                points: lit.points.len() as u32,
                lists: lit.lists.lists() as u32,
                entry: entry as u32,
                most: lights_per_dispatch as u32,
                cookies: first_texel(lit.emitters.len()),
                padding_a: 0,
                padding_b: 0,
                padding_c: 0,
            };
            self.dispatch(
                &Kernel {
                    label: "direct light of many lights",
                    parts: &parts,
                    entry: "add_direct_light",
                    constants: &constants,
                },
                &[
                    &[
                        Argument::uniform(scene),
                        Argument::read(lit.points),
                        Argument::read(&table),
                        Argument::read(&lists),
                        Argument::write(radiance),
                    ],
                    &shadows.arguments(),
                ],
                Workgroups::covering(lit.points.len(), GROUP),
            )?;
        }
        Ok(())
    }
}
