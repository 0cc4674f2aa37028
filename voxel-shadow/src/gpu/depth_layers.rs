//! Depth textures of a renderer as the source of a shadow volume.

use glam::Mat4;
use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::{DEPTH, FirstBlockerSlot};
use crate::DepthViews;
use crate::depth_views::MAX_VIEWS;

/// [`DepthViews`] and the texture with their depths, where they are: what
/// [`Rectify`](crate::Rectify) takes on a GPU.
///
/// The texture is a depth texture with a layer for each view, seen with the dimension
/// [`D2Array`](wgpu::TextureViewDimension::D2Array): a texture of one layer, an array, and
/// the six layers of a cube can all be seen like this without a copy. Its aspect is the
/// depth alone. The usage includes `TEXTURE_BINDING`, and it is not multisampled.
///
/// ```no_run
/// # fn frame(
/// #     gpu: &gpu_backend::gpu::Gpu<gpu_backend::gpu::Queued>,
/// #     lattice: &epipolar::Lattice,
/// #     depths: &wgpu::Texture,
/// #     map: &mut voxel_shadow::IndexMap<gpu_backend::gpu::GpuMemory>,
/// # ) -> Result<(), voxel_shadow::Error> {
/// use voxel_shadow::gpu::DepthLayers;
/// use voxel_shadow::{DepthViews, Rectify};
///
/// let views = DepthViews::cube([0.0, 3.0, -2.0], 0.05)?;
/// let layers = depths.create_view(&wgpu::TextureViewDescriptor {
///     dimension: Some(wgpu::TextureViewDimension::D2Array),
///     aspect: wgpu::TextureAspect::DepthOnly,
///     ..wgpu::TextureViewDescriptor::default()
/// });
/// gpu.rectify(lattice, &DepthLayers::new(&views, &layers), map)?;
/// # Ok(())
/// # }
/// ```
///
/// Light rays take the depth of the texel that they go through. Views without a layer have
/// nothing in the way.
#[derive(Debug, Clone, Copy)]
pub struct DepthLayers<'a> {
    views: &'a DepthViews,
    layers: &'a wgpu::TextureView,
}

/// `vsv_DepthViews` of `depth_layers.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct DepthViewsRecord {
    pub(super) matrices: [Mat4; MAX_VIEWS],
    pub(super) count: u32,
    pub(super) empty: f32,
    padding: [u32; 2],
}

impl<'a> DepthLayers<'a> {
    /// These views, whose depths are the layers of a texture, in their order.
    pub fn new(views: &'a DepthViews, layers: &'a wgpu::TextureView) -> Self {
        Self { views, layers }
    }
}

impl InShader<FirstBlockerSlot> for DepthLayers<'_> {
    fn part() -> Part {
        Part::new("vsv_layers")
            .source(DEPTH)
            .source(include_str!("depth_layers.wgsl"))
            .uniform("vsv_depth_views", "vsv_DepthViews")
            .texture("vsv_depth_layers", "texture_depth_2d_array")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut matrices = [Mat4::ZERO; MAX_VIEWS];
        for (view, matrix) in matrices.iter_mut().enumerate().take(self.views.len()) {
            *matrix = Mat4::from_cols_array_2d(&self.views.matrix(view));
        }
        vec![
            Argument::uniform(DepthViewsRecord {
                matrices,
                count: self.views.len() as u32,
                empty: self.views.empty(),
                padding: [0; 2],
            }),
            Argument::texture_of(
                self.layers,
                wgpu::TextureSampleType::Depth,
                wgpu::TextureViewDimension::D2Array,
            ),
        ]
    }
}
