//! Filtered shadow maps on a GPU, and in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Error};

use super::{Levels, Moments, Prefilter, PrefilteredMap};
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, PLACE, PointSlot};
use crate::shadow_map::ShadowMap;

/// Invocations per workgroup in `build.wgsl`.
const GROUP: u32 = 64;

/// `light_Levels` of `levels.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct LevelsRecord {
    pub(crate) pictures: PicturesRecord,
    pub(crate) kind: u32,
    pub(crate) channels: u32,
    pub(crate) first: u32,
    pub(crate) fine: u32,
    pub(crate) coarse: u32,
    pub(crate) part: f32,
    pub(crate) near: f32,
    pub(crate) far: f32,
}

impl LevelsRecord {
    fn new(levels: &Levels) -> Self {
        let [fine, coarse] = levels.sides;
        let [near, far] = levels.depths;
        Self {
            pictures: PicturesRecord::new(&levels.faces, levels.resolution),
            kind: match levels.moments {
                Moments::Variance => VARIANCE,
                Moments::ExponentialVariance => EXPONENTIAL,
                Moments::Four => FOUR,
                Moments::Six => SIX,
            },
            channels: levels.moments.channels() as u32,
            first: levels.first,
            fine,
            coarse,
            part: levels.level - levels.first as f32,
            near,
            far,
        }
    }
}

pub(crate) const VARIANCE: u32 = 0;
pub(crate) const EXPONENTIAL: u32 = 1;
pub(crate) const FOUR: u32 = 2;
pub(crate) const SIX: u32 = 3;

/// `Build` of `build.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct BuildRecord {
    pub(crate) levels: LevelsRecord,
    pub(crate) index: u32,
    pub(crate) first_texel: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

const LEVELS: &str = include_str!("levels.wgsl");

/// The shader that filters.
pub(crate) const BUILD: [&str; 5] = [INDEX_WGSL, FACE, PLACE, LEVELS, include_str!("build.wgsl")];

impl<E: Encode> Prefilter for Gpu<E> {
    fn prefilter(
        &self,
        map: &ShadowMap<GpuMemory>,
        levels: &Levels,
    ) -> Result<GpuBuffer<f32>, Error> {
        let mut moments = self.zeros::<f32>(levels.len())?;
        let record = LevelsRecord::new(levels);
        for index in 0..2 {
            let before = if index == 0 { 0 } else { levels.texels(0) };
            self.dispatch(
                &Kernel {
                    label: "prefilter",
                    parts: &BUILD,
                    entry: "prefilter",
                    constants: &[],
                },
                &[&[
                    Argument::uniform(BuildRecord {
                        levels: record,
                        index: index as u32,
                        first_texel: before as u32,
                        padding_a: 0,
                        padding_b: 0,
                    }),
                    Argument::read(map.depth()),
                    Argument::write(&mut moments),
                ]],
                Workgroups::covering(levels.texels(index), GROUP),
            )?;
        }
        Ok(moments)
    }
}

impl InShader<PointSlot> for PrefilteredMap<GpuMemory> {
    fn part() -> Part {
        Part::new("light_moments")
            .sources(&[FACE, PLACE, LEVELS, include_str!("lookup.wgsl")])
            .uniform("light_moments", "light_Levels")
            .read("light_moment_values", "array<f32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(LevelsRecord::new(&self.levels)),
            Argument::read(&self.moments),
        ]
    }
}
