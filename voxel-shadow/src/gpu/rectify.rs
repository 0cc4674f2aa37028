//! Rectification on a GPU.

use epipolar::Lattice;
use epipolar::gpu::{EPIPOLAR, LatticeRecord};
use glam::Vec3;
use gpu_backend::Buffer;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Part, Slot};

use super::GROUP;
use crate::rectify::check;
use crate::{Error, IndexMap, Rectify, RectifyMasked, RectifyTriangles};

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

/// *Is there a hole in this triangle?* The question that [`Holes`] answer, in shaders.
/// A part `x` defines
///
/// ```wgsl
/// fn x_is_hole(triangle: u32, at: vec2<f32>) -> bool
/// ```
///
/// where `at` are the barycentric coordinates of the second and third corner.
///
/// [`Holes`]: crate::Holes
#[derive(Debug, Clone, Copy)]
pub struct HolesSlot;

impl Slot for HolesSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn vsv_is_hole(triangle: u32, at: vec2<f32>) -> bool {{
    return {part}_is_hole(triangle, at);
}}
"
        )
    }
}

/// There are none.
impl InShader<HolesSlot> for () {
    fn part() -> Part {
        Part::new("vsv_whole").source(
            "
fn vsv_whole_is_hole(triangle: u32, at: vec2<f32>) -> bool {
    return false;
}
",
        )
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

/// Uniforms of `triangles.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct TriangleParameters {
    pub(super) lattice: LatticeRecord,
    pub(super) first: u32,
    pub(super) end: u32,
    padding: [u32; 2],
}

/// Triangles of a pass, at most: each is a turn of a loop, and some software drivers
/// end all loops of an invocation after 65,535 turns.
pub(super) const PASS: u32 = 1 << 15;

/// The shader for a source.
pub(super) fn shader<S: InShader<FirstBlockerSlot>>() -> Result<Assembly, gpu_backend::Error> {
    let mut shader = Assembly::new(&[INDEX_WGSL, EPIPOLAR, include_str!("rectify.wgsl")]);
    shader.fill::<FirstBlockerSlot>(&S::part())?;
    Ok(shader)
}

/// The shader for triangles with these holes.
pub(super) fn triangles_shader<H: InShader<HolesSlot>>() -> Result<Assembly, gpu_backend::Error> {
    let mut shader = Assembly::new(&[INDEX_WGSL, EPIPOLAR, include_str!("triangles.wgsl")]);
    shader.fill::<HolesSlot>(&H::part())?;
    Ok(shader)
}

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
        self.rectify_masked(lattice, triangles, &(), map)
    }
}

impl<H: InShader<HolesSlot>, E: Encode> RectifyMasked<H> for Gpu<E> {
    fn rectify_masked(
        &self,
        lattice: &Lattice,
        triangles: &GpuBuffer<[Vec3; 3]>,
        holes: &H,
        map: &mut IndexMap<GpuMemory>,
    ) -> Result<(), Error> {
        check(lattice, map)?;
        let shader = triangles_shader::<H>()?.finish(1);
        // A buffer with more would exceed 4 GiB many times.
        let count = triangles.len() as u32;
        // The first pass sets all indices, even without a triangle.
        for first in (0..count.max(1)).step_by(PASS as usize) {
            let parameters = TriangleParameters {
                lattice: LatticeRecord::new(lattice),
                first,
                end: first.saturating_add(PASS).min(count),
                padding: [0; 2],
            };
            self.dispatch(
                &Kernel {
                    label: "rectify triangles",
                    parts: &shader,
                    entry: "rectify_triangles",
                    constants: &holes.constants(),
                },
                &[
                    &[
                        Argument::uniform(parameters),
                        Argument::table(lattice.planes()),
                        Argument::table(lattice.light_angles()),
                        Argument::read(triangles),
                        Argument::write(map.indices_mut()),
                    ],
                    &holes.arguments(),
                ],
                Workgroups::covering(lattice.resolution().light_rays(), GROUP),
            )?;
        }
        Ok(())
    }
}
