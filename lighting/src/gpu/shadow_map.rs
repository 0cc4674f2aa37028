//! Shadow maps from the depth test of the GPU.

use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec2};
use gpu_backend::gpu::{Argument, Context, Encode, Gpu, GpuBuffer, GpuMemory, Kernel, Workgroups};
use gpu_backend::{Backend, Buffer, Error};

use super::scene::FaceRecord;
use super::{FACE, MASK};
use crate::scene::Bounds;
use crate::scene::raster::Face;
use crate::shadow_map::{Casters, EMPTY, RenderShadowMap, ShadowMapError, check_size};

/// Texels per side of what is rendered in one pass; a larger map is rendered
/// in tiles, which keeps the textures small beside the map.
const TILE: u32 = 2048;

/// Depth and distance attachments.
const DISTANCE: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Shaders of the two passes.
pub(super) const RENDER: [&str; 4] = [
    FACE,
    MASK,
    include_str!("tile.wgsl"),
    include_str!("depth.wgsl"),
];
pub(super) const COPY: [&str; 3] = [
    FACE,
    include_str!("tile.wgsl"),
    include_str!("depth_copy.wgsl"),
];

/// `Tile` of `tile.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Tile {
    pub(super) face: FaceRecord,
    pub(super) scale: Vec2,
    pub(super) offset: Vec2,
    pub(super) first: UVec2,
    pub(super) size: UVec2,
    pub(super) resolution: u32,
    pub(super) index: u32,
    pub(super) far: f32,
    pub(super) near: f32,
    pub(super) solid: u32,
    pub(super) padding: u32,
    pub(super) more_padding: UVec2,
}

impl Tile {
    fn new(face: &Face, index: u32, resolution: u32, first: UVec2, far: f32) -> Self {
        let size = (UVec2::splat(resolution) - first).min(UVec2::splat(TILE));
        let n = resolution as f32;
        let (start, extent) = (first.as_vec2(), size.as_vec2());
        // Columns grow with x, rows against y.
        let scale = n / extent;
        let offset = Vec2::new(
            (n - 2.0 * start.x) / extent.x - 1.0,
            1.0 - (n - 2.0 * start.y) / extent.y,
        );
        Self {
            face: FaceRecord::new(face),
            scale,
            offset,
            first,
            size,
            resolution,
            index,
            far,
            near: 1e-6 * far,
            solid: 0,
            padding: 0,
            more_padding: UVec2::ZERO,
        }
    }

    /// All tiles of a map.
    fn all(faces: &[Face], resolution: u32, bounds: Bounds) -> Vec<Self> {
        let starts = || (0..resolution).step_by(TILE as usize);
        let mut tiles = Vec::new();
        for (index, face) in (0..).zip(faces) {
            let reach = bounds.corners().map(|corner| corner.distance(face.origin));
            let far = 1.001 * reach.into_iter().fold(f32::MIN_POSITIVE, f32::max);
            for row in starts() {
                tiles.extend(starts().map(|column| {
                    Self::new(face, index, resolution, UVec2::new(column, row), far)
                }));
            }
        }
        tiles
    }
}

impl<E: Encode> RenderShadowMap for Gpu<E> {
    fn depths(
        &self,
        casters: &Casters<GpuMemory>,
        faces: &[Face],
        resolution: u32,
    ) -> Result<GpuBuffer<f32>, ShadowMapError> {
        check_size(faces.len(), resolution)?;
        let mut depth = self.zeros(faces.len() * (resolution as usize).pow(2))?;
        let side = resolution.min(TILE);
        let target = Target::new(self.context(), side)?;
        let solid = casters.solid() as u32;
        for tile in Tile::all(faces, resolution, casters.bounds()) {
            let tile = Tile { solid, ..tile };
            target.render(self, &tile, casters)?;
            self.dispatch(
                &Kernel {
                    label: "copy shadow map",
                    parts: &COPY,
                    entry: "copy",
                    constants: &[],
                },
                &[&[
                    Argument::uniform(tile),
                    Argument::texture(&target.distance),
                    Argument::write(&mut depth),
                ]],
                Workgroups::Grid([side.div_ceil(8), side.div_ceil(8), 1]),
            )?;
        }
        Ok(depth)
    }
}

/// What a tile is rendered into.
struct Target {
    distance: wgpu::TextureView,
    depth: wgpu::TextureView,
}

/// Kept in the context.
struct Pipeline {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl Target {
    fn new(context: &Context, side: u32) -> Result<Self, Error> {
        let limit = context.limits().max_texture_dimension_2d;
        if side > limit {
            return Err(Error::Limit {
                what: "a shadow map",
                unit: "texels per side",
                requested: u64::from(side),
                limit: u64::from(limit),
            });
        }
        let attachment = |format, usage| {
            let texture = context.device().create_texture(&wgpu::TextureDescriptor {
                label: Some("shadow map"),
                size: wgpu::Extent3d {
                    width: side,
                    height: side,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        context.scoped("the textures of a shadow map", || Self {
            distance: attachment(DISTANCE, wgpu::TextureUsages::TEXTURE_BINDING),
            depth: attachment(DEPTH, wgpu::TextureUsages::empty()),
        })
    }

    fn render<E: Encode>(
        &self,
        gpu: &Gpu<E>,
        tile: &Tile,
        casters: &Casters<GpuMemory>,
    ) -> Result<(), Error> {
        let label = "shadow map";
        let vertices = 3 * casters.triangles().len() as u64;
        let vertices = u32::try_from(vertices).map_err(|_| Error::Limit {
            what: label,
            unit: "vertices",
            requested: vertices,
            limit: u64::from(u32::MAX),
        })?;
        let arguments = [
            Argument::uniform(*tile),
            Argument::read(casters.triangles()),
            Argument::read(&casters.masks().records),
            Argument::read(&casters.masks().opacities),
        ];
        let context = gpu.context();
        let pipeline = context.cached(label, "crepuscular shadow map", |device| {
            Ok(Pipeline::new(device, context, &arguments))
        })?;
        let group = context.bind_group(label, &pipeline.layout, &arguments)?;
        gpu.with_encoder(label, |encoder| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &self.distance,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color {
                            r: f64::from(EMPTY),
                            ..wgpu::Color::BLACK
                        }),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(1.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &group, &[]);
            let [width, height] = tile.size.as_vec2().to_array();
            pass.set_viewport(0.0, 0.0, width, height, 0.0, 1.0);
            pass.set_scissor_rect(0, 0, tile.size.x, tile.size.y);
            pass.draw(0..vertices, 0..1);
        })
    }
}

impl Pipeline {
    fn new(device: &wgpu::Device, context: &Context, arguments: &[Argument<'_>]) -> Self {
        let label = Some("shadow map");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label,
            source: wgpu::ShaderSource::Wgsl(RENDER.join("\n").into()),
        });
        let layout =
            context.bind_group_layout("shadow map", wgpu::ShaderStages::VERTEX_FRAGMENT, arguments);
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
                entry_point: Some("project"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            // Both sides of a triangle cast shadows.
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::LessEqual),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("measure"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(DISTANCE.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { layout, pipeline }
    }
}
