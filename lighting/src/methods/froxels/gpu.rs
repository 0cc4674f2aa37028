//! Froxels on a GPU.

use airlight::gpu::PHASE;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::Assembly;
use gpu_backend::{Buffer, Error};

use super::{FroxelAirlight, FroxelGrid, FroxelLight, FroxelSteps, FroxelVolume, InjectFroxels};
use crate::Ray;
use crate::gather::check_lengths;
use crate::gpu::scene::{EmitterRecord, MediumRecord};
use crate::gpu::{NUMERIC, PATH, PointSlot};
use crate::scene::Medium;

/// Invocations per workgroup of all entry points.
const GROUP: u32 = 64;

const FROXELS: &str = include_str!("froxels.wgsl");

pub(super) const BLEND: [&str; 3] = [INDEX_WGSL, FROXELS, include_str!("blend.wgsl")];
pub(super) const INTEGRATE: [&str; 6] = [
    INDEX_WGSL,
    NUMERIC,
    PHASE,
    PATH,
    FROXELS,
    include_str!("integrate.wgsl"),
];
pub(super) const LOOK_UP: [&str; 3] = [INDEX_WGSL, FROXELS, include_str!("look_up.wgsl")];

/// The shader that injects a light whose shadow `P` knows.
pub(super) fn injection<P: InShader<PointSlot>>() -> Result<Assembly, Error> {
    let mut shader = Assembly::new(&[
        INDEX_WGSL,
        NUMERIC,
        PHASE,
        PATH,
        FROXELS,
        include_str!("inject.wgsl"),
    ]);
    shader.fill::<PointSlot>(&P::part())?;
    Ok(shader)
}

/// `light_Froxels` of `froxels.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct GridRecord {
    pub(super) eye: Vec3,
    pub(super) near: f32,
    pub(super) right: Vec3,
    pub(super) far: f32,
    pub(super) up: Vec3,
    pub(super) tile: f32,
    pub(super) forward: Vec3,
    pub(super) slices: u32,
    pub(super) middle: [f32; 2],
    pub(super) columns: u32,
    pub(super) rows: u32,
}

impl From<FroxelGrid> for GridRecord {
    fn from(grid: FroxelGrid) -> Self {
        Self {
            eye: grid.eye,
            near: grid.near,
            right: grid.right,
            far: grid.far,
            up: grid.up,
            tile: grid.tile,
            forward: grid.forward,
            slices: grid.slices,
            middle: grid.middle,
            columns: grid.columns,
            rows: grid.rows,
        }
    }
}

/// `Injection` of `inject.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Injection {
    pub(super) grid: GridRecord,
    pub(super) emitter: EmitterRecord,
    pub(super) medium: MediumRecord,
    pub(super) jitter: [f32; 3],
    pub(super) adds: u32,
    pub(super) extinction: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
    pub(super) padding_c: u32,
}

/// `Blend` of `blend.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Blend {
    pub(super) grid: GridRecord,
    pub(super) before: GridRecord,
    pub(super) share: f32,
    pub(super) is_same: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
}

/// `Integration` of `integrate.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Integration {
    pub(super) grid: GridRecord,
    pub(super) medium: MediumRecord,
}

/// `LookUp` of `look_up.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct LookUp {
    pub(super) grid: GridRecord,
    pub(super) rays: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
    pub(super) padding_c: u32,
}

impl<P: InShader<PointSlot>, E: Encode> InjectFroxels<P> for Gpu<E> {
    fn inject(
        &self,
        light: &FroxelLight<'_>,
        points: &P,
        volume: &mut FroxelVolume<GpuMemory>,
    ) -> Result<(), Error> {
        let (emitter, cookie) = EmitterRecord::new(light.emitter);
        let injection = Injection {
            grid: volume.grid.into(),
            emitter,
            medium: MediumRecord::new(light.medium),
            jitter: volume.jitter.place(),
            adds: u32::from(volume.lights > 0),
            extinction: u32::from(light.extinction),
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        };
        self.dispatch(
            &Kernel {
                label: "inject light into froxels",
                parts: &self::injection::<P>()?.finish(1),
                entry: "inject",
                constants: &points.constants(),
            },
            &[
                &[
                    Argument::uniform(injection),
                    Argument::table(&cookie),
                    Argument::write(&mut volume.scattered),
                ],
                &points.arguments(),
            ],
            Workgroups::covering(volume.grid.froxels(), GROUP),
        )?;
        volume.lights += 1;
        Ok(())
    }
}

impl<E: Encode> FroxelSteps for Gpu<E> {
    fn blend(
        &self,
        before: &FroxelVolume<GpuMemory>,
        share: f32,
        now: &mut FroxelVolume<GpuMemory>,
    ) -> Result<(), Error> {
        now.settle(self)?;
        let blend = Blend {
            grid: now.grid.into(),
            before: before.grid.into(),
            share,
            is_same: u32::from(now.grid == before.grid),
            padding_a: 0,
            padding_b: 0,
        };
        self.dispatch(
            &Kernel {
                label: "blend froxels",
                parts: &BLEND,
                entry: "blend_froxels",
                constants: &[],
            },
            &[&[
                Argument::uniform(blend),
                Argument::read(&before.scattered),
                Argument::write(&mut now.scattered),
            ]],
            Workgroups::covering(now.grid.froxels(), GROUP),
        )?;
        now.lights += 1;
        Ok(())
    }

    fn integrate(
        &self,
        medium: &Medium,
        volume: &mut FroxelVolume<GpuMemory>,
        airlight: &mut FroxelAirlight<GpuMemory>,
    ) -> Result<(), Error> {
        volume.settle(self)?;
        airlight.fit(self, volume.grid)?;
        let grid = volume.grid;
        let integration = Integration {
            grid: grid.into(),
            medium: MediumRecord::new(medium),
        };
        self.dispatch(
            &Kernel {
                label: "integrate froxels",
                parts: &INTEGRATE,
                entry: "integrate",
                constants: &[],
            },
            &[&[
                Argument::uniform(integration),
                Argument::read(&volume.scattered),
                Argument::write(&mut airlight.radiance),
            ]],
            Workgroups::covering(grid.columns as usize * grid.rows as usize, GROUP),
        )
    }

    fn look_up(
        &self,
        airlight: &FroxelAirlight<GpuMemory>,
        rays: &GpuBuffer<Ray>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        let look = LookUp {
            grid: airlight.grid.into(),
            // More rays than that are refused by the dispatch.
            rays: rays.len() as u32,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        };
        self.dispatch(
            &Kernel {
                label: "light at the ends of rays",
                parts: &LOOK_UP,
                entry: "look_up",
                constants: &[],
            },
            &[&[
                Argument::uniform(look),
                Argument::read(&airlight.radiance),
                Argument::read(rays),
                Argument::write(radiance),
            ]],
            Workgroups::covering(rays.len(), GROUP),
        )
    }
}
