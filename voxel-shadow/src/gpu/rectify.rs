//! Rectification on a GPU.

use epipolar::Lattice;
use epipolar::gpu::{EPIPOLAR, LatticeRecord};
use glam::Vec3;
use gpu_backend::Buffer;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Slot};

use super::GROUP;
use crate::rectify::check;
use crate::{Error, IndexMap, Rectify, RectifyTriangles};

/// *How far does this light ray get?* The question that a [`FirstBlocker`] answers,
/// in shaders. A part `x` defines
///
/// ```wgsl
/// fn x_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32
/// ```
///
/// the distance in metres along the ray to the first blocker, [`f32::MAX`] if there
/// is none.
///
/// [`FirstBlocker`]: crate::FirstBlocker
#[derive(Debug, Clone, Copy)]
pub struct FirstBlockerSlot;

impl Slot for FirstBlockerSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn vsv_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32 {{
    return {part}_first_blocker(origin, direction);
}}
"
        )
    }
}

/// Uniforms of `triangles.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct TriangleParameters {
    pub(super) lattice: LatticeRecord,
    pub(super) triangles: u32,
    padding: [u32; 3],
}

/// The shader for a source.
pub(super) fn shader<S: InShader<FirstBlockerSlot>>() -> Result<Assembly, gpu_backend::Error> {
    let mut shader = Assembly::new(&[INDEX_WGSL, EPIPOLAR, include_str!("rectify.wgsl")]);
    shader.fill::<FirstBlockerSlot>(&S::part())?;
    Ok(shader)
}

pub(super) const TRIANGLES: &[&str] = &[INDEX_WGSL, EPIPOLAR, include_str!("triangles.wgsl")];

impl<S: InShader<FirstBlockerSlot>, E: Encode> Rectify<S> for Gpu<E> {
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
                parts: &shader::<S>()?.finish(1),
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
