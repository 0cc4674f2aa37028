//! Atlases on a GPU.

use epipolar::gpu::{EPIPOLAR, LatticeRecord};
use epipolar::{Lattice, Resolution};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Slot};

use super::GROUP;
use crate::atlas::{capacity, check_build, check_lattices};
use crate::{AtlasGrid, AtlasMap, BuildAtlas, Error, RectifyAtlas};

/// *How far does this ray of that light get?* The question that an
/// [`AtlasBlocker`](crate::AtlasBlocker) answers, in shaders. A part `x` defines
///
/// ```wgsl
/// fn x_first_blocker_of(tile: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32
/// ```
///
/// the distance in metres along the ray to the first blocker of the light of that
/// tile, [`f32::MAX`] if there is none.
#[derive(Debug, Clone, Copy)]
pub struct AtlasBlockerSlot;

impl Slot for AtlasBlockerSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn vsv_first_blocker_of(tile: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {{
    return {part}_first_blocker_of(tile, origin, direction);
}}
"
        )
    }
}

/// Uniforms of `rectify_atlas.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct RectifyParameters {
    pub(super) theta: u32,
    pub(super) bits: u32,
    pub(super) tiles: u32,
}

/// Uniforms of `atlas.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct BuildParameters {
    pub(super) rows: u32,
    pub(super) columns: u32,
    pub(super) tiles: u32,
}

pub(super) const BUILD: &[&str] = &[INDEX_WGSL, include_str!("atlas.wgsl")];

/// The shader for a source.
pub(super) fn rectify_shader<S>() -> Result<Assembly, gpu_backend::Error>
where
    S: InShader<AtlasBlockerSlot>,
{
    let mut shader = Assembly::new(&[INDEX_WGSL, EPIPOLAR, include_str!("rectify_atlas.wgsl")]);
    shader.fill::<AtlasBlockerSlot>(&S::part())?;
    Ok(shader)
}

impl<S: InShader<AtlasBlockerSlot>, E: Encode> RectifyAtlas<S> for Gpu<E> {
    fn rectify_atlas(
        &self,
        lattices: &[Lattice],
        source: &S,
        map: &mut AtlasMap<GpuMemory>,
    ) -> Result<(), Error> {
        check_lattices(lattices, map)?;
        let resolution = map.resolution();
        let records: Vec<_> = lattices.iter().map(LatticeRecord::new).collect();
        let all = |of: fn(&Lattice) -> &[[f32; 2]]| lattices.iter().flat_map(of).copied().collect();
        let (planes, angles): (Vec<_>, Vec<_>) = (all(Lattice::planes), all(Lattice::light_angles));
        self.dispatch(
            &Kernel {
                label: "rectify atlas",
                parts: &rectify_shader::<S>()?.finish(1),
                entry: "rectify_atlas",
                constants: &source.constants(),
            },
            &[
                &[
                    Argument::uniform(RectifyParameters {
                        theta: resolution.theta(),
                        bits: resolution.bits(),
                        // Each has a tile in a buffer of the device.
                        tiles: lattices.len() as u32,
                    }),
                    Argument::table(&records),
                    Argument::table(&planes),
                    Argument::table(&angles),
                    Argument::write(map.indices_mut()),
                ],
                &source.arguments(),
            ],
            Workgroups::covering(lattices.len() * resolution.light_rays(), GROUP),
        )?;
        Ok(())
    }
}

impl<E: Encode> BuildAtlas for Gpu<E> {
    fn atlas_capacity(&self, resolution: Resolution) -> usize {
        let limits = self.context().limits();
        let bytes = limits.max_storage_buffer_binding_size;
        capacity(resolution, bytes.min(limits.max_buffer_size))
    }

    fn build_atlas(
        &self,
        map: &AtlasMap<GpuMemory>,
        used: usize,
        grid: &mut AtlasGrid<GpuMemory>,
    ) -> Result<(), Error> {
        check_build(map, used, grid)?;
        let resolution = grid.resolution();
        let columns = resolution.words_per_row();
        self.dispatch(
            &Kernel {
                label: "build atlas",
                parts: BUILD,
                entry: "build_atlas",
                constants: &[],
            },
            &[&[
                Argument::uniform(BuildParameters {
                    rows: resolution.alpha(),
                    columns: columns as u32,
                    tiles: used as u32,
                }),
                Argument::write(grid.words_mut()),
                Argument::read(map.indices()),
            ]],
            Workgroups::covering(used * columns, GROUP),
        )?;
        Ok(())
    }
}
