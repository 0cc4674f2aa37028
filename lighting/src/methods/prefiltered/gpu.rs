//! Filtered shadow maps on a GPU, and in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Error};

use super::{Level, Moments, Prefilter, PrefilteredMap};
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, PLACE, PointSlot};
use crate::shadow_map::ShadowMap;

/// Invocations per workgroup in `build.wgsl`.
const GROUP: u32 = 64;

/// `light_Level` of `level.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct LevelRecord {
    pub(crate) pictures: PicturesRecord,
    pub(crate) kind: u32,
    pub(crate) channels: u32,
    pub(crate) level: u32,
    pub(crate) side: u32,
    pub(crate) near: f32,
    pub(crate) far: f32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

impl LevelRecord {
    fn new(level: &Level) -> Self {
        let [near, far] = level.depths;
        Self {
            pictures: PicturesRecord::new(&level.faces, level.resolution),
            kind: match level.moments {
                Moments::Variance => VARIANCE,
                Moments::ExponentialVariance => EXPONENTIAL,
                Moments::Four => FOUR,
                Moments::Six => SIX,
            },
            channels: level.moments.channels() as u32,
            level: level.level,
            side: level.side,
            near,
            far,
            padding_a: 0,
            padding_b: 0,
        }
    }
}

pub(crate) const VARIANCE: u32 = 0;
pub(crate) const EXPONENTIAL: u32 = 1;
pub(crate) const FOUR: u32 = 2;
pub(crate) const SIX: u32 = 3;

const LEVEL: &str = include_str!("level.wgsl");

/// The shader that filters.
pub(crate) const BUILD: [&str; 5] = [INDEX_WGSL, FACE, PLACE, LEVEL, include_str!("build.wgsl")];

/// Levels whose texels cover more than 4^6 texels of the map are made in two steps: some
/// software drivers end loops after 65,535 turns.
const AT_ONCE: u32 = 6;

impl<E: Encode> Prefilter for Gpu<E> {
    fn prefilter(
        &self,
        map: &ShadowMap<GpuMemory>,
        level: &Level,
    ) -> Result<GpuBuffer<f32>, Error> {
        let mut moments = self.zeros::<f32>(level.len())?;
        let run = |entry, read: &GpuBuffer<f32>, write: &mut GpuBuffer<f32>, count| {
            self.dispatch(
                &Kernel {
                    label: "prefilter",
                    parts: &BUILD,
                    entry,
                    constants: &[],
                },
                &[&[
                    Argument::uniform(LevelRecord::new(level)),
                    Argument::read(read),
                    Argument::write(write),
                ]],
                Workgroups::covering(count, GROUP),
            )
        };
        if level.level <= AT_ONCE {
            run("prefilter", map.depth(), &mut moments, level.texels())?;
            return Ok(moments);
        }
        let parts = level.faces.len() * level.resolution as usize * level.side as usize;
        let mut rows = self.zeros::<f32>(parts * level.moments.channels())?;
        run("sum_rows", map.depth(), &mut rows, parts)?;
        run("join_rows", &rows, &mut moments, level.len())?;
        Ok(moments)
    }
}

impl InShader<PointSlot> for PrefilteredMap<GpuMemory> {
    fn part() -> Part {
        Part::new("light_moments")
            .sources(&[FACE, PLACE, LEVEL, include_str!("lookup.wgsl")])
            .uniform("light_moments", "light_Level")
            .read("light_moment_values", "array<f32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(LevelRecord::new(&self.level)),
            Argument::read(&self.moments),
        ]
    }
}
