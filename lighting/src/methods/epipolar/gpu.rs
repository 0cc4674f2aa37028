//! Line trees on a GPU, and the lit runs of a map in shaders.

use std::borrow::Borrow;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Error};

use super::blocks::{BuildMapBlocks, MapBlocks};
use super::fan::{Fan, Fans, MOST_FANS};
use super::tree::{BuildLineTrees, Node};
use super::{MapRuns, Trees};
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, LINE, PLACE, VisibilitySlot};
use crate::shadow_map::ShadowMap;

/// `light_Fan` of `fan.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct FanRecord {
    pub(crate) eye: Vec3,
    pub(crate) first: f32,
    pub(crate) density: f32,
    pub(crate) slices: u32,
    pub(crate) first_cell: u32,
    pub(crate) height: u32,
    pub(crate) nodes: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
    pub(crate) padding_c: u32,
}

impl FanRecord {
    fn new(fan: &Fan) -> Self {
        Self {
            eye: fan.eye.as_vec3(),
            first: fan.first as f32,
            density: fan.density as f32,
            slices: fan.slices,
            first_cell: fan.first_cell,
            height: fan.height,
            nodes: fan.nodes,
            ..Self::zeroed()
        }
    }
}

/// `Build` of `build.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct BuildRecord {
    pub(crate) fan: FanRecord,
    pub(crate) index: u32,
    pub(crate) resolution: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

/// `Blocks` of `blocks.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct BlocksRecord {
    pub(crate) resolution: u32,
    pub(crate) blocks: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

/// `light_Runs` of `runs.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct RunsRecord {
    pub(crate) pictures: PicturesRecord,
    pub(crate) fans: [FanRecord; MOST_FANS],
    pub(crate) eye: Vec3,
    pub(crate) padding: u32,
}

const FAN: &str = include_str!("fan.wgsl");

/// The shader that finds the bounds of blocks.
pub(crate) const BLOCKS: [&str; 4] = [INDEX_WGSL, FACE, FAN, include_str!("blocks.wgsl")];

/// The shader that makes trees.
pub(crate) const BUILD: [&str; 3] = [FACE, FAN, include_str!("build.wgsl")];

impl<E: Encode> BuildMapBlocks for Gpu<E> {
    fn map_blocks(&self, map: &ShadowMap<GpuMemory>) -> Result<MapBlocks<GpuMemory>, Error> {
        let (resolution, pictures) = (map.resolution(), map.faces().len());
        let blocks = MapBlocks::<GpuMemory>::len(resolution, pictures);
        let mut bounds = self.zeros(blocks)?;
        self.dispatch(
            &Kernel {
                label: "bounds of blocks",
                parts: &BLOCKS,
                entry: "find_bounds",
                constants: &[],
            },
            &[&[
                Argument::uniform(BlocksRecord {
                    resolution,
                    // More are refused by the dispatch.
                    blocks: blocks as u32,
                    ..BlocksRecord::zeroed()
                }),
                Argument::read(map.depth()),
                Argument::write(&mut bounds),
            ]],
            Workgroups::covering(blocks, 64),
        )?;
        Ok(MapBlocks {
            bounds,
            resolution,
            pictures,
        })
    }
}

impl<E: Encode> BuildLineTrees for Gpu<E> {
    fn line_trees(
        &self,
        blocks: &MapBlocks<GpuMemory>,
        fans: &Fans,
    ) -> Result<GpuBuffer<Node>, Error> {
        let mut nodes = self.zeros::<Node>(fans.nodes)?;
        for (index, fan) in (0..).zip(&fans.fans) {
            let Some(fan) = fan else { continue };
            self.dispatch(
                &Kernel {
                    label: "line trees",
                    parts: &BUILD,
                    entry: "build_trees",
                    constants: &[],
                },
                &[&[
                    Argument::uniform(BuildRecord {
                        fan: FanRecord::new(fan),
                        index,
                        resolution: fans.resolution,
                        padding_a: 0,
                        padding_b: 0,
                    }),
                    Argument::read(&blocks.bounds),
                    Argument::write(&mut nodes),
                ]],
                Workgroups::covering(fan.slices as usize, 1),
            )?;
        }
        Ok(nodes)
    }
}

impl<P: Borrow<ShadowMap<GpuMemory>>> InShader<VisibilitySlot> for MapRuns<P, GpuMemory> {
    fn part() -> Part {
        Part::new("light_runs")
            .sources(&[FACE, PLACE, LINE, FAN, include_str!("runs.wgsl")])
            .uniform("light_runs", "light_Runs")
            .read("light_runs_depths", "array<f32>")
            .read("light_runs_nodes", "array<vec2<f32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let map = self.map();
        let mut record = RunsRecord {
            pictures: PicturesRecord::new(map.faces(), map.resolution()),
            ..RunsRecord::zeroed()
        };
        let nodes = match &self.trees {
            Some(Trees { fans, nodes }) => {
                record.eye = fans.eye;
                for (to, fan) in record.fans.iter_mut().zip(&fans.fans) {
                    *to = fan.as_ref().map_or_else(FanRecord::zeroed, FanRecord::new);
                }
                Argument::read(nodes)
            }
            None => Argument::table::<Node>(&[]),
        };
        vec![
            Argument::uniform(record),
            Argument::read(map.depth()),
            nodes,
        ]
    }
}
