//! Filtered shadow maps on a GPU, and in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Error};

use super::{Level, MomentPyramid, Moments, Prefilter, PrefilteredMap};
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, PLACE, PointSlot, StepSlot};
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

/// The shader that makes a level from the one before it.
pub(crate) const COARSEN: [&str; 5] =
    [INDEX_WGSL, FACE, PLACE, LEVEL, include_str!("coarsen.wgsl")];

/// `Coarser` of `coarsen.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct CoarserRecord {
    pub(crate) level: LevelRecord,
    pub(crate) finer: u32,
    pub(crate) own: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

/// Levels of the largest map.
const MOST_LEVELS: usize = 17;

/// `light_Pyramid` of `pyramid.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct PyramidRecord {
    pub(crate) firsts: [[u32; 4]; MOST_LEVELS.div_ceil(4)],
    pub(crate) count: u32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
    pub(crate) padding_c: u32,
}

impl PyramidRecord {
    fn new(firsts: &[usize]) -> Self {
        let mut record = Self {
            count: firsts.len() as u32,
            ..Self::zeroed()
        };
        for (i, first) in firsts.iter().enumerate() {
            // A buffer with more numbers than a u32 counts cannot be bound.
            record.firsts[i / 4][i % 4] = *first as u32;
        }
        record
    }
}

/// Levels whose texels cover more than 4^6 texels of the map are made in two steps: some
/// software drivers end loops after 65,535 turns.
const AT_ONCE: u32 = 6;

/// Writes the moments of a level at the beginning of a buffer.
fn filter<E: Encode>(
    gpu: &Gpu<E>,
    map: &ShadowMap<GpuMemory>,
    level: &Level,
    moments: &mut GpuBuffer<f32>,
) -> Result<(), Error> {
    let run = |entry, read: &GpuBuffer<f32>, write: &mut GpuBuffer<f32>, count| {
        gpu.dispatch(
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
        return run("prefilter", map.depth(), moments, level.texels());
    }
    let parts = level.faces.len() * level.resolution as usize * level.side as usize;
    let mut rows = gpu.zeros::<f32>(parts * level.moments.channels())?;
    run("sum_rows", map.depth(), &mut rows, parts)?;
    run("join_rows", &rows, moments, level.len())
}

impl<E: Encode> Prefilter for Gpu<E> {
    fn prefilter(
        &self,
        map: &ShadowMap<GpuMemory>,
        level: &Level,
    ) -> Result<GpuBuffer<f32>, Error> {
        let mut moments = self.zeros::<f32>(level.len())?;
        filter(self, map, level, &mut moments)?;
        Ok(moments)
    }

    fn prefilter_all(
        &self,
        map: &ShadowMap<GpuMemory>,
        levels: &[Level],
    ) -> Result<GpuBuffer<f32>, Error> {
        let mut moments = self.zeros::<f32>(levels.iter().map(Level::len).sum())?;
        if let Some(finest) = levels.first() {
            filter(self, map, finest, &mut moments)?;
        }
        let mut finer = 0;
        for pair in levels.windows(2) {
            let own = finer + pair[0].len();
            self.dispatch(
                &Kernel {
                    label: "prefilter",
                    parts: &COARSEN,
                    entry: "coarsen",
                    constants: &[],
                },
                &[&[
                    Argument::uniform(CoarserRecord {
                        level: LevelRecord::new(&pair[1]),
                        finer: finer as u32,
                        own: own as u32,
                        padding_a: 0,
                        padding_b: 0,
                    }),
                    Argument::write(&mut moments),
                ]],
                Workgroups::covering(pair[1].len(), GROUP),
            )?;
            finer = own;
        }
        Ok(moments)
    }
}

impl InShader<PointSlot> for PrefilteredMap<GpuMemory> {
    fn part() -> Part {
        Part::new("light_moments")
            .sources(&LOOKUP)
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

/// What both are asked by.
const LOOKUP: [&str; 4] = [FACE, PLACE, LEVEL, include_str!("lookup.wgsl")];

impl InShader<StepSlot> for MomentPyramid<GpuMemory> {
    fn part() -> Part {
        Part::new("light_moments")
            .sources(&LOOKUP)
            .uniform("light_moments", "light_Level")
            .read("light_moment_values", "array<f32>")
            .uniform("light_pyramid", "light_Pyramid")
            .source(include_str!("pyramid.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(LevelRecord::new(&self.levels[0])),
            Argument::read(&self.moments),
            Argument::uniform(PyramidRecord::new(&self.firsts)),
        ]
    }
}
