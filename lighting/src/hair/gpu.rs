//! The light of hair on a GPU.
//!
//! The CPU finds and sorts the strands of each pixel; shaders light them, a point each, and add
//! up the points of each pixel.

use std::fmt::Debug;
use std::ops::Range;

use airlight::gpu::PHASE;
use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Part, Slot};
use gpu_backend::{Backend, Buffer, Cpu, Error};
use transmittance::Stored;
use transmittance::gpu::WgslStored;

use super::light::{HairPoint, TEXELS};
use super::{AddHairLight, Fibre, HairMemory, LitHair, SeenHair};
use crate::gpu::scene::{EmitterRecord, MediumRecord};
use crate::gpu::{ARRIVING, NUMERIC, PATH, PointSlot};
use crate::methods::exact::UploadedTracer;
use crate::methods::exact::gpu::ShadowRaySlot;
use crate::methods::translucent::TransmittanceMap;
use crate::scene::gpu::{HEIGHT_FOG, HeightFogRecord};

/// How a strand scatters light, as
///
/// ```wgsl
/// fn light_fibre_radiance(
///     fibre: u32,
///     colour: vec3<f32>,
///     tangent: vec3<f32>,
///     to_light: vec3<f32>,
///     to_eye: vec3<f32>,
/// ) -> vec3<f32>
/// ```
///
/// which is [`Fibre::radiance`] for `light_KAJIYA_KAY` or `light_MARSCHNER` as its first
/// argument, to a relative 1e-4 of it. It needs the part [`NUMERIC`].
pub const FIBRE: &str = include_str!("fibre.wgsl");

impl<T: Stored + Debug> HairMemory<T> for GpuMemory {
    type Tracer = UploadedTracer;
}

/// The slot for the map of strands and smoke.
#[derive(Debug)]
pub(super) struct HairMapSlot;

impl Slot for HairMapSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn light_hair_share(point: vec3<f32>) -> vec3<f32> {{
    return {part}_visibility(point);
}}
fn light_hair_texel_size(point: vec3<f32>) -> f32 {{
    return {part}_texel_size(point);
}}
"
        )
    }
}

impl<T: WgslStored + Debug> InShader<HairMapSlot> for TransmittanceMap<GpuMemory, T> {
    fn part() -> Part {
        <Self as InShader<PointSlot>>::part()
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        InShader::<PointSlot>::constants(self)
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        InShader::<PointSlot>::arguments(self)
    }
}

/// `Scene` of `hair.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) emitter: EmitterRecord,
    pub(super) medium: MediumRecord,
    pub(super) height: HeightFogRecord,
    pub(super) points: u32,
    pub(super) fibre: u32,
    pub(super) has_height: u32,
    pub(super) texels: f32,
}

/// `Pixels` of `pixels.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Pixels {
    pub(super) count: u32,
    pub(super) first: u32,
    pub(super) begin: u32,
    pub(super) most: u32,
}

/// Invocations per workgroup.
const GROUP: u32 = 64;

/// The bind group of the parts.
const PARTS: u32 = 1;

/// Storage buffers of the entry point.
#[cfg(test)]
pub(super) const STORAGE: usize = 3;

/// Points of a pixel that a dispatch adds: some software drivers end loops after 65,535 turns.
const MOST_TURNS: usize = 32_768;

/// The shader that lights points, for a kind of curves.
pub(super) fn shader<T: WgslStored + Debug>() -> Result<Assembly, Error> {
    let mut shader = Assembly::new(&[
        INDEX_WGSL,
        NUMERIC,
        PHASE,
        PATH,
        ARRIVING,
        HEIGHT_FOG,
        FIBRE,
        include_str!("hair.wgsl"),
    ]);
    shader
        .fill::<HairMapSlot>(&<TransmittanceMap<GpuMemory, T> as InShader<HairMapSlot>>::part())?;
    shader.fill::<ShadowRaySlot>(&<UploadedTracer as InShader<ShadowRaySlot>>::part())?;
    Ok(shader)
}

/// The shader that adds points to pixels.
pub(super) const ADD: [&str; 2] = [INDEX_WGSL, include_str!("pixels.wgsl")];

impl Fibre {
    /// Its number in `fibre.wgsl`.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::KajiyaKay => 0,
            Self::Marschner => 1,
        }
    }
}

/// Successive pixels with at most so many fragments, or a single pixel with more.
pub(super) fn batches(hair: &SeenHair, most: usize) -> impl Iterator<Item = Range<usize>> {
    let mut next = 0;
    std::iter::from_fn(move || {
        let first = next;
        let mut fragments = 0;
        while next < hair.pixels() {
            fragments += hair.of(next).len();
            if fragments > most && next > first {
                break;
            }
            next += 1;
        }
        (first < next).then_some(first..next)
    })
}

impl<T, E> AddHairLight<T> for Gpu<E>
where
    T: WgslStored + Debug + Sync,
    E: Encode,
{
    fn add_hair_light(
        &self,
        hair: &SeenHair,
        lit: &LitHair<'_, GpuMemory, T>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        lit.check(hair, radiance.len())?;
        let limit = self.context().limits().max_storage_buffer_binding_size;
        let most = (limit / size_of::<HairPoint>() as u64) as usize;
        for pixels in batches(hair, most) {
            let of_pixels = Cpu::new().map(pixels.len(), |index| {
                let mut points = Vec::new();
                lit.for_each_point(hair, pixels.start + index, |point| points.push(point));
                points
            });
            let points = of_pixels.concat();
            if points.is_empty() {
                continue;
            }
            let scattered = scattered(self, &points, lit)?;
            add_points(self, pixels.start, &of_pixels, &scattered, radiance)?;
        }
        Ok(())
    }
}

/// The light of points that reaches the eye.
fn scattered<T: WgslStored + Debug, E: Encode>(
    gpu: &Gpu<E>,
    points: &[HairPoint],
    lit: &LitHair<'_, GpuMemory, T>,
) -> Result<GpuBuffer<[f32; 4]>, Error> {
    let mut scattered = gpu.zeros::<[f32; 4]>(points.len())?;
    let uploaded = gpu.upload(points)?;
    let parts = shader::<T>()?.finish(PARTS);
    let media = lit.media;
    for (emitter, map) in lit.lights {
        let (emitter, cookie) = EmitterRecord::new(emitter);
        let scene = Scene {
            emitter,
            medium: (media.medium()).map_or_else(MediumRecord::zeroed, MediumRecord::new),
            height: (media.height_fog())
                .map_or_else(HeightFogRecord::zeroed, HeightFogRecord::from),
            // A binding holds no more than a u32 counts.
            points: points.len() as u32,
            fibre: lit.fibre.number(),
            has_height: u32::from(media.height_fog().is_some()),
            texels: TEXELS,
        };
        let mut arguments = InShader::<HairMapSlot>::arguments(*map);
        arguments.extend(InShader::<ShadowRaySlot>::arguments(lit.tracer));
        gpu.dispatch(
            &Kernel {
                label: "light of hair",
                parts: &parts,
                entry: "scatter",
                constants: &InShader::<HairMapSlot>::constants(*map),
            },
            &[
                &[
                    Argument::uniform(scene),
                    Argument::read(&uploaded),
                    Argument::table(&cookie),
                    Argument::write(&mut scattered),
                ],
                &arguments,
            ],
            Workgroups::covering(points.len(), GROUP),
        )?;
    }
    Ok(scattered)
}

/// Adds the light of points to their pixels, the first of which is `first`.
fn add_points<E: Encode>(
    gpu: &Gpu<E>,
    first: usize,
    of_pixels: &[Vec<HairPoint>],
    scattered: &GpuBuffer<[f32; 4]>,
    radiance: &mut GpuBuffer<[f32; 4]>,
) -> Result<(), Error> {
    let mut end = 0;
    let ends: Vec<u32> = of_pixels
        .iter()
        .map(|points| {
            end += points.len() as u32;
            end
        })
        .collect();
    let ends = gpu.upload(&ends)?;
    let longest = of_pixels.iter().map(Vec::len).max().unwrap_or(0);
    for begin in (0..longest).step_by(MOST_TURNS) {
        let pixels = Pixels {
            // A picture with more pixels than a u32 counts is refused by a binding.
            count: of_pixels.len() as u32,
            first: first as u32,
            begin: begin as u32,
            most: MOST_TURNS as u32,
        };
        gpu.dispatch(
            &Kernel {
                label: "hair of pixels",
                parts: &ADD,
                entry: "add_to_pixels",
                constants: &[],
            },
            &[&[
                Argument::uniform(pixels),
                Argument::read(&ends),
                Argument::read(scattered),
                Argument::write(radiance),
            ]],
            Workgroups::covering(of_pixels.len(), GROUP),
        )?;
    }
    Ok(())
}
