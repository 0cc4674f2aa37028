//! The fog of a renderer's frame, by one object.
//!
//! A [`FogPass`] is made once for the format of a texture. In each frame it is told what a
//! renderer has anyway: the depths of its picture with the matrix that they were drawn by, its
//! lights with their shadow maps, and the medium. It records into the renderer's command
//! encoder and draws into the renderer's texture, as [`wgpu::util::TextureBlitter`] does. Each
//! pixel of that texture holds the radiance that fog scatters towards the eye before the
//! surface, and in the fourth channel the transmittance, which is the share of the surface's
//! light that gets through the fog.
//!
//! ```no_run
//! # fn frame(
//! #     device: wgpu::Device,
//! #     queue: wgpu::Queue,
//! #     encoder: &mut wgpu::CommandEncoder,
//! #     [depth, fog_texture, cube]: [&wgpu::TextureView; 3],
//! #     view_projection: [[f32; 4]; 4],
//! # ) -> Result<(), Box<dyn std::error::Error>> {
//! use glam::Vec3;
//! use lighting::Emitter;
//! use lighting::fog_pass::{DepthLayers, DepthViews, FogEye, FogFrame, FogLight, FogPass};
//! use lighting::gpu_backend::gpu::Context;
//! use lighting::scene::{Emission, Medium, PhaseFunction};
//!
//! // Once.
//! let context = Context::new(device, queue);
//! let mut pass = FogPass::new(&context, wgpu::TextureFormat::Rgba16Float, 1)?;
//!
//! // Each frame.
//! let lamp = Vec3::new(0.0, 3.0, -2.0);
//! let emitter = Emitter::point(lamp, Vec3::splat(50.0), f32::INFINITY, Emission::Isotropic)?;
//! let faces = DepthViews::cube(lamp, 0.05)?;
//! let air = Medium::new(Vec3::splat(0.02), Vec3::ZERO, PhaseFunction::Isotropic)?;
//! pass.record(
//!     encoder,
//!     &FogFrame {
//!         eyes: &[FogEye { view_projection, depth, fog: fog_texture }],
//!         empty_depth: 0.0, // depths are reversed
//!         reach: f32::INFINITY,
//!         medium: &air,
//!         lights: &[FogLight::shadowed(&emitter, DepthLayers::new(&faces, cube))],
//!     },
//! )?;
//! # Ok(())
//! # }
//! ```
//!
//! A whole program is `lighting/examples/frame` in the repository:
//!
//! ```console
//! $ cargo run -p crepuscular-lighting --example frame \
//!       --features wgpu,voxel-shadow,gpu-backend/vulkan
//! ```
//!
//! The picture in fog is then, pixel by pixel in linear light,
//!
//! ```text
//! colour × transmittance + radiance
//! ```
//!
//! The renderer computes it in a shader of its own, or by blending: with
//! [`FogPass::with_blend`] and [`FogPass::OVER`] the fog is drawn over the colours themselves,
//! and no fog texture is needed.
//!
//! # Pictures
//!
//! * *Depths* may run either way, from 0 at the near plane or reversed, to a far plane or to
//!   infinity: the matrix says which. A pixel has the fog along the ray through its centre.
//! * *Multisampling*: depths of four samples per pixel are read without being resolved. A pixel
//!   has the mean of the fog before the surfaces in its samples, which costs little more than
//!   the fog of one sample. Drawn over resolved colours, this is right except where both
//!   colours and distances differ within a pixel.
//! * *Two eyes* are two [`FogEye`]s, whose views may be layers of array textures. They share
//!   the shadow maps; the rest is done for each eye.
//!
//! # Lights
//!
//! For each eye, each light with a shadow map becomes a voxelized shadow volume (see the module
//! [`voxelized`](crate::voxelized)). It is made anew in every frame by a few dispatches, and
//! gathered by one more. One dispatch gathers all lights without a map. Whatever lies between
//! two samples of a shadow map is lost, and shadows are off by about one of the voxels, whose
//! number [`FogPass::with_voxels`] sets. The light of lit parts is integrated to a relative
//! error of 1e-3.
//!
//! # What it needs
//!
//! wgpu 30, for which you choose the driver, as [`gpu_backend::gpu`] says. [`DepthViews`] and
//! [`DepthLayers`] are those of the crate `voxel_shadow`, re-exported, so that a program needs no
//! second package for them.
//!
//! # Limits
//!
//! * Light is scattered once, in a homogeneous medium whose extinction is the same for all
//!   colours.
//! * Views are perspective views, and shadow maps have one sample per texel.
//! * Along the line through a lamp the radiance grows without bound; formats of half precision
//!   hold up to 65504.
//! * Fog is drawn into level 0 of its texture.
//!
//! Memory: the voxels of one light, and 16 bytes per pixel. WebGPU's default limit on bindings
//! therefore allows 3840 × 2160 pixels.

mod error;
mod frame;
mod gather;
mod view;

#[cfg(test)]
mod tests;

use airlight::PhaseFunction;
use gpu_backend::gpu::{Argument, Context, Encode, Gpu, GpuBuffer, GpuMemory};
use gpu_backend::{Backend, Buffer};

use crate::airlight::Quadrature;
use crate::visibility::Unshadowed;
use crate::voxelized::{Detail, Resolution, VoxelError, VoxelVolume};

pub use error::FogError;
pub use frame::{FogEye, FogFrame, FogLight};
pub use voxel_shadow::DepthViews;
pub use voxel_shadow::gpu::DepthLayers;

use gather::{GatherFog, Lights, Scene};
use view::View;

/// Draws the fog of frames. The [module](self) has an example.
#[derive(Debug)]
pub struct FogPass {
    context: Context,
    format: wgpu::TextureFormat,
    samples: u32,
    blend: Option<wgpu::BlendState>,
    volume: VoxelVolume<GpuMemory>,
    /// Radiance and transmittance of the pixels of one eye.
    fog: GpuBuffer<[f32; 4]>,
    /// The quadrature for the phase function of the last medium.
    airlight: Option<(PhaseFunction, Quadrature)>,
}

/// Relative error of the light that is integrated over a lit part.
const TOLERANCE: f32 = 1e-3;

/// Copies the gathered pixels into the fog texture.
const DRAW: &str = include_str!("draw.wgsl");

/// What draws into textures of one format with one blending; the context keeps it.
struct Pipeline {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl FogPass {
    /// The blending that draws fog over the colours of a picture: those that are there
    /// times the transmittance, plus the radiance. The fourth channel of the picture is
    /// left as it is.
    pub const OVER: wgpu::BlendState = wgpu::BlendState {
        color: wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::SrcAlpha,
            operation: wgpu::BlendOperation::Add,
        },
        alpha: wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::Zero,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        },
    };

    /// A pass that draws into textures of `format`, from depths with `samples` samples per
    /// pixel: 1, or 4, the only other number that WebGPU has.
    ///
    /// # Errors
    /// [`FogError::Samples`] for another number, [`FogError::Voxels`] if the device cannot
    /// hold 512 × 512 × 256 voxels.
    pub fn new(
        context: &Context,
        format: wgpu::TextureFormat,
        samples: u32,
    ) -> Result<Self, FogError> {
        if ![1, 4].contains(&samples) {
            return Err(FogError::Samples { samples });
        }
        let gpu = Gpu::new(context.clone());
        let voxels = Resolution::new(512, 512, 256).map_err(VoxelError::from)?;
        Ok(Self {
            context: context.clone(),
            format,
            samples,
            blend: None,
            volume: VoxelVolume::new(&gpu, voxels)?,
            fog: gpu.zeros(0)?,
            airlight: None,
        })
    }

    /// The same pass, which blends the fog with what the textures already hold.
    #[must_use]
    pub fn with_blend(self, blend: wgpu::BlendState) -> Self {
        Self {
            blend: Some(blend),
            ..self
        }
    }

    /// The same with another number of voxels for each light, 512 × 512 × 256 if nothing is
    /// said: finer shadows, in more time and memory.
    ///
    /// # Errors
    /// [`FogError::Voxels`] if the device cannot hold them.
    pub fn with_voxels(self, voxels: Resolution) -> Result<Self, FogError> {
        let gpu = Gpu::new(self.context.clone());
        Ok(Self {
            volume: VoxelVolume::new(&gpu, voxels)?,
            ..self
        })
    }

    /// Records the fog of a frame into `encoder`, which must be submitted to the queue of the
    /// context. Nothing is submitted here, and nothing blocks.
    ///
    /// # Errors
    /// Before anything is recorded: [`FogError::Format`], [`FogError::SampleCount`],
    /// [`FogError::Size`] and [`FogError::Usage`] for textures that are not as they should be,
    /// [`FogError::NoEye`] for the matrix of a parallel view, [`FogError::BadValue`] for an
    /// empty depth or a reach that is none, [`FogError::ColouredExtinction`],
    /// [`FogError::Airlight`]. Later: [`FogError::Voxels`] and [`FogError::Backend`] for what
    /// does not fit on the device or is refused by it; the encoder then holds a part of the
    /// steps.
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FogFrame<'_>,
    ) -> Result<(), FogError> {
        frame.check(self.format, self.samples)?;
        let views = frame.eyes.iter().map(|eye| View::new(&eye.view_projection));
        let views = views.collect::<Result<Vec<_>, _>>()?;
        let airlight = match self.airlight.take() {
            Some((phase, airlight)) if phase == frame.medium.phase() => airlight,
            _ => Quadrature::with_tolerance(frame.medium.phase(), TOLERANCE)?,
        };
        let gpu = Gpu::record(&self.context, encoder);
        let lights = Lights::upload(&gpu, frame)?;
        let drawn = views.iter().zip(frame.eyes).try_for_each(|(view, eye)| {
            self.gather(&gpu, frame, &lights, &airlight, (view, eye))?;
            self.draw(&gpu, eye)
        });
        self.airlight = Some((frame.medium.phase(), airlight));
        drawn
    }

    /// Records what fills the buffer of the pixels of an eye.
    fn gather<E: Encode>(
        &mut self,
        gpu: &Gpu<E>,
        frame: &FogFrame<'_>,
        lights: &Lights<'_>,
        airlight: &Quadrature,
        (view, eye): (&View, &FogEye<'_>),
    ) -> Result<(), FogError> {
        let [width, height] = eye.size();
        let pixels = width as usize * height as usize;
        if self.fog.len() < pixels {
            self.fog = gpu.zeros(pixels)?;
        }
        let pass = GatherFog {
            gpu,
            samples: self.samples,
            depth: eye.depth,
            lights,
            airlight,
        };
        let scene = Scene::new(frame, lights, view, [width, height]);
        pass.gather(scene, &Unshadowed, &mut self.fog)?;
        let space = view.volume(frame.medium, frame.reach);
        for (number, (emitter, map)) in (scene.lights..).zip(&lights.shadowed) {
            self.volume.update_from(gpu, emitter, &space, map)?;
            let shadow = self.volume.source(Detail::Runs);
            pass.gather(scene.with_light(number), &shadow, &mut self.fog)?;
        }
        Ok(())
    }

    /// Records what draws that buffer.
    fn draw<E: Encode>(&self, gpu: &Gpu<E>, eye: &FogEye<'_>) -> Result<(), FogError> {
        let label = "fog";
        let arguments = [Argument::uniform(eye.size()), Argument::read(&self.fog)];
        let key = ("crepuscular fog", self.format, self.blend);
        let pipeline = self.context.cached(label, key, |device| {
            let stages = wgpu::ShaderStages::FRAGMENT;
            let layout = self.context.bind_group_layout(label, stages, &arguments);
            Ok(Pipeline::new(device, layout, self.format, self.blend))
        })?;
        let group = self
            .context
            .bind_group(label, &pipeline.layout, &arguments)?;
        gpu.with_encoder(label, |encoder| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: eye.fog,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
        })?;
        Ok(())
    }
}

impl Pipeline {
    fn new(
        device: &wgpu::Device,
        layout: wgpu::BindGroupLayout,
        format: wgpu::TextureFormat,
        blend: Option<wgpu::BlendState>,
    ) -> Self {
        let label = Some("fog");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label,
            source: wgpu::ShaderSource::Wgsl(DRAW.into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cover"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("draw"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format,
                    blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { layout, pipeline }
    }
}
