//! How shaders see what a query is told.

use crate::Sampling;

/// A [`Sampling`] as shaders see it: `vsv_Sampling`.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SamplingRecord {
    pub(super) alpha_bias: f32,
    pub(super) phi_bias: f32,
    pub(super) axis: f32,
    pub(super) interpolate: u32,
}

impl SamplingRecord {
    /// The numbers of a sampling.
    pub fn new(sampling: &Sampling) -> Self {
        Self {
            alpha_bias: sampling.alpha_bias,
            phi_bias: sampling.phi_bias,
            axis: sampling.axis,
            interpolate: u32::from(sampling.interpolate),
        }
    }
}
