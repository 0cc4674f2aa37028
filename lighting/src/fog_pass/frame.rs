//! The description of a frame: its eyes, its medium, its lights.

use wgpu::TextureUsages;

use super::{DepthLayers, FogError};
use crate::Emitter;
use crate::scene::Medium;

/// What [`FogPass::record`](super::FogPass::record) is told of a frame.
#[derive(Debug, Clone, Copy)]
pub struct FogFrame<'a> {
    /// The pictures that fog is drawn for: one, or the two of a headset.
    pub eyes: &'a [FogEye<'a>],
    /// The depth of pixels in which nothing was drawn, which is the value that the depth
    /// texture was cleared to: 0 where depths are reversed, else 1.
    pub empty_depth: f32,
    /// The distance from the eye at which the fog ends, m; positive, may be infinite. A shorter
    /// reach makes shadows finer, because the voxels divide it. They end ten mean free paths
    /// behind the place where a line of sight enters the fog; the air behind takes the shadows
    /// of the last voxel.
    pub reach: f32,
    /// The fog. Its extinction must be the same for all colours.
    pub medium: &'a Medium,
    /// The lights that the fog scatters.
    pub lights: &'a [FogLight<'a>],
}

/// The picture of one eye, and the texture that its fog is drawn into.
#[derive(Debug, Clone, Copy)]
pub struct FogEye<'a> {
    /// The matrix of a perspective view from the world, in metres, to clip coordinates as wgpu
    /// has them, column by column: `to_cols_array_2d` of glam's `Mat4` gives it.
    pub view_projection: [[f32; 4]; 4],
    /// The depths of the picture: a view of a single layer, of the depth aspect alone. The
    /// texture's usage includes `TEXTURE_BINDING`.
    pub depth: &'a wgpu::TextureView,
    /// The texture that the fog is drawn into: a view of a single layer with as many pixels as
    /// the depths and one sample per pixel. Its usage includes `RENDER_ATTACHMENT`.
    pub fog: &'a wgpu::TextureView,
}

/// A light with its shadow map, or without one.
#[derive(Debug, Clone, Copy)]
pub struct FogLight<'a> {
    pub(super) emitter: &'a Emitter,
    pub(super) shadow: Option<DepthLayers<'a>>,
}

impl<'a> FogLight<'a> {
    /// A light that nothing blocks.
    pub fn unshadowed(emitter: &'a Emitter) -> Self {
        Self {
            emitter,
            shadow: None,
        }
    }

    /// A light with the renderer's own shadow map.
    pub fn shadowed(emitter: &'a Emitter, map: DepthLayers<'a>) -> Self {
        Self {
            emitter,
            shadow: Some(map),
        }
    }
}

impl FogEye<'_> {
    /// Width and height, pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        size(self.fog)
    }
}

impl FogFrame<'_> {
    /// Refuses a frame that a pass for textures of `format` and depths of `samples` samples per
    /// pixel cannot draw.
    pub(super) fn check(&self, format: wgpu::TextureFormat, samples: u32) -> Result<(), FogError> {
        if !(0.0..=1.0).contains(&self.empty_depth) {
            return Err(FogError::BadValue {
                what: "the depth of empty pixels",
                value: self.empty_depth,
                expected: "0 to 1",
            });
        }
        if !(self.reach > 0.0) {
            return Err(FogError::BadValue {
                what: "the reach of the fog",
                value: self.reach,
                expected: "a positive distance",
            });
        }
        let sigma_t = self.medium.sigma_t();
        // The sums of scattering and absorption may differ by rounding.
        if sigma_t.max_element() - sigma_t.min_element() > 1e-6 * sigma_t.max_element() {
            let sigma_t = sigma_t.to_array();
            return Err(FogError::ColouredExtinction { sigma_t });
        }
        for eye in self.eyes {
            let depth = "the depth texture of an eye";
            if !eye.depth.texture().format().has_depth_aspect() {
                return Err(FogError::Format {
                    what: depth,
                    expected: "one of depths".into(),
                    actual: eye.depth.texture().format(),
                });
            }
            require(depth, eye.depth, samples, TextureUsages::TEXTURE_BINDING)?;
            let fog = "the fog texture of an eye";
            if eye.fog.texture().format() != format {
                return Err(FogError::Format {
                    what: fog,
                    expected: format!("{format:?}"),
                    actual: eye.fog.texture().format(),
                });
            }
            require(fog, eye.fog, 1, TextureUsages::RENDER_ATTACHMENT)?;
            let [depth, fog] = [eye.depth, eye.fog].map(size);
            if depth != fog {
                return Err(FogError::Size { depth, fog });
            }
        }
        Ok(())
    }
}

fn size(view: &wgpu::TextureView) -> [u32; 2] {
    [view.texture().width(), view.texture().height()]
}

fn require(
    what: &'static str,
    view: &wgpu::TextureView,
    samples: u32,
    usage: TextureUsages,
) -> Result<(), FogError> {
    let texture = view.texture();
    if texture.sample_count() != samples {
        return Err(FogError::SampleCount {
            what,
            expected: samples,
            actual: texture.sample_count(),
        });
    }
    if !texture.usage().contains(usage) {
        return Err(FogError::Usage {
            what,
            expected: usage,
            actual: texture.usage(),
        });
    }
    Ok(())
}
