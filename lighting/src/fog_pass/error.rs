//! What can go wrong with the fog of a frame.

use crate::voxelized::VoxelError;

/// Why the fog of a frame could not be recorded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FogError {
    /// A pass was asked for with a number of samples per pixel that pictures do not have.
    #[error("{samples} samples in each pixel, expected 1 or 4")]
    Samples {
        /// The number that was given.
        samples: u32,
    },
    /// A texture has another number of samples than the pass was made for.
    #[error("{what} has {actual} samples in each pixel, expected {expected}")]
    SampleCount {
        /// Which texture.
        what: &'static str,
        /// How many it should have.
        expected: u32,
        /// How many it has.
        actual: u32,
    },
    /// A texture has another format than it should have.
    #[error("{what} has the format {actual:?}, expected {expected}")]
    Format {
        /// Which texture.
        what: &'static str,
        /// The format that it should have.
        expected: String,
        /// The format that it has.
        actual: wgpu::TextureFormat,
    },
    /// A texture lacks a usage that the pass needs.
    #[error("{what} has the usage {actual:?}, expected {expected:?}")]
    Usage {
        /// Which texture.
        what: &'static str,
        /// The usage that it should have.
        expected: wgpu::TextureUsages,
        /// The usage that it has.
        actual: wgpu::TextureUsages,
    },
    /// The depths and the fog of an eye differ in size.
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
    /// The matrix of an eye is not that of a perspective view.
    #[error("the matrix of an eye is that of no perspective view: {matrix:?}")]
    NoEye {
        /// The matrix that was given.
        matrix: [[f32; 4]; 4],
    },
    /// A number is outside of its range.
    #[error("{what} is {value}, expected {expected}")]
    BadValue {
        /// Which number.
        what: &'static str,
        /// The value that was given.
        value: f32,
        /// The range that it should be in.
        expected: &'static str,
    },
    /// The extinction differs between colours; the fourth channel of the fog holds one
    /// transmittance for all of them.
    #[error("the extinction of the fog is {sigma_t:?} / m, expected the same for all colours")]
    ColouredExtinction {
        /// The extinction that was given, 1/m.
        sigma_t: [f32; 3],
    },
    /// The phase function of the medium cannot be integrated.
    #[error(transparent)]
    Airlight(#[from] airlight::Error),
    /// No shadow volume could be made for a light.
    #[error(transparent)]
    Voxels(#[from] VoxelError),
    /// The device refused, or something is too large for it.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
}
