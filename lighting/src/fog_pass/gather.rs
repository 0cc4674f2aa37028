//! The dispatches that gather the light of a picture's pixels.

use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec3, Vec4};
use gpu_backend::Backend;
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, InShader, Kernel, Workgroups};
use gpu_backend::shader::Assembly;

use super::view::View;
use super::{DepthLayers, FogFrame};
use crate::Emitter;
use crate::airlight::Quadrature;
use crate::gpu::scene::MediumRecord;
use crate::gpu::{AirlightSlot, LIT_PARTS, VisibilitySlot, assembly};
use crate::methods::many_lights::gpu::{LIGHTS, first_texel, table};

/// The uniform `Scene` of `fog.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) medium: MediumRecord,
    pub(super) eye: Vec3,
    pub(super) depth: f32,
    pub(super) right: Vec4,
    pub(super) up: Vec4,
    pub(super) forward: Vec4,
    pub(super) size: UVec2,
    pub(super) empty: f32,
    pub(super) reach: f32,
    pub(super) first: u32,
    pub(super) lights: u32,
    pub(super) cookies: u32,
    pub(super) adds: u32,
}

impl Scene {
    /// The first pass over a picture, which gathers all lights without a shadow map.
    pub(super) fn new(
        frame: &FogFrame<'_>,
        lights: &Lights<'_>,
        view: &View,
        size: [u32; 2],
    ) -> Self {
        Self {
            medium: MediumRecord::new(frame.medium),
            eye: view.eye,
            depth: view.depth,
            right: view.right,
            up: view.up,
            forward: view.forward,
            size: size.into(),
            empty: frame.empty_depth,
            reach: frame.reach.min(f32::MAX),
            first: 0,
            // A table of more lights does not fit into a binding.
            lights: lights.unshadowed as u32,
            cookies: first_texel(lights.unshadowed + lights.shadowed.len()),
            adds: 0,
        }
    }

    /// A later pass, which gathers the light with this number.
    pub(super) fn with_light(self, number: u32) -> Self {
        Self {
            first: number,
            lights: 1,
            adds: 1,
            ..self
        }
    }
}

/// The lights of a frame, those without a shadow map first.
pub(super) struct Lights<'a> {
    table: GpuBuffer<[u32; 4]>,
    unshadowed: usize,
    pub(super) shadowed: Vec<(&'a Emitter, DepthLayers<'a>)>,
}

impl<'a> Lights<'a> {
    pub(super) fn upload<E: Encode>(
        gpu: &Gpu<E>,
        frame: &FogFrame<'a>,
    ) -> Result<Self, gpu_backend::Error> {
        let (mut unshadowed, mut shadowed) = (Vec::new(), Vec::new());
        if !frame.medium.scatters_nothing() {
            for light in frame.lights {
                match light.shadow {
                    Some(map) => shadowed.push((light.emitter, map)),
                    None => unshadowed.push(light.emitter),
                }
            }
        }
        let all = unshadowed.iter().copied();
        let all = all.chain(shadowed.iter().map(|(emitter, _)| *emitter));
        Ok(Self {
            table: gpu.upload(&table(all))?,
            unshadowed: unshadowed.len(),
            shadowed,
        })
    }
}

/// What all passes over a picture share.
pub(super) struct GatherFog<'a, E: Encode> {
    pub(super) gpu: &'a Gpu<E>,
    pub(super) samples: u32,
    pub(super) depth: &'a wgpu::TextureView,
    pub(super) lights: &'a Lights<'a>,
    pub(super) airlight: &'a Quadrature,
}

/// Invocations along each side of a workgroup in `fog.wgsl`.
const GROUP: u32 = 8;

/// The bind group with the variables of all parts.
const PARTS: u32 = 1;

/// The shader of a pass that asks `V` for lit parts.
pub(super) fn shader<V: InShader<VisibilitySlot>>(
    samples: u32,
) -> Result<Assembly, gpu_backend::Error> {
    let depths = match samples {
        1 => include_str!("depth.wgsl"),
        _ => include_str!("depth_of_samples.wgsl"),
    };
    let mut shader = assembly(&[LIGHTS, LIT_PARTS, depths, include_str!("fog.wgsl")]);
    shader.fill::<VisibilitySlot>(&V::part())?;
    shader.fill::<AirlightSlot>(&Quadrature::part())?;
    Ok(shader)
}

impl<E: Encode> GatherFog<'_, E> {
    /// Gathers the lights of `scene`. The first pass writes the pixels; later ones add to them.
    pub(super) fn gather<V: InShader<VisibilitySlot>>(
        &self,
        scene: Scene,
        visibility: &V,
        fog: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), gpu_backend::Error> {
        let depths = match self.samples {
            1 => Argument::texture_of(
                self.depth,
                wgpu::TextureSampleType::Depth,
                wgpu::TextureViewDimension::D2,
            ),
            _ => Argument::multisampled(self.depth, wgpu::TextureSampleType::Depth),
        };
        let mut arguments = visibility.arguments();
        arguments.extend(self.airlight.arguments());
        self.gpu.dispatch(
            &Kernel {
                label: "fog",
                parts: &shader::<V>(self.samples)?.finish(PARTS),
                entry: "gather_fog",
                constants: &[visibility.constants(), self.airlight.constants()].concat(),
            },
            &[
                &[
                    Argument::uniform(scene),
                    depths,
                    Argument::read(&self.lights.table),
                    Argument::write(fog),
                ],
                &arguments,
            ],
            Workgroups::Grid([
                scene.size.x.div_ceil(GROUP),
                scene.size.y.div_ceil(GROUP),
                1,
            ]),
        )
    }
}
