//! Rectification on a GPU.

use epipolar::Lattice;
use epipolar::gpu::{EPIPOLAR, LatticeRecord};
use glam::Vec3;
use gpu_backend::Buffer;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};

use super::GROUP;
use crate::rectify::check;
use crate::{Error, IndexMap, Rectify, RectifyTriangles};

/// Anything whose first blocker a shader knows; the [`FirstBlocker`] of shaders.
///
/// [`FirstBlocker`]: crate::FirstBlocker
pub trait WgslFirstBlocker {
    /// WGSL that defines
    /// `fn vsv_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32`,
    /// the distance in metres along a light ray to the first blocker,
    /// [`f32::MAX`] if there is none. Its bindings are in `@group(1)`.
    fn parts() -> &'static [&'static str];

    /// Values of `override` constants.
    fn constants(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// What is bound to `@group(1)`.
    fn arguments(&self) -> Vec<Argument<'_>>;
}

/// Uniforms of `triangles.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct TriangleParameters {
    pub(super) lattice: LatticeRecord,
    pub(super) triangles: u32,
    padding: [u32; 3],
}

/// All parts of the shader for a source.
pub(super) fn parts<S: WgslFirstBlocker>() -> Vec<&'static str> {
    let before = [INDEX_WGSL, EPIPOLAR];
    let entry = [include_str!("rectify.wgsl")];
    [&before, S::parts(), &entry].concat()
}

pub(super) const TRIANGLES: &[&str] = &[INDEX_WGSL, EPIPOLAR, include_str!("triangles.wgsl")];

impl<S: WgslFirstBlocker, E: Encode> Rectify<S> for Gpu<E> {
    fn rectify(
        &self,
        lattice: &Lattice,
        source: &S,
        map: &mut IndexMap<GpuMemory>,
    ) -> Result<(), Error> {
        check(lattice, map)?;
        let rays = lattice.resolution().light_rays();
        self.dispatch(
            &Kernel {
                label: "rectify",
                parts: &parts::<S>(),
                entry: "rectify",
                constants: &source.constants(),
            },
            &[
                &[
                    Argument::uniform(LatticeRecord::new(lattice)),
                    Argument::table(lattice.planes()),
                    Argument::table(lattice.light_angles()),
                    Argument::write(map.indices_mut()),
                ],
                &source.arguments(),
            ],
            Workgroups::covering(rays, GROUP),
        )?;
        Ok(())
    }
}

impl<E: Encode> RectifyTriangles for Gpu<E> {
    fn rectify_triangles(
        &self,
        lattice: &Lattice,
        triangles: &GpuBuffer<[Vec3; 3]>,
        map: &mut IndexMap<GpuMemory>,
    ) -> Result<(), Error> {
        check(lattice, map)?;
        let parameters = TriangleParameters {
            lattice: LatticeRecord::new(lattice),
            // A buffer with more would exceed 4 GiB many times.
            triangles: triangles.len() as u32,
            padding: [0; 3],
        };
        self.dispatch(
            &Kernel {
                label: "rectify triangles",
                parts: TRIANGLES,
                entry: "rectify_triangles",
                constants: &[],
            },
            &[&[
                Argument::uniform(parameters),
                Argument::table(lattice.planes()),
                Argument::table(lattice.light_angles()),
                Argument::read(triangles),
                Argument::write(map.indices_mut()),
            ]],
            Workgroups::covering(lattice.resolution().light_rays(), GROUP),
        )?;
        Ok(())
    }
}
