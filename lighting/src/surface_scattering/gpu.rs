//! Light that fog scatters onto surfaces, in shaders.

use airlight::gpu::{PHASE, SURFACE};
use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Part, Slot};
use gpu_backend::{Buffer, Error};

use super::{AddSurfaceScattering, ClosedForm, Covers, LitSurfaces, Quadrature, check_covered};
use crate::gather::check_lengths;
use crate::gpu::scene::{EmitterRecord, MediumRecord};
use crate::gpu::{NUMERIC, PATH, PointSlot, SURFACE_POINT};

/// The slot for the question: *how much light does the fog scatter onto this surface?* A part
/// `x` defines
///
/// ```wgsl
/// fn x_irradiance(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32>
/// ```
///
/// and calls `light_emitter()` and `light_medium()` for the light and the fog.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceScatteringSlot;

impl Slot for SurfaceScatteringSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn light_scattered_irradiance(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {{
    return {part}_irradiance(position, normal);
}}
"
        )
    }
}

impl InShader<SurfaceScatteringSlot> for ClosedForm {
    fn part() -> Part {
        Part::new("light_closed_form")
            .sources(&[SURFACE, include_str!("closed_form.wgsl")])
            .read("light_lobe", "array<f32>")
            .read("light_sun_table", "array<f32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::table(self.lobe().coefficients()),
            Argument::table(self.sun()),
        ]
    }
}

impl<P: InShader<PointSlot>> InShader<SurfaceScatteringSlot> for Quadrature<P> {
    fn part() -> Part {
        let points = P::part();
        Part::new("light_surface_quadrature")
            .glue::<PointSlot>(&points)
            .with(points)
            .source(include_str!("quadrature.wgsl"))
            .read("light_rules", "array<vec2<f32>>")
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.points().constants()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let rules = self.rules();
        let mut arguments = self.points().arguments();
        arguments.push(Argument::table(
            &[&rules.line[..], &rules.circle, &rules.arc].concat(),
        ));
        arguments
    }
}

/// `Scene` of `surface_scattering.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) emitter: EmitterRecord,
    pub(super) medium: MediumRecord,
    pub(super) points: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
    pub(super) padding_c: u32,
}

/// Invocations per workgroup in `surface_scattering.wgsl`.
const GROUP: u32 = 64;

/// The bind group of the parts.
pub(super) const PARTS: u32 = 1;

/// Storage buffers of the entry point.
#[cfg(test)]
pub(super) const STORAGE: usize = 3;

pub(super) fn shader<S: InShader<SurfaceScatteringSlot>>() -> Result<Assembly, Error> {
    let mut shader = Assembly::new(&[
        INDEX_WGSL,
        NUMERIC,
        PHASE,
        PATH,
        SURFACE_POINT,
        include_str!("surface_scattering.wgsl"),
    ]);
    shader.fill::<SurfaceScatteringSlot>(&S::part())?;
    Ok(shader)
}

impl<S, E> AddSurfaceScattering<S> for Gpu<E>
where
    S: InShader<SurfaceScatteringSlot> + Covers,
    E: Encode,
{
    fn add_surface_scattering(
        &self,
        lit: &LitSurfaces<'_, GpuMemory>,
        scattering: &S,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(lit.points.len(), radiance.len())?;
        check_covered(scattering, lit.emitter, lit.medium)?;
        if lit.medium.scatters_nothing() {
            return Ok(());
        }
        let (emitter, cookie) = EmitterRecord::new(lit.emitter);
        let scene = Scene {
            emitter,
            medium: MediumRecord::new(lit.medium),
            // The dispatch refuses more points than a u32 counts.
            points: lit.points.len() as u32,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        };
        self.dispatch(
            &Kernel {
                label: "surface scattering",
                parts: &shader::<S>()?.finish(PARTS),
                entry: "add_surface_scattering",
                constants: &scattering.constants(),
            },
            &[
                &[
                    Argument::uniform(scene),
                    Argument::read(lit.points),
                    Argument::table(&cookie),
                    Argument::write(radiance),
                ],
                &scattering.arguments(),
            ],
            Workgroups::covering(lit.points.len(), GROUP),
        )
    }
}
