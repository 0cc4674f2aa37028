//! An environment behind fog, in shaders.

use airlight::gpu::PHASE;
use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};
use gpu_backend::{Buffer, Error};

use super::{AddEnvironment, Ambient, EnvironmentMap};
use crate::gather::check_lengths;
use crate::gpu::scene::MediumRecord;
use crate::gpu::{NUMERIC, PATH, SURFACE_POINT};
use crate::{Ray, SurfacePoint};

/// `Scene` of `environment.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) medium: MediumRecord,
    pub(super) sky_width: u32,
    pub(super) sky_height: u32,
    pub(super) halo_width: u32,
    pub(super) halo_height: u32,
    pub(super) levels: u32,
    pub(super) count: u32,
    pub(super) longest: f32,
    pub(super) distance: f32,
}

/// `Ambient` of `ambient.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct AmbientRecord {
    pub(super) medium: MediumRecord,
    pub(super) radiance: [f32; 3],
    pub(super) count: u32,
    pub(super) before_sky: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
    pub(super) padding_c: u32,
}

/// Invocations per workgroup.
const GROUP: u32 = 64;

pub(super) const SKY: [&str; 6] = [
    INDEX_WGSL,
    NUMERIC,
    PHASE,
    PATH,
    include_str!("environment.wgsl"),
    include_str!("sky.wgsl"),
];

pub(super) const LIGHT: [&str; 7] = [
    INDEX_WGSL,
    NUMERIC,
    PHASE,
    PATH,
    SURFACE_POINT,
    include_str!("environment.wgsl"),
    include_str!("light.wgsl"),
];

pub(super) const AMBIENT: [&str; 5] = [
    INDEX_WGSL,
    NUMERIC,
    PHASE,
    PATH,
    include_str!("ambient.wgsl"),
];

impl EnvironmentMap<GpuMemory> {
    /// The uniform for so many rays or points. If a u32 does not count them, the dispatch
    /// refuses them.
    fn scene(&self, count: usize) -> Scene {
        // A vacuum has no bounds either, and its distance is 0.
        let distance = match (self.distance, self.medium.bounds()) {
            (Some(distance), _) => distance,
            (None, None) => 0.0,
            (None, Some(_)) => -1.0,
        };
        Scene {
            medium: MediumRecord::new(&self.medium),
            sky_width: self.sky_grid.width as u32,
            sky_height: self.sky_grid.height as u32,
            halo_width: self.halo_grid.width as u32,
            halo_height: self.halo_grid.height as u32,
            levels: self.levels as u32,
            count: count as u32,
            longest: self.longest,
            distance,
        }
    }
}

impl<E: Encode> AddEnvironment for Gpu<E> {
    fn add_sky(
        &self,
        rays: &GpuBuffer<Ray>,
        environment: &EnvironmentMap<GpuMemory>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        self.dispatch(
            &Kernel {
                label: "sky",
                parts: &SKY,
                entry: "add_sky",
                constants: &[],
            },
            &[&[
                Argument::uniform(environment.scene(rays.len())),
                Argument::read(rays),
                Argument::read(&environment.sky),
                Argument::read(&environment.halos),
                Argument::write(radiance),
            ]],
            Workgroups::covering(rays.len(), GROUP),
        )
    }

    fn add_environment_light(
        &self,
        points: &GpuBuffer<SurfacePoint>,
        environment: &EnvironmentMap<GpuMemory>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(points.len(), radiance.len())?;
        self.dispatch(
            &Kernel {
                label: "light of the environment",
                parts: &LIGHT,
                entry: "add_environment_light",
                constants: &[],
            },
            &[&[
                Argument::uniform(environment.scene(points.len())),
                Argument::read(points),
                Argument::read(&environment.patches),
                Argument::write(radiance),
            ]],
            Workgroups::covering(points.len(), GROUP),
        )
    }

    fn add_ambient(
        &self,
        rays: &GpuBuffer<Ray>,
        ambient: &Ambient,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        let record = AmbientRecord {
            medium: MediumRecord::new(&ambient.medium),
            radiance: ambient.radiance.into(),
            count: rays.len() as u32,
            before_sky: u32::from(ambient.before_sky),
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        };
        self.dispatch(
            &Kernel {
                label: "ambient light in fog",
                parts: &AMBIENT,
                entry: "add_ambient",
                constants: &[],
            },
            &[&[
                Argument::uniform(record),
                Argument::read(rays),
                Argument::write(radiance),
            ]],
            Workgroups::covering(rays.len(), GROUP),
        )
    }
}
