//! What can go wrong.

use crate::voxelized::VoxelError;

/// Why the fog of a frame could not be recorded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FogError {
    /// A number of samples that pictures do not have.
    #[error("{samples} samples in each pixel, expected 1 or 4")]
    Samples {
        /// As it was given.
        samples: u32,
    },
    /// A texture does not have the samples that the pass was made for.
    #[error("{what} has {actual} samples in each pixel, expected {expected}")]
    SampleCount {
        /// Which texture.
        what: &'static str,
        /// How many it should have.
        expected: u32,
        /// How many it has.
        actual: u32,
    },
    /// A texture has another format.
    #[error("{what} has the format {actual:?}, expected {expected}")]
    Format {
        /// Which texture.
        what: &'static str,
        /// What would have been right.
        expected: String,
        /// What it has.
        actual: wgpu::TextureFormat,
    },
    /// A texture may not be used for what it is needed for.
    #[error("{what} has the usage {actual:?}, expected {expected:?}")]
    Usage {
        /// Which texture.
        what: &'static str,
        /// What it needs.
        expected: wgpu::TextureUsages,
        /// What it has.
        actual: wgpu::TextureUsages,
    },
    /// The textures of an eye differ in size.
    #[error(
        "the depths of an eye have {} × {} pixels, and its fog has {} × {}",
        depth[0], depth[1], fog[0], fog[1]
    )]
    Size {
        /// Pixels of the depths.
        depth: [u32; 2],
        /// Pixels of the fog.
        fog: [u32; 2],
    },
    /// A matrix has no point from which it is seen.
    #[error("the matrix of an eye is that of no perspective view: {matrix:?}")]
    NoEye {
        /// As it was given.
        matrix: [[f32; 4]; 4],
    },
    /// A number outside of its range.
    #[error("{what} is {value}, expected {expected}")]
    BadValue {
        /// Which number.
        what: &'static str,
        /// As it was given.
        value: f32,
        /// What would have been right.
        expected: &'static str,
    },
    /// The fourth channel holds one transmittance for all colours.
    #[error("the extinction of the fog is {sigma_t:?} / m, expected the same for all colours")]
    ColouredExtinction {
        /// As it was given.
        sigma_t: [f32; 3],
    },
    /// The phase function of the medium cannot be integrated.
    #[error(transparent)]
    Airlight(#[from] airlight::Error),
    /// No shadow volume could be made for a light.
    #[error(transparent)]
    Voxels(#[from] VoxelError),
    /// The device refused.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
}
