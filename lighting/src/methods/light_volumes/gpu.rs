//! Light volumes on a GPU: how they are made, and their runs in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Error};

use super::mesh::{Layout, MOST_LEVELS, Node};
use super::{BuildLightVolume, LightVolume};
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, LINE, PLACE, VisibilitySlot};
use crate::scene::raster::Rays;
use crate::shadow_map::ShadowMap;

/// `light_volume_Layout` of `mesh.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct LayoutRecord {
    pub(crate) width: [f32; 2],
    pub(crate) tolerance: f32,
    pub(crate) resolution: u32,
    pub(crate) pictures: u32,
    pub(crate) levels: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
    pub(crate) first: [u32; MOST_LEVELS],
}

impl LayoutRecord {
    fn new(layout: &Layout) -> Self {
        Self {
            width: layout.width,
            tolerance: layout.tolerance.min(f32::MAX),
            resolution: layout.resolution(),
            pictures: layout.pictures(),
            levels: layout.levels(),
            padding_a: 0,
            padding_b: 0,
            first: layout.first,
        }
    }
}

/// `Heights` of `heights.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct HeightsRecord {
    pub(crate) tan: f32,
    pub(crate) resolution: u32,
    pub(crate) texels: u32,
    pub(crate) padding: u32,
}

/// `Level` of `level.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct LevelRecord {
    pub(crate) mesh: LayoutRecord,
    pub(crate) level: u32,
    pub(crate) nodes: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

/// `light_Volume` of `volume.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct VolumeRecord {
    pub(crate) pictures: PicturesRecord,
    pub(crate) mesh: LayoutRecord,
}

const MESH: &str = include_str!("mesh.wgsl");

/// The shader that finds the heights of vertices.
pub(crate) const HEIGHTS: [&str; 4] = [INDEX_WGSL, FACE, MESH, include_str!("heights.wgsl")];

/// The shader that makes a level of a quadtree.
pub(crate) const LEVEL: [&str; 4] = [INDEX_WGSL, FACE, MESH, include_str!("level.wgsl")];

impl<E: Encode> BuildLightVolume for Gpu<E> {
    fn light_volume(
        &self,
        map: &ShadowMap<GpuMemory>,
        tolerance: f32,
    ) -> Result<LightVolume<GpuMemory>, Error> {
        let layout = Layout::new(map.faces(), map.resolution(), tolerance);
        let mut heights = self.zeros(layout.vertices())?;
        let mut nodes = self.zeros::<Node>(layout.nodes())?;
        let tan = match map.faces()[0].rays {
            Rays::Parallel { .. } => 0.0,
            Rays::Central { tan } => tan,
        };
        self.dispatch(
            &Kernel {
                label: "heights of a light volume",
                parts: &HEIGHTS,
                entry: "find_heights",
                constants: &[],
            },
            &[&[
                Argument::uniform(HeightsRecord {
                    tan,
                    resolution: layout.resolution(),
                    // More are refused by the dispatch.
                    texels: layout.vertices() as u32,
                    padding: 0,
                }),
                Argument::read(map.depth()),
                Argument::write(&mut heights),
            ]],
            Workgroups::covering(layout.vertices(), 64),
        )?;
        for level in 1..=layout.levels() {
            let of_level = layout.level(level).0.len();
            self.dispatch(
                &Kernel {
                    label: "nodes of a light volume",
                    parts: &LEVEL,
                    entry: "find_nodes",
                    constants: &[],
                },
                &[&[
                    Argument::uniform(LevelRecord {
                        mesh: LayoutRecord::new(&layout),
                        level,
                        nodes: of_level as u32,
                        padding_a: 0,
                        padding_b: 0,
                    }),
                    Argument::read(&heights),
                    Argument::write(&mut nodes),
                ]],
                Workgroups::covering(of_level, 64),
            )?;
        }
        Ok(LightVolume::new(map.faces(), layout, heights, nodes))
    }
}

impl InShader<VisibilitySlot> for LightVolume<GpuMemory> {
    fn part() -> Part {
        Part::new("light_volume")
            .sources(&[FACE, PLACE, LINE, MESH, include_str!("volume.wgsl")])
            .uniform("light_volume", "light_Volume")
            .read("light_volume_heights", "array<f32>")
            .read("light_volume_nodes", "array<vec2<f32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(VolumeRecord {
                pictures: PicturesRecord::new(&self.faces, self.layout.resolution()),
                mesh: LayoutRecord::new(&self.layout),
            }),
            Argument::read(&self.heights),
            Argument::read(&self.nodes),
        ]
    }
}
