//! What a frame is.

use wgpu::TextureUsages;

use super::{DepthLayers, FogError};
use crate::Emitter;
use crate::scene::Medium;

/// What fog is drawn of.
#[derive(Debug, Clone, Copy)]
pub struct FogFrame<'a> {
    /// The pictures: one, or two of a headset.
    pub eyes: &'a [FogEye<'a>],
    /// The depth of pixels in which nothing was drawn, to which the textures were cleared: 0
    /// where depths are reversed, else 1.
    pub empty_depth: f32,
    /// The distance from the eye at which the fog ends, m; positive, may be infinite. A short
    /// reach makes shadows finer. Voxels reach no farther than ten mean free paths into the
    /// fog, and air behind the last of them is as lit as that.
    pub reach: f32,
    /// The fog.
    pub medium: &'a Medium,
    /// The lights.
    pub lights: &'a [FogLight<'a>],
}

/// A picture, and where its fog goes.
#[derive(Debug, Clone, Copy)]
pub struct FogEye<'a> {
    /// From the world, in metres, to clip coordinates as wgpu has them, column by column: the
    /// matrix of a perspective view, what `Mat4` of glam gives as `to_cols_array_2d`.
    pub view_projection: [[f32; 4]; 4],
    /// The depths, seen as a single layer with the aspect of depth alone. The usage includes
    /// `TEXTURE_BINDING`.
    pub depth: &'a wgpu::TextureView,
    /// What is drawn into, a single layer of as many pixels. The usage includes
    /// `RENDER_ATTACHMENT`, and there is one sample in each pixel.
    pub fog: &'a wgpu::TextureView,
}

/// A light, and what it sees.
#[derive(Debug, Clone, Copy)]
pub struct FogLight<'a> {
    pub(super) emitter: &'a Emitter,
    pub(super) shadow: Option<DepthLayers<'a>>,
}

impl<'a> FogLight<'a> {
    /// A light that nothing is in the way of.
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
    /// Pixels along x and y.
    pub(super) fn size(&self) -> [u32; 2] {
        size(self.fog)
    }
}

impl FogFrame<'_> {
    /// Whether all is as a pass needs it that draws into textures of `format`, from so many
    /// samples in each pixel.
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
        // What scattering and absorption add up to may differ by rounding.
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
